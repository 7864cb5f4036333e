"""Find which part of a post is for which robot."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from functools import cache

from agentrob.language.registry import known
from agentrob.language.visible_text import mention_spans, without_mentions

_ONLY_JOINT = re.compile(r"(?:[\s,;&+/，、;]|\band\b|和|与|跟|还有|both|of|you|all|please|请|你|都)*", re.IGNORECASE)

_POSSESSIVE = re.compile(r"(?P<latin>['’]s\b)|\s*的")


def part_for(visible: str, names: Sequence[str], others: Sequence[str]) -> str:
    """Return the text for the robot called `names`, without mentions of robots.

    It is the text after the robot's own mention, up to another robot's mention. Adjacent mentions ("@a and @b wave")
    share what follows, and a clause that begins with "both of you" is for every robot mentioned. Text before the first
    mention counts only when no other robot is mentioned. What is said of "@robot's wave" is said of "your wave". A post
    that mentions no robot is returned whole: the caller has decided that it is for this robot.
    """
    mine = {n.lower() for n in names}
    robots = mine | {n.lower() for n in others}
    spans = [(name in mine, start, end) for name, start, end in mention_spans(visible) if name in robots]
    if not spans:
        return visible.strip()
    parts: list[str] = []
    if all(is_mine for is_mine, _, _ in spans):
        parts.append(visible[: spans[0][1]])
    called = False
    for i, (is_mine, _, end) in enumerate(spans):
        called |= is_mine
        text = visible[end : spans[i + 1][1] if i + 1 < len(spans) else len(visible)]
        if i + 1 < len(spans) and only_joint(text):
            continue
        if called and (of := _POSSESSIVE.match(text)):  # "I love @robot's wave": your wave
            before = parts.pop() if parts else ""
            parts.append(f"{before}{'your' if of['latin'] else '你的'}{text[of.end() :]}")
        elif called:
            parts.append(text)
        elif any(is_mine for is_mine, _, _ in spans) and (shared := together().search(text)):
            parts.append(text[shared.start("words") :])
        called = False
    return "\n".join(parts).strip()


#: Ends of clauses, and what may precede a mention that addresses: "hey @robot nice work", "well done, @robot!".
_CLAUSE = re.compile(r"[.,;:!?\n。，；：！？、…]+")
_CALLING = re.compile(r"\s*(?:[^\W\d_]+|[\u3400-\u9fff]{1,2})?\s*")


def addresses(visible: str, names: Collection[str]) -> bool:
    """Return whether the text speaks to the robot called `names`, not about it ("I like how @robot looks").

    It does if the mention begins a clause, after at most one word of greeting, or ends a clause in a post that mentions
    nobody else.
    """
    alone = all(name in names for name, _, _ in mention_spans(visible))
    clauses, at = [], 0
    for end in _CLAUSE.finditer(visible):
        clauses.append(visible[at : end.start()])
        at = end.end()
    for clause in (*clauses, visible[at:]):
        for name, start, end_at in mention_spans(clause):
            before, after = (without_mentions(part) for part in (clause[:start], clause[end_at:]))
            if name in names and ((alone and not after.strip()) or _CALLING.fullmatch(before)):
                return True
    return False


def only_joint(text: str) -> bool:
    """Return whether the text between two mentions only joins them: "@a and @b wave" addresses both."""
    return _ONLY_JOINT.fullmatch(text) is not None


@cache
def together() -> re.Pattern[str]:
    """Match words that address all robots at the beginning of a clause: "… Then both of you wave"."""
    words = [w for t in known().values() for w in t.together.replace("\n", "").split("|") if w]
    said = "|".join(re.escape(w) for w in sorted(words, key=len, reverse=True))
    leads = "and|then|after|that|this|finally|lastly|next|afterwards|now|also|please|okay|at|in|the|end"
    begins = rf"(?:^|[.;:,!?\n。！？；，：])\s*(?:(?:{leads}),?\s+){{0,4}}(?:然后|最后|接着|之后|再|请)*"
    return re.compile(rf"{begins}(?P<words>(?:{said})(?![A-Za-z]))", re.IGNORECASE)
