"""How often an account may command a robot: short waits are queued, long ones are reported, and stops never count."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.intake import rate_limit
from agentrob.agent.intake.rate_limit import RateLimiter, RateLimitWait
from agentrob.config.robots import RatesConfig
from agentrob.model import Post
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene

TURN = f"@{ROBOT} turn left 30 degrees"
FREE = {"commands_per_hour": 0, "cooldown_s": 0, "waiting": 0}


def state(reply: Post) -> str:
    assert reply.card is not None
    return reply.card.state


async def test_beyond_the_hour_s_number_it_is_refused_with_when_to_come_again(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, rates=FREE | {"commands_per_hour": 2})
    scene.person("carol")
    async with scene.agent():
        ends = [await scene.final(await scene.post("alice", TURN)) for _ in range(3)]
        other = await scene.final(await scene.post("carol", TURN))
    assert [state(end) for end in ends] == ["done", "done", "refused"]
    assert "`rate.hour`" in ends[2].raw
    assert "again in 60 min" in ends[2].raw
    assert state(other) == "done", "another account's commands are not counted with them"


async def test_after_a_refusal_for_its_rate_the_account_still_stops_and_asks(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, rates=FREE | {"commands_per_hour": 1})
    async with scene.agent():
        await scene.final(await scene.post("alice", TURN))
        assert state(await scene.final(await scene.post("alice", TURN))) == "refused"
        assert state(await scene.final(await scene.post("alice", f"@{ROBOT} battery?"))) == "answered"
        stop = await scene.post("alice", f"@{ROBOT} stop")
        assert "Stopped" in (await scene.until(lambda: scene.replies(stop)))[0].raw


async def test_within_the_cooldown_it_waits_and_others_go_before_it(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, rates=FREE | {"cooldown_s": 4})
    scene.person("carol")
    async with scene.agent() as agent:
        first = await scene.post("alice", TURN)
        second = await scene.post("alice", TURN)
        held = await scene.until(lambda: next((p for p in scene.replies(second) if "by myself" in p.raw), None))
        assert state(held) == "queued"
        third = await scene.post("carol", TURN)
        assert state(await scene.final(third)) == "done"
        assert [job.command.post_id for job in agent.queue] == [second.id]
        begun_s = time.monotonic()
        assert state(await scene.final(second)) == "done"
        assert time.monotonic() - begun_s < 8
        assert state(await scene.final(first)) == "done"


async def test_a_stop_ends_what_waits_for_its_cooldown(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, rates=FREE | {"cooldown_s": 20})
    async with scene.agent():
        await scene.final(await scene.post("alice", TURN))
        second = await scene.post("alice", TURN)
        await scene.state(second, "queued")
        await scene.post("bob", f"@{ROBOT} stop")
        assert state(await scene.final(second)) == "cancelled"


async def test_one_account_cannot_fill_the_line(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, rates=FREE | {"cooldown_s": 3, "waiting": 2})
    scene.person("carol")
    async with scene.agent():
        posts = [await scene.post("alice", TURN) for _ in range(8)]
        assert state(await scene.final(await scene.post("carol", TURN))) == "done"
        await scene.post("carol", f"@{ROBOT} stop")
        ends = [await scene.final(post) for post in posts]
    full = [end for end in ends if "`rate.waiting`" in end.raw]
    assert {state(end) for end in full} == {"refused"}
    assert len(full) >= 5
    assert {state(end) for end in ends if end not in full} <= {"done", "cancelled"}


async def test_a_restart_begins_to_count_anew_and_loses_nothing_that_waits(
    driver: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rate_limit, "SHORT_S", 3600.0)
    scene = make_scene(driver, tmp_path, rates=FREE | {"cooldown_s": 3600})
    async with scene.agent():
        await scene.final(await scene.post("alice", TURN))
        second = await scene.post("alice", TURN)
        await scene.state(second, "queued")
    async with scene.agent():
        assert state(await scene.final(second)) == "done"


@pytest.mark.parametrize(
    ("seconds", "short", "minutes"), [(0.1, True, 1), (30, True, 1), (31, False, 1), (61, False, 2), (3600, False, 60)]
)
def test_a_wait_is_reported_in_full_minutes(seconds: float, short: bool, minutes: int) -> None:
    wait = RateLimitWait("rate.hour", seconds)
    assert (wait.short, wait.minutes) == (short, minutes)


@given(st.integers(1, 20), st.integers(1, 60))
def test_exactly_the_number_is_allowed_in_an_hour(number: int, asked: int) -> None:
    pace = RateLimiter(RatesConfig(commands_per_hour=number, cooldown_s=0))
    waits = [pace.take("a") for _ in range(asked)]
    assert waits[:number] == [None] * min(number, asked)
    assert all(wait is not None and 3500 < wait.seconds <= 3600 for wait in waits[number:])
    assert pace.take("b") is None


def test_what_had_to_wait_is_not_counted() -> None:
    pace = RateLimiter(RatesConfig(commands_per_hour=2, cooldown_s=600))
    assert pace.take("a") is None
    assert [wait.rule for _ in range(9) if (wait := pace.take("a"))] == ["rate.cooldown"] * 9


def test_no_rates_are_no_limits(scene: Scene) -> None:
    pace = RateLimiter(RatesConfig(**FREE))
    assert [pace.take("a") for _ in range(1000)] == [None] * 1000
