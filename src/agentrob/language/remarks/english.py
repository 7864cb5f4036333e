"""Words of English remarks."""

from __future__ import annotations

from agentrob.language.remarks.words import RemarkWords

_BE = "is|are|was|were|am|isn't|aren't|wasn't|weren't"
_HAVE = "has|have|had"
_PAST = """ate|began|bought|broke|brought|built|came|did|died|drew|drove|fell asleep|felt|flew|forgot|found|gave|got
   |grew|heard|kept|knew|left|lost|made|met|paid|put|ran|sat|saw|sent|shut|slept|sold|spent|stood|swept|taught|thought
   |took|went|won|wore|[a-z]{2,}ed"""
_PRESENT = """believe|believes|deserve|deserves|enjoy|enjoys|feel|feels|hate|hates|hope|hopes|know|knows|like|likes|live
   |lives|look|looks|love|loves|need|needs|seem|seems|smell|smells|sound|sounds|think|thinks|trust|trusts|want|wants
   |work|works"""

WORDS = RemarkWords(
    leads="""ok|okay|so|well|and|but|oh|ah|um|uh|hm|hmm|hey|lol|haha|anyway|alright|by the way|btw|fyi|you know|see|look
       |now""",
    subjects="""the|my|our|his|her|their|your|its|this|that|these|those|a|an|some|all|both|most|every|each|no|any
       |everyone|everybody|everything|nobody|nothing|none|someone|somebody|something|anyone|anybody|anything|no one|i
       |we|he|she|they|it|there|here|today|yesterday|dad|mum|mom|grandma|grandpa|even my|even the|one of us|one of them
       |one of my|one of our""",
    verbs=f"{_BE}|{_HAVE}|{_PAST}|{_PRESENT}|will|would|could|can|might|must|does|[a-z]+'(?:s|re|m|ve|ll)",
    linking=f"{_BE}|looks|seems|has|have",
    bare_subjects="i|we|they|he|she",
    about_robot="you're|you are|you were|you look|you seem|you went|you did|you must be|you must have",
    exclamations="""no joke|no hurry|no rush|no pressure|no stress|no big deal|no doubt|no offence|no offense|what a
       |what an|such a|merry|happy|long live|lovely day|nice day|lovely weather|nice weather|just testing|just curious
       |just checking in|thanks again|thanks for|thank you for|good to see|nice to see|so much fun|purpose
       |background""",
    settings="keep (?:the|your )?(?:obstacle|collision) (?:avoidance|detection|sensors?) (?:on|enabled|active)",
    reasons="so that|because|'?cause|cuz|coz|in order to|so as to",
    reason_subjects=r"i|we|he|she|they|it|nobody|no one|everyone|everybody|people|the \w+|my \w+|our \w+",
    aims="""align|avoid|be|calibrate|celebrate|check|compare|demonstrate|fit|line|make room|measure|practice|practise
        |prove|see|show|test|warm up|get (?:a|the) (?:better|clearer|closer|full|good|nice|whole|wide|wider)""",
    occasions="""audience|camera|camera test|class|demo|demonstration|experiment|film|fun|group photo|kids|log
       |measurement|movie|photo|picture|presentation|record|science|show|students|test|video|visitors""",
    meaning={
        "condition": """only|except|unless|until|instead|rather|ready|enough|wait|waits|waiting|first|later|tomorrow
           |tonight|yet""",
        "correction": """wrong|mistake*|misspoke|mix(?:ed)? (?:it |that |them )?up|other way (?:a?round)|backwards|mean
           |means|meant|too (?:far|much|fast|close|long|near|many)|last one|cancel*""",
        "rule": r"""forb[ia]d*|prohibit*|allow*|permi*|ban|bans|banned|limit*|should*|supposed|ought
           |must (?!be\b|have\b)""",
        "denial": r"""
            (?:don't|doesn't|didn't|do not|does not|did not|not|never) (?:want|need|agree|like|mean|sure|think|care
            |trust|do|go|now|move|moving)
           |(?:is|are|was|were) not|'(?:s|re) not|i(?:'m| am) not (?!\w+ing\b)
           |(?:is|are|was|were|have|has|wo|ca|would|could)n't(?! wait\b| believe\b)|cannot""",
        "time": r"""
            (?:once|when|after) (?:that|this|it)(?:'s| is| has been) [a-z]+
           |then [a-z]+|[a-z]+ [&+] [a-z]+|(?:once|when|after|before) [a-z]+ing
           |(?:once|when|after|before) (?:done|finished|you're done|you are done) [a-z]+ing""",
        "order": r"commands?|orders?(?<!in order)|posts?|example|motion|moving|movements?|more|less",
        "amount": r"""
            (?:(?:centi)?met(?:re|er)s?|(?<!')m|cm|mm|km|ft|feet|foot|inch|inches|yards?|steps?|paces?
            |degrees?)(?! (?:of|long|wide|tall|high|outside|inside|today|in here|celsius)\b)""",
        "request": r"""please|pls|tell|let me|let us|show me|send|report|i'd|we'd|i want|we want|i need|we need|i would
           |we would
           |(?:wants?|needs?|likes?|loves?|wish*|expects?|asks?|prefers?|requires?|lets?|makes?
            |have) (?:\w+ ){0,2}?(?:you|to|it|the robot|him)""",
        "question": r"what (?!a\b|an\b)|which|who|whom|where|how|why|whether",
        "authority": """owners?|boss|admin*|manager|police|in charge|(?:your|the) (?:new )?(?:operator|master|commander)
           |developer|programmer""",
        "quotation": r"""
            (?:said|says?|wrote|writes?|told|tells?|asked|shouts?|shouted|yells?|yelled|replie[ds]|answers?|answered
            |suggest*|claim*|typed?|called)(?! (?:it's|it is|it was|you're so|this is|hi|hello)\b)
           |quote*|pretend*|asking|telling|kidding|joking|jokes?(?<!no joke)|dream*|story|movie""",
        "tampering": "secret*|hack*|password|off|disabled|unplugged|stop*|halt*",
    },
    danger={
        "the way": """ahead|in front|right there|edge|wet|oil|oily|icy?|ice|slipp*|spil*|covered|water|fires?|smoke|gas
           |wires?|cables?|broken|crack*|holes?|pits?|steep|glass|hot|burn*|loose|drop|drops""",
        "in the way": r"""
            (?:is|are|'s|'re|sits?|sitting|stands?|standing|lies) (?:\w+ ){0,2}?on the (?:floor|ground|carpet|rug)
           |in (?:the|your) way|on the (?:way|path)|block*""",
        "people": """asleep|sleeping|lying|lies|hurts?|blood|barefoot|blind|deaf|afraid|scared|baby|toddler|crawl*
           |coming|approach*|crossing|falling|fragile|careful*|watch out|beware|mind the|danger*|risk*|safety|sharp
           |knife|knives|weapons?""",
        "the robot's place": r"""
            (?:you're|you are|you were|the robot is) (?:\w+ ){0,3}?(?:on|in|under|at|near|above|against|inside|by
            |over|beside|next|up)""",
    },
    near_robot="""in|on|under|underneath|behind|near|beside|below|above|around|at|by|to|toward|towards|over|against
       |before|between|inside|close to|next to|across|onto|into|round|on top of|in front of|ahead of""",
    robot=r"you|yourself|your \w+|the robot",
    unfinished=r"""will|can|could|would|should|must|may|might|cannot|do|does|did|not|going|you|we|i|they|it|he|she|them
       |him|of|in|for|with|at|on|to|from|about|the|my|your|our|a|an|no|just|is|are|was|were|be|been|people|dogs|robots
       |kids|and|or|but|that|than|as|if|when|\w+'s|\w+'m|\w+'re|\w+n't
       |(?!(?:morning|evening|building|ceiling|thing)$)\w+ing""",
    governs_verb="""if|when|who|that(?!')|which|where|what(?!')|how|because|than|or|but|and|see|sees|saw|seen|watch
       |watches|watched|make|makes|made|let|lets|help|helps|helped|hear|heard|want|wants|wanted|like|likes|liked|love
       |loves|need|needs|making|letting|helping|seeing|watching|hearing|wanting|told|tell|tells|say|says|said|ask|asks|asked|to""",
    never_where="forward|forwards|backward|backwards|back",
    before_noun="""the|a|an|my|our|his|her|their|its|this|that|is|are|was|were|wide|very|still|already|new|last|next
       |your|no|any|of|for|at|on|some|good|great""",
)
