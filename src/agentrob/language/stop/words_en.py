"""English words of the wide stop rule (law 13), as patterns over one clause in lower case without mentions.

A line end separates alternatives, as `|` does; a line with deeper indentation continues the group that the line before
left open. `while_moving` corrects typing mistakes first, and decides when a word that is found does not count.
"""

# ruff: noqa: SIM905 (tables of words)
from __future__ import annotations

import re


def any_of(lines: str, **parts: str) -> re.Pattern[str]:
    """Compile a pattern that matches one of these lines as whole words; `<name>` stands for `parts[name]`."""
    found = "|".join(line.strip() for line in lines.strip().splitlines())
    for name, part in parts.items():
        found = found.replace(f"<{name}>", f"(?:{part})")
    return re.compile(rf"\b(?:{found})\b")


#: What a robot does and can be told not to do.
_MOTION = (
    "advance|approach|break|budge|bump|carry on|climb|come|coming|continue|crash|cross|do|drive|driving|drop"
    "|enter|execute|fall|follow|get|go|going|hit|hurt|jump|keep|move|moving|proceed|push|run|running|spin"
    "|spinning|start|step|stepping|take|touch|turn|turning|walk|walking"
)
#: What it must not run into, or over.
_THING = (
    "bab(?:y|ies)|bag|bike|bottle|box|boys?|cables?|car|cats?|chair|child|children|cliff|coffee|computer|cord|couch"
    "|cup|curb|desk|dogs?|door|drop|edge|feet|fence|fingers?|foot|girls?|glass|guy|hands?|head|hole|kids?|ladder"
    "|lady|lamp|laptop|ledge|legs?|man|mirror|monitor|obstacles?|people|person|pillar|plant|pole|puddle|pupp(?:y|ies)"
    "|ramp|rope|shelf|sofa|somebody|someone|staircase|stairs?|steps|table|toddlers?|toes?|tv|vase|wall|water"
    "|wheelchair|window|wires?|woman"
)
#: Whom it must not hurt.
_LIVING = (
    "bab(?:y|ies)|boys?|cats?|child|children|daughter|dogs?|girls?|grandma|kids?|kitten|people|person|pupp(?:y|ies)"
    "|somebody|someone|son|toddlers?"
)
#: Parts of people and animals.
_LIMB = "arm|feet|fingers?|foot|hands?|legs?|paws?|tail|toes?"
_HARM = (
    "break|breaking|bump|bumping|burn|burning|collide|colliding|crash|crashes|crashing|crush|crushing|damage"
    "|destroy|drive into|driving into|drop|dropping|explode|fall|falling|falls|flip over|get (?:hurt|stuck)"
    "|go over|going over|hit|hits|hitting|hurt|hurting|injure|kick|kill|knock|knocking|land on|ram|ramming"
    "|roll over|run (?:into|over)|run out of|running (?:into|over)|scrape|slam|slip|slipping|smash|smashing"
    "|squash|step off|step on|stepping on|tip|tipping|topple|toppling|tread on|trip|tripping|tumble"
    "|walk (?:into|off)|walking (?:into|off)"
)

