"""The forms of English talk."""

from __future__ import annotations

from agentrob.language.talk.forms import TalkForms

_LEAD = (
    r"^(?:ok(?:ay)?|everybody|everyone|there|guys|folks|so|well|oh|ah+|hm+|um+|uh+|wow|whoa|hey|hi|hello|lol"
    r"|ha(?:ha)+|haha|yeah|yep|yes|no|nah|man|dude|omg|aww*"
    r"|oops|sorry|thanks|thank you|cheers|please note that|by the way|btw|fyi|anyway|honestly|actually|and|but"
    r"|robot|buddy"
    r"|doggo|good (?:dog|boy|girl|robot))\b[ ,]*"
)
#: Verbs of the mind and the senses: asking whether somebody can do these asks for no action.
_MENTAL = (
    "understand|speak|hear|see|feel|think|remember|know|believe|imagine|guess|recognis?e|recogniz?e|smell|taste|learn"
    "|love|like|dream|sleep|die|theoretically|in theory|hypothetically|ever|really|actually|still|even"
)
_QUESTION = (
    r"(?:what(?! about)|what's|whats|who|who's|whose|whom|which|why(?! (?:don't|not|won't))|how(?! about)|how's"
    r"|where|where's"
    r"|when (?:is|was|are|were|did|do|does|will|can)"
    r"|(?:is|are|was|were|does|did|has|isn't|aren't|wasn't|doesn't|didn't|hasn't|would|should|may|might|could|can)"
    r" (?:i|we|it|he|she|they|this|that|these|those|there|the|a|an|my|our|his|her|your|any\w*|some\w*|every\w*|all"
    r"|[a-z]+'s)\b"
    r"|(?:do|have|had|am|don't|haven't) (?:i|we|they|he|she|people|robots|dogs|any\w*)\b"
    r"|(?:are|were|do|did|have|had|was|don't|didn't|haven't|aren't) (?:you|u|ya)\b(?! able| mind)"
    rf"|(?:can|could|will|would) (?:you|u|ya) (?:{_MENTAL}|be (?:at|in|there|here|available|online)|come to the)\b"
    r"|any(?:one|body) (?!please)|has any(?:one|body)|(?:did|does|has|is|was|will) [a-z]+ (?:ever|always|still"
    r"|already|really)\b)"
)
_PAST = (
    r"(?:took|went|sat|stood|did|made|saw|had|got|ran|came|gave|felt|broke|fell|won|lost|(?!need|speed|feed|proceed"
    r"|indeed)"
    r"[a-z]{2,}[^aeiou\W]ed|tried|moved|waved|rotated|finished)\b(?! me)"
)
_IT = (
    r"(?:it|he|she|they|that|(?:the|that|this|your|my|our) [a-z]+)(?: (?:just|also|really|almost|even|always"
    r"|never|once))?"
)
_GERUND = (
    r"(?:sitting|walking|standing|turning|running|moving|waving|driving|dancing|filming|taking|looking|watching)"
    r"(?: (?!please\b|now\b|then\b|and\b|forward|back|left|right|around|\d|met|feet|degrees)[\w'-]+){0,5} (?:is"
    r"|are|was|were|can|makes?|takes?|hurts?|sounds?|seems?|looks?)\b"
)
_FORUM = (
    r"(?:looking forward to|can't wait|cannot wait|stay tuned|keep up the)\b|back in (?:my|the|those) days?\b|"
    r"(?:moving|closing|locking|merging|pinning|splitting|quoting|editing|bumping|following|deleting|reporting"
    r"|subscribing to) (?:this|the|my|that|your)(?: \w+)? (?:thread|topic|posts?|question|discussion|title"
    r"|reply|message)\b"
)
_WHEN = (
    r"(?:yesterday|last (?:night|week|month|year|time|monday|tuesday|wednesday|thursday|friday|saturday|sunday)"
    r"|earlier|this morning|previously|(?:\d+|a|two|three|few|an?) (?:day|hour|week|minute|month|year)s? ago"
    r"|(?:log|notes?|minutes|report|summary|transcript|results?) (?:of|from|for)\b)"
)
_HUMAN = (
    "mum|mom|mommy|mummy|dad|daddy|grandma|grandpa|granny|honey|darling|sweetheart|babe|sis|bro|son|kids|guys|folks"
)
_SOCIAL = (
    r"(?:what'?s up|wass?up|sup|how'?s it going|howdy|hello|hi|hey|greetings|welcome|cheers|thanks?|thank you|ty"
    r"|thx|congrat\w*"
    r"|(?:so |very )?(?:nice|pleased|good|great|glad|lovely) to (?:meet|see|have) (?:you|u|ya)|bless you|happy \w+"
    r"|merry \w+"
    r"|(?:see|talk to|catch) (?:you|u|ya)\b|take care|bye\b|good ?(?:bye|night|morning|evening|afternoon|day)"
    r"|same here|no worries"
    r"|take your time|love (?:you|u|it|this)|i love|you (?:rock|rule|win|did|were|are)\b|you're\b|u r(?:ock)?\b"
    r"|what an? |so (?:cute|cool|funny)"
    r"|well done|good (?:job|work|dog|boy|girl|robot|bot)|nice (?:one|work|job)|how (?:cute|cool|funny|nice|lovely"
    r"|sweet)"
    r"|long time|much obliged|sweet dreams|sorry\b|rofl|lmao|agreed|indeed|exactly|me too|same\b|true\b|fair enough"
    r"|\+1$|this$|first$"
    r"|(?:so |very |pretty |really |super |quite |the )*(?:best|worst|impressive|amazing|great|nice|cool|cute|funny"
    r"|sweet|lovely"
    r"|awesome|beautiful|interesting|clever|smart|crazy|weird|strange|sad|poor|epic|incredible|fantastic|wonderful"
    r"|brilliant"
    r"|tired|bored|hungry|happy|excited|curious|not (?:bad|sure))\b(?! (?:forward|back\w*|left|right))"
    r"|[a-z]+ (?:died|broke|failed|fell|crashed|froze|works?|worked|looks?|seems?)\b|poor (?:thing|robot|dog)"
    r"|never mind|my bad|my pleasure|(?:both|all|everything|nothing|none|not bad)"
    r"(?: (?:is|are|was|were|looks?))?(?: \w+)?(?: (?:fine|good|ok|okay|great|perfect|bad|wrong|clear))?$)"
)
_THIRD = (
    r"(?:(?:my|our|his|her|their|the|that|this|your|yours|mine|ours|it|he|she)(?: [a-z0-9'-]+){0,4}?"
    r" (?:[a-z]{2,}[^s\W]s|goes|does|passes|has)\b(?! please)(?! photo| picture| image))"
)

