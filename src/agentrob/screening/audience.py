"""Find the part of a post to several robots that must be judged for one of them (pure).

This includes its own part, and everything that may also apply to it. Only text that plainly addresses another robot
about its own place is left out: "@humanoid, there is a chair in front of you" says nothing about the other robots' way.
If that is not clear, the whole post is judged.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from agentrob.language.addressing import only_joint
from agentrob.language.visible_text import mention_spans
from agentrob.screening.text.described_hazards import clauses
from agentrob.screening.text.harm import plain_words

#: A mention at the beginning of a sentence or clause addresses somebody; any other may only name them.
_BEGINS = re.compile(
    r"(?:^|[.!?;:,\n。！？；：，、])\s*(?:(?:and|then|but|while|meanwhile|now|next|also|finally)\s+)*$"
    r"|(?:然后|再|接着|同时|另外|而)\s*$",
    re.IGNORECASE,
)
#: How text continues that is said to the account just mentioned, not about it ("@bob stands before you").
_CALLED = re.compile(
    r"[\s,:，：]*(?:(?:please|kindly|now|then|first|hey|hi|hello|ok|okay)[\s,]+)*"
    r"(?:you(?:'re)?|there(?:'s)?|here(?:'s)?|can|could|would|will you|do|don't|be|mind|watch out|careful|walk|go|move"
    r"|run|step|turn|rotate|back|drive|come|wave|sit|stand|take|say|look|show|greet|clap|shake|stretch|stop|wait|stay|make)\b"
    r"|[\s,:，：]*(?:请|先|再)*(?:你|您|前进|后退|左转|右转|转身|挥手|拍|坐下|站起|小心|注意|别|不要"
    r"|走(?!在|到|过来)|[向往朝](?!你|您))",
    re.IGNORECASE,
)
_SECOND_PERSON = re.compile(r"\b(?:you|your|yours)\b|[你您]")
#: Words that address everybody, or refer to what was said to others.
_SHARED = re.compile(
    r"\b(?:both|all|each|every\w*|together|robots|two of you|same|too|also|likewise|as well|similarly|it|its|that|those"
    r"|these|them|there(?!'s| is| are))\b|都|大家|你们|一起|两个|也|一样|同样|[它那]"
)


def text_for_robot(text: str, names: Sequence[str], others: Sequence[str], *, known: bool = False) -> str:
    """Return the part of `text` (the visible text of a post) by which the robot called `names` is judged.

    `others` are the other robots it mentions. Returns the whole text unless it plainly addresses this robot and another
    one. `known`: every word of the robot's own part was understood, as in a goal of a closed vocabulary; then only text
    for others may add something.
    """
    mine = {name.lower() for name in names}
    robots = mine | {name.lower() for name in others}
    spans = [(name in mine, start, end) for name, start, end in mention_spans(text) if name in robots]
    if len({is_mine for is_mine, _, _ in spans}) < 2:
        return "" if known else text
    heard = [text[: spans[0][1]]]
    mine_called, first = False, spans[0][1]
    for at, (is_mine, _, end) in enumerate(spans):
        until = spans[at + 1][1] if at + 1 < len(spans) else len(text)
        mine_called |= is_mine
        if at + 1 < len(spans) and only_joint(text[end:until]):
            continue
        said, plainly = text[end:until], _BEGINS.search(text[:first]) is not None
        if mine_called and (not plainly or _SHARED.search(plain_words(said))):
            return text
        if not (mine_called and known):
            heard.append(said if mine_called or not plainly else _of_all(said))
        mine_called, first = False, until
    return "\n".join(heard)


def _of_all(said: str) -> str:
    """Return what was said to another robot, without what describes its own place."""
    plain = plain_words(said)
    if not _CALLED.match(plain) or re.search(
        r"\b(?:both|all|each|every\w*|together|two of you)\b|都|大家|你们|一起", plain
    ):
        return said
    return ". ".join(clause.said for clause in clauses(plain) if not _SECOND_PERSON.search(clause.said))
