"""Agents that restart: schedules continue, and a run at a write of which the agent dies is neither doubled nor silently
missed (law 6).

The agent runs in this process; where it dies, its write never returns, and the forum is out of its reach. The next
agent has only what was written.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.rows import KeptSchedule
from tests.agent.agent_scene import Driver, Scene, make_scene, robot_settings
from tests.agent.queue.test_schedule_renewal import answer, kept_of, limited
from tests.agent.queue.test_schedules import HOUR, finals, next_at, posted, run_of, runs_done, state

pytestmark = pytest.mark.usefixtures("database")


@pytest.fixture
def scene(tmp_path: Path) -> Iterator[Scene]:
    """A scene with a driver of its own: a restart after a kill stops the robot, which would end the next test's run."""
    driver = Driver(tmp_path, robot_settings())
    yield make_scene(driver, tmp_path)
    driver.end()


async def test_law_6_a_restart_continues_schedules_and_tells_what_was_missed(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "every hour wave")
        due = await next_at(agent)
    scene.world.clock_offset_s = (due - post.created_at).total_seconds() + 600.0
    async with scene.agent() as agent:
        told = await run_of(scene, post, 1)
        assert (state(told), "I did not run at" in told.raw) == ("expired", True)
        assert await next_at(agent) == due + HOUR
    scene.world.clock_offset_s += 3000.0 + 1.0
    async with scene.agent():
        assert state(await run_of(scene, post, 2)) == "done"


#: Some writes of a run, by the method of the journal, are tried in every run of the tests.
ALWAYS = (("begin_run", "after"), ("_begin", "after"))
#: Each write of a run, and whether the agent dies before or after it.
WRITES = [
    pytest.param(name, when, marks=() if (name, when) in ALWAYS else pytest.mark.slow)
    for name in ("begin_run", "assess", "set_status_post", "_begin", "_end", "set_plan", "finish")
    for when in ("before", "after")
]


@pytest.mark.parametrize(("name", "when"), WRITES)
async def test_law_6_killed_at_any_write_of_a_run_it_is_not_doubled_and_not_silent(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, name: str, when: str
) -> None:
    async with scene.agent() as agent:
        post = await posted(scene, "in 10 minutes wave")
        due = await next_at(agent)
        await scene.until(lambda: not len(agent.queue))
    began: list[str] = []
    original_begin, original = Journal._begin, getattr(Journal, name)
    dead, gone = asyncio.Event(), asyncio.Event()

    async def counted(self: Journal, key: str) -> str | None:
        instead = await original_begin(self, key)
        began.extend([key] if instead is None else [])
        return instead

    async def dies(self: Journal, *args: object, **more: object) -> object:
        if when == "after":
            await original(self, *args, **more)
        dead.set()
        await gone.wait()  # a dead process writes nothing more
        raise asyncio.CancelledError

    scene.world.clock_offset_s = (due - post.created_at).total_seconds() + 2.0
    with monkeypatch.context() as patched:
        patched.setattr(Journal, name, dies)
        killed = scene.make()
        running = asyncio.create_task(killed.run())
        async with asyncio.timeout(60):
            await dead.wait()
        scene.world.reachable = False
        running.cancel()
        gone.set()
        await asyncio.gather(running, return_exceptions=True)
        await killed.close()
        scene.world.reachable = True
    monkeypatch.setattr(Journal, "_begin", counted)
    async with scene.agent() as agent:
        end = state(await run_of(scene, post, 1))
        await scene.until(lambda: not len(agent.queue))
        assert await agent.journal.schedules() == []
        assert await agent.journal.open_claims() == []
    moved_before = name in ("_end", "set_plan", "finish") or (name, when) == ("_begin", "after")
    assert len(began) == (0 if moved_before else 1), "it moves at most once"
    cut_off = (name, when) in {("_begin", "after"), ("_end", "before")}
    assert end == ("interrupted" if cut_off else "done")
    assert len(finals(scene, post)) == 2


@pytest.mark.parametrize("when", ["before", "after"])
async def test_law_6_killed_at_the_write_of_a_renewal_it_is_neither_doubled_nor_silent(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    async with limited(scene) as (_, post):
        pass
    original = Journal.renew_schedule
    dead, gone = asyncio.Event(), asyncio.Event()

    async def dies(self: Journal, renewed: KeptSchedule) -> bool:
        if when == "after":
            await original(self, renewed)
        dead.set()
        await gone.wait()  # a dead process writes nothing more
        raise asyncio.CancelledError

    with monkeypatch.context() as patched:
        patched.setattr(Journal, "renew_schedule", dies)
        killed = scene.make()
        running = asyncio.create_task(killed.run())
        async with asyncio.timeout(60):
            await killed.ready.wait()
            asks = await scene.post("alice", "keep on", topic=post.topic_id)
            await dead.wait()
        scene.world.reachable = False
        running.cancel()
        gone.set()
        await asyncio.gather(running, return_exceptions=True)
        await killed.close()
        scene.world.reachable = True
    async with scene.agent() as agent:
        assert "Renewed: wave." in await answer(scene, asks)
        kept = await kept_of(agent, post)
        assert (kept.ended, kept.runs_left, kept.asked.renewed_by) == (None, 30, asks.id)
        assert runs_done(scene, post) == 0