#: Stop words. The context decides whether one is a request, denied, asked about, or a noun.
STOP = any_of(
    """
    stop|stops|stopping|halt|halts|halting|freeze|freezing|brake|brakes|braking|abort|aborting|cease|ceasing|desist
    pause|pausing|estop|e-stop|emergency-stop|standstill
    """
)
#: A stop in other words.
IDIOM = any_of(
    """
    (?:hold|hang) (?:on|up|it(?! (?:for (?:<number>)|high|like|with))|still|your (?:horses|position|ground)|off|fire)
    whoa|quit|quit (?:it|that|moving)|(?:cut|knock|pack) (?:it|that|this) (?:out|off|in)
    kill (?:it|that|this|power|the (?:motors?|power|engine|robot|thing))
    (?:shut|turn|switch|power) (?:it|that|this|him|her|everything|(?:the|that|this) \\w+) (?:down|off)
    (?:shut|power|switch) (?:down|off)|(?:shut|power)down|unplug|pull the plug|cut (?:the )?(?:power|motors?|engine)
    cancel(?:s|ling)?(?! culture)|(?<!i )(?<!we )cancelled|call (?:it|him|her) (?:off|back)|call it a day
    terminat(?:e|ed|ing)|discontinued?|deactivate|disengage|suspend
    interrupt(?! (?:does|handler|routine|request|line))
    (?<!we )(?<!i )(?<!they )(?:don't|do not|never|must not|mustn't|shouldn't|should not|cannot
        please not) (?:you )?(?:dare )?(?:ever )?<motion>
    (?:don't|do not) (?:let|make) (?:it|him|her|the \\w+) <motion>
    no (?:more|further|farther|closer) ?(?:steps?|walking|moving|please)?
    not (?:so fast|any (?:further|farther|closer|more))
    ^(?:please |pls |no |oh |hey )*(?:don't|do not) (?!<fine>)\\w+(?! (?:it|that) again (?:later|tomorrow))
    (?:make|have|having|making|get|keep) (?:it|him|her|the \\w+) (?:to )?(?:not|from) <motion>
    (?:weren't|wasn't|stopped) (?:moving|walking|running)|(?:not|never) <motion> (?:any ?more|another)
    not (?:another|one more) (?:step|inch|meter|metre|centimeter|cm|move)|not (?:that|this) (?:way|direction|side|far)
    not (?:there|like that|into|onto|my|so close|too close)|not the <thing>|not on (?:the|my)|not through the
    still (?:going|moving|walking|running|turning|spinning)(?: on)?$|i said (?:\\w+ )?(?:<number>|stop|halt|no|enough)
    (?:hit|press|push|slam|use|pull|smash|someone hit) (?:the|that|that big) (?:kill|red|big red|emergency)
    (?:stay|stays|staying) (?:where|there|here|put|still|back|away|right|in place|in position|as you|clear)
    remain (?:where|there|still)
    stand (?:still|down|by|there|where|back|fast|your ground|clear)
    keep (?:still|away|back|clear|off|your distance|out)
    (?:back|get|step|move|go) (?:off|away|back off)|get (?:back|down|out)|get (?:it|him|her) (?:off|away|out)|get off
    (?:far|close|that's|that is|that was|it's|it is|had|ok|okay|already|quite|more than|just|say|said
    now) (?:enough|plenty)
    enough (?:already|now|is enough|of|please|thanks|thank you|walking|moving|turning|with)
    that(?:'ll| will) do
    (?<!ms )(?<!second )(?<!seconds )(?<!minute )(?<!a )(?<!the )time[ -]?out(?! of| timer| value| in)|break off
    pull over|^off (?:the|my|our|his|her) \\w+$
    red light(?! green)|let go|give up|down boy|leave (?:it|him|her|me) (?:be|alone|there)
    (?:easy|steady) (?:there|boy|girl|now|does it|tiger|buddy|on)|slow(?:er)? down|slow it down
    (?:take|have) a (?:break|rest)|give it a rest|let it (?:be|rest)|hit the (?:brakes?|breaks?)|slam the
    on second thoughts?|leave (?:the|my|that|his|her|our) (?:\\w+ )?\\w+ (?:alone|be|where)
    put (?:it|that|this|him|her) down
    (?:get|need|call|take|want) a time[ -]?out|(?:standing|sit|sitting) still|can (?:we|you|it) (?:please )?not
    put a pause|it's got (?:my|his|her|our|the)
    drop (?:what|everything|whatever)|(?:ok|okay|just|now|please) park it|(?:a|take) breather
    (?:leave|keep) it (?:where|right)
    never ?mind (?:leave|stay|stop|forget)|forget (?:it|that|about it)|belay (?:that|this|the|my)
    (?:zero|null|no) velocity|velocity (?:to )?zero
    (?:be|get it|get him|get her|want it|wants?|needs?) stopped|put (?:an end|a stop) to
    give (?:me|us) (?:a|one) (?:sec|second|moment|minute|min)
    too (?:far|close|fast|near|quick|dangerous|risky|rough|wild)|hands off|no no|nope nope|(?:nono)+(?:no)?|nah nah
    (?:i'd|i would|we'd|we would) rather (?:you|it|he|she) (?:didn't|did not|don't|wouldn't)
    wrong (?:way|direction|side|robot|room|turn)|do nothing|nobody move|stationary
    i (?:said|meant) (?:no|enough)|come back here|that's (?:as )?far
    """,
    fine=(
        "(?:stop|pause|halt|wait|worry|forget|mind|be|bother|think|know|care|ask|tell|say|hesitate|give|quit"
        "|abort|cancel|freeze|brake|hold|rush|let|listen|get me|need|have|you|listen|want|like|see|understand"
        "|believe|hurry|leave|feel|call|blame|miss|remember|even|cancel|interrupt|break|shut|turn it"
        "|make it stop|slow)\\b"
    ),
    number="one|two|three|four|five|six|seven|eight|nine|ten|\\d+",
    motion=_MOTION,
    thing=_THING,
)
WAIT = any_of("wait")
#: Words before a stop or a warning that do not change it.
_LEAD = (
    "all|alright|and|boy|bro|buddy|dog|dude|everybody|everyone|god|guys|hey|hm+|just|man|no|now|oh|ok|okay|omg"
    "|please|right|robot|so|sorry|uh|um|well|yo"
)
#: A danger that is named.
WARNING = any_of(
    """
    (?:watch|look) (?:out|it|where|your|behind|ahead|in front|yourself)|watch the <thing>|heads? up|heads-up|beware
    caution|warning|mind (?:the|your|my|that|out)|danger|dangerous|dangerously|unsafe|hazard
    (?:not|isn't|no longer|hardly) (?:\\w+ )?safe|safety first|emergency|mayday|sos|911|accident|fire|smoke|smoking
    sparks?|bleeding|blood|injured|screaming|ouch|ow|yikes|uh[ -]?oh|oh no|aargh|argh|aah|eek|holy (?:shit|crap|cow)
    shit
    (?:about|going|gonna|bound|ready|trying|tries) (?:to )?(?:\\w+ )?<harm>
    (?:will|it'll|you'll|he'll|she'll|might|almost|nearly|keeps?|is|are|it's|you're|he's|she's
        they're) (?:\\w+ )?<harm>
    (?:it|you|robot|he|she|dog) (?:hit|hits|bumped|crashed|fell|falls|tips|broke|knocked|ran|stepped|drops|dropped)
    (?:hit|bumped|crashed|ran|fell|stepped|knocked|smashed|broke|crushed) (?:\\w+ )?(?:me|my|into|over|someone
    somebody|him|her)
    (?:going|goes|heading|heads|walking|walks|running|rolling|sliding|leaning
        driving) (?:right |straight )?(?:off|over|towards?|for|into) the (?:<thing>|\\w+ (?:stairs|edge))
    it's (?:going|heading) (?:for|into|at) (?:the|my|a)|dragging|tangled|wobbl\\w+|teetering|caught (?:on|in)
    (?:is|are|got|gets|it's|i'm|you're) (?:\\w+ )?(?:caught|trapped|jammed|pinned|pinched|wedged)|limping|staggering
    smell\\w* (?:\\w+ ){0,2}(?:burn\\w*|smoke|gas)|burn(?:t|ing) smell|code red|oops|whoops
    (?:making|makes|made|hear) (?:a |an |some )?(?:weird|strange|odd|horrible|awful|bad|grinding) (?:noise|sound)s?
    (?:it|he|she|robot|dog|you|thing) (?:doesn't|don't|won't|isn't|aren't|does not|is not) (?:listen|respond|obey)\\w*
    chewing|knocked over
    falling|tipping over|tripping over|collision|toppling|crashing
    (?:there's|there is|there are|i see|it's|is|are) (?:\\w+ ){0,3}<thing> (?:\\w+ )?<where>
    (?:<thing>|something)(?:'s)? (?:is |are |just |right )*<where>
    ^(?:(?:<lead>) )*(?:there's|there is|there are|i see|here comes?) (?:\\w+ ){0,2}<thing>(?: (?:here|there|now|too))*$
    (?:<living>)(?:'s| is| are) (?:\\w+ ){0,2}(?:there|here|inside|close|nearby)
    (?:you're|you are|it's|it is|is|standing) (?:\\w+ )?on (?:my|his|her|our|their|someone's|the \\w+'s) <limb>
    in (?:the|its|your|his|her|my|our) (?:way|path)|(?:behind|in front of|right next to) you
    out of control|off course|(?:gone|going|went|goes) (?:crazy|mad|wild|haywire|berserk)|malfunction\\w*|haywire
    (?:is|got|it's|am|i'm|gets) stuck|it hurts|hurts|hurting|(?:somebody|someone|please|god) help
    help (?:me|us|him|her|it|someone|somebody|now|please)|call (?:an ambulance|911|112|security)
    panic|scared|afraid|scary|scares|scaring|frighten\\w*|terrif\\w+|slippery|wet floor|floor is wet|broken glass
    let me (?:out|go|pass)|(?:floor|rug|carpet|table) (?:is|ends|gives)
    """,
    harm=_HARM,
    thing=_THING,
    living=_LIVING,
    limb=_LIMB,
    lead=_LEAD,
    where=("in front|on the|behind|ahead|under|near|next to|coming|crossing|beside|running|walking|in the way|lying"),
)
#: A warning, but praise of one that is.
CAREFUL = any_of("careful|cautious")
#: Clauses that are a stop when they are nothing else.
_TAIL = (
    "a bit|a sec|already|asap|boy|bro|buddy|dog|dude|everybody|everyone|for now|girl|guys|here|immediately|it"
    "|man|no|now|omg|please|quick|quickly|right now|robot|thank you|thanks|then|there|you"
)
_BY_ITSELF = (
    "back|bad dog|bad idea|bad robot|break|breaks|calm down|cancelled|chill|danger|do not|don't|down|drop it"
    "|easy|end|end it|enough|finish|hang|heel|hold|(?:just )?(?:one|a|1) (?:sec|second|moment|minute|min)"
    "|kill ?switch|leave it|nah|no|no way|nope|not good|not now|not yet|off|oi(?: oi)*|relax|rest|retreat"
    "|settle down|slow|slowly|stand|stay|steady|stopped|that's all|timeout|undo|wrong|yield"
)
WHOLE = re.compile(rf"(?:(?:{_LEAD}) )*(?:{_BY_ITSELF})(?: (?:{_TAIL}))*")
#: A scream.
SCREAM = re.compile(r"\b(?:a{3,}h*|a+h{3,}|a+r+g+h*|e{2,}k+|i{3,}h*)\b")
#: The same, where somebody shouts it: "my foot!", "HELP".
SHOUTED = re.compile(
    rf"(?:(?:{_LEAD}) )*(?:help|(?:the|my|your|our|his|her|that|a|watch) (?:\w+ )?(?:{_THING})"
    rf"|{_THING})(?: (?:{_TAIL}))*"
)
#: What is said again and again is shouted: "the edge the edge the edge".
REPEATED = re.compile(r"(.{2,40}?)(?: \1)+")

