"""Law 18 where parts of the agent fail after the robot has moved: the reply has the measurements, whatever failed."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent import final_report, motion, pipeline
from agentrob.agent.execution import execute
from agentrob.agent.intake.event_stream import EventStream
from agentrob.agent.media.recorder import Recorder
from agentrob.agent.reporting import report, visual_text
from agentrob.agent.reporting.status_post import StatusPost
from agentrob.agent.store import journal
from agentrob.agent.store.records import Records
from agentrob.agent.understanding.surroundings import Surroundings
from agentrob.agent.understanding.understand import Assessor
from agentrob.errors import ForumUnreachable, JournalError, RobotError, RobotUnreachable
from agentrob.forums.memory.forum import MemoryForum
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import ActionResult, Plan, Post, Primitive, Understanding
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings

TWO_STEPS = f"@{ROBOT} walk forward 1 metre, then turn left 90 degrees"
#: The row of the first step with its measurement, whatever the other sentences say.
WALKED = re.compile(r"walk forward 1 m \| (0\.9\d|1\.0\d) m \| done")
DENIALS = ("before anything moved", "nothing moved", "还没有任何动作", "没有动作")


class CountingClient(DriverClient):
    """Counts the steps that have ended."""

    ended = 0

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        try:
            return await super().step(lease, primitive, deadline_s)
        finally:
            self.ended += 1


@dataclass(frozen=True)
class Fault:
    """Which call fails, with what error, and after how many steps. `rest` is the expected result of the second step."""

    owner: Any
    name: str
    error: Exception = RuntimeError("broken by a test")
    after: int = 1
    rest: str = "done"
    once: bool = False

    @property
    def id(self) -> str:
        return f"{getattr(self.owner, '__name__', self.owner).split('.')[-1]}.{self.name} after {self.after}"

    def make_fail(self, patch: pytest.MonkeyPatch, ended: Callable[[], int]) -> Callable[[], int]:
        """Make it fail from the given step on; return a counter of its failures."""
        original = inspect.getattr_static(self.owner, self.name)
        failures = 0

        def fails() -> None:
            nonlocal failures
            if ended() >= self.after and not (self.once and failures):
                failures += 1
                raise self.error.with_traceback(None)

        def call(*args: Any, **more: Any) -> Any:
            fails()
            return original(*args, **more)

        async def awaited(*args: Any, **more: Any) -> Any:
            fails()
            return await original(*args, **more)

        def read(one: Any) -> Any:
            fails()
            return original.fget(one)

        @contextlib.contextmanager
        def entered(*args: Any, **more: Any) -> Iterator[Any]:
            with original(*args, **more) as inner:
                yield inner
            fails()

        broken: Any = awaited if inspect.iscoroutinefunction(original) else call
        broken = property(read) if isinstance(original, property) else broken
        patch.setattr(self.owner, self.name, entered if self.name == "filming" else broken)
        return lambda: failures


FULL = OSError(28, "No space left on device")
LOST = JournalError("the journal cannot be written: disk I/O error")
#: After both steps: every call that follows a motion.
AFTER_BOTH = [
    Fault(Records, "keep_pictures", FULL, 2),
    Fault(Records, "keep_pictures", after=2),
    Fault(Records, "write", FULL, 2),
    Fault(Records, "write", after=2),
    Fault(Recorder, "filming", after=2),
    Fault(Recorder, "animation", after=2),
    Fault(Recorder, "stored_path", after=2),
    Fault(Recorder, "late", after=2),
    Fault(Surroundings, "after", after=2),
    Fault(EventStream, "now", after=2),
    Fault(journal.Journal, "_end", LOST, 2),
    Fault(journal.Journal, "set_plan", LOST, 2),
    Fault(journal.Journal, "finish", LOST, 2),
    Fault(Assessor, "summary", after=2),
    Fault(final_report, "illustrate", after=2),
    Fault(final_report, "page_of", after=2),
    Fault(final_report, "publish", after=2),
    Fault(final_report, "late_recording", after=2),
    Fault(pipeline, "decisive", after=2),
    Fault(final_report, "notes", after=2),
    Fault(final_report, "summary_text", after=2),
    Fault(final_report, "approval", after=2),
    Fault(visual_text, "paragraphs", after=2),
    Fault(visual_text, "why", after=2),
    Fault(report, "short", after=2),
    Fault(DriverClient, "lost", RobotUnreachable("gone"), 2),
]
#: Between the steps: every call before the second step, which then has not begun.
BETWEEN = [
    Fault(motion, "permission", rest="not begun"),
    Fault(execute, "mandate_violation", rest="not begun"),
    Fault(EventStream, "prove", rest="not begun"),
    Fault(report, "running", rest="not begun"),
    Fault(StatusPost, "show", rest="not begun"),
]
#: During the second step: the code that supervises it, and the driver. The step was sent, so it is never "not begun".
WITHIN = [
    Fault(EventStream, "silent", rest="stopped", once=True),
    Fault(DriverClient, "step", rest="unknown"),
    Fault(DriverClient, "step", RobotError("the driver answered 500"), rest="unknown"),
    Fault(DriverClient, "step", RobotUnreachable("no driver answers"), rest="unknown"),
    Fault(DriverClient, "step", ValueError("an answer that is no JSON"), rest="unknown"),
]


@contextlib.contextmanager
def failures(fault: Fault, scene: Scene) -> Iterator[tuple[CountingClient, Callable[[], int]]]:
    driver = CountingClient(scene.driver.name, scene.driver.socket)
    with pytest.MonkeyPatch.context() as patch:
        yield driver, fault.make_fail(patch, lambda: driver.ended)


def assert_reports_motion(reply: Post) -> None:
    assert WALKED.search(reply.raw), reply.raw
    assert not any(denial in reply.raw for denial in DENIALS), reply.raw


def outcome_of(reply: Post, step: int) -> str:
    row = next(line for line in reply.raw.splitlines() if line.startswith(f"| {step} |"))
    return row.split("|")[4].strip()


#: Run by default, one of each kind: disk, journal, permission, supervision of a step, driver.
FAST = {
    "Records.keep_pictures after 2",
    "Journal._end after 2",
    "motion.permission after 1",
    "EventStream.silent after 1",
}
FAULTS = [*AFTER_BOTH, *BETWEEN, *WITHIN]
CASES = [pytest.param(f, id=f.id, marks=() if f.id in FAST else pytest.mark.slow) for f in FAULTS]
assert {f.id for f in FAULTS} >= FAST


@pytest.mark.parametrize("fault", CASES)
async def test_law_18_whatever_fails_once_it_moved_the_reply_tells_what_was_measured(
    scene: Scene, fault: Fault
) -> None:
    with failures(fault, scene) as (driver, times):
        async with scene.agent(driver=driver):
            post = await scene.post("alice", TWO_STEPS)
            reply = await scene.final(post)
            if fault.name not in ("late_recording", "late", "publish"):  # these come after the end is written
                assert times() or fault.name == "lost", "the fault was never reached"
    assert_reports_motion(reply)
    assert outcome_of(reply, 2) == fault.rest, reply.raw
    assert len(scene.replies(post)) == 1
    assert reply.card is not None
    assert reply.card.state == {"done": "done", "unknown": "interrupted"}.get(fault.rest, "failed")
    async with scene.agent():  # and the next agent, which knows only the journal, adds nothing and moves nothing again
        await scene.final(await scene.post("alice", f"@{ROBOT} turn right 30 degrees"))
        assert [r.raw for r in scene.replies(post)] == [reply.raw]


async def test_law_18_a_report_that_cannot_be_put_into_words_is_reported_as_data(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    def final(*_: Any) -> str:
        raise KeyError("do.clap")

    monkeypatch.setattr(report, "final", final)
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 1 metre"))
    assert reply.raw.startswith("**done**")
    assert re.search(r"'distance_m': 1\.0}`: done, measured `{'distance_m': (0\.9|1\.0)", reply.raw), reply.raw


class OfflineAfterFirstStep(CountingClient):
    """After its first step the forum does not answer for a moment, as during a restart of the board or its database."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene.driver.name, scene.driver.socket)
        self.forum = OfflineForum(scene.world, ROBOT)

    async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
        result = await super().step(lease, primitive, deadline_s)
        self.forum.away = self.ended == 1
        return result


