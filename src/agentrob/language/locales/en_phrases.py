"""English phrases of several words that mean less than their words one by one: "nice wave!" asks for no wave."""

from __future__ import annotations

import re
from collections.abc import Sequence

from agentrob.language.parser.lexicon import Token, TokenKind

_BLAME = "bad|poor|terrible|awful|horrible|sloppy|wobbly|weird|odd|strange"
_JUDGES = (
    "nice|good|great|lovely|cool|sweet|cute|neat|awesome|amazing|wonderful|beautiful|fantastic|brilliant|excellent"
    "|perfect|superb|impressive|incredible|fabulous|terrific|marvell?ous|splendid|gorgeous|elegant|graceful|flawless"
    "|adorable|charming|delightful|outstanding|epic|stunning|best|solid|decent"
    f"|{_BLAME}"
)
_ACTION = (
    "waves?|waving|dance|dancing|dance moves|moves?|walk|walking|turns?|turning|rotation|spin|twirl|flip|backflip"
    "|sit|sitting|stretch|stretching|heart|handshake|bow|clap|clapping|high five|greeting|gesture|pose|routine"
)
_LEAD = "wow|oh|ah|ha(?:ha)*|ok|okay|hey|hi|thanks|thank you|cheers|yay|yes|well|lol|robot|buddy|doggo"
_TAIL = (
    "there|today|indeed|ever|earlier|just now|by the way|btw|thanks|thank you|buddy|pal|mate|friend|bro|dude|man|robot"
    "|bot|dog|doggo|doggy|boy|girl|sir|lol"
)
_REQUESTED = re.compile(r"\b(?:please|pls|plz|now|again|want|like|need|could|can|would)\b")
#: A sentence, or its beginning up to a comma, that only judges what the robot did.
_PRAISE = re.compile(
    rf"(?:^|[.!?\n])[\s,]*(?:(?:{_LEAD})\b[\s,!]*)*(?P<praise>(?:(?:really|very|so|such|pretty|truly|absolutely|quite|super"
    rf"|what|such an?|what an?|the)\s+)*(?:(?:{_JUDGES}),? )*(?:{_JUDGES}) (?:little |big )?(?:{_ACTION})"
    rf"|(?:(?:{_JUDGES}|well) (?:job|work|one|done)|well done|congrat\w*|kudos|props|bravo) (?:on|with|at|for|doing)"
    rf" (?:the|that|this|your) (?:little |big )?(?:{_ACTION}))"
    rf"(?P<tail>(?:[\s,]+(?:{_TAIL})\b)*)\s*(?=$|[.,;!?\n)(:]|and now\b)",
    re.IGNORECASE,
)
_WORD = re.compile(rf"\b(?:{_JUDGES}|job|done|congrat\w*|kudos|props|bravo)\b", re.IGNORECASE)


def with_phrases(tokens: Sequence[Token], text: str) -> list[Token]:
    """Return the tokens of an English post, with praise of an action as thanks and blame as a report; `text` is the
    post."""
    found = list(tokens)
    if not _WORD.search(text):
        return found
    for praise in _PRAISE.finditer(text):
        start, end = praise.start("praise"), praise.end("tail")
        if _REQUESTED.search(re.split(r"[.!?,\n]|\band\b", text[end:], maxsplit=1)[0]):
            continue
        blames = re.search(rf"\b(?:{_BLAME})\b", praise["praise"], re.IGNORECASE)
        found = as_judgement(found, start, end, blames=blames is not None)
    return found


def as_judgement(tokens: Sequence[Token], start: int, end: int, *, blames: bool) -> list[Token]:
    """Return the tokens with those of a judgement as one: thanks for praise; blame is a report, and ends its sentence,
    so that what follows is read by itself."""
    before = [token for token in tokens if token.start < start]
    behind = [token for token in tokens if token.start >= end]
    if not blames:
        return [*before, Token(TokenKind.THANKS, None, start, end), *behind]
    return [*before, Token(TokenKind.REPORT, None, start, end), Token(TokenKind.END, None, end - 1, end), *behind]
