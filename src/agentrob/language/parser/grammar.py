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
from agentrob.language.parser.lexicon import Lexicon, Soft, TokenKind, tokens_of, without_statements
from agentrob.language.parser.order import in_order, in_plain_words, items_of
from agentrob.language.parser.remarks import names_deed, without_remarks
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.robot_order import ordering_words
from agentrob.language.parser.small_talk import SmallTalk, small_talk_in
from agentrob.language.parser.steps import ParsedSteps, read_steps
from agentrob.language.registry import language_of, locale
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.talk.forms import is_spoken_of, is_talk, order_beside, topic_of
from agentrob.language.visible_text import without_mentions
from agentrob.model import Capabilities, Intent, Language, Op, Plan, Primitive, Understanding

#: Longer texts are not parsed as commands (stops still are), so that parsing stays fast.
MAX_CHARS = 2_000
_WORDLESS = re.compile(r"[\s.,:;!?…。，：；！？]*")
#: Longer texts are parsed once, as they stand.
_LONGEST_RESTATED = 500
_EMOTICON = re.compile(r"(?:(?<=\s)|^)(?:[:;=]['’]?-?[)(DPp3*]|<3+|\^_?\^|[xX]D|T_T|o_o)(?=\s|$|[.!?,])")
#: Words that rank the items of a list in another order than their numbers.
_RANKED = re.compile(r"\b(?:first|last|lastly|before|after|afterwards|finally)\b|先|最后|之前|之后", re.IGNORECASE)
_CLAUSE_END = re.compile(r"(?<!\d)[,.;!](?!\d)|[，。；！\n]")
_FIRST_JOINT = re.compile(r"[,.;!，。；！]|\b(?:and|but|just)\b", re.IGNORECASE)
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
    part = _EMOTICON.sub(lambda found: " " * len(found[0]), part_for(visible, names, others))
    language = language_of(part)
    if stop := stop_intent(part):
        picture = remarks and stop is Intent.STOP and _picture_at_rest(part, names, language, ops, background)
        return picture or Understanding(stop, language)
    if part and (words := ordering_words(visible, names, others)):
        return _ask(ParsedSteps([], [], say("ask.order", language, words=quote(words))), ops, language, background.can)
    if len(part) > MAX_CHARS:
        return _ask(ParsedSteps([], [], say("ask.long", language, chars=MAX_CHARS)), ops, language)
    understood = _understood(part, names, language, ops, background, asks=True)
    unclear = understood.intent in (Intent.ASK_BACK, Intent.NOTHING)
    if remarks and unclear and len(part) <= _LONGEST_RESTATED:
        understood = (
            _listed(part, names, language, ops, background)
            or _in_order(part, names, language, ops, background)
            or _beside_remarks(part, names, language, ops, background)
            or _in_plain_words(part, names, language, ops, background)
            or (understood.intent is Intent.NOTHING and _command_within(part, names, language, ops, background))
            or understood
        )
    if words := _put_first(part, understood.plan, names, language):
        steps = list(understood.plan.steps)
        swapped = [steps[::-1]] if len(steps) == 2 else []
        problem = say("ask.first", language, words=quote(words))
        return _ask(ParsedSteps([], [], problem, offers=swapped), ops, language, background.can)
    if understood.intent is Intent.NOTHING and (words := _order_beside(part, language)):
        problem = say("ask.besides", language, words=quote(words))
        return _ask(ParsedSteps([], [], problem), ops, language, background.can)
    if understood.intent in (Intent.ASK_BACK, Intent.COMMAND) and _only_talks(part, understood, language):
        return Understanding(Intent.NOTHING, language)
    return understood


def _order_beside(part: str, language: Language) -> str:
    """Return an order behind talk that the grammar passes over; empty if there is none."""
    known = locale(language)
    return order_beside(part.translate(known.words.twins), known.talk, lambda clause: names_deed(clause, known))


def _only_talks(part: str, understood: Understanding, language: Language) -> bool:
    """Return whether a post is only talk (see `talk.forms`), although the grammar reads or suspects a command."""
    known = locale(language)
    plain = part.translate(known.words.twins)
    if is_spoken_of(plain, known.talk):
        return True
    return understood.intent is Intent.ASK_BACK and is_talk(
        plain, known.remark, known.talk, lambda clause: names_deed(clause, known)
    )


def _put_first(part: str, plan: Plan, names: Sequence[str], language: Language) -> str:
    """Return the words that put a later clause before an earlier one ("walk 1 m, but wave first"); empty if none do."""
    if len(plan.steps) < 2 or not re.search(locale(language).put_first, part.lower()):
        return ""
    rest, _ = without_remarks(part, locale(language))
    for found in re.finditer(locale(language).put_first, rest.lower()):
        before = rest[: found.start()]
        read = _understood(before, names, language, frozenset(), _NOTHING_KNOWN)
        read = _in_order(before, names, language, frozenset(), _NOTHING_KNOWN) or read
        if read.plan.steps:
            return found[0].strip(" ,.;!，。；！")
    return ""


