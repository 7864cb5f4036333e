"""Words of English remarks."""

from __future__ import annotations

from agentrob.language.remarks.words import RemarkWords

_BE = "is|are|was|were|am|isn't|aren't|wasn't|weren't"
_HAVE = "has|have|had"
_PAST = """ate|became|began|blew|bought|broke|brought|built|came|caught|chose|did|died|drank|drew|drove|fed|felt|flew
   |forgot|fought|found|froze|gave|got|grew|heard|held|kept|knew|left|lent|lit|lost|made|met|paid|put|ran|rang|rode
   |sang|sat|saw|sent|shut|slept|sold|spent|spoke|stood|stuck|swam|swept|taught|thought|threw|took|understood|went
   |woke|won|wore|fell asleep|[a-z]{2,}ed"""
_PRESENT = """agree|believe|call|crave|dance|deserve|disagree|doubt|drive|eat|enjoy|expect|fear|feel|forget|guess|hate
   |hope|imagine|know|laugh|learn|like|live|look|love|miss|need|play|prefer|read|remember|seem|sing|smell|smile|sound
   |speak|study|suppose|talk|taste|think|trust|understand|use|want|watch|wonder|work"""
#: The third person is a verb only if something follows: "the demo starts at noon", but "the tennis balls".
_THIRD_PERSON = r"[a-z]{3,}(?<![isu])s(?= (?!(?:of|from|in|on|at|there|here|and|or|with|for|to)\b)\w)"
_FEELINGS = """adorable|amazing|amused|awesome|awful|bad|beautiful|bored|brilliant|cool|crazy|curious|cute|delighted
   |excellent|excited|exhausted|fabulous|fantastic|fine|fun|funny|gorgeous|great|happy|hilarious|hungry|impressed
   |impressive|incredible|interesting|jealous|lovely|lucky|nervous|neat|nice|nostalgic|pleased|proud|sad|shocking
   |sleepy|smart|sorry|speechless|strange|surprised|sweet|terrible|thirsty|thrilled|tired|typical|weird|wonderful"""
_WORDS_OF_FEELING = "|".join(word.strip() for word in _FEELINGS.split("|"))

_WHERE = r"""(?:ahead(?: of you)?|in front(?: of you)?|behind you|around(?: you)?|near(?:by| you)?|next to you
    |there|here|now|in sight|(?:to|on) (?:the|your) (?:left|right)|in (?:the|your) way|on the (?:floor|ground|way)
    |in the (?:room|area|lab|hall|hallway|corridor))""".replace("\n    ", "")
_FREE = "(?:clear|free|empty|dry|clean|flat|level|even|safe|open)"
#: A whole clause that says that nothing is in the way.
CLEAR_PATH = (
    r"(?:(?:and|because|since|as|so|also|but|don't worry|no worries|ok|okay) )*(?:"
    r"(?:(?:the|your|our|this) )?(?:way|path|route|floor|ground|carpet|room|area|lane|space|lab|hall|hallway|corridor"
    r"|stage)"
    rf"(?: {_WHERE})? (?:is|looks) (?:(?:all|quite|totally|completely|perfectly|now) )*{_FREE}(?: and {_FREE})?"
    r"|(?:there(?:'s| is| are) )?(?:nobody|no ?one|nothing|no people|no obstacles?)(?: is| are| stands)?"
    rf"(?= {_WHERE})|(?:it's|it is|all is|everything is|all) (?:all )?(?:clear|free|safe)"
    r"|(?:there(?:'s| is)|you have|you've got) (?:plenty of|enough|lots of) (?:space|room))"
    rf"(?: {_WHERE})*"
)

