"""Restate what people say out of the order of doing, or not as an imperative, in the words that the grammar knows.

"Take a photo after turning left", "before you sit, wave", "would you mind turning around", "1. … 2. …". Only what is
certain is restated: the subject is the robot, and one action stands in the clause of time. Everything else stays as it
is, and the grammar asks about it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

#: Counts the steps of a text, 0 if it is not a complete command.
StepCounter = Callable[[str], int]

_LABEL = re.compile(
    r"(?:^|(?<=[\s.,;!]))\s*(?:(?:step|part|number|no\.?)\s*)?(?P<number>\d)\s*[.:)](?!\d)", re.IGNORECASE
)
_SENTENCE = re.compile(r"(?:[^.!?\n;]|\.(?=\d))+")


@dataclass(frozen=True)
class OrderWords:
    """Words that put clauses into order; alternatives are separated by |.

    `base` maps gerunds and participles of actions to their base forms.
    """

    base: Mapping[str, str]
    when: str
    after: str
    before: str
    done: str  # says of the robot that it has done something: "you have", "you are done"; also after `when`
    subject: str  # the robot, which does something; not after `when`: "when you turn" may be any time
    not_doing: str  # before a gerund, denies it: "without"
    polite: str  # before a gerund, requests it: "would you mind"
    then: str  # joins what is done first with what is done later
    never: str  # denies an imperative
    idioms: Sequence[tuple[str, str]] = ()  # patterns, and what they are in plain words

    @cached_property
    def _acting(self) -> str:
        return "(?:" + "|".join(sorted(map(re.escape, self.base), key=lambda w: (-len(w), w))) + ")"

    @cached_property
    def _plain_verb(self) -> str:
        return "(?:" + "|".join(sorted(set(self.base.values()), key=lambda w: (-len(w), w))) + ")"

    @cached_property
    def _finished(self) -> str:
        """Match the beginning of a clause about what is done first, up to its verb."""
        acting, doing = rf"(?={self._acting}\b)", rf"(?={self._acting}\b|{self._plain_verb}\b)"
        done = rf"(?:{self.when}|{self.after})\s+(?:(?:{self.done})\s+)?{acting}"
        return rf"(?:but )?(?:only )?\b(?:{done}|(?:{self.after})\s+(?:{self.subject})\s+{doing})"

    @cached_property
    def _coming(self) -> str:
        """Match the beginning of a clause about what is done later, up to its verb."""
        return rf"\b(?:{self.before})\s+(?:(?:{self.subject})\s+(?={self._plain_verb}\b)|(?={self._acting}\b))"

    @cached_property
    def fronted(self) -> re.Pattern[str]:
        return re.compile(
            rf"^\s*(?:and |then )*{self._finished}(?P<first>[^,]+),(?!\s*and\b)\s*(?P<later>.+)$", re.IGNORECASE
        )

    @cached_property
    def behind(self) -> re.Pattern[str]:
        return re.compile(rf"^(?P<later>[^,]+?)\s+{self._finished}(?P<first>[^,]+)$", re.IGNORECASE)

    @cached_property
    def fronted_before(self) -> re.Pattern[str]:
        return re.compile(rf"^\s*(?:and )*{self._coming}(?P<later>[^,]+),\s*(?P<first>.+)$", re.IGNORECASE)

    @cached_property
    def behind_before(self) -> re.Pattern[str]:
        return re.compile(rf"^(?P<first>.+?)\s+{self._coming}(?P<later>[^,]+)$", re.IGNORECASE)

    @cached_property
    def denied(self) -> re.Pattern[str]:
        return re.compile(rf"\b(?:{self.not_doing})\s+(?={self._acting}\b)", re.IGNORECASE)

    @cached_property
    def requested(self) -> re.Pattern[str]:
        return re.compile(rf"\b(?:{self.polite})\s+(?={self._acting}\b)", re.IGNORECASE)

    def imperative(self, clause: str) -> str:
        """Replace gerunds and participles where a clause begins: "turning left and taking a photo"."""
        begins = re.compile(rf"(^\s*|,\s*|\b(?:and|then)\s+)({self._acting})\b", re.IGNORECASE)
        return begins.sub(lambda m: m[1] + self.base[m[2].lower()], clause)


_JOINED = re.compile(r"(?:\b(?:and|then|or)|,)\s*$|\band\b|,", re.IGNORECASE)


def in_order(part: str, words: OrderWords, steps: StepCounter) -> str:
    """Return the text restated in the order of doing; unchanged if nothing in it can be."""
    text = _without_labels(part)
    for pattern, plain in words.idioms:
        text = re.sub(pattern, plain, text, flags=re.IGNORECASE)
    text = _SENTENCE.sub(lambda sentence: _restated(sentence[0], words, steps), text)
    return text


def _restated(sentence: str, words: OrderWords, steps: StepCounter) -> str:
    if words.requested.search(sentence):
        sentence = words.imperative(words.requested.sub("", sentence))
    if words.denied.search(sentence):
        sentence = words.denied.sub(lambda m: f", {words.never} ", sentence)
        return re.sub(
            rf"({re.escape(words.never)} )(\w+(?: up)?)",
            lambda m: m[1] + words.base.get(m[2].lower(), words.base.get(m[2].split()[0].lower(), m[2])),
            sentence,
        ).removeprefix(", ")
    if found := words.fronted.match(sentence):
        first = words.imperative(found["first"])
        if steps(first) == 1:
            return f" {first}, {words.then} {found['later']}"
    if found := words.fronted_before.match(sentence):
        later = words.imperative(found["later"])
        if steps(later) == 1:
            return f" {found['first']}, {words.then} {later}"
    if (found := words.behind.match(sentence)) and not _JOINED.search(found["later"]):
        first = words.imperative(found["first"])
        done, joint, last = found["later"].rpartition(f" {words.then} ")
        if steps(first) == 1:
            return f"{done}{joint}{first}, {words.then} {last}"
    if found := words.behind_before.match(sentence):
        later = words.imperative(found["later"])
        if steps(later) == 1:
            return f"{found['first']}, {words.then} {later}"
    return sentence


def _without_labels(part: str) -> str:
    """Replace the numbers of a list by sentence ends: "1. turn left 2. wave", "step 1: …"; they count from one."""
    found = list(_LABEL.finditer(part))
    if (
        len(found) < 2
        or part[: found[0].start()].strip()
        or [int(m["number"]) for m in found] != list(range(1, len(found) + 1))
    ):
        return part
    return _LABEL.sub(". ", part)