class OfflineForum(MemoryForum):
    """A forum that answers no request for a post while it is away; its event stream has not noticed yet."""

    away = False

    async def post(self, post_id: str) -> Post:
        found = await super().post(post_id)
        if self.away:
            self.away = found.card is not None  # until the command's own post was requested
            raise ForumUnreachable("the board answered 503")
        return found


@pytest.mark.parametrize(
    ("text", "head", "why", "walked", "rest"),
    [
        (
            TWO_STEPS,
            "**Interrupted.**",
            "I could not check whether the command still holds, so I did not go on.",
            "walk forward 1 m",
            "not begun",
        ),
        (
            f"@{ROBOT} 向前走 1 米，然后左转 90 度",
            "**中断。**",
            "无法确认命令是否仍然有效，所以没有继续。",
            "向前走 1 米",
            "未开始",
        ),
    ],
    ids=["en", "zh"],
)
async def test_law_18_a_board_that_is_away_between_two_steps_denies_no_motion(
    scene: Scene, text: str, head: str, why: str, walked: str, rest: str
) -> None:
    driver = OfflineAfterFirstStep(scene)
    async with scene.agent(driver=driver, forum=driver.forum):
        reply = await scene.final(await scene.post("alice", text))
    assert driver.ended == 1
    assert reply.raw.startswith(head), reply.raw
    assert why in reply.raw
    assert re.search(rf"{walked} \| (0\.9\d|1\.0\d) m", reply.raw), reply.raw
    assert outcome_of(reply, 2) == rest
    assert not any(denial in reply.raw for denial in DENIALS), reply.raw


