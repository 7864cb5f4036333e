"""English idioms in plain words: what a table of phrases cannot hold, since a part of it varies.

Each entry is a pattern and what it means in the words of the table. They apply only to posts that are not understood as
they stand, and the plain words are understood by the same grammar, which asks about all that it does not know.
"""

from __future__ import annotations

_WHOM = r"((?!(?:me|us|it|sure|certain|a|an|one|another|\d)\b)[a-z][a-z'-]*(?: [a-z][a-z'-]*){0,3}?)"
_KINDLY = "big|little|nice|nice big|quick|friendly|warm|good|great|lovely|huge|firm"
_PICTURE = "photo|picture|pic|image|shot|snapshot|photograph"
_GESTURE = "wave|heart|backflip|flip|clap|handshake|stretch|sit"
_NUMBER = (
    r"(?:\d+|one|two|three|four|five|six|seven|eight|nine|ten|eleven|twelve|fifteen|twenty|thirty|forty|fifty|sixty"
    r"|seventy|eighty|ninety|hundred)"
)
#: Where a clause begins; group 1 is what stands there.
_BEGIN = (
    r"(^\s*|[,.;:!?]\s*|\b(?:and|then|so|but|ok|okay|alright|well|now|hey|hi|hello|uh|um|please|robot|doggo|buddy)\s+)"
)
_END = r"(?=\s*(?:$|[,.;:!?]|\b(?:and|then|please|pls|plz|thanks|thank)\b))"
_AHEAD = "forward|forwards|backward|backwards"
_A_TURN = r"(?:an?|another|one|the) (?:[\w-]+ ){0,4}?(?:turn|rotation|spin|about face|u turn)\b"
_FINE = "quick|clear|nice|good|better|sharp|wide|final|last|fresh|full|detailed|proper|simple|decent|great|close up"
_LIVE = "current|live|front|camera|clear|quick|better|fresh|updated"
_TASK = (
    r"(?:so |now |okay )?(?:what (?:i|we)(?:'d like| would like| want| need) you to do(?: now| next| here)?"
    r"|what (?:i|we) (?:want|need)(?: now| next)?|your (?:next |first |new )?(?:job|task|mission|move|step"
    r"|order|instruction)"
    r"|the (?:next|first|new) (?:thing|step|task|move|instruction|order|action))"
)
_VIEW = "view|feed|frame|scene|capture|screenshot|camera feed|visual"
_ANEW = r"(?:sorry|oops|whoops|my mistake|my bad|no|no wait|wait|wait no|actually|uh|er)"
_ANGLE = rf"{_NUMBER}(?:[ -]{_NUMBER})* degrees?"
_TENS = r"(?:[1-9]0|ten|twenty|thirty|forty|fifty|sixty|seventy|eighty|ninety)"
_WHOLE = "(?:full|whole|complete|entire)"
_CIRCLE = "(?:circle|turn|rotation|spin|revolution|twirl|loop)"
_CLOCKWISE = "(?:to the |to your )?(?:clockwise|anti ?clockwise|counter ?clockwise)"
_OTHER_WAY = r"(?:the )?other (?:way|direction|side)"
#: Hours of a clock face that a robot can turn to; twelve is ahead.
_HOURS = ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven")


def _clock() -> tuple[tuple[str, str], ...]:
    """ "Turn to your three o'clock" is a turn of 90° to the right; "at three o'clock" is a time."""
    found = []
    for hour, word in enumerate(_HOURS, 1):
        side, degrees = ("right", hour * 30) if hour <= 6 else ("left", 360 - hour * 30)
        plain = "turn around" if degrees == 180 else f"turn {side} {degrees} degrees"
        found.append(
            (
                rf"\b(?:(?:turn|rotate|spin|pivot|swing|swivel|look)(?: around| round)? (?:to|towards?)|face)"
                rf"(?: your| the| my)? (?:{hour}|{word}) ?o'? ?clock(?: position| direction)?\b",
                plain,
            )
        )
    return tuple(found)