WORDS = RemarkWords(
    leads="""tbh|honestly|frankly|seriously|obviously|literally|apparently|sadly|luckily|fortunately|finally|wow|woah
       |whoa|haha|hahaha|hehe|ha|yay|ugh|argh|phew|hmm|yeah|yes|yep|sure|cool|great|nice|ok so|right|guess what|fun fact
       |funny|hi|hello|hi all|hi everyone|hi folks|hello everyone|hello all|hey guys|hey all|hey everyone|good morning
       |good evening|good afternoon|morning|evening|because|cause|since|also|ok|okay|so|well|and|but|oh|ah|um|uh|hm|hey
       |lol|lmao|omg|ngl|idk|imo|imho|anyway|anyways|alright|by the way|btw|fyi|you know|see|look|now|even though|though
       |although|whereas|given that|seeing that|considering|considering that|now that|to be honest|to be fair
       |not gonna lie
       |as you can see|as you know|as you can tell|for the record|for context|for your information|between you and me
       |believe it or not|as it happens|as luck would have it|in case you wondered|in case you were wondering|today
       |yesterday|nowadays|these days|this morning|this week|this year|last night|last week|last year|right now
       |currently
       |actually|basically|personally|normally|usually|sometimes|maybe|perhaps|probably|clearly|surely|of course
       |no wonder|turns out|no kidding|i mean|whatever|in my (?:country|class|town|village|job|opinion|experience|lab)
       |in our (?:country|class|town|village|opinion|experience|lab|school|office)""",
    subjects="""the|my|our|his|her|their|your|its|this|that|these|those|a|an|some|all|both|most|every|each|no|any
       |everyone|everybody|everything|nobody|nothing|none|someone|somebody|something|anyone|anybody|anything|no one
       |whoever|i|we|he|she|they|it|there|here|here's|there's|that's|thats|it's|its|today|yesterday|dad|mum|mom|mummy
       |mommy|daddy|grandma|grandpa|granny|even my|even the|one of us|one of them|one of my|one of our|people|kids
       |half of us|half the|only my""",
    verbs=f"""{_BE}|{_HAVE}|{_PAST}|{_PRESENT}|{_THIRD_PERSON}|will|would|could|can|might|must|should|does|happens|matters|exists|helps|starts|ends|begins|opens|depends
       |sounds|tastes|smells|seems|feels|loves|likes|hates|knows|thinks|makes|keeps|lives|cries|laughs|smiles|rocks|rules
       |sucks|deserves
       |[a-z]+'(?:s|re|m|ve|ll)|thats""",
    linking=f"{_BE}|looks|seems|has|have",
    bare_subjects="i|im|ive|we|they|he|she",
    about_robot="""you're|you are|you were|you look|you seem|you sound|you went|you did|you must be|you must have
       |you've (?:been|got)|you made|you took|you already (?:did|took|have|had|went|made|know|[a-z]{2,}ed)|you deserve
       |you remind|you rock|you never|you always|you make (?:me|us|my|everyone|everybody|people) (?:smile|laugh|happy
       |day)
       |you have (?:no idea|a lot|lots|many|such|nice|great|lovely|beautiful|good)""",
    feelings=r"""(?:FEELINGS)(?: (?:to|how|that|what|about|for|with|at|when|because|it|this|the|my|our|his|her|i|we
       |you|in
        |of|as|enough|though|though|day|work|idea|view|weather|one|place|room|robot|project|team|people|crowd
       |show)\b[\w' -]*
        |(?: [\w'-]+){0,3} (?:today|tonight|here|there|now|outside|btw|lol|again|already|everyone|everybody|guys
       |folks|all|mate))?$
       """.replace("FEELINGS", _WORDS_OF_FEELING),
    musings=r"""assuming|been|bet|can't|cannot|couldn't|didn't|dunno|enjoying|feeling|feels|glad|gotta love
       |guess (?:i|we|it|that|this|what|so)|guessing|haven't|hope|hopefully|hoping|(?:just )?(?:checking
        |experimenting|practicing|practising|playing around|killing
        time|passing by|dropping by|visiting|watching (?:this )?from)|just (?:curious|got|joined|saying
       |testing
        |trying|wanted|wondering|woke|moved|landed|arrived|finished|discovered|found)|knowing|looks|love|loving|missed
       |never (?:seen|thought|imagined|heard|knew)|no clue|no doubt|no idea|not bad|praying|rumou?r has|seems|sounds
       |speaking (?:of|as)|still (?:can't|learning|laughing|amazed|waking)|suppose (?:i|we|it|that|this)|thinking
       |testing(?=$| (?:if|whether|my|this|one two|testing|1))|took (?:me|us|him|her|them|ages|forever|long)
       |trying (?:this|it|out|to|my)|typing (?:on|from|this|with)|was|wishing|wondering|works|writing (?:from|this|for)
       |would be (?:an|a|so|nice|great|lovely|cool|fun)""",
    verbless=r"""(?:hello|hi|hey|greetings|love|cheers|regards|salutations|welcome) (?:again )?(?:from|to) [\w' ]+
       |back from (?:the )?[a-z]+$|(?:my|our) [\w'-]+(?: [\w'-]+){0,4}$
       |(?:first|second|third|fourth|another|next|final|last|my first|our first)
        (?:try|attempt|time|trial|test|run|round|demo|experiment|post|day|visit|lesson|robot)
       |(?:attempt|test|run|try|trial|round|demo|experiment|session|episode|day|week|lesson|part|exercise|question)
        (?:number |no )?(?:\d+|one|two|three|four|five|six|seven|eight|nine|ten|twelve)(?: of [\w' ]+)?$
       |(?:a |just a |only a )?(?:quick|little|small|short|simple) (?:test|check|demo|question|hello|experiment|trial)
       |as (?:a|an) (?:test|experiment|exercise|demo|treat|reward|joke|thank you|warm up|check|trial)
       |as (?:agreed|promised|discussed|planned|expected|announced)|according to (?:the|my|our) (?:schedule|plan
       |calendar)
       |sorry (?:for|about) |apologies for |excuse (?:the|my|any) |pardon (?:the|my) |forgive (?:the|my) |never mind the
       |almost there|nearly there|getting there|so close|ah so close|oh so close|good to go|here goes|here we go
       |let's go$|long time no see|big fan|huge fan|poor (?:thing|you|guy|fellow)|too cute|too funny|no hard feelings
       |(?:almost |nearly )?(?:lunch|tea|coffee|break|dinner|nap|bed|show|party|play|story|snack) ?time
       |(?:only )?\d+ (?:percent|%) battery|plenty of (?:room|space|time)|lots of (?:room|space|time)
       |no (?:joke|hurry|rush|pressure|stress|big deal|offence|offense|pun|worries|problem|complaints)
       |what a|what an|such a|such an|so much|so many|happy [a-z]+(?: (?:to|from|for|everyone|all|folks|guys
       |new)\b[\w' ]*)?$|merry|long live|god bless|bless (?:you|them|him|her)|congrat\w*
       |(?:thanks|thank you|cheers)(?: (?:a|again|for|to|so|very|from|everyone|all|guys|team|folks)\b[\w' ]*)?$
       |good (?:luck|night|morning|afternoon|evening|job|boy|girl|stuff|to see|to be|thing|point|question|old|news)
       |(?:folks|guys|everyone|everybody|team|people|friends|mates|gang|y'all|ladies and gentlemen|class|chat|fam)$
       |(?:(?:a|an) )?(?:new|old|proud|happy|long ?time|first time|frequent|occasional|regular|returning|fellow
        |complete)
        (?:member|user|lurker|reader|fan|visitor|viewer|listener|follower|poster|subscriber|student|newbie|beginner
       |stranger|enthusiast)(?: (?:from|of|at|in|here|and)\b[\w' ]*)?$
       |(?:(?:just )?a )?(?:quick|small|little|short|simple|another) (?:test|check|demo|hello|experiment)
        (?:from|of|for|with|on) [\w' ]+$
       |(?:you )?(?:lazy ?bones|sleepy ?head|silly|sunshine|superstar|rock ?star|little guy|big guy|buddy|pal|mate|champ
       |partner|beautiful|handsome|genius|hero|cutie|my friend|my dear|my hero)$
       |[a-z]{3,}s (?:really |always |just )?(?:fascinate|amaze|bore|inspire|impress|confuse|delight|excite|relax) (?:me
       |us)
       |(?:(?:another|a|one more|yet another|the usual|typical) )?(?:\w+ )?(?:rainy|sunny|cold|warm|lovely|beautiful
       |busy|quiet|boring|long|lazy|perfect|gr[ae]y|snowy|foggy|stormy|chilly|windy|crazy|wonderful
        |normal) (?:day|morning
       |evening|afternoon|night|week|weekend|monday|tuesday|wednesday|thursday|friday|saturday|sunday|summer|winter
       |autumn|spring)(?: (?:in|at|here|for|today|out|outside)\b[\w' ]*)?$
       |[a-z]+ (?:\w+ )?(?:setup|place|room|lab|house|home|garden|floor|view|robot|forum|stream|office|project|idea)
        (?:you(?:'ve| guys)? (?:have|got|made|built)(?: there| here)?|there|here)$
       |dear (?:all|team|friends|everyone|class|robot)$|my bad|mondays|tuesdays|fridays|(?:so|very|pretty
        |really|super|quite|too|how) (?:FEELINGS)\b
       |rest in peace|case closed|long story|fair enough|true story|same here|me too|us too
       |first things first|side note|note to self|random thought|quick note|purpose|background
       |(?:in|from|here in) [a-z]+ (?:with love|today|tonight)$""".replace("FEELINGS", _WORDS_OF_FEELING),
    introductions=r"""(?:my|our) (?:\w+ )?(?:vote|wish|request|turn|suggestion|pick|choice|bid|exercise|homework|task
       |entry)
        (?:is|goes to|would be|for today|for tonight|today|now|of the day|this time)?
       |(?:here's|here is|here are|here comes) (?:the|my|our|a|an|your)(?: [\w'-]+){1,6}
       |(?:one|two|three|another|a|my|our|first|last)(?: \w+)? (?:wish|wishes|request|requests|vote|votes)
        (?:from|by|of|on behalf of)(?: [\w'-]+){1,4}
       |(?:greetings|hello|hi|a request|a wish|message)(?: \w+)? from(?: [\w'-]+){1,5}
       |(?:i|we)(?: just)? (?:bet|wagered|promised) (?:[\w']+ ){0,6}?(?:that )?(?:you|it|the robot)
        (?:can|could|will|would)(?: [\w']+){1,4}
       |(?:it's|it is|now it's|finally) (?:my|our|his|her) turn(?: now| today| again| at last)?|(?:and )?the winner is
       |(?:my|our|the) (?:\w+ )?(?:students?|kids?|son|daughter|friends?|class|viewers|chat|team|family|group|audience)
        (?:voted|decided|chose|picked|agreed)(?: [\w']+){0,6}
       |(?:a |just a |another )?(?:quick|small|little|simple) (?:test|check|request|wish)(?: (?:from|for|of) [\w' ]+)?
       |would be (?:an honou?r|a pleasure|a dream|lovely|great|nice|cool|awesome)""",
    prefaces=r"""if (?:i|we) (?:remember|recall|understand|see|know)(?: (?:it|that|this))?
        (?: correctly| right| rightly| well)?
       |if (?:i'm|i am|we're|we are) (?:honest|not mistaken|lucky|being honest)|if memory serves|if i may (?:say|add) so
       |if you ask me|if you must know|if anyone (?:wonders|cares|asks|is wondering|is curious|is interested)
       |if (?:my|the|our) [\w' ]+ (?:isn't lying|doesn't lie|is not lying|serves me well|is to be believed)
       |in case (?:you|anyone|anybody) (?:wondered|were wondering|missed it|cares?|is wondering|wonders|asks)""",
    asides=r"""(?:test|testing|wonder|wondered|wondering|check|checking|curious|sure|know|knows|idk|dunno|find out
        |figure out|see) (?:if|whether)(?! you\b)
       |while (?=(?:i|we|he|she|they|my|our|his|her|their)\b)|when (?=it (?:does|did|walks|moves|dances)\b|you (?:do
       |did)
        that\b|(?:i|we|he|she|they) (?:was|were|did|had|saw)\b)
       |you look(?:ed)? (?:\w+ )?(?=(?:FEELINGS)\b|like (?:a|my|our)\b)
       |you (?:already |just |nearly |almost |really )?(?:took|made|did|went|had|got|found|showed|gave)
       |(?:be|am|i'm|is|are|was|were|came|got|welcome) (?:right )?back(?! (?:up|off|away)\b)
       |back (?=in \d{4}\b|then\b|home\b|at (?:home|work|school)\b|(?:from|to) (?:work|school|lunch|the office)\b)
       |look(?:ing)? forward(?= to\b)|should be (?:plenty|enough|fine|ok|okay|good|easy|fun|nice|interesting|great)$
       |(?:will|would|might|should|does|did|may|must|could) look (?!left|right|up|down|back|around|at|ahead|behind
       |forward|over|into)
       |(?:this|that|the|a|different|better|good|nice|another|camera|viewing|whole) angle(?! of\b)
       |(?:have|has|had|got) (?:my|our|the) (?:\w+ )?(?:camera|phone|tea|coffee|popcorn|recorder|notebook|pen|timer
       |stopwatch|tape measure|video|recording|snacks|drink|beer|lunch|dinner|homework|notes) (?:all )?ready
       |(?:been|was|were|am|i'm|we're|kept) (?:\w+ )?waiting(?! (?:for|until|till) (?:\w+ ){1,2}to\b)
       |(?:late|long|short|old|double|duplicate|boring|silly|off topic) (?:posts?|repl(?:y|ies)|messages?)
       |(?:internet|connection|wifi|network|stream|feed|video|computer|laptop|phone|page|site|server|traffic|bus|day
       |morning|week|typing) (?:is|was|has been|seems|feels|got|looks) (?:\w+ )?(?:slow|slower|fast|quick)
       |(?:slow|fast|quick) (?:connection|internet|wifi|day|morning|week|typist|typing|reader|learner|computer|laptop
       |phone|news day)
       |you must (?:be|feel) (?:so |very |pretty |really )?(?:FEELINGS|stiff|busy|popular|famous|lonely|freezing|dizzy
       |starving)
       |(?:i|we) (?:have|had|still have|must|need)(?: to)? (?:go|run|head|leave|move|drive|walk|come|sit|get|sleep|rest)
        (?:out|off|home|soon|now|later|away|early|again|to bed|to work|to sleep|to school|there|in a \w+)
       |i(?:'ve)? (?:got to|gotta) (?:go|run|leave|sleep)|thanks (?:[\w' ]+ )?in advance
       |(?:curious|wonder|wondering)(?: about)? (?:what|how|who|where|which|why)(?: (?:is|it's|was|are))?
       |on the other (?:side|end)
       |(?:i|we) (?:also )?(?:need|have|should|ought|must)(?: to)? (?:do|try) (?:that|this|it)(?: too| as well
        | myself)?$
       |(?:see|seeing|check|checking|testing|test|know|measuring|finding out) (?:just |exactly )?how (?:precise|accurate
       |exact|well|good|fast|quick|smooth|strong|quiet|smart|clever|it|this|that)(?: (?:you|it|this|that|the \w+))?
        (?:are|is|can|does|do|goes|go|works?|looks?|turns? out)?
       |(?:photo|picture|image|shot|colou?rs?|framing|audio|sound|music|lighting) (?:\w+ ){1,3}?(?:a (?:bit
        |little)|slightly
       |way|totally) off|in (?:my|the|those|our) days?
       |first (?:language|name|love|job|car|computer|grade|year|semester|week|term|impression)
       |should (?:still |already |now |soon )?(?:be (?:visible|fine|nice|good|great|fun|easy|ok|okay|interesting|lovely
       |beautiful|pretty|online)|look (?:great|good|nice|better)|come out|help)
       |[a-z]{3,}s look (?:so |very |really )?(?:FEELINGS|pretty|clean|cozy|comfy|new|old|fresh|huge|tiny)
       |(?:figured?|find|found|works?|worked|learned|learnt|learn|know|knew|knows|forgot) (?:out )?how to
       |know how (?:you|it|they|he|she|we|i|that) (?:feels?|felt|works?|worked)
       |you (?:could|can|might) (?:use|do with) (?:some|a|an|more)|you look(?:ed)? like|what a time to
       |(?:love|like|glad|happy|cool|nice|amazing|great|awesome|crazy|wild|incredible|fun|funny|surprised
       |impressed) (?:that |how )?(?:you|we|i|one|people|anyone|it) (?:can|could)
       |clean (?:setup|place|room|lab|house|home|floor|space|desk|office)
       |(?:you|it|the robot|he|she) (?:can|could|will|would) (?:do|manage|handle|pull off) (?:it|this|that|so)
       |the same (?!as\b|way\b|thing\b|again\b|but\b|turn|walk|move|please)(?=[a-z]+)""".replace(
        "FEELINGS", _WORDS_OF_FEELING
    ),
    settings="keep (?:the|your )?(?:obstacle|collision) (?:avoidance|detection|sensors?) (?:on|enabled|active)",
    reasons=r"""so that|because|'?cause|cuz|coz|in order to|so as to|while (?=(?:i|we|he|she|they|my|our)\b)
        |since (?=(?:i|we|he|she|they|it|it's|the|my|our|today|there|everyone)\b)|(?:even )?though (?=(?:i|we|it|the
       |my)\b)
        |although|given that|seeing that|now that (?=(?:i|we|the|my|our|everyone)\b)""",
    reason_subjects=r"i|we|he|she|they|it|nobody|no one|everyone|everybody|people|the \w+|my \w+|our \w+",
    aims=r"""align|avoid|be|calibrate|celebrate|check|compare|demonstrate|fit|line|make (?:some |more )?room|measure
       |practice|practise
        |prove|see|show|test|warm up|cheer up|help|impress|please|entertain|amuse|surprise|thank|honour|honor|greet
       |welcome
        |say (?:thanks|thank you)
        |give (?:them|him|her|us|me|everyone|everybody|people|others|the|my) (?:\w+ )?(?:room|space|time)
        |keep|save|verify|validate|confirm|document|record|inspect|centre|center|straighten|balance|position|capture
        |clear|free up|let|leave|cool down|relax|loosen up|wake up|mark|honou?r|have (?:a|some) fun|face (?:the|my|a|our
        |that|this|his|her)(?! (?:left|right|other|opposite|back|rear|front|same)\b) \w+
        |get (?:a|the|some) (?:better|clearer|closer|full|good|nice|whole|wide|wider|different|new|nicer|cleaner)
        (?:view|look|shot|angle|picture|photo|image|idea|impression)""",
    occasions="""mum|mom|mummy|mommy|dad|daddy|wife|husband|son|daughter|sister|brother|grandma|grandpa|gran|nan|granny
       |family|parents|mother|father|cousin|uncle|aunt|niece|nephew|friend|friends|team|teammates|colleagues|albums
       |crew|guests|customers|clients|client|fans|followers|viewers|subscribers|people|crowd|folks|class|teacher
       |professor
       |blog|website|site|page|channel|vlog|album|newsletter|report|records|archive|archives|file|files|docs
       |documentation
       |logs|logbook|diary|journal|scrapbook|gallery|forum|thread|post|wiki|poster|flyer|brochure|slides|paper|thesis
       |homework|project|study|research|insurance|catalogue|calendar|instagram|insta|facebook|youtube|twitter|reddit
       |tiktok|discord|slack|social media|socials|github|linkedin|whatsapp|fun|laughs|practice|science|luck
       |old times sake
       |(?:closer|better|wider|nicer|good|clear|clearer|full|different|quick|proper|second|new)
        (?:look|view|shot|angle|picture|photo|image)
       |birthday|wedding|party|anniversary|celebration|occasion|holiday|meeting|lesson|lecture|workshop|exhibition
       |open day
       |audience|camera|camera test|class|demo|demonstration|experiment|film|fun|group photo|kids|log
       |measurement|movie|photo|picture|presentation|record|science|show|students|test|video|visitors""",
    meaning={
        "condition": r"""only(?! (?:my|the|our|a)\b)|except|unless|until|instead|rather|enough
           |(?<!is )(?<!are )(?<!'s )(?<!'m )(?<!am )ready|wait(?<!can't wait)(?<!cannot wait)|waits|waiting
           |first(?! (?:time|try|attempt|visit|day|test|trial|run|demo|robot|post|week|ever)\b)|later|tomorrow
           |tonight|yet""",
        "correction": r"""(?<!nothing's )(?<!nothing is )(?<!nothing )wrong|mistake*|misspoke|mix(?:ed)? (?:it |that 
        |them )?up|other way (?:a?round)|backwards|mean
           |means|meant|too (?:far|much|fast|close|long|near|many)|cancel*
           |last one(?! (?:was|is|came out|looked|turned out|looks) (?:\w+ )?(?:blurry|dark|great|good|nice|fun|funny
            |perfect|lovely|fine|cool|amazing|awesome|easy|hard|crooked|grainy|bright|sharp|fuzzy)\b)""",
        "rule": r"""forb[ia]d*|prohibit*|allow*|permi*|ban|bans|banned|limit*|should(?:n't|ve|'ve)?|supposed|ought
           |must (?!be\b|have\b)""",
        "denial": r"""
            (?:don't|doesn't|didn't|do not|does not|did not|not|never) (?:want|need|agree|like|mean|sure|think|care
            |trust|do|go|now|move|moving)
           |(?:is|are|was|were) not(?! (?:so|very|that|really|even|bad|easy|my) )|'(?:s|re) not|i(?:'m
       | am) not (?!\w+ing\b|picky|fussy|in a |an? |from |good|great|very|so|that|even|tired|hungry|alone|much of)
           |(?:is|are|was|were|have|has|wo|ca|would|could)n't(?! (?:wait|believe|complain|tell|imagine|remember
       |resist|sleep|afford|speak|spell|type|cook|sing|swim
            |draw|count|thank|get over|help it|stop laughing|stop smiling|be happier|agree more|been|had)\b)
           |against|vot(?:e|es|ed|ing) (?:no|down|for nothing)|(?:decided|chose|agreed|voted) not
       |cannot(?! (?:wait|believe|complain|imagine|remember|resist|sleep|afford|thank)\b)""",
        "blocked": r"""(?:(?:is|are|was|looks?|'s|'re)(?:n't| not)|ain't|no longer|hardly|barely)
            (?: (?:yet|quite|really|all|that|so|very|entirely|completely))*
            (?:clear|free|safe|empty|open|flat|level|dry)""",
        "objection": r"""i (?:disagree|object|protest|oppose)
            |(?:do not|don't|never) (?:execute|run|perform|carry out|follow|obey) (?:this|that|it|any|the)
            |in theory|theoretically|hypothetically|per (?:day|hour|week|person|minute)""",
        "time": r"""
            (?:once|when|after) (?:that|this|it)(?:'s| is| has been) [a-z]+
           |then [a-z]+|[a-z]+ [&+] [a-z]+|(?:once|when|after|before) [a-z]+ing
           |(?:once|when|after|before) (?:done|finished|you're done|you are done) [a-z]+ing""",
        "another": r"""(?:other|another|different|wrong|second) (?:robot|one|dog|bot|machine|unit|left|right|way|side)
           |too (?:early|late|soon)|(?:bad|terrible|awful|stupid|crazy|risky|silly) (?:idea|plan|move|sign|place
       |time)""",
        "order": r"""commands?|orders?(?<!in order)|posts?(?<!first post)(?<!blog post)(?! about\b| here\b)|example
        |motion|moving|movements?|more|less""",
        "amount": r"""
            (?:(?:centi)?met(?:re|er)s?|(?<!')m|cm|mm|km|ft|feet|foot|inch|inches|yards?|steps?|paces?
            |degrees?)(?! (?:of|long|wide|tall|high|outside|inside|today|in here|celsius)\b)""",
        "request": r"""please|pls|tell|let me|let us|show me|send|report|i'd|we'd|i want|we want|i need|we need|i would
           |we would
           |(?:likes?|loves?) (?:\w+ ){0,2}?(?:to|(?:you|it|the robot|him)(?!$))
           |(?:wants?|needs?|wish*|expects?|asks?|prefers?|requires?|lets?|makes?) (?:\w+ ){0,2}?(?:you|to|it
        |the robot|him)""",
        "demand": r"(?:(?:^|to |and |please |also )(?:tell|let me|let us|show me|send|report))",
        "causative": "(?<!would )(?<!'d )(?<!'ve )have (?:you|it|the robot|him)(?! (?:in|at|on|for|here)\\b)",
        # Within a statement these ask for nothing: "that's where the plant was".
        "question": r"""(?<!\w )(?:what (?!a\b|an\b)|which|who|whom|where|how(?! (?:cool|cute|nice|lovely|great)\b)
        |why|whether)
           |(?:show|tell|see|find|check|know|sure) (?:me |us )?(?:what|which|who|whom|where|how|why|whether)
           |what (?:about|to)|how (?:about|to)|where to|which (?:way|side|direction|one)""",
        "authority": r"""owners?|boss|admin*|manager|police|in charge|(?:your|the) (?:new )?(?:operator|master
        |commander)
           |developer|programmer
           |(?:promised|have|had|got|need) to ask|ask (?:my|our|his|her) \w+ first""",
        "quotation": r"""
            (?:said|says?|wrote|writes?|told|tells?|asked|shouts?|shouted|yells?|yelled|replie[ds]|answers?|answered
            |suggest*|claim*|typed|called)(?! (?:it's|it is|it was|you're so|this is|hi|hello|thanks|thank you
       |goodbye|good)\b)
           |quote*|asking|telling|dream*|story|movie""",
        "speech": r"""(?:said|says?|wrote|writes?|told|tells?|asked|asks|shout(?:s|ed)|yell(?:s|ed)|replie[ds]
        |answer(?:s|ed)
            |suggest(?:s|ed)|typed|called)(?: (?:me|us|him|her|them|everyone|that|to))*$""",
        "jest": "pretend*|kidding|joking|jokes?(?<!no joke)",
        "tampering": "secret*|hack*|password|off|disabled|unplugged|stop*|halt*",
    },
    danger={
        "the way": """ahead|in front|right there|steps?$|stairs?|narrow|tight$|(?:little|no|not much) (?:space|room)
           |(?:will|might|may|could|would|gonna) break|limping|limps?|damaged|injured|upside down
           |edge|wet|oil|oily|icy?|ice|slipp*|spil*|covered|water|fires?|smoke|gas
           |wires?|cables?|broken|crack*|holes?|pits?|steep|glass|hot|burn*|loose|drop|drops|cords?|ropes?|glue*|sticky|tacky
           |varnish*|marbles?|drawing pins?|pins somewhere|nails|puddles?|shards?|strewn|scattered|spread|stretched
           |ankle height|paint tins?|over there|around there|(?:that|this|your) side
           |(?<!first )(?<!second )(?<!third )(?<!ground )(?<!top )(?<!dance )(?<!shop )floor(?:boards?)?""",
        "in the way": r"""
            (?:is|are|'s|'re|sits?|sitting|stands?|standing|lies) (?:\w+ ){0,2}?on the (?:floor|ground|carpet|rug)
           |in (?:the|your) way|on the (?:way|path)|block*""",
        "a place": r"""(?:stand|sit|sleep|nap|doze|play|wait|crouch|kneel|hang|rest|crawl|run|walk|squat|hide|cower)s?
            (?:\w+ ){0,2}?(?:there|here|behind|under|underneath|near|beside|by|next|close|ahead|in|on|at|around|between)
           |[a-z]{3,}s (?:right |just |over )?there$(?<!like there)
           |(?:put|left|set|placed|dropped|parked|stood|laid|hung|threw) (?:\w+ ){1,4}?(?:there|here|around|about|across
            |in the (?:middle|way|hall\w*|corridor|corner|doorway)|by the \w+|near the \w+)""",
        "people": r"""asleep|sleeping|lying|lies|hurts?|blood|barefoot|blind|deaf|afraid|scared|baby|toddler|crawl*
           |i(?:'m| am)(?: \w+)? (?:standing|sitting|lying|kneeling|behind|beside|in front|near|next to|right there)
           |my (?:foot|feet|hands?|legs?|fingers?|kids?|son|daughter|cat|dog) (?:is|are) (?:there|here|in|on|under)
           |coming|approach*|crossing|falling|fall(?! (?:weather|semester|season|break|colou?rs|in love))|falls
        |crash*|fragile|careful*|watch out|beware|mind the|danger*|risk*|safety|sharp
           |knife|knives|weapons?""",
        "the robot's place": r"""
            (?:you're|you are|you were|the robot is) (?:\w+ ){0,3}?(?:on|in|under|at|near|above|against|inside|by
            |over|beside|next|up)""",
    },
    near_robot="""in|on|under|underneath|behind|near|beside|below|above|around|at|by|to|toward|towards|over|against
       |before|between|inside|close to|next to|across|onto|into|round|on top of|in front of|ahead of""",
    light=("condition", "denial", "order", "question", "request", "quotation", "speech", "another", "rule"),
    decisive=("blocked", "objection", "correction", "authority", "causative", "demand", "tampering", "time"),
    doers="""i|we|he|she|they|who|people|kids|everyone|everybody|nobody|can|can't|could|couldn't|will|won't|used to
        |have to|had to""",
    often="always|never|usually|often|sometimes|also|still|really|just|mostly|mainly|all|both|even",
    not_introducing=r"""is|are|was|were|says?|said|wrote|writes?|reads|goes|went|does|did|do|told|asked|this|that|these|it|like|example
       |plan|order|orders|command|commands|rule|rules|means?|post|posted|for|to|as|of|me|us|him|her|them|\w+ed""",
    robot=r"you|yourself|your \w+|the robot",
    unfinished=r"""will|can|could|would|should|must|may|might|cannot|do|does|did|not|going|you|we|i|they|it|he|she|them
       |him|of|in|for|with|at|on|to|from|about|the|my|your|our|a|an|no|just|is|are|was|were|be|been|people|dogs|robots
       |kids|first|second|third|last|next|new|own|same|other|and|or|but|that|than|as|if|when|\w+'s|\w+'m|\w+'re|\w+n't
       |(?!(?:morning|evening|building|ceiling|thing)$)\w+ing""",
    joins_verb="""if|when|once|until|till|before|after|unless|while|since|as|who|that(?!'| [a-z]+$)|which|where
       |what(?!')|how|because|than|or|but|and""",
    governs_verb="""see|sees|saw|seen|watch
       |watches|watched|make|makes|made|let|lets|help|helps|helped|hear|heard|want|wants|wanted|need
       |needs|making|letting|helping|seeing|watching|hearing|wanting|told|tell|tells|say|says|said|ask|asks|asked""",
    never_where="forward|forwards|backward|backwards|back",
    before_noun="""closer|better|wider|nicer|clear|clearer|full|different|quick|proper|the|a|an|my|our|his|her|their|its
       |this|that|is|are|was|were|(?:is|are|was|were|'s) (?:very|still|already)|wide|new|last|next
       |first|second|third|only|own|same|other|favou?rite
       |your|no|any|of|for|at|on|some|good|great|line|folk|tap|barn|square|ballroom|every|each|school|chicken""",
)