async def test_law_18_a_command_that_is_withdrawn_between_two_steps_says_at_which_it_was(scene: Scene) -> None:
    class SuspendingClient(CountingClient):
        async def step(self, lease: str, primitive: Primitive, deadline_s: float) -> ActionResult:
            result = await super().step(lease, primitive, deadline_s)
            scene.world.suspend("alice")
            return result

    async with scene.agent(driver=SuspendingClient(scene.driver.name, scene.driver.socket)):
        reply = await scene.final(await scene.post("alice", TWO_STEPS))
    why = "**Cancelled** at step 2. Its author may not command me now. Until then: walked "
    assert reply.raw.startswith(why), reply.raw
    assert_reports_motion(reply)
    assert outcome_of(reply, 2) == "not begun"


async def test_law_18_what_was_measured_before_a_restart_is_reported_also_when_the_driver_is_away_then(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The agent dies with the end in its journal but not on the forum; the next one fails before it writes the end."""

    async def dies(*_: Any) -> None:
        raise asyncio.CancelledError

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(final_report.FinalReport, "post_final", dies)
        async with scene.agent() as agent:
            post = await scene.post("alice", TWO_STEPS)
            await scene.state(post, "running")
            await scene.until(lambda: not len(agent.queue))

    async def away(*_: Any) -> Any:
        raise RobotUnreachable("no driver answers")

    monkeypatch.setattr(Assessor, "think", away)
    async with scene.agent():
        reply = await scene.final(post)
    assert_reports_motion(reply)
    assert outcome_of(reply, 2) == "done"


async def test_an_agent_that_is_ended_says_so_once(tmp_path: Path) -> None:
    slow = Driver(tmp_path, robot_settings(options={"time_scale": 1}), name="slow")
    scene = make_scene(slow, tmp_path)
    try:
        async with scene.agent() as agent:
            post = await scene.post("alice", f"@{ROBOT} walk forward 4 metres")
            await scene.until(lambda: agent.queue.moving)
            await scene.state(post, "running")
        reply = await scene.final(post)
    finally:
        slow.end()
    assert reply.card is not None
    assert reply.card.state == "interrupted"
    assert reply.raw.count("My agent was ended.") == 1, reply.raw


async def test_where_no_model_is_configured_none_is_missed(scene: Scene) -> None:
    """The command was stopped during the reading, so the rules read it instead of the mind."""
    asked = asyncio.Event()

    class StuckMind(RulesMind):
        async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
            asked.set()
            await asyncio.Event().wait()
            raise AssertionError

    async with scene.agent(mind=StuckMind()):
        post = await scene.post("alice", TWO_STEPS)
        await asyncio.wait_for(asked.wait(), 60)
        await scene.post("bob", "stop", topic=post.topic_id)
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "cancelled"
    assert "model" not in reply.raw, reply.raw
