"""Parse the visible text of a post into what one robot is asked to do, in English or Chinese, without a model.

    text ── addressing ──► text for this robot ── lexicon ──► tokens ── amounts ──► tokens with metres and degrees
         ── clauses ──► one draft per step ── steps ──► steps, or a question

To add a word, add it to the table of its language (`locales/en.py`, `locales/zh.py`). To add a language, add a file
beside them: see `docs/languages.md`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from agentrob.language.addressing import part_for
from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.help import examples as help_examples
from agentrob.language.messages.help import within
from agentrob.language.messages.plan_text import outline, sentence
from agentrob.language.parser.amounts import with_amounts, with_pictures
from agentrob.language.parser.clauses import sentences_of
from agentrob.language.parser.drafts import RemarkKind, Sentence
from agentrob.language.parser.lexicon import Lexicon, TokenKind, tokens_of, without_statements
from agentrob.language.parser.remarks import without_remarks
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.robot_order import ordering_words
from agentrob.language.parser.small_talk import SmallTalk, small_talk_in
from agentrob.language.parser.steps import ParsedSteps, read_steps
from agentrob.language.registry import language_of, locale
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.visible_text import without_mentions
from agentrob.model import Capabilities, Intent, Language, Op, Plan, Primitive, Understanding

#: Longer texts are not parsed as commands (stops still are), so that parsing stays fast.
MAX_CHARS = 2_000
_WORDLESS = re.compile(r"[\s.,:;!?…。，：；！？]*")
_NOTHING_KNOWN = ParseContext()


def parse(
    visible: str,
    names: Sequence[str],
    others: Sequence[str],
    ops: frozenset[Op],
    background: ParseContext = _NOTHING_KNOWN,
    *,
    remarks: bool = True,
) -> Understanding:
    """Parse the part of `visible` (law 3) that is for the robot called `names`; `others` are other robots' handles.

    Only `Intent.COMMAND` carries a plan. `ops` are the robot's operations, from which examples in questions are taken.
    A request for another operation is parsed too, so that the screen can say that the robot cannot do it. `background`
    is the context: earlier plans in the thread, the robot's speed and step length. Without `remarks`, a post with a
    remark in words that the grammar does not know is asked back.
    """
    part = part_for(visible, names, others)
    language = language_of(part)
    if stop := stop_intent(part):
        return Understanding(stop, language)
    if part and (words := ordering_words(visible, names, others)):
        return _ask(ParsedSteps([], [], say("ask.order", language, words=quote(words))), ops, language, background.can)
    if len(part) > MAX_CHARS:
        return _ask(ParsedSteps([], [], say("ask.long", language, chars=MAX_CHARS)), ops, language)
    understood = _understood(part, names, language, ops, background)
    if len(understood.plan.steps) > 1 and (first := re.search(locale(language).put_first, part.lower())):
        words = first[0].strip(" ,.;!，。；！")  # "walk 1 m, but wave first": the other way round
        return _ask(ParsedSteps([], [], say("ask.words", language, words=quote(words))), ops, language, background.can)
    if remarks and understood.intent in (Intent.ASK_BACK, Intent.NOTHING):
        return _beside_remarks(part, names, language, ops, background) or understood
    return understood


def _understood(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding:
    sentences, mistyped = _sentences(part, names, language)
    reading = read_steps(sentences, part, language, ops, background)
    if reading.problem:
        return _without_command(sentences, language) or _ask(reading, ops, language, background.can)
    if reading.steps:
        spelt = [say("note.spelling", language, wrong=quote(wrong), right=quote(right)) for wrong, right in mistyped]
        return Understanding(Intent.COMMAND, language, Plan(tuple(reading.steps), (*spelt, *reading.notes)))
    return _without_command(sentences, language) or Understanding(Intent.NOTHING, language)


def _beside_remarks(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return the command that is left when remarks are left out, each told in a note; None if there is none."""
    rest, remarks = without_remarks(part, locale(language))
    if not remarks or _WORDLESS.fullmatch(rest):
        return None
    understood = _understood(rest, names, language, ops, background)
    steps = understood.plan.steps
    if understood.intent is not Intent.COMMAND or any(a == b and a.direction for a, b in pairwise(steps)):
        return None  # a motion that is said again after a remark may be the same one
    told = [say("note.left_out", language, words=quote(words)) for words in remarks]
    notes = (*understood.plan.notes, *told)
    return replace(understood, plan=replace(understood.plan, notes=notes))


