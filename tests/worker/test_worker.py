"""A worker serves several robots, and one robot's failure ends nothing of another's."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from structlog.testing import capture_logs

from agentrob.agent.store.journal import Journal
from agentrob.agent.store.journals import SqliteJournals
from agentrob.errors import JournalError, JournalHeld
from agentrob.worker import worker as module
from agentrob.worker.worker import Worker, WorkerObserver
from tests.waiting import until

LIMIT_S = 30.0


class StubAgent:
    """Serves until its test makes it fail."""

    def __init__(self, robot: str, get_ready: asyncio.Event) -> None:
        self.robot = robot
        self.failing: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._get_ready = get_ready
        self.closed = False

    async def run(self, on_ready: Callable[[], None] = lambda: None) -> None:
        await self._get_ready.wait()
        on_ready()
        await self.failing

    async def close(self) -> None:
        self.closed = True

    def drain(self) -> None:
        """Nothing moves, so it ends at once."""
        self.failing.set_result(None)


class RecordingObserver(WorkerObserver):
    """Keeps which robots were taken over, and whose journals failed."""

    def __init__(self, changed: asyncio.Event) -> None:
        self._changed = changed
        self.robots_taken_over: list[str] = []
        self.journals_failed: list[str] = []

    def taken_over(self, robot: str) -> None:
        self.robots_taken_over.append(robot)

    def journal_failed(self, robot: str) -> None:
        self.journals_failed.append(robot)
        self._changed.set()


class Workers:
    """Workers on the journals of one folder and their agents, which get ready once `get_ready` is set."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.get_ready = asyncio.Event()
        self.get_ready.set()
        self.agents: list[tuple[str, StubAgent]] = []
        self.tasks: dict[str, asyncio.Task[None]] = {}
        self._changed = asyncio.Event()
        self.observer = RecordingObserver(self._changed)

    @asynccontextmanager
    async def running(
        self, name: str, robots: tuple[str, ...] = ("ada", "rex"), most: int | None = None, standby: bool = False
    ) -> AsyncIterator[Worker]:
        def make(robot: str, _: Journal) -> StubAgent:
            self.agents.append((name, agent := StubAgent(robot, self.get_ready)))
            self._changed.set()
            return agent

        worker = Worker(
            robots, SqliteJournals(self._folder), make, most, standby, lambda _: self._changed.set(), self.observer
        )
        task = self.tasks[name] = asyncio.create_task(worker.run())
        task.add_done_callback(lambda _: self._changed.set())
        try:
            yield worker
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    async def open(self, robot: str) -> Journal:
        return await SqliteJournals(self._folder).open(robot)

    def served_by(self, name: str) -> list[str]:
        """The robots that a worker serves now."""
        return sorted(agent.robot for by, agent in self.agents if by == name and not agent.closed)

    def agent(self, robot: str) -> StubAgent:
        return next(agent for _, agent in reversed(self.agents) if agent.robot == robot)

    async def until(self, condition: Callable[[], object]) -> None:
        async with asyncio.timeout(LIMIT_S):
            while not condition():
                self._changed.clear()
                await self._changed.wait()


@pytest.fixture
def workers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Workers:
    monkeypatch.setattr(module, "AGAIN_S", (0.01, 0.05))
    monkeypatch.setattr(module, "TAKE_S", 0.05)
    monkeypatch.setattr(module, "STANDBY_S", 0.5)
    return Workers(tmp_path)


async def test_it_serves_all_its_robots_and_ends_their_agents(workers: Workers) -> None:
    async with workers.running("one"):
        await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
    assert workers.served_by("one") == []
    async with workers.running("two"):
        await workers.until(lambda: workers.served_by("two") == ["ada", "rex"])


async def test_an_agent_that_fails_is_started_again_and_the_other_serves_on(workers: Workers) -> None:
    async with workers.running("one"):
        await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
        rex, ada = workers.agent("rex"), workers.agent("ada")
        for _ in range(3):
            failed = workers.agent("rex")
            failed.failing.set_exception(ValueError("a defect"))
            await workers.until(lambda failed=failed: workers.agent("rex") is not failed)
            assert failed.closed
        assert workers.agent("rex") is not rex
        assert workers.agent("ada") is ada
        assert not ada.closed


