"""Parse the visible text of a post into what one robot is asked to do, in English or Chinese, without a model.

    text ── addressing ──► text for this robot ── lexicon ──► tokens ── amounts ──► tokens with metres and degrees
         ── clauses ──► one draft per step ── steps ──► steps, or a question

To add a word, add it to the table of its language (`locales/en_words.py`, `locales/zh_words.py`). To add a language,
add a file beside them: see `docs/inside/languages.md`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

from agentrob.language.addressing import part_for
from agentrob.language.locale import Locale
from agentrob.language.messages.catalog import quote, say
from agentrob.language.messages.help import examples as help_examples
from agentrob.language.messages.help import within
from agentrob.language.messages.plan_text import outline, sentence
from agentrob.language.operations.spoken import POSTURES
from agentrob.language.operations.words import locale_of, own_words
from agentrob.language.parser.clauses import sentences_of
from agentrob.language.parser.drafts import RemarkKind, Sentence
from agentrob.language.parser.lexicon import Lexicon, Soft, TokenKind, tokens_of, without_statements
from agentrob.language.parser.order import in_order, items_of
from agentrob.language.parser.remarks import Clauses, without_remarks
from agentrob.language.parser.repetition import ParseContext
from agentrob.language.parser.robot_order import ordering_words
from agentrob.language.parser.small_talk import SmallTalk, small_talk_in
from agentrob.language.parser.steps import ParsedSteps, read_steps
from agentrob.language.registry import language_of, locale
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.talk.forms import Judges, is_spoken_of, is_talk, order_beside, topic_of
from agentrob.language.visible_text import without_mentions
from agentrob.model import (
    PHOTO,
    BaseMotion,
    Capabilities,
    Intent,
    Language,
    Op,
    Operation,
    Plan,
    Primitive,
    Understanding,
)

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
#: Operations that change nothing when they are done again at once.
_NOTHING_KNOWN = ParseContext()


def parse(
    visible: str,
    names: Sequence[str],
    others: Sequence[str],
    ops: frozenset[str],
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
    reader = _Reader(names, language, ops, background)
    if stop := stop_intent(part):
        picture = remarks and stop is Intent.STOP and reader.picture_at_rest(part)
        return picture or Understanding(stop, language)
    if part and (words := ordering_words(visible, names, others)):
        return reader.ask("ask.order", words=quote(words))
    if len(part) > MAX_CHARS:
        return _Reader(names, language, ops).ask("ask.long", chars=MAX_CHARS)
    understood = reader.understood(part)
    unclear = understood.intent in (Intent.ASK_BACK, Intent.NOTHING)
    if remarks and unclear and len(part) <= _LONGEST_RESTATED:
        understood = reader.restated(part) or understood
    if words := reader.put_first(part, understood.plan):
        steps = list(understood.plan.steps)
        return reader.ask("ask.first", [steps[::-1]] if len(steps) == 2 else [], words=quote(words))
    if understood.intent is Intent.NOTHING and (words := reader.order_beside(part)):
        return reader.ask("ask.besides", words=quote(words))
    if understood.intent in (Intent.ASK_BACK, Intent.COMMAND) and reader.only_talks(part, understood):
        return Understanding(Intent.NOTHING, language)
    return reader.asked(part) if understood.intent is Intent.ASK_BACK and not understood.question else understood


class _Reader:
    """Reads the texts that are made of one post, for one robot; each clause is read once."""

    def __init__(
        self,
        names: Sequence[str],
        language: Language,
        ops: frozenset[str],
        background: ParseContext = _NOTHING_KNOWN,
    ) -> None:
        self.names = names
        self.language = language
        self.ops = ops
        self.background = background
        self.declared = background.can.declared if background.can else ()
        self.known = locale_of(language, self.declared)
        self._clauses = Clauses(self.known)
        self._read: dict[str, tuple[Understanding, ParsedSteps]] = {}

    def understood(self, text: str) -> Understanding:
        """Read a text as it stands. The question about what is not understood is worded by `asked`."""
        return self._reading(text)[0]

    def _reading(self, text: str) -> tuple[Understanding, ParsedSteps]:
        if text not in self._read:
            sentences, mistyped = _sentences(text, self.names, self.known, self.declared)
            steps = read_steps(sentences, text, self.language, self.ops, self.background)
            self._read[text] = self._judged(sentences, mistyped, steps), steps
        return self._read[text]

    def _judged(
        self, sentences: Sequence[Sentence], mistyped: Sequence[tuple[str, str]], read: ParsedSteps
    ) -> Understanding:
        if read.steps and not read.problem:
            spelt = [
                say("note.spelling", self.language, wrong=quote(wrong), right=quote(right)) for wrong, right in mistyped
            ]
            steps = map(self.background.can.bound, read.steps) if self.background.can else read.steps
            return Understanding(Intent.COMMAND, self.language, Plan(tuple(steps), (*spelt, *read.notes)))
        otherwise = Intent.ASK_BACK if read.problem else Intent.NOTHING
        return _without_command(sentences, self.language) or Understanding(otherwise, self.language)

    def _command(self, text: str) -> Understanding | None:
        """Return the command that a text is as it stands; None if it is none."""
        understood = self.understood(text)
        return understood if understood.intent is Intent.COMMAND else None

    # ------------------------------------------------------------------ questions
    def asked(self, text: str) -> Understanding:
        """Return the question about what is not understood of a text."""
        steps = self._reading(text)[1]
        if not steps.unfit and len(text) <= _LONGEST_RESTATED:
            plain = self._reading(self.known.restated_idioms.in_plain_words(text.translate(self.known.words.twins))[0])[
                1
            ]
            steps = plain if plain.unfit and plain.doubts == 1 else steps  # "walk a 9 m square"
        done = say("ask.understood", self.language, steps=outline(steps.steps, self.language)) if steps.steps else ""
        return self._question(steps.problem, steps.offers, done)

    def ask(self, key: str, offers: Sequence[Sequence[Primitive]] = (), **values: object) -> Understanding:
        """Return a question with the sentence `key`."""
        return self._question(say(key, self.language, **values), offers)

    def _question(self, problem: str, offers: Sequence[Sequence[Primitive]], understood: str = "") -> Understanding:
        known = self.background.abilities(self.ops)
        offered = _offered(known, offers) or [_general_example(known)]
        examples = " · ".join(f"`{sentence(steps, self.language)}`" for steps in offered)
        question = say("ask.frame", self.language, problem=problem, understood=understood, examples=examples)
        return Understanding(Intent.ASK_BACK, self.language, question=question)

    # ------------------------------------------------------------------ other ways to read a post
    def restated(self, part: str) -> Understanding | None:
        """Return what a post that is no command as it stands is in other words; None if nothing better is found."""
        return (
            self._listed(part)
            or self._in_order(part)
            or self._beside_remarks(part)
            or self._in_plain_words(part)
            or (self._command_within(part) if self.understood(part).intent is Intent.NOTHING else None)
        )

    def _listed(self, part: str) -> Understanding | None:
        """Return the command of a numbered list on one line, of which each item is complete; None if it is none.

        An item about which something is assumed is not complete: in "turn left 2. wave" the number may be its amount.
        """
        items = items_of(part)
        if not items or _RANKED.search(part):
            return None
        plans = [self.understood(item).plan for item in items]
        if not all(plan.steps for plan in plans) or any(plan.notes for plan in plans[:-1]):
            return None
        return self._command(". ".join(items))

    def _in_order(self, part: str) -> Understanding | None:
        """Return the command when its clauses are put into the order of doing; None if they cannot be."""
        if self.known.in_order is None:
            return None

        def steps(text: str) -> int:
            return len(self.understood(text).plan.steps)

        restated = in_order(part, self.known.in_order, steps)
        if restated == part:
            return None
        understood = self._command(restated) or self._beside_remarks(restated)
        return None if understood and self._repeats(restated) else understood

    def _repeats(self, text: str) -> bool:
        """Return whether a text repeats what was said ("do all of that twice"): where its parts stand then matters."""
        tokens = [token for token in self.known.tokens(text) if token.kind is not TokenKind.SOFT]
        following = [token.kind for token in tokens[1:]] + [TokenKind.END]
        acts = (TokenKind.OP, TokenKind.MOVE, TokenKind.TURN)  # "again take a photo"
        return any(t.kind is TokenKind.AGAIN and after not in acts for t, after in zip(tokens, following, strict=True))

    def _beside_remarks(self, part: str) -> Understanding | None:
        """Return the command that is left when remarks are left out, each reported in a note; None if there is none."""
        rest, remarks = without_remarks(part, self._clauses)
        if not remarks or _WORDLESS.fullmatch(rest):
            return None
        understood = self._command(rest)
        if understood is None or any(
            a == b and (a.direction or a.op in POSTURES) for a, b in pairwise(understood.plan.steps)
        ):
            return None  # a motion or a posture that is said again after a remark may be the same one
        return self._with_left_out(understood, remarks)

    def _in_plain_words(self, part: str) -> Understanding | None:
        """Return the command when the idioms of a post are put into plain words; None if it is still none."""
        standard = part.translate(self.known.words.twins)
        plain, left = self.known.restated_idioms.in_plain_words(standard)
        if plain == standard or stop_intent(plain):
            return None
        understood = self._command(plain) or self._in_order(plain) or self._beside_remarks(plain)
        return self._with_left_out(understood, left) if understood else None

    def _with_left_out(self, understood: Understanding, remarks: Sequence[str]) -> Understanding:
        left_out = [say("note.left_out", self.language, words=quote(words)) for words in remarks]
        notes = (*understood.plan.notes, *left_out)
        return replace(understood, plan=replace(understood.plan, notes=notes))

    def _command_within(self, part: str) -> Understanding | None:
        """Return a question about what stands beside a complete command in a post that would get no answer."""
        clauses = [clause.strip() for clause in _CLAUSE_END.split(part) if clause.strip()]
        for clause in clauses if len(clauses) > 1 else ():
            if self._command(clause):
                beside = next((other for other in clauses if other != clause), clause)
                return self.ask("ask.besides", words=quote(beside))
        return self._conditional(part)

    def _conditional(self, part: str) -> Understanding | None:
        """Return a question about the condition in a post that is not understood as a command: "after they left walk
        1 m"."""
        tokens = self.known.tokens(part)
        condition = next((token for token in tokens if token.kind is TokenKind.CONDITION), None)
        for before, token in pairwise(tokens):
            if condition is None or token.kind not in _BEGINS_COMMAND or token.start < condition.end:
                continue
            if before.value != Soft.TO and self._command(part[token.start :]):  # not "if I told you to walk 2 m"
                return self.ask("ask.condition", words=quote(part[condition.start : condition.end]))
        return None

    def picture_at_rest(self, part: str) -> Understanding | None:
        """Return the plan of pictures beside a "don't move"; None if there is anything else."""
        if not (joint := _FIRST_JOINT.search(part)) or len(part) > _LONGEST_RESTATED:
            return None
        denial, rest = part[: joint.start()], part[joint.end() :]
        denials, _ = _sentences(denial, self.names, self.known, self.declared)
        if not all(s.denied and not s.drafts for s in denials) or stop_intent(rest):
            return None
        understood = self._command(rest)
        if understood is None or any(step.op is not PHOTO for step in understood.plan.steps):
            return None
        note = say("note.not_done", self.language, words=quote(denial.strip()))
        return replace(understood, plan=replace(understood.plan, notes=(note, *understood.plan.notes)))

    # ------------------------------------------------------------------ what else a post says
    def put_first(self, part: str, plan: Plan) -> str:
        """Return the words that put a later clause before an earlier one ("walk 1 m, but wave first"); empty if none
        do."""
        if len(plan.steps) < 2 or not any(self.known.putting_first.finditer(part.lower())):
            return ""
        anywhere = _Reader(self.names, self.language, frozenset(), ParseContext(can=self.background.can))
        rest, _ = without_remarks(part, self._clauses)
        for found in self.known.putting_first.finditer(rest.lower()):
            before = rest[: found.start()]
            if (anywhere._in_order(before) or anywhere.understood(before)).plan.steps:
                return found[0].strip(" ,.;!，。；！")
        return ""

    def order_beside(self, part: str) -> str:
        """Return an order behind talk that the grammar passes over; empty if there is none."""
        return order_beside(part.translate(self.known.words.twins), self.known.talk, self._names_action)

    def only_talks(self, part: str, understood: Understanding) -> bool:
        """Return whether a post is only talk (see `talk.forms`), although the grammar reads or suspects a command."""
        plain = part.translate(self.known.words.twins)
        if is_spoken_of(plain, self.known.talk):
            return True
        if understood.intent is not Intent.ASK_BACK:
            return False
        known = self.known
        judges = Judges(known.states, known.surely_states, known.may_be_talk, self._asks_for_action)
        return is_talk(plain, known.talk, judges)

    def _asks_for_action(self, words: str) -> bool:
        """Return whether a clause names an action and does not read as a statement."""
        clause = self._clauses[words]
        return self._names_action(words) and (clause.directs or not self.known.reads_as_statement(clause.plain))

    def _names_action(self, words: str) -> bool:
        clause = self._clauses[words]
        again = any(token.kind is TokenKind.AGAIN for token in clause.tokens)
        return clause.names_action and (again or clause.without_asides.names_action)


