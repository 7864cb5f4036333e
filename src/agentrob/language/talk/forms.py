"""Recognise a post that is only talk by the form of its clauses, and what it is about.

The grammar knows the words of commands. A post that it does not understand may still be plain talk: a question, a
statement, a greeting, or words to another person. Asking "what shall I do with …?" about those is a nuisance. A post
counts as talk only if every clause has such a form and no clause begins like an order; it never moves anything.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

#: Judges a clause or a sentence.
Judge = Callable[[str], bool]


@dataclass(frozen=True)
class TalkForms:
    """The forms of one language, as regular expressions on text in lower case.

    `lead` matches interjections before a clause. `clauses` match talk at the beginning of a clause, `sentences` at
    the beginning of a whole sentence, commas included: questions, reports, words to others. `named` does the same
    in the writing of the post, for names in capitals. `wish` matches what asks for something in any form, and
    `order` how an order begins: neither is talk; with `done` in it, a clause is reported and not ordered. `spoken_of`
    matches clauses that speak of an action as done, even where the grammar reads a command in them; `praised` matches
    a whole post of praise that does. A statement (`Locale.states`) is talk too.
    `topics` are what a line of talk may be about, by the key of its answer.
    """

    lead: str = "(?!)"
    clauses: str = "(?!)"
    sentences: str = "(?!)"
    named: str = "(?!)"
    wish: str = "(?!)"
    order: str = "(?!)"
    done: str = "(?!)"
    spoken_of: str = "(?!)"
    praised: str = "(?!)"
    topics: Mapping[str, str] = field(default_factory=dict)


_SENTENCE = re.compile(r"(?:[^.!?;。！？；\n…]|(?<=\w)[.!](?=\w))+[?？]?")
#: What somebody else said: "he wrote: walk 2 m".
_SAID = re.compile(
    r"(?:\b(?:wrote|writes|said|says|typed|asked|reads|told \w+)|[说写道问喊唱])\s*[:：].*", re.IGNORECASE
)
_CLAUSE = re.compile(r"(?:[^,，、:：—]|(?<=\d)[,:](?=\d))+")


class Judges(NamedTuple):
    """`states` tells whether a clause is a statement, `sure` whether a whole sentence certainly is one, `likely`
    whether a clause beside a statement may be talk, `commands` whether a clause asks for an action."""

    states: Judge
    sure: Judge
    likely: Judge
    commands: Judge


def is_talk(text: str, forms: TalkForms, judges: Judges) -> bool:
    """Return whether every clause of a text is talk, or may be and stands beside talk."""
    sentences = [match[0].strip() for match in _SENTENCE.finditer(text) if match[0].strip()]
    if not sentences or not all(_may_be_talk(sentence, forms, judges) for sentence in sentences):
        return False
    return any(_is_talk(sentence, forms, judges) for sentence in sentences)


def order_beside(text: str, forms: TalkForms, commands: Judge) -> str:
    """Return a clause of an order beside talk ("I'm tired, follow me"); empty if there is none.

    What belongs to a question, a report, or words to others is no order.
    """
    for sentence in (match[0].strip() for match in _SENTENCE.finditer(text)):
        said = _without_lead(_plain(_SAID.sub("", sentence)), forms)
        if _compiled(forms.named).search(sentence) or _compiled(forms.sentences).search(said):
            continue
        for clause in (_without_lead(found[0], forms) for found in _CLAUSE.finditer(said)):
            done = _compiled(forms.done).search(clause)
            if not done and _compiled(forms.order).search(clause) and commands(clause):
                return clause
    return ""


def is_spoken_of(text: str, forms: TalkForms) -> bool:
    """Return whether a text praises or reports an action instead of asking for it, and asks for no other."""
    said = _plain(text)
    if _compiled(forms.praised).fullmatch(said):
        return True
    if not _compiled(forms.spoken_of.replace("^", "").replace("$", "")).search(said):
        return False
    clauses = [_without_lead(found[0], forms) for found in re.finditer(r"[^,，.。!！;；?？]+", said)]
    reported = [_compiled(forms.spoken_of).search(clause) is not None for clause in clauses]
    others = [clause for clause, is_reported in zip(clauses, reported, strict=True) if not is_reported]
    orders = any(_compiled(forms.order).search(clause) for clause in others)
    return any(reported) and not orders and not _compiled(forms.wish).search(said)


def topic_of(text: str, forms: TalkForms) -> str:
    """Return what a line of talk is about, as the key of its answer without its section; empty if that is not known."""
    said = _plain(text).strip(" ?？!！.。~,，")
    found = (topic for topic, pattern in forms.topics.items() if _compiled(pattern).search(said))
    return next(found, "")


def _is_talk(sentence: str, forms: TalkForms, judges: Judges) -> bool:
    """Return whether some clause of a sentence that may be talk certainly is."""
    said = _without_lead(_plain(sentence), forms)
    if any(_compiled(form).search(words) for form, words in ((forms.named, sentence), (forms.sentences, said))):
        return True
    return judges.sure(said) or any(_talks(clause, forms, judges) for clause in _clauses_of(said, forms))


def _may_be_talk(sentence: str, forms: TalkForms, judges: Judges) -> bool:
    if _compiled(forms.named).search(sentence):
        return True
    plain = _plain(sentence)
    said = _without_lead(plain, forms)
    if _compiled(forms.wish).search(plain):
        return False
    clauses = _clauses_of(said, forms)
    orders = [bool(_compiled(forms.order).search(clause)) for clause in clauses]
    if any(orders[1:]):
        return False
    if _compiled(forms.sentences).search(said):
        return True
    talked = judges.sure(said) or all(_talks(clause, forms, judges) or judges.likely(clause) for clause in clauses)
    return talked and not any(orders) and not any(judges.commands(clause) for clause in clauses)


def _clauses_of(said: str, forms: TalkForms) -> list[str]:
    return [clause for found in _CLAUSE.finditer(said) if (clause := _without_lead(found[0], forms))]


def _talks(clause: str, forms: TalkForms, judges: Judges) -> bool:
    return _compiled(forms.clauses).search(clause) is not None or judges.states(clause)


def _without_lead(said: str, forms: TalkForms) -> str:
    """Return what is said after interjections and marks."""
    before = None
    while before != said:
        before, said = said, _compiled(forms.lead).sub("", said.strip(" \t,，、:：—-~'\"“”()（）"), count=1).strip()
    return said


def _plain(text: str) -> str:
    return " ".join(text.lower().replace("’", "'").split())


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)
