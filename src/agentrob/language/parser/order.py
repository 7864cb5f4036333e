"""Restate what people say out of the order of doing, or not as an imperative, in the words that the grammar knows.

"Take a photo after turning left", "before you sit, wave", "would you mind turning around", "1. … 2. …". Only what is
certain is restated: the subject is the robot, and one action stands in the clause of time. Everything else stays as it
is, and the grammar asks about it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

from agentrob.language.needed_words import one_needed

#: Counts the steps of a text, 0 if it is not a complete command.
StepCounter = Callable[[str], int]

_LABEL = re.compile(
    r"(?:^|(?<=[\s.,;!]))\s*(?:(?:step|part|number|no\.?)\s*)?(?P<number>\d)\s*[.:)](?!\d)", re.IGNORECASE
)
_LABEL_END = re.compile(r"\d\s*[.:)]")
#: Longer sentences are not divided, so that parsing stays fast.
_MOST_DIVISIONS = 4
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
    def timed(self) -> re.Pattern[str]:
        """Match words without one of which no order is said."""
        return re.compile(rf"\b(?:{self.when}|{self.after}|{self.before})\s", re.IGNORECASE)

    @cached_property
    def fronted(self) -> re.Pattern[str]:
        return re.compile(
            rf"^\s*(?:and |then )*{self._finished}(?P<first>[^,]+),(?!\s*and\b)\s*(?P<later>.+)$", re.IGNORECASE
        )

    @cached_property
    def fronted_open(self) -> re.Pattern[str]:
        return re.compile(rf"^\s*(?:and |then )*{self._finished}(?P<rest>[^,]+)$", re.IGNORECASE)

    @cached_property
    def fronted_before_open(self) -> re.Pattern[str]:
        return re.compile(rf"^\s*(?:and )*{self._coming}(?P<rest>[^,]+)$", re.IGNORECASE)

    @cached_property
    def beginning(self) -> re.Pattern[str]:
        """Match where a clause may begin without a pause."""
        return re.compile(rf"(?<=\w )(?:then )?(?={self._plain_verb}\b)", re.IGNORECASE)

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


class Idioms:
    """Idioms in plain words. One is searched for only in a text that contains a word which it needs."""

    def __init__(self, idioms: Sequence[tuple[str, str]]) -> None:
        self._idioms = [(re.compile(said, re.IGNORECASE), one_needed(said), plain) for said, plain in idioms]
        self._words = tuple(frozenset[str]().union(*(one_of for _, one_of, _ in self._idioms)))

    def in_plain_words(self, part: str) -> tuple[str, list[str]]:
        """Return the text with its idioms in plain words, and what was left out: what has no plain words, or is
        `left`.
        """
        left: list[str] = []

        def restated(found: re.Match[str], plain: str) -> str:
            if said := found[0] if not plain else found.groupdict().get("left") or "":
                left.append(said.strip(" ,.:;!?"))
            return found.expand(plain)

        part = _without_labels(part)
        words = self._words_in(part)
        for idiom, one_of, plain in self._idioms:
            if one_of.isdisjoint(words):
                continue
            part, restatements = idiom.subn(partial(restated, plain=plain), part)
            words = self._words_in(part) if restatements else words
        return part, left

    def _words_in(self, part: str) -> list[str]:
        said = part.lower()
        return [word for word in self._words if word in said]


def in_order(part: str, words: OrderWords, steps: StepCounter) -> str:
    """Return the text restated in the order of doing; unchanged if nothing in it can be."""
    text = _without_labels(part)
    if not any(pattern.search(text) for pattern in (words.timed, words.requested, words.denied)):
        return text
    return _SENTENCE.sub(lambda sentence: _restated(sentence[0], words, steps), text)


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
    if not words.timed.search(sentence):
        return sentence
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
    return _restated_open(sentence, words, steps) or sentence


def _restated_open(sentence: str, words: OrderWords, steps: StepCounter) -> str:
    """Restate a sentence in which no comma divides its two commands; return "" if it is none."""
    if (found := words.fronted_open.match(sentence)) and (parts := _divided(found["rest"], words, steps)):
        return f" {parts[0]}, {words.then} {parts[1]}"
    if (found := words.fronted_before_open.match(sentence)) and (parts := _divided(found["rest"], words, steps)):
        return f" {parts[1]}, {words.then} {parts[0]}"
    return ""


def _divided(rest: str, words: OrderWords, steps: StepCounter) -> tuple[str, str] | None:
    """Divide "turned left 45 degrees go forward 1 m" into its two commands; None unless one division works."""
    found = []
    for begun in list(words.beginning.finditer(rest))[:_MOST_DIVISIONS]:
        first, second = words.imperative(rest[: begun.start()]), rest[begun.end() :]
        if steps(first) == 1 and steps(second):
            found.append((first, second))
    return found[0] if len(found) == 1 else None


def _labels(part: str) -> list[re.Match[str]]:
    return list(_LABEL.finditer(part)) if _LABEL_END.search(part) else []


def items_of(part: str) -> list[str]:
    """Return the items of a list on one line whose first number Markdown has taken: "sit 2. wave 3) stand up"."""
    found = _labels(part)
    if not found or [int(m["number"]) for m in found] != list(range(2, len(found) + 2)):
        return []
    ends = [*(m.start() for m in found), len(part)]
    starts = [0, *(m.end() for m in found)]
    return [part[start:end] for start, end in zip(starts, ends, strict=True)]


def _without_labels(part: str) -> str:
    """Replace the numbers of a list by sentence ends: "1. turn left 2. wave", "step 1: …"; they count from one."""
    found = _labels(part)
    if (
        len(found) < 2
        or part[: found[0].start()].strip()
        or [int(m["number"]) for m in found] != list(range(1, len(found) + 1))
    ):
        return part
    return _LABEL.sub(". ", part)