FORMS = TalkForms(
    spoken_of=r"^(?:just |now )?(?:picture|imagine) (?:this|that|it)$",
    lead=_LEAD,
    clauses=(
        rf"^(?:{_SOCIAL}|{_QUESTION}|{_THIRD}|{_PAST}|{_IT} {_PAST}|{_FORUM}|i(?:'m|'ll|'d|'ve)?\b|we(?:'re|'ll"
        rf"|'ve)?\b|to \w+ to the )"
    ),
    sentences=(
        rf"^(?:{_QUESTION}.*|{_IT} {_PAST}(?!.*\b(?:now|then|please|next|again and)\b).*|{_GERUND}.*|{_WHEN}.*"
        rf"|(?:{_HUMAN}),? (?:can|could|would|will) you\b.*)"
    ),
    named=(
        r"^(?:(?i:dear |hey |ok |okay )*(?i:admins?|mods?|moderators?|webmaster),? .*"
        r"|[@＠](?!\s)\S+,? (?i:can|could|would|will|do|did|have|are|please|thanks|you|i|what|how|where|when|why"
        r"|who)\b|(?:Hey|Hi|Yo|Hello|OK|Ok),? (?!Robot|Dog)[A-Z][a-z]+,? .*\byour (?!left|right|head|body|paw|hand"
        r"|leg|arm|camera|face|position))"
    ),
    wish=(
        r"\b(?:may i ask|would it be possible|be so kind|(?:ask|want|tell|get|need|like) (?:you|it|the robot) to"
        r"|please|pls|plz|kindly|(?:i|we)(?:'d| would)? (?:want|need|like|wish|expect|order|command|ask"
        r"|require)\b(?! (?:it|this|that|how)\b)"
        r"|i'd (?:like|love)|(?:you|it|robot|everyone|somebody|someone|man|dog) (?:should|must|ought|shall|have to"
        r"|has to|needs? to|better)"
        r"|needs? to be|has to be|must be (?:done|moved|lifted|carried|cleaned|opened|closed)|(?:should"
        r"|must) (?:sing|be|go|come|do)"
        r"|let's|lets|let us|let me know|make sure|be sure|don't forget|remember to|your (?:task|turn|job)|time to"
        r"|why don't you|how about"
        r"|if you)\b"
    ),
    order=(
        r"^(?:then |now |and |please |just |also |next |so |today |quickly |only |but |you can "
        r"|you may )*(?:forward|walk|move|go|come|turn|step|run|sit|stand|wave|take (?!care|your time)|show|send"
        r"|bring|fetch|get|give|look|find|follow|open|close|face|spin|rotate|back|head|climb|jump|dance|sing|clap"
        r"|shake|make|do (?!i\b|we\b|you\b|they\b|it\b|not\b)"
        r"|let|put|pick|push|pull|hit|kick|throw|drop|hold|carry|lift|lead|guide|guard|watch|check|count|tell|say"
        r"|stop|wait|stay|keep"
        r"|start|begin|approach|enter|leave|exit|map|patrol|search|park|use|try|photograph|film|record|drive|crawl"
        r"|creep|charge|ram|chase)\b"
    ),
    topics={
        "joke": (
            r"^(?:(?!\band\b)[^,.;:])*\b(?:tell|know|got|have|give|say|hear"
            r"|crack)\b(?:(?!\band\b)[^,.;:])*\bjokes?(?: \w+){0,3}$"
            r"|^(?:(?!\band\b)[^,.;:])*\b(?:make (?:me|us) laugh|say something funny)(?: \w+){0,3}$"
            r"|^(?:a )?joke(?: please)?$"
        ),
        "see": (
            r"^(?:(?:hey|hi|so|ok|okay|robot|dog|and|now)\W+)*(?:what (?:do|can|are) you (?:see|seeing|looking at)"
            r"|what(?:'s| is) (?:in front of|around|before) you|can you see (?:anything|something)"
            r"|what does it look like there)\b"
            r"(?: (?:now|there|here|right now|in front of you|around you|at the moment|robot|dog|today))*$"
        ),
        "who": (
            r"\b(?:who|what) (?:are|r) (?:you|u)$|\bwho(?:'s| is) (?:this|there)$|what(?:'s| is) your name"
            r"|your name\?*$"
            r"|introduce yourself|who (?:made|built|created|owns) you|are you (?:a|an|really|the|real|some)\b"
            r"|what kind of (?:robot|dog|thing)"
            r"|where (?:do |did )?you come from|where are you from|how old are you|are you (?:male|female|alive"
            r"|human)|tell me about yourself"
        ),
        "language": (
            r"\b(?:do|can) you (?:speak|understand|read|know)\b.*\b[a-z]+(?:ish|ese|man|ian|ench|atin)\b"
            r"|which languages?"
        ),
        "thanks": (r"\b(?:thanks|thank you|thx|ty|cheers|much appreciated|appreciate it)\b"),
        "praise": (
            r"\b(?:good|great|nice|clever|smart|brave|sweet|cute|lovely|best|awesome|amazing|cool|adorable|well) ?"
            r"(?:dog|doggo|boy|girl|robot|bot|job|work|one|done|doggy|pup|puppy)\b|you(?:'re| are| r)? (?:so |the "
            r"|really |very |such an? )*"
            r"(?:amazing|awesome|great|good|cute|cool|best|smart|clever|lovely|adorable|rock|rule|fantastic"
            r"|wonderful|funny)\b|love you"
            r"|you did it|well done|congrat|impressive|bravo|that was (?:great|awesome|cool|amazing|sick|nice|good"
            r"|perfect|brilliant)"
            r"|so cute|how cute"
            r"|(?:^|[,.!;] ?|\b(?:that was an?|what an?|such an?|really|very) )(?:nice|good|great|lovely|cool|sweet"
            r"|amazing|awesome|wonderful|beautiful|perfect|excellent|fantastic|brilliant) (?:waves?|dance|moves?|walk"
            r"|turns?|spin|flip|backflip|sit|stretch|heart|handshake|bow|clap|pose|greeting|gesture|photos?|pictures?"
            r"|pics?|shots?)\b"
        ),
        "bye": (r"\b(?:good ?bye|bye|good ?night|see (?:you|ya|u)|talk to you later|take care|farewell)\b"),
        "greeting": (
            r"^(?:hello|hi|hey|howdy|hiya|greetings|good (?:morning|evening|afternoon|day)|what'?s up|wass?up|sup"
            r"|how'?s it going"
            r"|nice to meet you|pleased to meet you|welcome)\b"
        ),
    },
)