def asks_for_picture_at_rest(text: str) -> bool:
    """Return whether a text only denies motion and asks for a picture: "don't move, just take a photo"."""
    return _picture_at_rest(text, (), language_of(text), frozenset(Op), _NOTHING_KNOWN) is not None


def _picture_at_rest(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return the plan of pictures beside a "don't move"; None if there is anything else."""
    if not (joint := _FIRST_JOINT.search(part)) or len(part) > _LONGEST_RESTATED:
        return None
    denials, rest = _sentences(part[: joint.start()], names, language)[0], part[joint.end() :]
    if not all(s.denied and not s.drafts for s in denials) or stop_intent(rest):
        return None
    understood = _understood(rest, names, language, ops, background)
    pictures = understood.plan.steps and all(step.op is Op.GET_FRONT_IMAGE for step in understood.plan.steps)
    if not pictures or understood.intent is not Intent.COMMAND:
        return None
    note = say("note.not_done", language, words=quote(part[: joint.start()].strip()))
    return replace(understood, plan=replace(understood.plan, notes=(note, *understood.plan.notes)))


def _understood(
    part: str,
    names: Sequence[str],
    language: Language,
    ops: frozenset[Op],
    background: ParseContext,
    *,
    asks: bool = False,
) -> Understanding:
    """Read a text as it stands; with `asks` the question is worded if there is one, which takes time."""
    sentences, mistyped = _sentences(part, names, language)
    reading = read_steps(sentences, part, language, ops, background)
    if reading.problem:
        asked = _without_command(sentences, language)
        if asked is None and not asks:
            return Understanding(Intent.ASK_BACK, language)
        return asked or _ask(reading, ops, language, background.can)
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
    return _with_left_out(understood, remarks, language)


def _with_left_out(understood: Understanding, remarks: Sequence[str], language: Language) -> Understanding:
    told = [say("note.left_out", language, words=quote(words)) for words in remarks]
    notes = (*understood.plan.notes, *told)
    return replace(understood, plan=replace(understood.plan, notes=notes))


def _command_within(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return a question about what stands beside a complete command in a post that would get no answer."""
    clauses = [clause.strip() for clause in _CLAUSE_END.split(part) if clause.strip()]
    for clause in clauses if len(clauses) > 1 else ():
        understood = _understood(clause, names, language, ops, background)
        if understood.intent is Intent.COMMAND:
            beside = next((other for other in clauses if other != clause), clause)
            problem = say("ask.besides", language, words=quote(beside))
            return _ask(ParsedSteps([], [], problem), ops, language, background.can)
    return None


def _listed(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return the command of a numbered list on one line, of which each item is complete; None if it is none.

    An item about which something is assumed is not complete: in "turn left 2. wave" the number may be its amount.
    """
    items = items_of(part)
    if not items or _RANKED.search(part):
        return None
    plans = [_understood(item, names, language, ops, background).plan for item in items]
    if not all(plan.steps for plan in plans) or any(plan.notes for plan in plans[:-1]):
        return None
    understood = _understood(". ".join(items), names, language, ops, background)
    return understood if understood.intent is Intent.COMMAND else None


def _in_order(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return the command when its clauses are put into the order of doing; None if they cannot be."""
    words = locale(language).in_order
    if words is None:
        return None

    def steps(text: str) -> int:
        understood = _understood(text, names, language, ops, background)
        return len(understood.plan.steps) if understood.intent is Intent.COMMAND else 0

    restated = in_order(part, words, steps)
    if restated == part or _repeats(restated, language):
        return None
    understood = _understood(restated, names, language, ops, background)
    if understood.intent is not Intent.COMMAND:
        understood = _beside_remarks(restated, names, language, ops, background) or understood
    return understood if understood.intent is Intent.COMMAND else None


def _in_plain_words(
    part: str, names: Sequence[str], language: Language, ops: frozenset[Op], background: ParseContext
) -> Understanding | None:
    """Return the command when the idioms of a post are put into plain words; None if it is still none."""
    plain, left = in_plain_words(part.translate(locale(language).words.twins), locale(language).idioms)
    if plain == part.translate(locale(language).words.twins) or stop_intent(plain):
        return None
    understood: Understanding | None = _understood(plain, names, language, ops, background)
    if understood is None or understood.intent is not Intent.COMMAND:
        understood = _in_order(plain, names, language, ops, background)
        understood = understood or _beside_remarks(plain, names, language, ops, background)
    return _with_left_out(understood, left, language) if understood else None


def _repeats(text: str, language: Language) -> bool:
    """Return whether a text repeats what was said ("do all of that twice"): where its parts stand then matters."""
    read = with_pictures(with_amounts(tokens_of(text, locale(language).words)[0], text))
    tokens = [token for token in read if token.kind is not TokenKind.SOFT]
    following = [token.kind for token in tokens[1:]] + [TokenKind.END]
    acts = (TokenKind.OP, TokenKind.MOVE, TokenKind.TURN)  # "again take a photo"
    return any(t.kind is TokenKind.AGAIN and after not in acts for t, after in zip(tokens, following, strict=True))


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


_ASIDE_KINDS = (TokenKind.CONDITION, TokenKind.BEYOND, TokenKind.EACH)
_LEADS_TO_THING = (Soft.TO, Soft.THE, Soft.TOWARDS, Soft.OBJECT)


def asks_for_more(words: str, language: Language) -> bool:
    """Return whether the words that an action leaves over change or extend it (law 18): a condition, an order in time,
    a place or a thing, an ability that robots lack. Unknown words alone may be how somebody speaks.
    """
    tokens, _ = tokens_of(words, locale(language).words)
    if any(token.kind in _ASIDE_KINDS or token.value == "place" for token in tokens):
        return True
    return any(
        before.kind is TokenKind.SOFT and before.value in _LEADS_TO_THING and after.kind is TokenKind.WORD
        for before, after in pairwise(tokens)
    )


def reorders(text: str, language: Language) -> bool:
    """Return whether a text may put a later clause before an earlier one ("…, but first wave", "wave after …")."""
    tokens, _ = tokens_of(text, locale(language).words)
    return any(t.kind is TokenKind.CONDITION for t in tokens) or bool(
        re.search(locale(language).put_first, text.lower())
    )


def small_talk_of(visible: str, names: Sequence[str], others: Sequence[str]) -> SmallTalk | None:
    """Classify a post in which `parse` finds no command: a cancellation, a question, a report; None if unclear."""
    part = part_for(visible, names, others)
    if len(part) > MAX_CHARS or stop_intent(part):
        return None
    if _WORDLESS.fullmatch(part):  # "@robot" alone; beside words for others it is only mentioned
        return SmallTalk.GREETING if _WORDLESS.fullmatch(without_mentions(visible)) else None
    return small_talk_in(_sentences(part, names, language_of(part))[0])


def talk_topic_of(visible: str, names: Sequence[str], others: Sequence[str]) -> str:
    """Return what a post without a command talks about ("joke", "see", "who", …); empty if that is not known."""
    part = part_for(visible, names, others)
    return topic_of(part, locale(language_of(part)).talk) if len(part) <= MAX_CHARS else ""


def _sentences(part: str, names: Sequence[str], language: Language) -> tuple[list[Sentence], list[tuple[str, str]]]:
    words = locale(language).words
    called = _without_names(without_statements(part, locale(language).stated, words.twins), names, words)
    if pet_names := locale(language).called:
        called = re.sub(pet_names, _without_name, called, flags=re.IGNORECASE)
    tokens, mistyped = tokens_of(called, words)
    tokens = with_pictures(with_amounts(tokens, called))
    phrases = locale(language).phrases
    return sentences_of(phrases(tokens, called) if phrases else tokens), mistyped


def _without_name(call: re.Match[str]) -> str:
    start, end = (at - call.start() for at in call.span("name"))
    return call[0][:start] + " " * (end - start) + call[0][end:]


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
    known = can or Capabilities("", ops)
    offers = _offered(known, reading.offers) or [_general_example(known)]
    examples = " · ".join(f"`{sentence(steps, language)}`" for steps in offers)
    question = say("ask.frame", language, problem=reading.problem, understood=understood, examples=examples)
    return Understanding(Intent.ASK_BACK, language, question=question)


def _general_example(can: Capabilities) -> list[Primitive]:
    """Return a command that works with this robot, for a post from which none can be made."""
    firsts = {step.op: step for step in reversed(help_examples(can))}
    motions = [firsts[op] for op in (Op.MOVE, Op.TURN) if op in firsts]
    return motions or list(firsts.values())[:1]


#: The most sentences that a question offers.
_MOST_OFFERS = 2


def _offered(can: Capabilities, plans: Sequence[Sequence[Primitive]]) -> list[list[Primitive]]:
    """Return at most two of these plans, each shortened to what this robot can do in one step and in one command."""
    found: list[list[Primitive]] = []
    for plan in plans:
        steps = [within(step, can) for step in plan]
        far = sum(step.distance_m or 0.0 for step in steps) > can.limits.command_m
        if all(_goes(step, can) for step in steps) and 0 < len(steps) <= can.limits.command_steps and not far:
            found += [steps] if steps not in found else []
    return found[:_MOST_OFFERS]


def _goes(step: Primitive, can: Capabilities) -> bool:
    return step.op in can.ops and (step.op is not Op.MOVE or step.direction in can.move_directions)