async def fail_again(workers: Workers, times: int) -> float:
    """Let each new agent of `rex` fail at once, `times` times; return the seconds until the last one was replaced."""
    clock = asyncio.get_running_loop()
    begun_s = clock.time()
    for _ in range(times):
        failed = workers.agent("rex")
        failed.failing.set_exception(ValueError("a defect"))
        await workers.until(lambda failed=failed: workers.agent("rex") is not failed)
    return clock.time() - begun_s


async def test_an_agent_that_fails_again_and_again_waits_longer_each_time(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "AGAIN_S", (0.02, 1e3))
    async with workers.running("one", ("rex",)):
        await workers.until(lambda: workers.served_by("one") == ["rex"])
        assert await fail_again(workers, 4) >= 0.02 + 0.04 + 0.08 + 0.16


@pytest.mark.parametrize(("longest_s", "steady_s"), [(0.002, 1e3), (1e3, -1.0)])
async def test_the_wait_is_bounded_and_short_again_for_an_agent_that_ran_for_long(
    workers: Workers, monkeypatch: pytest.MonkeyPatch, longest_s: float, steady_s: float
) -> None:
    monkeypatch.setattr(module, "AGAIN_S", (0.001, longest_s))
    monkeypatch.setattr(module, "STEADY_S", steady_s)
    async with workers.running("one", ("rex",)):
        await workers.until(lambda: workers.served_by("one") == ["rex"])
        await fail_again(workers, 17)  # twice as long each time, the last wait would be a minute


@pytest.mark.parametrize(
    ("errors", "journal_lost"),
    [
        ([JournalError("not held")], True),
        ([JournalError("not held"), JournalError("closed")], True),
        ([JournalError("not held"), ValueError("a defect")], False),
    ],
)
async def test_a_journal_that_is_lost_is_counted_and_logged_in_one_line(
    workers: Workers, errors: list[Exception], journal_lost: bool
) -> None:
    with capture_logs() as logs:
        async with workers.running("one", ("rex",)):
            await workers.until(lambda: workers.served_by("one") == ["rex"])
            failed = workers.agent("rex")
            failed.failing.set_exception(ExceptionGroup("tasks of an agent", errors))
            await workers.until(lambda: workers.agent("rex") is not failed)
    assert workers.observer.journals_failed == (["rex"] if journal_lost else [])
    (log,) = [log for log in logs if log["event"].startswith("agent ended")]
    assert log["error"] == "; ".join(f"{type(error).__name__}: {error}" for error in errors)
    assert (log["trace"] is None) is journal_lost


async def test_a_standby_takes_over_the_robots_of_a_worker_that_ends(workers: Workers) -> None:
    async with workers.running("standby", standby=True):
        async with workers.running("one"):
            await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
            with pytest.raises(JournalHeld, match="already runs"):
                await workers.open("rex")
            assert workers.served_by("standby") == []
        await workers.until(lambda: workers.served_by("standby") == ["ada", "rex"])


async def test_a_robot_that_another_worker_holds_is_logged_and_its_takeover_reported_once(workers: Workers) -> None:
    held = "robot held by another worker; waiting for it"
    with capture_logs() as logs:
        async with workers.running("two", standby=True):
            async with workers.running("one"):
                await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
                await until(lambda: sum(log["event"] == held for log in logs) >= 2, limit_s=LIMIT_S)
                assert workers.observer.robots_taken_over == []
            await workers.until(lambda: workers.served_by("two") == ["ada", "rex"])
            assert sorted(workers.observer.robots_taken_over) == ["ada", "rex"]
            failed = workers.agent("rex")
            failed.failing.set_exception(ValueError("a defect"))
            await workers.until(lambda: workers.agent("rex") is not failed)
    assert sorted(workers.observer.robots_taken_over) == ["ada", "rex"], "a restart does not count"
    assert sorted(log["robot"] for log in logs if log["event"] == held) == ["ada", "rex"]


async def test_a_journal_that_cannot_be_opened_is_counted_and_tried_again(workers: Workers, tmp_path: Path) -> None:
    unreadable = tmp_path / "agents" / "rex" / "journal.sqlite"
    unreadable.mkdir(parents=True)
    async with workers.running("one"):
        await workers.until(lambda: workers.served_by("one") == ["ada"])
        await workers.until(lambda: len(workers.observer.journals_failed) > 1)
        unreadable.rmdir()
        await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
    assert set(workers.observer.journals_failed) == {"rex"}


