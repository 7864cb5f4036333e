"""List every call of a visual loop with its result: a table for the reply, JSON lines for programs. Pure.

The table replaces the table of steps: each row shows a call, what was measured and the picture that was taken. A
model's words are escaped code of at most 100 characters; the JSON lines and the command's record have all of them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict

from agentrob.agent.media.pictures import Picture
from agentrob.agent.reporting.report import asked, markdown_table, measured, outcome
from agentrob.language.messages.catalog import quote, say
from agentrob.minds.visual_loop.loop import LoopCall, LoopRecord
from agentrob.model import ActionResult, Language

#: The maximum number of rows in a reply.
MOST_ROWS = 30
_NONE = "–"


def table(looked: LoopRecord, results: Sequence[ActionResult], pictures: Sequence[Picture], language: Language) -> str:
    """Return all calls in order as Markdown, with the steps that no call requested (pictures shown to the model)."""
    head = [
        say("agent.table.step", language), say("visual.calls.asked", language), say("agent.table.measured", language),
        say("agent.table.outcome", language),
    ]  # fmt: skip
    rows = list(_rows(looked.turns, results, pictures, language))
    text = markdown_table(head, rows[:MOST_ROWS])
    more = len(rows) - MOST_ROWS
    return text + "\n\n" + say("visual.calls.more", language, count=more) if more > 0 else text


def lines(looked: LoopRecord) -> bytes:
    """Return the calls as JSON lines: the goal and its end, then one line per call."""
    head = {"goal": looked.goal, "mind": looked.mind, "end": asdict(looked.end), "contradicted": looked.contradicted}
    rows = [head, *(asdict(turn) for turn in looked.turns)]
    return "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in rows).encode()


def _rows(
    turns: Sequence[LoopCall], results: Sequence[ActionResult], pictures: Sequence[Picture], language: Language
) -> Iterator[list[str]]:
    seen = _seen(pictures, language)
    called = {turn.step for turn in turns}
    left = [(n, _step(n, r, asked(r, language), seen, language)) for n, r in enumerate(results, 1) if n not in called]
    at = 0
    for turn in (None, *turns):
        if turn is not None and turn.step is not None and turn.step <= len(results):
            at = turn.step
            yield _step(at, results[at - 1], call(turn), seen, language)
        elif turn is not None:
            yield ["", call(turn), _NONE, _outcome(turn, language)]
        while left and left[0][0] == at + 1:
            at, row = left.pop(0)
            yield row
    yield from (row for _, row in left)


def _step(number: int, result: ActionResult, called: str, seen: dict[int, str], language: Language) -> list[str]:
    what = measured(result, language) if not result.primitive.operation.picture else _NONE
    cell = outcome(result, language)
    if number in seen:
        cell += ("，" if language == "zh" else ", ") + seen[number]
    return [str(number), called, what, cell]


def _seen(pictures: Sequence[Picture], language: Language) -> dict[int, str]:
    """Return the label of the picture of each step, with its link if it has one."""
    seen, place = {}, 0
    for picture in pictures:
        place += picture.attached
        if picture.kind == "step":
            words = say("visual.calls.picture", language, number=place if picture.attached else picture.step)
            seen[picture.step] = f"[{words}]({picture.link.url})" if picture.link else words
    return seen


def _outcome(turn: LoopCall, language: Language) -> str:
    if turn.problem:
        return say("visual.calls.problem", language, problem=_code(turn.problem))
    if turn.outcome:
        return say("visual.calls.claims", language, outcome=_code(turn.outcome))
    return say("visual.calls.words", language)


def call(turn: LoopCall) -> str:
    """Return a call as code, with its arguments; words without a call unchanged."""
    if not turn.tool:
        return _code(turn.words)
    given = turn.arguments.get("raw") if list(turn.arguments) == ["raw"] else None
    arguments = given if given is not None else " ".join(_argument(*one) for one in turn.arguments.items())
    return _code(" ".join(f"{turn.tool} {'' if arguments == '{}' else arguments}".split()))


def _argument(name: str, value: object) -> str:
    if value in (None, False, "", []):
        return ""
    return _plain(value) if name == "direction" else f"{name}={_plain(value)}"


def _plain(value: object) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _code(words: str) -> str:
    """Return inline code that is safe inside a table."""
    return quote(words.replace("|", "¦"))