#: A length, and where one is said of the sides of a square.
_LENGTH = (
    rf"(?:{_NUMBER}|\d*\.\d+|\d+\.\d+|half an?|an?)(?: and a half)? ?-?"
    r"(?:m|cm|met(?:er|re)s?|centimet(?:er|re)s?|ft|feet|foot)"
)
_A_SIDE = r"(?:sides?|side lengths?|edges?|edge lengths?|legs?)"


def _routines() -> tuple[tuple[str, str], ...]:
    """Sizes and counts of routines that stand elsewhere than behind their names: "walk a 1 m square"."""
    walk = r"\b(?:walk|do|make|drive|trace|go|move|trot)(?: in)? "
    return (
        (rf"{walk}an? ({_LENGTH}) (?:by|x) \1 square\b", r"walk a square of \1"),
        (rf"{walk}an? ({_LENGTH}) square\b", r"walk a square of \1"),
        (rf"{walk}an? ({_LENGTH}) circle\b", r"walk a circle of \1"),
        (rf"(\bsquare),? (?:with|of) (?:an? |each )?{_A_SIDE} (?:of |is |being )?(?={_LENGTH})", r"\1 of "),
        (rf"(\bsquare)(?: of|,| with)? ({_LENGTH}) (?:sides|a side|per side|each side|on each side)\b", r"\1 of \2"),
        (rf"(\bcircle),? (?:with|of) an? diameter (?:of )?(?={_LENGTH})", r"\1 of "),
        (rf"{walk}a circle,? (?:with|of) an? radius (?:of )?(?={_LENGTH})", "walk a circle with a radius of "),
        (rf"(\b(?:circle|square) of {_LENGTH}) across\b", r"\1"),
        (rf"\bpatrol ({_NUMBER}) (?:laps?|rounds?|loops?)\b", r"patrol \1 times"),
        (r"\bpatrol (?:for )?(?:a|one) (?:lap|round|loop)\b", "patrol once"),
    )


