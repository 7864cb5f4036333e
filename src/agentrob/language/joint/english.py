"""How English puts the parts of several robots in order."""

from agentrob.language.joint.parts import JointWords

_DONE = (
    r"(?:(?:is|are|has|have|gets|get|'s|'re|was|were)\s+)?(?:(?:all|both)\s+)?"
    r"(?:done|finished|ready|through|there|arrived|finishes|finish|arrives|arrive|ended|ends|end)"
    r"(?:\s+(?:with\s+)?(?:that|it|moving|walking|turning))?"
)
_WHEN = r"(?:when|once|after|as\s+soon\s+as)"
_NEARER = r"(?:near|clos)(?:er|est)"
#: Nearer to what; a comma or colon must end it, since only the robots' owners know the names of things.
_TO = r"(?:\s+to\s+[a-z][a-z0-9 '-]{0,38}(?=\s*[,:]))?"

WORDS = JointWords(
    then=r"and\s+then|then|after\s+that|after\s+this|after\s+which|afterwards?|next|finally|lastly|subsequently"
    r"|thereafter|once\s+done|when\s+done|when\s+finished|once\s+finished",
    ended_it=rf"{_WHEN}\s+(?:it|that|this|he|she|that\s+robot|the\s+first\s+(?:one|robot))(?:\s+|(?='s)){_DONE}",
    ended_all=rf"{_WHEN}\s+(?:they|both|both\s+of\s+them|all\s+of\s+them|all|everyone|everybody)(?:\s+|(?='re)){_DONE}",
    ended_robot=rf"{_WHEN}\s+R(?:\s+|(?='s)){_DONE}|after\s+R(?=\s*[,.!;]|\s*$)",
    meanwhile=r"meanwhile|in\s+the\s+meantime|at\s+the\s+same\s+time|simultaneously|concurrently|in\s+parallel",
    any_of=r"(?:any\s+|just\s+|only\s+)?one\s+of\s+(?:you(?:\s+two|\s+both|\s+all)?|the\s+robots|the\s+two)|either\s+of\s+you"
    r"|(?:any|either)\s+robot|any\s+of\s+you",
    nearest=rf"(?:whoever|whichever(?:\s+(?:one|robot))?)\s+is\s+(?:the\s+)?{_NEARER}{_TO}"
    rf"|the\s+{_NEARER}\s+(?:one|robot|of\s+you){_TO}|the\s+(?:one|robot)\s+{_NEARER}{_TO}",
    near=r"\sto\s+(?:the\s+|a\s+|an\s+)?(?P<place>\S.*)$",
    free=r"(?:whoever|whichever(?:\s+(?:one|robot))?)\s+(?:is|has)\s+(?:free|time|idle|available)(?:\s+first)?",
    either=r"or",
    leads=r"and|please|let|have|make|ask|tell|now|so|but|also|it's|it\s+is",
    linking=r"please|should|must|to",
    first=r"first",
    greets=r"hi|hello|hey|ok|okay|alright|well|please|everyone|everybody|all|guys|team|robots|both|now|so|good\s+(?:morning|evening|afternoon|day)",
)
