"""The table of a model's calls in a report, and the same calls as JSON lines."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

from pydantic import TypeAdapter

from agentrob.agent.execution.execute import Execution
from agentrob.agent.media.image_store import Link
from agentrob.agent.media.pictures import Picture, illustrate
from agentrob.agent.media.recorder import Recorder
from agentrob.agent.reporting.report import final
from agentrob.agent.reporting.visual_calls import MOST_ROWS, lines, table
from agentrob.config.robots import RecordingConfig
from agentrob.minds.visual_loop.loop import LoopCall, LoopEnd, LoopRecord
from agentrob.model import Account, ActionResult, Command, CommandState, Direction, Op, Outcome, Primitive, Report


def test_the_calls_are_kept_with_the_motion_and_outlive_the_agent() -> None:
    turns = (
        LoopCall("act_move", {"distance_m": 1.0}, outcome="done", step=1),
        LoopCall("act_fly", {}, problem="no such tool"),
    )
    step = ActionResult(Primitive(Op.MOVE, Direction.FORWARD, 1.0), Outcome.DONE, {"distance_m": 0.98})
    looked = LoopRecord("go to the red ball", LoopEnd("calls"), turns, mind="clever")
    kept = TypeAdapter(Execution)
    again = kept.validate_json(kept.dump_json(Execution(CommandState.FAILED, results=(step,), looked=looked)))
    assert again.looked is not None
    assert table(again.looked, again.results, (), "en") == table(looked, (step,), (), "en")
    assert [json.loads(line) for line in lines(looked).splitlines()][2]["problem"] == "no such tool"


def test_of_very_many_calls_the_first_are_reported_and_how_many_more_there_are() -> None:
    turns = tuple(LoopCall("act_fly", {}, problem="@alice | no such tool " * 20) for _ in range(50))
    text = table(LoopRecord("x", LoopEnd("calls"), turns), (), (), "zh")
    assert text.count("\n| ") == MOST_ROWS + 1
    assert "此处省略 20 行" in text
    assert "@alice" not in text
    assert len(text) < 8_000
    linked = Picture("step", b"", 1, Link("https://bucket.example/1.jpg", datetime.now(UTC), 60.0))
    step = ActionResult(Primitive(Op.GET_FRONT_IMAGE), Outcome.DONE)
    assert "done, [picture 1](https://bucket.example/1.jpg)" in table(
        LoopRecord("x", LoopEnd("calls")), (step,), (linked,), "en"
    )


class Store:
    """A store that keeps what it gets under its name."""

    def __init__(self) -> None:
        self.kept: dict[str, bytes] = {}

    async def keep(self, name: str, data: bytes) -> Link:
        self.kept[name] = data
        return Link(f"https://bucket.example/{name}", datetime.now(UTC), 60.0)


async def test_with_an_image_store_the_report_links_the_calls(tmp_path: Path) -> None:
    step = ActionResult(Primitive(Op.GET_FRONT_IMAGE), Outcome.DONE, image=b"\xff\xd8jpeg")
    author = Account("1", "alice")
    command = Command("7", "1", "", author, "quadruped", "look around", "en", datetime.now(UTC), "trace")
    report = Report(command, CommandState.DONE, results=(step,), goal="look around")
    looked = LoopRecord(
        "look around", LoopEnd("finished", "done"), (LoopCall("finish", {"outcome": "done"}, outcome="done"),)
    )
    store, recorder = Store(), Recorder(tmp_path, RecordingConfig(view="none"))
    pictures = await illustrate(report, recorder, store, calls=lines(looked))
    text = final(report, pictures, calls=table(looked, report.results, pictures, "en"))
    assert "[all calls of the model](https://bucket.example/7-calls)" in text
    assert "[picture 1](https://bucket.example/7-step1)" in text
    assert [json.loads(line) for line in store.kept["7-calls"].splitlines()][1]["tool"] == "finish"
    assert [p.kind for p in await illustrate(report, recorder, None, calls=lines(looked))] == ["step"]
