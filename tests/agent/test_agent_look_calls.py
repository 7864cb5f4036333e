"""The table of a model's calls in a report, and the same as lines for programs."""

from __future__ import annotations

import json
from datetime import UTC, datetime

from pydantic import TypeAdapter

from agentrob.agent.execute import Execution
from agentrob.agent.look_calls import MOST_ROWS, lines, table
from agentrob.agent.pictures import Picture
from agentrob.images.store import Link
from agentrob.minds.loop import Looked, LoopEnd, Turn
from agentrob.model import ActionResult, Direction, Op, Outcome, Primitive


def test_the_calls_are_kept_with_the_motion_and_outlive_the_agent() -> None:
    turns = (Turn("act_move", {"distance_m": 1.0}, outcome="done", step=1), Turn("act_fly", {}, problem="no such tool"))
    step = ActionResult(Primitive(Op.MOVE, Direction.FORWARD, 1.0), Outcome.DONE, {"distance_m": 0.98})
    looked = Looked("go to the red ball", LoopEnd("calls"), turns, mind="clever")
    kept = TypeAdapter(Execution)
    again = kept.validate_json(kept.dump_json(Execution("failed", results=(step,), looked=looked)))
    assert again.looked is not None
    assert table(again.looked, again.results, (), "en") == table(looked, (step,), (), "en")
    assert [json.loads(line) for line in lines(looked).splitlines()][2]["problem"] == "no such tool"


def test_of_very_many_calls_the_first_are_told_and_how_many_more_there_are() -> None:
    turns = tuple(Turn("act_fly", {}, problem="@alice | no such tool " * 20) for _ in range(50))
    told = table(Looked("x", LoopEnd("calls"), turns), (), (), "zh")
    assert told.count("\n| ") == MOST_ROWS + 1
    assert "此处省略 20 行" in told
    assert "@alice" not in told
    assert len(told) < 8_000
    linked = Picture("step", b"", 1, Link("https://bucket.example/1.jpg", datetime.now(UTC)))
    step = ActionResult(Primitive(Op.GET_FRONT_IMAGE), Outcome.DONE)
    assert "done, [picture 1](https://bucket.example/1.jpg)" in table(
        Looked("x", LoopEnd("calls")), (step,), (linked,), "en"
    )