# ---------------------------------------------------------------------- when it does not count
#: The word is a thing: "the bus stop", "the stop button".
NOUN = any_of(
    r"""
    (?:bus|tram|train|metro|subway|truck|pit|rest|next|last|first|second|final|door|taxi) (?:stops?|halt)
    (?:non|one|bus|tram)-stop|non ?stop
    (?:the|a|each|every|which|any|another|my|our|this|that|its|an) (?:<kind> )?(?:stops?|halt|pause|brakes?
        freeze|e-?stop)
    stop[ -]motion|freeze[ -]frame|(?:regenerative|disc|hydraulic|good|bad|its) brakes|brakes (?:would|are|were)
    (?:sudden|abrupt|nice|good|great|perfect|clean|smooth|lovely|short) (?:stops?|halt|pause|brakes?)
    (?:stop|brake|pause|abort|halt|wait|cancel)[ -](?:signs?|buttons?|lights?|watch|words?|pads?|pedals?|keys?
        marks?|bars?|points?|positions?)
    (?:stop|brake|pause|abort|halt|cancel)[ -](?:distances?|functions?|features?|commands?|times?|lines?|posts?
        rules?|modes?|states?)
    (?:halting|stopping) (?:states?|problems?|points?|conditions?|criteri\w+)|freeze[ -]dr\w+|early stopping
    (?:code|pip|hiring|budget|feature|deep) freeze|docker stop|category \w+ stop|heart-stopping
    call(?:ing|s|ed)? abort|freezing (?:cold|weather|rain|here|point|outside)|(?:hard|mechanical|end) stops?
    full stops? (?:is|are|means?)
    stopping distances?|one stop
    """,
    kind=(
        "next|last|first|second|final|emergency|soft|hard|full|whole|new|old|red|big|wireless|physical|software"
        "|hardware|remote|other|same|cool|sudden"
    ),
)
#: … but here the thing is the wish: "come to a stop", "hit the brakes".
COME_TO = any_of(
    r"""
    (?:to|make|into|bring|bring it|need|want|take|have|hit|use|pull|press|push
    apply) (?:it )?(?:to )?<a> (?:<how> )?<stop>
    """,
    how=(
        "full|complete|sudden|quick|immediate|hard|dead|proper|total|gentle|smooth|slow|screeching|emergency"
        "|hand|bloody|damn"
    ),
    a="a|an|the|your",
    stop=(
        "(?:stop|halt|standstill|pause|brakes?|handbrake|break|e-?stop)(?! (?:signs?|buttons?|marks?|lines?"
        "|lights?|states?|modes?|function))"
    ),
)
#: Right before the word, at most these beside it: it is denied.
DENIED = re.compile(
    r"\b(?:don't|do not|never|no need(?: for (?:you|it))? to|needn't|need not|not to|without|(?:i|we) wouldn't"
    r"|no reason to|(?:don't|doesn't|do not|not) (?:have|need|want(?:ed)? (?:it|you)) to|mustn't|must not"
    r"|shouldn't|should not|not|can't|cannot|couldn't|can not|didn't|hasn't|doesn't|instead of"
    r"|(?:never|didn't|did not) say|never said"
    r"|(?:nobody|no one) (?:asked|wanted|told|wants|said)(?: for)?(?: it| you| him| her)?(?: to)?"
    r"|nobody|no one|noone|won't|(?:shame|pity|silly|stupid|sad|too (?:early|soon)|sin|waste) to)"
    r"(?: (?:you|it|him|her|dare|ever|even|please|yet|now|just|let|make|want|to|think|about|be|suddenly|say"
    r"|there))*\s*$"
)
#: It does not stop, or cannot be stopped: a cry, no denial. With people's laughter it is neither.
CRY = any_of(
    r"""
    (?:can't|cannot|couldn't|doesn't|didn't|won't|isn't|hasn't|(?:can|does|is|will|did) not) (?:\w+ )?(?:stop
    stopping|halt|brake)
    """
)
SMILE = any_of(r"(?:can't|cannot|couldn't) stop (?:myself )?\w+ing")
#: "It stops at walls" tells what it does.
HABIT = re.compile(
    r"(?<!it )(?<!you )(?<!he )(?<!she )\bwould (?:stop|halt|abort|freeze|pause)$|"
    r"\b(?:until|till|when|once|unless) (?:i|we|somebody|someone|they|he|she) (?:say|says|tell|tells|ask|asks"
    r"|give|gives)(?: \w+){0,2}(?: to)? (?:stop|halt|pause|freeze)$|"
    r"\b(?:it|he|she|robot|dog|watchdog|system|controller|firmware|software|guard|driver|button|timer|code|that"
    r"|who|which|always|usually|never|only|then|and|really|often|music|one|sometimes) stops$"
)
PRAISE = any_of(
    r"""
    (?:thanks|thank you|nice|good|great|love|loved|like|liked|impressive|amazing|glad|happy) .{0,40}<done>
    (?:so|very|how|really|pretty|quite|super|is|it's|was|are|looks|extremely|being|such a) (?:\w+ )?(?:careful
        cautious)
    """,
    done="stopping|stops|brakes|braking|careful|cautious|pausing",
)
#: People wait themselves.
SELF_WAIT = any_of(
    r"""
    (?:can't|cannot|couldn't|can not|hardly|barely) wait|(?:i|we|i'll|we'll|they|people|who|i'd|let's) (?:\w+ )?wait
    (?:worth the|long|the|a|minute|hour|needn't|not|asyncio) wait|(?:don't|do not|never|not|always) wait
    (?:did|does|do) (?:\w+ )?wait
    (?:have|had|has|used) to wait|wait (?:times?|list)
    wait (?:till|until) (?:you|they|he|she|everyone|people|my \w+|the \w+) (?:sees?|hears?|finds?|gets?
        tr(?:y|ies))
    """
)
PAST = any_of(
    r"""
    (?<!like )yesterday|last (?:time|week|night|run|round|month|year|try|demo)|earlier|ago|previously
    the other day|this morning
    in the (?:video|demo|film|movie)|used to|back then|first time|(?:i|we|he|she|they|it) had to
    on (?:monday|tuesday|wednesday|thursday|friday|saturday|sunday)
    """
)
#: A warning that is denied: "it won't fall".
NO_WARNING = any_of(
    r"""
    (?:won't|not|never|didn't|doesn't|don't|without|no|isn't|hasn't|can't|couldn't|wouldn't) (?:\w+ ){0,3}<harm>
    (?:no|not|isn't|without|any|never|how|is it|is that|is this) (?:\w+ )?<danger>
    (?:nobody(?:'s)?|no one(?:'s)?|nothing(?:'s)?|not|isn't|aren't) (?:\w+ ){0,2}in (?:the|its|your|his|her|my
        our) (?:way|path)
    (?:fire|emergency) (?:exit|door|engine)|(?:stopped|quit|no|gave up) smoking
    (?:smoking|crash|fire|blood|emergency) (?:hot|test|tests|course|truck|type|area|exit|contact|number)
    (?:love|like|nice|cool|great) .{0,30}<harm>|fall (?:asleep|in love|for|season|term|semester)
    falling (?:asleep|in love)
    no (?:\w+ )?<thing>
    i'm not (?:scared|afraid)|not (?:scared|afraid|scary)|don't be (?:scared|afraid)
    (?:hits?|hitting) (?:the spot|different)
    """,
    harm=_HARM + "|hurt|fell|stuck|falling|fire|smoke",
    thing=_THING,
    danger="danger|dangerous|hazard|risk|accident|emergency",
)
_FILLED = (
    "also|and|any idea|anyone know|anyway|btw|but|can someone (?:explain|tell me)|can you tell me"
    "|could you tell me|curious|do you know|does anyone know|dog|excuse me|explain|guys|hello|hey|hi|hm+"
    "|i want to know|i was wondering|i wonder|i'd like to know|idk|just|just curious|let's see|not sure|oh|ok"
    "|okay|please|question|quick question|robot|so|sorry|tell me|uh|um|wondering|wow"
)
#: A question begins so …
QUESTION = re.compile(
    rf"^(?:(?:{_FILLED}) )*(?:(?P<wh>why|why's|how|how's|when|where|where's|what|what's|who|who's|whose|which|if"
    rf"|whether)"
    r"|(?P<aux>did|can (?:a|an)|didn't|does|do (?=you|we|they|i|robots|these|those|all)|was|were|has|have|had"
    r"|can (?:it|he|she|this|that|the|i|we|people|anyone|robots)"
    r"|could (?:it|he|she|this|that|the|i)|should i|may i|am i|doesn't)"
    r"|(?P<be>is|are|will (?:it|he|she|this|that|the)|would (?:it|he|she|this|that|the|a)|isn't))\b"
)
#: … and these are wishes, or cries, in the shape of one.
ASKED = any_of(
    r"""
    (?:why|when) (?:don't|do not|won't|doesn't|isn't|aren't|can't|wouldn't)|(?:how|what) about
    (?:why|how) (?:is|are|does|do|did|has) (?:it|he|she|you|this|that|the \w+) (?:still |just )?(?:not|still)
    can (?:someone|somebody|anyone|we|you)|(?:will|would|could) (?:you|we|someone|somebody|anyone)|do you mind
    when (?:will|are|do) you|what the (?:hell|heck|fuck)|isn't that|is there (?:a|any) way|have a (?:break|rest)
    """
)
#: The word right before the stop in a real question; "what are you doing stop" is none.
GOVERNS = frozenset(
    """
    it you i we they he she to robot dog this that one thing machine humanoid quadruped him her them suddenly just
    really always ever even actually automatically never not did does do would will can could should must the a
    press emergency immediately early there so push call use anything robots everything usually mean manually still
    write wrote typed reply answer post send writing typing saying
    remotely sometimes normally properly sudden quickly gently say said type post safely by of for on before
    gradually after when is was were are been being got again only fully or and about with its first go
    """.split()
)