def commands_nothing(words: str, language: Language) -> bool:
    """Return whether words are only politeness or a remark, which may be left out beside a command (law 18).

    Unknown words, questions and requests for an answer may ask for something, so they do not count.
    """
    if not words.strip():
        return True
    sentences, _ = _sentences(words, (), language)
    marked = (s.wants_status or s.help or s.cancelled or s.condition or s.denied or s.fix_unclear for s in sentences)
    remarks = [r for s in sentences for r in s.remarks]
    plain = all(r.kind is RemarkKind.REMARK and not (r.actions or r.beyond) for r in remarks)
    return plain and not any(marked) and not any(s.drafts or s.asked for s in sentences)


def small_talk_of(visible: str, names: Sequence[str], others: Sequence[str]) -> SmallTalk | None:
    """Classify a post in which `parse` finds no command: a cancellation, a question, a report; None if unclear."""
    part = part_for(visible, names, others)
    if len(part) > MAX_CHARS or stop_intent(part):
        return None
    if _WORDLESS.fullmatch(part):  # "@robot" alone; beside words for others it is only mentioned
        return SmallTalk.GREETING if _WORDLESS.fullmatch(without_mentions(visible)) else None
    return small_talk_in(_sentences(part, names, language_of(part))[0])


def _sentences(part: str, names: Sequence[str], language: Language) -> tuple[list[Sentence], list[tuple[str, str]]]:
    words = locale(language).words
    called = _without_names(without_statements(part, locale(language).stated, words.twins), names, words)
    tokens, mistyped = tokens_of(called, words)
    tokens = with_pictures(with_amounts(tokens, called))
    phrases = locale(language).phrases
    return sentences_of(phrases(tokens, called) if phrases else tokens), mistyped


def _without_names(part: str, names: Sequence[str], words: Lexicon) -> str:
    """Blank out the robot's own name without an @ ("Rex, sit"), unless the name is also a known word."""
    for name in names:
        if (name.lower(),) not in words.phrases:
            part = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", " " * len(name), part, flags=re.IGNORECASE)
    return part


def _without_command(sentences: Sequence[Sentence], language: Language) -> Understanding | None:
    """Return help or status if the post asks for it and requests no motion."""
    drafts = [d for s in sentences for d in s.drafts]
    if any(d.is_motion or d.op or d.verb is TokenKind.BEYOND for d in drafts):
        return None
    if any(s.help for s in sentences):
        return Understanding(Intent.HELP, language)
    if any(s.wants_status for s in sentences):
        return Understanding(Intent.STATUS, language)
    return None


def _ask(
    reading: ParsedSteps, ops: frozenset[Op], language: Language, can: Capabilities | None = None
) -> Understanding:
    understood = say("ask.understood", language, steps=outline(reading.steps, language)) if reading.steps else ""
    limits = can or Capabilities("", ops)
    examples = " · ".join(f"`{sentence(steps, language)}`" for steps in _examples(limits, reading.hints))
    question = say("ask.frame", language, problem=reading.problem, understood=understood, examples=examples)
    return Understanding(Intent.ASK_BACK, language, question=question)


def _examples(can: Capabilities, hints: Sequence[Sequence[Primitive]]) -> list[list[Primitive]]:
    """Return two commands that work with this robot, first those similar to what was not understood."""
    steps = help_examples(can)
    firsts = {step.op: step for step in reversed(steps)}
    chain = [firsts[op] for op in (Op.MOVE, Op.TURN) if op in firsts]
    pictured = [firsts[op] for op in (Op.TURN, Op.GET_FRONT_IMAGE) if op in firsts]
    found = [[within(step, can) for step in steps] for steps in hints if all(_goes(step, can) for step in steps)]
    found += [c for c in (chain, pictured) if len(c) > 1]
    found += [chain] + [[step] for step in steps if step.op not in (Op.MOVE, Op.TURN)]
    return [c for at, c in enumerate(found) if c and c not in found[:at]][:2]


def _goes(step: Primitive, can: Capabilities) -> bool:
    return step.op in can.ops and (step.op is not Op.MOVE or step.direction in can.move_directions)
