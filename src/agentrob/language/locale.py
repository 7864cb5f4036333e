"""Define what a language file provides: words to parse, sentences to say, and stop words."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

from agentrob.language.joint.parts import JointWords
from agentrob.language.needed_words import Prefiltered
from agentrob.language.parser.amounts import with_amounts, with_pictures
from agentrob.language.parser.lexicon import Lexicon, Token, tokens_of
from agentrob.language.parser.order import Idioms, OrderWords
from agentrob.language.previews.words import PreviewWords
from agentrob.language.remarks.classifier import Confidence, StatementClassifier
from agentrob.language.schedule.parts import ScheduleWords
from agentrob.language.talk.forms import TalkForms


@dataclass(frozen=True, eq=False)
class Locale:
    """One language, which a file in `locales/` provides under the name `LOCALE`.

    `sentences` are what robots say, with the keys of `messages.en`; a missing sentence is said in English.
    `stop`, `halt` and `polite` are phrases separated by |. They only add to the built-in stop words of all
    languages (law 13); `halt` is for explicit emergency stops, which lock the robot (law 17). `together`
    lists words for all robots at once ("both of you"). `stated` is a regular expression for the beginning of
    a clause that states where something is and would otherwise be parsed as a command (前面五米是墙). `order` lists
    words that put one robot's steps after another's ("then"), `waits` words that begin a condition to wait
    for ("when"). `phrases` rewrites the tokens of a post where several words mean something else than each by itself.

    Regular expressions for `parser.remarks`, which a language may build with `remarks.words`: `remark` matches a
    clause in the form of a statement, purpose or reason; `fragment` those of them without a verb, in which a
    direction may belong to a command; `introduction` what introduces a command before a colon; `aside` words in the
    form of a condition that set none ("if I remember correctly"); `purpose` where one begins within a clause;
    `weighty` what may change the meaning or the danger of a command, and is left out only where the classifier is
    quite sure that it does not; `grave` words of those for which it must be certain; `crucial` those that are never
    left out; `unsettling` what of `weighty` counts where the grammar knows the words of the remark, whose danger the
    screen judges; `quotes` what may introduce the words of others before a colon; `after_subject` the words after
    which a verb says what they do; `noun_after` the words before a noun or an adjective; `run_on` a whole statement
    that a command may follow without punctuation; `begins` where a statement may begin that follows a command without
    punctuation; `open_end` words after which it cannot; `claims` talk that is always asked about: somebody claims
    rights, or introduces what another person said. `looks` lists words that turn the robot and are also said of
    looking: "I look at it".
    `prohibits` matches the beginning of a prohibition ("do not"), and `reassures` those that limit no command: wishes,
    and bumps and falls, which the robot's guard prevents ("don't worry", "don't bump into it"). `warns` matches denials
    that deny no action, but say why not to do what is commanded ("it isn't safe").
    A walk in the words of one of these is asked about: `circular` matches what is said of turns only ("clockwise"),
    `some_side` a side that may be the left or the right one, `pointing` where somebody points ("that way"). So are two
    steps at the same time, which `meanwhile` matches. `clear_path` matches a whole clause that says that nothing is in
    the way; it is left out, because the guard measures that.
    `never_where` lists directions that nobody says of a place. `put_first` matches words that put a later
    clause before an earlier one.

    `in_order` lists the words by which `parser.order` restates clauses in the order of doing; `idioms` are patterns and
    what they are in plain words, for posts that are not understood as they stand. `called` matches names
    for a robot where one is called: "Rover, sit".

    `statements` estimates whether a clause in words that no pattern knows is a statement or an order.
    `talk` is how posts are recognised that are only talk, and what they are about. `schedule` is how the language says
    when something is to be done, `previews` how it asks to be shown first, `joint` how it puts the parts of several
    robots in order.
    """

    words: Lexicon
    sentences: Mapping[str, str]
    script: Literal["latin", "han"] = "latin"
    stop: str = ""
    halt: str = ""
    polite: str = ""
    together: str = ""
    stated: str = ""
    order: str = ""
    waits: str = ""
    remark: str = ""
    fragment: str = "(?!)"
    introduction: str = "(?!)"
    aside: str = "(?!)"
    purpose: str = ""
    weighty: str = "(?!)"
    grave: str = "(?!)"
    crucial: str = "(?!)"
    quotes: str = ""
    after_subject: str = "(?!)"
    unsettling: str = "(?!)"
    noun_after: str = ""
    run_on: str = ""
    begins: str = ""
    open_end: str = "(?!)"
    looks: str = ""
    prohibits: str = "(?!)"
    reassures: str = "(?!)"
    warns: str = "(?!)"
    circular: str = "(?!)"
    some_side: str = "(?!)"
    pointing: str = "(?!)"
    meanwhile: str = "(?!)"
    clear_path: str = "(?!)"
    never_where: str = ""
    claims: str = "(?!)"
    put_first: str = "(?!)"
    statements: StatementClassifier | None = None
    talk: TalkForms = TalkForms()
    schedule: ScheduleWords = ScheduleWords()
    previews: PreviewWords = PreviewWords()
    joint: JointWords = JointWords()
    in_order: OrderWords | None = None
    idioms: Sequence[tuple[str, str]] = ()
    called: str = ""
    phrases: Callable[[Sequence[Token], str], list[Token]] | None = None

    def tokens(self, text: str) -> Sequence[Token]:
        """Return the tokens of a text, with its amounts, photos and phrases put together."""
        return _tokens(text, self)

    @cached_property
    def restated_idioms(self) -> Idioms:
        return Idioms(self.idioms)

    @cached_property
    def putting_first(self) -> Prefiltered:
        return Prefiltered(self.put_first)

    def limits_command(self, denial: str) -> bool:
        """Return whether a denial with unknown words, in lower case, may limit what is commanded beside it: "don't go
        past the door"."""
        return bool(self._prohibits.match(denial)) and not self._reassures.search(denial)

    @cached_property
    def _prohibits(self) -> re.Pattern[str]:
        return re.compile(self.prohibits)

    @cached_property
    def _reassures(self) -> re.Pattern[str]:
        return re.compile(self.reassures)

    @cached_property
    def calls(self) -> Prefiltered:
        return Prefiltered(self.called)

    def says_path_is_clear(self, clause: str) -> bool:
        """Return whether a clause in lower case only says that nothing is in the way: "nobody is behind you"."""
        return self._clear_path.fullmatch(clause.strip()) is not None

    @cached_property
    def _clear_path(self) -> re.Pattern[str]:
        return re.compile(self.clear_path)

    def states(self, clause: str) -> bool:
        """Return whether a clause in lower case is a statement, by its form or its words."""
        return self.has_form_of_remark(clause) or self.reads_as_statement(clause)

    def has_form_of_remark(self, clause: str) -> bool:
        return bool(self.remark) and self._remarks.search(clause) is not None

    def reads_as_statement(self, clause: str) -> bool:
        """Return whether the classifier takes a clause for a statement."""
        return self.statements is not None and self.statements.is_statement(clause)

    def surely_states(self, clause: str) -> bool:
        """Return whether the classifier is sure that a clause is a statement."""
        return self.statements is not None and self.statements.is_statement(clause, sure=True)

    def may_be_talk(self, clause: str) -> bool:
        """Return whether a clause may be talk beside a statement, by the classifier."""
        return self.statements is not None and self.statements.may_be_talk(clause)

    def harmless(self, clause: str) -> Confidence:
        """Return how surely a clause may be left out beside a command, by the classifier."""
        return Confidence.LIKELY if self.statements is None else self.statements.harmless(clause)

    @cached_property
    def _remarks(self) -> re.Pattern[str]:
        return re.compile(self.remark)

    @property
    def code(self) -> str:
        """The ISO 639-1 code: en, zh."""
        return self.words.language


@lru_cache(maxsize=128)  # a clause is read again, with and without what stands beside it
def _tokens(text: str, known: Locale) -> tuple[Token, ...]:
    tokens = with_pictures(with_amounts(tokens_of(text, known.words)[0], text))
    return tuple(known.phrases(tokens, text) if known.phrases else tokens)