def asks_for_picture_at_rest(text: str) -> bool:
    """Return whether a text only denies motion and asks for a picture: "don't move, just take a photo"."""
    return _Reader((), language_of(text), frozenset(Op)).picture_at_rest(text) is not None


def commands_nothing(words: str, language: Language) -> bool:
    """Return whether words are only politeness or a remark, which may be left out beside a command (law 18).

    Unknown words, questions and requests for an answer may ask for something, so they do not count.
    """
    if not words.strip():
        return True
    sentences, _ = _sentences(words, (), locale(language))
    marked = (s.wants_status or s.help or s.cancelled or s.condition or s.denied or s.fix_unclear for s in sentences)
    remarks = [r for s in sentences for r in s.remarks]
    plain = all(r.kind is RemarkKind.REMARK and not (r.actions or r.beyond) for r in remarks)
    return plain and not any(marked) and not any(s.drafts or s.asked for s in sentences)


_BEGINS_COMMAND = (TokenKind.MOVE, TokenKind.TURN, TokenKind.OP, TokenKind.DIR)
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
    return any(t.kind is TokenKind.CONDITION for t in tokens) or any(
        locale(language).putting_first.finditer(text.lower())
    )


def small_talk_of(visible: str, names: Sequence[str], others: Sequence[str]) -> SmallTalk | None:
    """Classify a post in which `parse` finds no command: a cancellation, a question, a report; None if unclear."""
    part = part_for(visible, names, others)
    if len(part) > MAX_CHARS or stop_intent(part):
        return None
    if _WORDLESS.fullmatch(part):  # "@robot" alone; beside words for others it is only mentioned
        return SmallTalk.GREETING if _WORDLESS.fullmatch(without_mentions(visible)) else None
    return small_talk_in(_sentences(part, names, locale(language_of(part)))[0])