IDIOMS: tuple[tuple[str, str], ...] = (
    *_routines(),
    (rf"\bgive {_WHOM} an? (?:{_KINDLY} )?wave\b", r"wave to \1"),
    (rf"\bgive {_WHOM} an? (?:{_KINDLY} )?(?:clap|round of applause|hand)\b", r"clap for \1"),
    (rf"\b(?:give|show|send|make) {_WHOM} (?:a|your) (?:{_KINDLY} )?heart\b", r"make a heart for \1"),
    (rf"\bgive {_WHOM} (?:an?|your) (?:{_KINDLY} )?(?:handshake|paw|hand)\b", r"shake hands with \1"),
    (rf"\b(?:take|snap|send|get) {_WHOM} an? (?:{_KINDLY} )?(photo|picture|pic|shot)\b", r"take a \2 for \1"),
    # ---------------------------------------------------------------- amounts
    *_clock(),
    (rf"{_BEGIN}(?:mm+|mhmm+|hmm+|huh|er+m?|eh)[,.]? (?=[a-z])", r"\1"),
    (rf"\b{_WHOLE} (?={_NUMBER}[\w -]* degrees?\b)", ""),
    (
        rf"\b(turn|swing|spin|rotate|pivot) (?:all the way|completely|fully|right) (?:around|round) "
        rf"(?=to (?:the|your) (?:left|right),? (?:by |about |an? )?{_NUMBER})",
        r"\1 ",
    ),
    (r"\b(degrees?) back (?=to (?:the|your) (?:left|right)\b)", r"\1 "),
    (
        rf"{_BEGIN}(?:adjust|correct|align)(?: yourself)? (?=(?:by |about |another )?{_ANGLE}\b)",
        r"\1turn ",
    ),
    (rf"\bturn (left|right) around (?={_NUMBER})", r"turn \1 about "),
    (r"\b(?:l|lt)-?(\d{2,3})\b(?! ?(?:m|cm|mm|ft|feet|foot|met|in|inch|sec|s|step))", r"turn left \1 degrees"),
    (r"\b(?:r|rt)-?(\d{2,3})\b(?! ?(?:m|cm|mm|ft|feet|foot|met|in|inch|sec|s|step))", r"turn right \1 degrees"),
    (r"(?<=[\w ])\s+x ?([2-9])\b", r" \1 times"),
    (
        rf"{_BEGIN}((?:\d|two|three|four|five) (?:more )?(?:photos|pictures|pics|images|shots|snapshots)\b)",
        r"\1take \2",
    ),
    (rf"\bthere and back[:,]? ({_NUMBER} \w+)", r"walk \1 and come back"),
    (rf"\b((?:go|walk|move)) there and back[:,]? ({_NUMBER} \w+)", r"walk \1 and come back"),
    (r"\b(\d+ ?(?:deg|degrees|degree|°)) l\b(?!')", r"\1 left"),
    (r"\b(\d+ ?(?:deg|degrees|degree|°)) r\b(?!')", r"\1 right"),
    (r"\brt (?=\d)", "right "),
    (
        rf"\b(turn|swing|spin|rotate|pivot) (?:around|round) (to (?:the|your) (?:left|right)),? "
        rf"(?=(?:by |about )?{_NUMBER}[\w -]* degrees?\b)",
        r"\1 \2 ",
    ),
    (r"\byoure\b", "you're"),
    (r"\bur\b", "your"),
    (r"\bfotos?\b|\bfotograph\b", "photo"),
    (r"\b(?:tiny|teeny|wee|slight) (?=turn|left|right|step|bit of a turn|wave|move)", ""),
    # ---------------------------------------------------------------- remarks without a verb
    (
        r"(?<=\w),? no (obstacles?|obstructions?|people|persons?|pets?|furniture) "
        r"(ahead(?: of you)?|in (?:the|your) way|around|nearby|in front of you)(?=\s*(?:$|[.!]))",
        r", there are no \1 \2",
    ),
    # ---------------------------------------------------------------- one more of the same
    (r"\b(?:take|have|get|give me|grab) another (?:look|peek|glance)\b", "take a photo"),
    (
        rf"^(.*\b(?:{_PICTURE})s?\b.*?\b(?:take|snap|grab|send|get|shoot)) "
        rf"(?:it again|(?:another|one more|a second|a new|the next)(?: one)?|one again){_END}",
        r"\1 another photo",
    ),
    (r"\b(sit|stand|wave|stay|backflip),? (?:boy|girl|doggy|doggo),? \1\b", r"\1"),
    # ---------------------------------------------------------------- corrections
    (rf"\b({_ANEW}),? {_OTHER_WAY},? (?=(?:turn |rotate |go )?(?:left|right)\b)", r"\1 "),
    (rf"\bleft\b((?:(?!\bright\b)[^,.;!?])*)[,.;!?—-]+ ?(?:{_ANEW},? )+{_OTHER_WAY}{_END}", r"right\1"),
    (rf"\bright\b((?:(?!\bleft\b)[^,.;!?])*)[,.;!?—-]+ ?(?:{_ANEW},? )+{_OTHER_WAY}{_END}", r"left\1"),
    (r"^\s*i (?:said|wrote|typed) (\w+),? but (?:i )?meant (\w+)[:;,. ]+(?=.*\b\2\b)", ""),
    (rf"(?<=\w),? sorry,? (?=(?:{_NUMBER}|left|right|forwards?|backwards?|back)\b)", " i mean "),
    (r"\bturn (?:ri|rig|righ|r|le|lef|l) (?=(?:uh |um |er )?turn (?:to the )?(?:left|right)\b)", ""),
    (r"\bi (?:don't|dont|do not) (?:want|need) you to (.+?),? (?:but )?i (?:want|need) you to ", r"don't \1, "),
    (
        rf"^\s*(?:rather than|instead of) (?:an? |the |another )?((?:{_PICTURE}|{_GESTURE})),? ?",
        r"don't \1, ",
    ),
    (rf"\b(?:rather than|instead of) (?:an? |the |another )?((?:{_PICTURE}|{_GESTURE}))$", r", don't \1"),
    # ---------------------------------------------------------------- order
    (r"^\s*(?:after|following|having done) an? (.{3,30}?) (?:turn|rotation),? (?=\w)", r"turn \1, then "),
    (r"^([^,]+?) (?:after|following) an? ([^,]{3,30}?) (?:turn|rotation)$", r"turn \2, then \1"),
    (r"^\s*(?:start|begin) with (.+?)[, ]+(?:and |then |and then )*(?:end|finish) with (.+)$", r"please \1, then \2"),
    (
        r"^\s*(?:(?:my |our |a |the |new )*(?:request|task|mission|job|order|instructions?|assignment|challenge)"
        r"(?: (?:for|of) (?:today|tonight|the day|you|now))?|here(?:'s| is) (?:what (?:i|we) (?:want|need|would like)"
        r"(?: you to do)?|your (?:task|job|mission)))\s*:\s*",
        "please ",
    ),
    (r"^\s*(?:let's |we'll |please )?(?:start|begin|kick|lead)(?: off| out)? (?:with|by) ", "please "),
    (
        r"(?<=[,.;!]) *(?:please )?(?:end|finish|clos|conclud)(?:e|ing)?(?: up| off)? (?:with|by) (?=[^,.;!]*$)",
        " then ",
    ),
    (r"\b(?:and|then|and then) (?:end|finish)(?: up| off)? with\b", "then"),
    (r"\bhaving (turned|moved|walked|gone|stepped|backed)\b", r"once you've \1"),
    (r",? followed by (?=an? |the |\d|your )", ", then "),
    (
        r"[,.]? (?:and )?(?:that'll|that will|that would|that'd) be (?:it|all)(?: for now| thanks)?(?=[.!]*$)",
        "",
    ),
    (r",? (?:while )?(?:keeping|maintaining) (?:the|your) (?:same )?(?:heading|orientation|direction)\b", ""),
    # ---------------------------------------------------------------- requests
    (rf"{_BEGIN}(?:could|can|would|will) the (?:robot|dog|bot|doggo) (?:please |kindly )?(?=[a-z])", r"\1please "),
    (
        rf"{_BEGIN}(?:the )?robot (?:must|should|shall|has to|needs to|is to|can) (?:please )?(?=[a-z]+\b(?<!ing))",
        r"\1please ",
    ),
    (rf"\b(do|perform|show us|show me) its (?=(?:{_GESTURE})\b)", r"\1 your "),
    (
        rf"{_BEGIN}(?:may|can|could) (?:i|we) (?:please )?(?:ask for|request|get|have|do) (?=an? [\w -]*\bturn\b)",
        r"\1do ",
    ),
    (rf"{_BEGIN}(?:reposition|relocate) (?:yourself )?(?=[a-z\d])", r"\1move "),
    (rf"{_BEGIN}(?:can|could|may) (?:we|i) (?:just )?have you (?=[a-z])", r"\1please "),
    (rf"{_BEGIN}oi(?= |,)", r"\1hey"),
    (rf"{_BEGIN}mind (?=[a-z]+ing\b)", r"\1would you mind "),
    (rf"{_BEGIN}(?:so )?why (?:not|don't we|don't u) (?=\w)", r"\1please "),
    (
        rf"{_BEGIN}(?:is there |there's |there is )?(?:any|some|no) (?:way|chance|possibility) "
        r"(?:that )?(?:you|u) (?:could|can|would|might) ",
        r"\1please ",
    ),
    (rf"{_BEGIN}would it (?:kill|hurt|be (?:ok|okay|too much)(?: for)?) (?:you )?to ", r"\1please "),
    (rf"{_BEGIN}(?:can|could|may) (?:we|i) see (?=(?:an?|your|the|that) (?:\w+ )?(?:{_GESTURE})\b)", r"\1do "),
    (
        rf"{_BEGIN}(?:let's (?:have|see|get|do|try)|time for|who wants|we want|bust out|pull off|throw in|treat us to"
        r"|hit us with|how about|ready for|may i request|requesting|request:) "
        rf"(?=(?:an?|your|the|another|one|one more) (?:\w+ )?(?:{_GESTURE}|{_PICTURE})\b)",
        r"\1please do ",
    ),
    (rf"{_BEGIN}(?:maybe |let's |lets |just |we |we could )?(?:try|attempt) (?:to )?(?=[a-z]+)(?!again)", r"\1please "),
    (rf"{_BEGIN}(?:let's|lets) (?=(?:\d|{_NUMBER}\b))", r"\1please "),
    (rf"{_BEGIN}be an? (?:good|nice|dear|kind) (?:\w+ )?(?:and|& ) ?", r"\1please "),
    (
        r"^\s*(hello|hi|hey|yo|good (?:morning|evening|afternoon))((?: [a-z]+){0,2}?)[,.!]? "
        r"(?P<left>how are you(?: doing)?(?: today)?|how's it going|what's up|sup|how do you do)[?!.,]* (?=\w)",
        r"\1\2, ",
    ),
    (r"^\s*((?:er|um|uh|ok|okay|well)[, ]+)?right,? (?=(?:robot|dog|doggo|buddy|mate|so|ok|okay|folks|team)\b)", ""),
    (r"(?<=\w) (please|pls|plz)\s*([.!]*)$", r", \1\2"),
    (
        rf"{_BEGIN}(?:you(?:'re| are) (?:gonna|going to)|you(?:'ll| will)(?: now| then| just)?|{_TASK} (?:is|would be)"
        r"(?: for you)?(?: to)?|all (?:that )?you (?:need|have|got) to do is(?: to)?|i(?:'m| am) (?:gonna"
        r"|going to) have you"
        r"|i(?:'d| would) (?:appreciate|love) you to|i(?:'d| would) (?:like|want) for you to) (?=[a-z])",
        r"\1please ",
    ),
    (
        rf"{_BEGIN}(?:let me|let us|let's|lets|i'll|we'll) (?:just )?(?:get|have|grab|take) "
        rf"(?=(?:an?|your|another|one|one more|the) (?:\w+ )?(?:{_PICTURE})\b)",
        r"\1take ",
    ),
    (
        rf"\b(?:proceed with|perform|execute|initiate|carry out|conduct|complete|go for|make"
        rf"|go ahead with) (?={_A_TURN})",
        "do ",
    ),
    (
        rf"\b(?:move in a |make a |do a )?({_AHEAD}) (?:motion|movement)(?: of| by| for)?\b(?=.*\d|.*{_NUMBER})",
        r"move \1",
    ),
    (
        rf"{_BEGIN}(?:show|send|give)(?: me| us)? (?:an?|the|your|another|one more)(?: new)? (?:(?:{_LIVE}) )?"
        rf"(?:{_VIEW})(?: of what(?:'s| is) (?:ahead|in front of you|there)| from (?:here|there|where you are))?{_END}",
        r"\1take a photo",
    ),
    (
        rf"\b(turn|rotate|pivot|spin|swivel|swing)(?: yourself)? back (?=(?:by |about )?{_NUMBER}\b.*\b(?:left"
        rf"|right)\b)",
        r"\1 ",
    ),
    (rf",? (?:let's |i'd |i would )?say,? (?=(?:about |another |a |an )?{_NUMBER}\b)", " "),
    (rf"(\b(?:{_PICTURE})) (?:straight|directly|facing|looking|pointing)? ?(?:ahead|forwards?|straight){_END}", r"\1"),
    (
        rf"\b((?:take|snap|grab|send|get|give|shoot|show)(?: me| us)? (?:an?|the|one|another"
        rf"|your))(?: (?:{_FINE})){{1,2}}"
        rf" (?=(?:{_PICTURE})\b)",
        r"\1 ",
    ),
    (rf"\b({_AHEAD}|left|right|feet|foot|met(?:er|re)s?|degrees) go{_END}", r"\1"),
    (rf"{_BEGIN}i(?:'d)? (?:just|only|really|simply) ((?:want|need|like) )", r"\1i \2"),
    (r"\b(?:toward|towards) (?=(?:the |your )?(?:left|right)\b)", "to "),
    (rf",? (?:um |uh |er )?let(?:'s| me) see,? (?=(?:about |maybe )?{_NUMBER}\b)", " uh "),
    (
        rf"\b(turn|spin|back|move|rotate|roll|walk|drive) you (?=around|back|up|forward|ahead|left|right|{_NUMBER}\b)",
        r"\1 ",
    ),
    (rf"{_BEGIN}give (?:it|me|us) (?=(?:another )?{_NUMBER}\b[\w ]*\b(?:{_AHEAD}|back|left|right))", r"\1move "),
    # ---------------------------------------------------------------- verbs in -ing, nouns for actions, manners
    (rf"{_BEGIN}(?:(?:and|then) )*making (?=an? (?:\w+ )?heart\b)", r"\1make "),
    (rf"{_BEGIN}(?:(?:and|then) )*giv(?:e|ing)(?: me| us| everyone)? (?=(?:an?|one) (?:\w+ )?heart\b)", r"\1make "),
    (rf"\b(?:an?|one|a single|another) (?:{_WHOLE} )?{_CIRCLE},? (?={_CLOCKWISE}\b)", "turn 360 degrees "),
    (rf"{_BEGIN}(?:do |make |turn |give us |perform )?(?:one|a single) {_WHOLE} {_CIRCLE}\b", r"\1turn 360 degrees"),
    (rf"{_BEGIN}(?:just )?one (?=(?:{_GESTURE})\b)", r"\1a "),
    (rf"\b(?:just )?an? single (?=foot|met(?:er|re)|yard|inch|centimet(?:er|re)|degree|{_PICTURE}|{_GESTURE})", "one "),
    (r"\b(?:over|round|across) (?=to (?:the|your) (?:left|right)\b)", ""),
    (r",? (?:stepping|moving|walking|shuffling|going|side ?stepping) sideways\b", ""),
    (r"\bsideways,? (?:to the |on the |to your )?(left|right)(?: side)?\b", r"to the \1"),
    (r",? (?:crab|crab walk|sidestep|military|moonwalk|robot)[ -]style\b", ""),
    (
        rf"\b({_NUMBER} met(?:er|re)s?) (?:and )?({_TENS})(?=$|[.,;!]| (?:and|then|to|forward|back|left|right)\b)",
        r"\1 \2 cm",
    ),
    (rf"\b({_AHEAD}),? go[!.]*$", r"\1"),
    (rf"\bkeep (?:going )?(?:straight|on)(?: ahead)? for (?={_NUMBER})", "walk forward "),
    (
        rf"\b((?:turn|rotate|spin|pivot)\b[\w ]*?),? until you(?:'ve| have)? (?:done|turned|reached) (?={_NUMBER})",
        r"\1 ",
    ),
    (
        r"\b(?:turn|spin) (?:yourself )?(?:a)?round,? "
        r"(?:so (?:that )?you(?:'re| are| face)?(?: facing)?|to face|and face) "
        r"(?:the (?:other|opposite) (?:way|side|direction)|(?:back )?where you (?:came|come) from)\b",
        "turn around",
    ),
    (r",? (?:and )?(?:at|in) the end(?: of (?:that|it|this|the (?:turn|move|walk|rotation)))?(?=[.!]*$)", " "),
)