async def test_it_serves_no_more_robots_than_it_has_room_for(workers: Workers) -> None:
    robots = ("ada", "kim", "rex")
    async with workers.running("one", robots, most=2) as one:
        await workers.until(lambda: len(workers.served_by("one")) == 2)
        async with workers.running("two", robots, most=2):
            await workers.until(lambda: len(workers.served_by("two")) == 1)
            assert len(one.serving) == 2
        left = next(robot for robot in robots if robot not in workers.served_by("one"))
        workers.agent(workers.served_by("one")[0]).failing.set_result(None)
        await workers.until(lambda: left in workers.served_by("one"))
        assert len(one.serving) <= 2


async def test_it_starts_few_agents_at_a_time_and_waits_for_none_for_long(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "AT_A_TIME", 2)
    monkeypatch.setattr(module, "START_S", 1e3)
    robots = ("ada", "kim", "moe", "rex")
    workers.get_ready.clear()
    async with workers.running("one", robots):
        await workers.until(lambda: len(workers.served_by("one")) == 2)  # and it waits for them
        async with workers.running("two", robots):
            await workers.until(lambda: len(workers.served_by("two")) == 2)
    monkeypatch.setattr(module, "START_S", 0.01)
    async with workers.running("three", robots):
        await workers.until(lambda: workers.served_by("three") == list(robots))


async def test_a_worker_that_drains_gives_its_robots_to_the_others_and_ends(workers: Workers) -> None:
    async with workers.running("two", standby=True) as two, workers.running("one") as one:
        await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
        one.drain()
        await workers.until(lambda: workers.served_by("two") == ["ada", "rex"])
        assert workers.served_by("one") == []
        assert two.serving == {"ada", "rex"}
        await workers.until(workers.tasks["one"].done)
        assert not workers.tasks["one"].cancelled()


async def test_a_worker_that_drains_while_it_takes_robots_takes_no_more(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "AT_A_TIME", 1)
    monkeypatch.setattr(module, "START_S", 1e3)
    workers.get_ready.clear()
    async with workers.running("one") as one:
        await workers.until(lambda: len(workers.agents) == 1)
        one.drain()
        await workers.until(workers.tasks["one"].done)
        assert not workers.tasks["one"].cancelled()
    assert len(workers.agents) == 1


async def test_a_worker_that_drains_while_it_opens_a_journal_starts_no_agent(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    opening, drained, open_now = asyncio.Event(), asyncio.Event(), SqliteJournals.open

    async def open_later(journals: SqliteJournals, robot: str) -> Journal:
        opening.set()
        await drained.wait()
        return await open_now(journals, robot)

    monkeypatch.setattr(SqliteJournals, "open", open_later)
    async with workers.running("one", ("rex",)) as one:
        await opening.wait()
        one.drain()
        drained.set()
        await workers.until(workers.tasks["one"].done)
        assert not workers.tasks["one"].cancelled()
    assert workers.agents == []


async def test_a_worker_that_drains_at_the_moment_at_which_it_took_a_robot_gives_it_back(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    draining: list[Worker] = []
    journals: list[Journal] = []
    open_now = SqliteJournals.open

    async def open_and_drain(opener: SqliteJournals, robot: str) -> Journal:
        journals.append(await open_now(opener, robot))
        asyncio.get_running_loop().call_soon(draining[0].drain)  # before the task that serves the robot begins
        return journals[0]

    monkeypatch.setattr(SqliteJournals, "open", open_and_drain)
    closed: list[Journal] = []
    close_now = Journal.close

    async def close(journal: Journal) -> None:
        closed.append(journal)
        await close_now(journal)

    monkeypatch.setattr(Journal, "close", close)
    async with workers.running("one", ("rex",)) as one:
        draining.append(one)
        await workers.until(workers.tasks["one"].done)
        assert one.serving == set()
    assert closed[:1] == journals
    assert workers.agents == []


async def test_a_worker_that_waits_for_robots_ends_at_once_when_it_drains(
    workers: Workers, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "STANDBY_S", 1e3)
    async with workers.running("one"), workers.running("two", standby=True) as two:
        await workers.until(lambda: workers.served_by("one") == ["ada", "rex"])
        two.drain()
        async with asyncio.timeout(LIMIT_S):
            await workers.tasks["two"]
        assert workers.served_by("two") == []
