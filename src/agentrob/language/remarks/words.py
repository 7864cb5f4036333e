"""Define the word lists of remarks, and build from them the few patterns that `parser.remarks` applies."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

_ANY_ENDING = re.compile(r"(?<=[a-z])\*")
_LINE_END = re.compile(r"\s*\n\s*(?=\|)")
_INNER = r"\([^()]*\)"
for _ in range(3):  # parentheses within parentheses
    _INNER = rf"\((?:[^()]|{_INNER})*\)"
_LETTER = re.compile(r"[a-z '](?![?{+])")
_PHRASE = re.compile(rf"(?:[^|()]|{_INNER})+")


def one_of(*lists: str) -> str:
    """Return a pattern for the phrases of lists separated by |; * at the end of a word stands for any ending.

    A phrase may be a pattern; what stands in its parentheses is not split.
    """
    joined = [_LINE_END.sub("", words) for words in lists]
    phrases = {" ".join(phrase.split()) for words in joined for phrase in _PHRASE.findall(words)} - {""}
    return _either([_ANY_ENDING.sub(r"[\\w'-]*", p) for p in sorted(phrases, key=lambda p: (-len(p), p))])


def _either(phrases: Sequence[str]) -> str:
    """Return a pattern for any of these; those that begin with the same letter are tried only where it stands."""
    by_letter: dict[str, list[str]] = {}
    for phrase in phrases:
        begins = _LETTER.match(phrase)
        by_letter.setdefault(begins[0] if begins else phrase, []).append(phrase)
    found = (f"{letter}{_either([p[1:] for p in same])}" if same[1:] else same[0] for letter, same in by_letter.items())
    return f"(?:{'|'.join(found)})"


@dataclass(frozen=True)
class RemarkWords:
    """Word lists, separated by |, for a language that puts the subject before the verb.

    A statement is a subject, at most six words and a finite verb. `verbs` may also be patterns for endings.
    """

    leads: str  # may stand before a statement: "well", "by the way"
    subjects: str  # begin a noun phrase, or stand for one
    verbs: str  # finite verbs: "is", "has", "went"
    linking: str  # the few verbs that make a statement also of a noun without an article: "weather is"
    bare_subjects: str  # pronouns with which any verb makes a statement: "I", "they"
    about_robot: str  # harmless statements about the robot: "you are", "you look"
    feelings: str  # adjectives of what somebody feels or finds: "curious"
    musings: (
        str  # begin a clause whose subject is left out and cannot be the robot: "hope you are well", "took me ages"
    )
    verbless: str  # whole clauses, or their beginning, without a verb: "what a", "no hurry", "my first post"
    introductions: str  # before a colon, introduce the command itself: "my vote goes to: …"
    prefaces: str  # conditions in form that are none, and may begin a clause: "if I remember correctly"
    asides: str  # words that only look like a condition or an action: "wondering if", "be right back"
    settings: str  # whole clauses: settings that are on anyway
    reasons: str  # begin a reason or purpose, also within a clause: "because", "so that"
    reason_subjects: str  # "so" before one of these, and a verb, begins a purpose
    aims: str  # "to" and one of these verbs begins a purpose
    occasions: str  # "for the" and one of these nouns, at the end of a clause, is a purpose
    meaning: Mapping[str, str]  # words that may change what a command means, by reason
    danger: Mapping[str, str]  # words that may change how dangerous it is, by what is in danger
    near_robot: str  # prepositions: what is there may be hit
    doers: str  # a verb after these says what they do: "I", "used to"
    often: str  # … also with one of these between: "always"
    not_introducing: str  # a statement that ends in one of these before a colon introduces words of others
    robot: str  # words for the robot after them
    light: Sequence[str]  # reasons in `meaning` that do not weigh where the classifier is quite sure
    decisive: Sequence[str]  # reasons in `meaning` that always weigh
    unfinished: str  # a statement cannot end in these: a verb after them belongs to it
    joins_verb: str  # … within the three words before it: "what happens when dogs walk"
    governs_verb: str  # with one of these in a statement a verb after it belongs to it: "I saw the dog walk"
    never_where: str  # directions that nobody says of a place: "forward"
    before_noun: str  # a word after one of these is a noun or adjective, also if it may be an action: "my turn"

    @cached_property
    def _lead(self) -> str:
        return rf"^(?:{one_of(self.leads)} )*"

    @cached_property
    def _statement(self) -> str:
        subject, verb = one_of(self.subjects), one_of(self.verbs)
        contracted = r"'(?:s|re|m|ve|ll|d)\b"
        return (
            rf"(?:{subject}(?:{contracted}|\b(?: [\w'-]+){{0,6}}? {verb}\b)|{one_of(self.bare_subjects)} \w+"
            rf"|{one_of(self.about_robot)}\b|[a-z][\w-]*(?: [a-z][\w-]*)?(?:'s| {one_of(self.linking)})\b)"
        )

    @cached_property
    def remark(self) -> str:
        """Match a clause in the form of a statement, purpose, reason or exclamation."""
        return (
            rf"{self._lead}(?:{self._statement}|{self._reason}|to {one_of(self.aims)}\b(?= \w+|$)|{self._occasion}"
            rf"|{one_of(self.musings)}\b|{one_of(self.verbless, self.feelings)}(?!\w)"
            rf"|{one_of(self.prefaces)}\b|{one_of(self.settings)}$)|{self._only_leads}"
        )

    @cached_property
    def fragment(self) -> str:
        """Match a clause without a verb. With a direction it may belong to a command: "my left"."""
        return rf"{self._lead}{one_of(self.verbless, self.feelings)}(?!\w)|{self._only_leads}"

    @cached_property
    def _only_leads(self) -> str:
        return rf"^{one_of(self.leads)}(?: {one_of(self.leads)})*$"

    @cached_property
    def introduction(self) -> str:
        """Match what introduces a command before a colon."""
        return rf"{self._lead}{one_of(self.introductions)}$"

    @cached_property
    def aside(self) -> str:
        """Match words of a condition that sets none."""
        return rf"\b{one_of(self.prefaces, self.asides)}"

    @cached_property
    def _reason(self) -> str:
        return rf"(?:{one_of(self.reasons)}\b|so {one_of(self.reason_subjects)}(?:'ll|'d)? (?!am\b)\w+)"

    @cached_property
    def _occasion(self) -> str:
        return rf"for (?:{one_of('the|my|our|his|her|a|an|this|some')} )?(?:\w+ )?{one_of(self.occasions)}$"

    @cached_property
    def purpose(self) -> str:
        """Match where a reason or purpose begins within a clause."""
        return rf"\b(?:{self._reason}|{self._occasion}|to {one_of(self.aims)}\b(?= \w+ \w+|\s*$))"

    @cached_property
    def weighty(self) -> str:
        """Match what may change the meaning or the danger of a command."""
        return rf"{self.dangerous}|\b{one_of(*self.meaning.values())}\b"

    @cached_property
    def grave(self) -> str:
        """Match what weighs unless the classifier is certain."""
        heavy = (words for reason, words in self.meaning.items() if reason not in self.light)
        return rf"{self.dangerous}|\b{one_of(*heavy)}\b"

    @cached_property
    def after_subject(self) -> str:
        """Match words after which a verb says what they do: "I drive", "we used to dance"."""
        return rf"(?:^|\s){one_of(self.doers)} (?:{one_of(self.often)} )?$"

    @cached_property
    def quotes(self) -> str:
        """Match a clause that, before a colon, may introduce the words of others."""
        return rf"\b{one_of(self.not_introducing)}$"

    @cached_property
    def crucial(self) -> str:
        """Match what is never left out: corrections, claims of rights, tampering, and what is by the robot."""
        return rf"{self._by_robot}|\b{one_of(*(self.meaning[reason] for reason in self.decisive))}\b"

    @cached_property
    def unsettling(self) -> str:
        """Match what may change the meaning of a command, apart from amounts: those may say how far off a thing is."""
        return rf"\b{one_of(*(words for reason, words in self.meaning.items() if reason != 'amount'))}\b"

    @cached_property
    def dangerous(self) -> str:
        return rf"\b{one_of(*self.danger.values())}\b|{self._by_robot}"

    @cached_property
    def _by_robot(self) -> str:
        return rf"\b{one_of(self.near_robot)} {one_of(self.robot)}\b"

    @cached_property
    def run_on(self) -> str:
        """Match a whole statement that a command may follow without punctuation: "the kids are gone move forward"."""
        finished = rf"(?!.*\b{one_of(self.unfinished)}$)"
        plain = rf"(?!.*\b{one_of(self.governs_verb)}\b)(?!.*\b{one_of(self.joins_verb)}(?: [\w'-]+){{0,3}}$)"
        words = r"[\w' -]*"
        others = one_of(self.musings, self.verbless, self.feelings)
        whole = rf"^{finished}{self._lead}{plain}(?:{self._statement} {words}\w|{others}(?!\w){words})$"
        return rf"{whole}|{self._lead}{one_of(self.settings)}$"

    @cached_property
    def open_end(self) -> str:
        """Match words after which a clause goes on: "go forward once", "what happens when"."""
        return rf"\b(?!(?:and|or|but)$){one_of(self.unfinished, self.joins_verb, self.reasons)}$"

    @cached_property
    def begins(self) -> str:
        """Match where a statement may begin after a command without punctuation: "… i think it works"."""
        return rf"\b{one_of(self.subjects, self.bare_subjects, self.about_robot, self.verbless)}(?=\b|')"

    @cached_property
    def noun_after(self) -> str:
        return rf"(?:^|\s)(?:{one_of(self.before_noun)}|\w+'s)\s+$"