# ---------------------------------------------------------------------- slips
#: Words that typing mistakes are corrected to, and similar words that must not be corrected.
MEANT = "stop halt freeze brake wait pause abort careful danger enough whoa hold stopping cancel watch emergency crash"
OTHERS = frozenset(
    """
    abode aborts about alt anger apart art atop await awaits awake bail bait bait's bake bat batch best bet bold
    bort brace brae braked braker brakes brash brave break breaks breeze brisk broke broken cancels cancer candle
    carefully carful cash cast catch cause clash cold crashes crass crop crops crush dagger danger's dangers date
    drake drop drops eight emergence enoch fail fast flop fold freed frees freezer freezes frieze gait ganger gate
    gold haft hail hale half hall halo halter halts hand hang hanger hart hast haste hat hatch hath hats haul hauled
    hay heart heat height held hilt hint hoa hod holds hole holed holt holy hood hop hoped hoping hops hunt hurt
    jail last latch late light mail malt manger match mold nail nurse pail parse pass past patch path patse paused
    pauses paws pays phase plop poise pop port pose post posts prop props pulse purse rail rake ranger rash rest
    right sail salt salute scoop setup shaft shalt shop shopping shops shot sight slop slot snoop sold sop spoon
    spot spots spout stag stamp star stat stay step step's stepping steps sto stock stoke stole stomp stone stood
    stooping stopover stopped stopper stops store story stoup stout stow strap strip stripe strop stub stump swatch
    swoop tail though told top topic topping tops tough trap trash vast wade wage waif wail wain waist waite waits
    wake walt want wants wart wash wast waste wat watched watches water watt watts wave waved waves weight wet what
    whit white wiat's wick wide wild wise wit witch wits woah
    """.split()
)
SLANG = {
    "cant": "can't", "carefull": "careful", "damn": "god", "didnt": "didn't", "doesnt": "doesn't", "dont": "don't",
    "dun": "don't", "dunt": "don't", "emergancy": "emergency", "enuf": "enough", "enuff": "enough", "frz": "freeze",
    "gie": "give", "gimme": "give me", "goddamn": "god", "goin": "going", "gona": "gonna", "gonnae": "gonna",
    "hangon": "hang on", "haud": "hold", "hepl": "help", "hlep": "help", "hlt": "halt", "hol": "hold",
    "holdit": "hold it", "holdon": "hold on", "holdup": "hold up", "hollup": "hold up", "holup": "hold up",
    "im": "i'm", "isnt": "isn't", "its": "it's", "lookout": "look out", "mustnt": "mustn't", "nono": "no no",
    "nonono": "no no", "noo": "no", "nuff": "enough", "pleasestop": "stop", "pls": "please", "plss": "please",
    "plz": "please", "plzstop": "stop", "shouldnt": "shouldn't", "shtop": "stop", "stahp": "stop", "stap": "stop",
    "staph": "stop", "stawp": "stop", "sthap": "stop", "stob": "stop", "stopit": "stop it", "stopnow": "stop now",
    "stoppit": "stop it", "stopplease": "stop", "stopstop": "stop", "stopstopstop": "stop", "stp": "stop",
    "thats": "that's", "theres": "there's", "u": "you", "ur": "your", "w8": "wait", "waitwait": "wait",
    "watchout": "watch out", "wen": "when", "whoah": "whoa", "wo": "whoa", "woah": "whoa", "woh": "whoa",
    "wont": "won't", "yer": "your", "youre": "you're",
}  # fmt: skip
#: Chinese stops in Latin letters, typed in a hurry.
PINYIN = any_of(
    r"""
    ting|ting ?xia(?: ?lai)?|ting ?zhi|ting ?zhu|zan ?ting|zhan ?zhu|bie ?(?:dong|zou|pao)|bu ?yao ?(?:dong|zou)
    kuai ?ting
    deng ?(?:deng|yi ?xia|yi ?deng)|xiao ?xin|wei ?xian|sha ?che|ji ?ting|jiu ?ming|man ?zhe|zhu ?shou|gou ?le
    dang ?xin
    """
)
PINYIN_DENIED = re.compile(r"\b(?:bie|bu ?yao|bu|mei|bu ?yong|wei ?shen ?me|zen ?me)(?: \w+)? ?ting\b")