def talk_topic_of(visible: str, names: Sequence[str], others: Sequence[str]) -> str:
    """Return what a post without a command talks about ("joke", "see", "who", …); empty if that is not known."""
    part = part_for(visible, names, others)
    return topic_of(part, locale(language_of(part)).talk) if len(part) <= MAX_CHARS else ""


def _sentences(
    part: str, names: Sequence[str], known: Locale, declared: Sequence[Operation] = ()
) -> tuple[list[Sentence], Sequence[tuple[str, str]]]:
    words = known.words
    names = [name for name in names if name.lower() not in own_words(tuple(declared))] if declared else names
    called = _without_names(without_statements(part, known.stated, words.twins), names, words)
    if known.called:
        called = known.calls.sub(_without_name, called)
    _, mistyped = tokens_of(called, words)
    return sentences_of(known.tokens(called), {operation.name: operation for operation in declared}), mistyped


def _without_name(call: re.Match[str]) -> str:
    start, end = (at - call.start() for at in call.span("name"))
    return call[0][:start] + " " * (end - start) + call[0][end:]


def _without_names(part: str, names: Sequence[str], words: Lexicon) -> str:
    """Blank out the robot's own name without an @ ("Rex, sit"), unless the name is also a known word."""
    said = part.lower()
    for name in names:
        if name.lower() in said and (name.lower(),) not in words.phrases:
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


def _general_example(can: Capabilities) -> list[Primitive]:
    """Return a command that works with this robot, for a post from which none can be made."""
    examples = help_examples(can)
    firsts = {step.base_motion: step for step in reversed(examples)}
    return [firsts[motion] for motion in BaseMotion if motion in firsts] or examples[:1]


#: The most sentences that a question offers.
_MOST_OFFERS = 2


def _offered(can: Capabilities, plans: Sequence[Sequence[Primitive]]) -> list[list[Primitive]]:
    """Return at most two of these plans, each shortened to what this robot can do in one step and in one command."""
    found: list[list[Primitive]] = []
    for plan in plans:
        steps = [within(step, can) for step in plan]
        far = sum(step.distance_m or 0.0 for step in steps) > can.limits.command_m
        if all(can.can_do(step) for step in steps) and 0 < len(steps) <= can.limits.command_steps and not far:
            found += [steps] if steps not in found else []
    return found[:_MOST_OFFERS]
