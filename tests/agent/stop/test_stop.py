"""Stops (laws 13 to 17), on the memory forum with a driver process."""

from __future__ import annotations

import asyncio
import re
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.stop import replies as stopping
from agentrob.errors import RobotUnreachable
from agentrob.model import AccountKind, Role, StopResult
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.lease import TTL_S
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings
from tests.agent.store.journal_store import fail_disk
from tests.waiting import until, walks

#: Time in which a body at 0.5 m/s comes to rest; most of it is for busy machines.
REST_S = 1.5


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    """Return a scene in real time, so that there is a motion to stop."""
    made = Driver(
        tmp_path_factory.mktemp("driver"), robot_settings(options={"time_scale": 1}), "stoppable", lease_s=TTL_S
    )
    yield made
    made.end()


async def running(scene: Scene) -> str:
    """Start a walk and return the id of its post once the robot moves."""
    post = await scene.post("alice", "@quadruped walk forward 5 metres")
    await scene.state(post, "running")
    async with scene.driver.client() as client:
        await until(client.state, walks)
    return post.id


async def test_law_13_the_button_stops_and_the_report_says_who_and_how_fast(scene: Scene) -> None:
    async with scene.agent():
        post = scene.world.posts[await running(scene)]
        await scene.world.sign_in("bob").press_stop(ROBOT)
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "stopped"
    assert "**Stopped** by `bob`" in reply.raw
    assert "ms after the stop" in reply.raw
    assert "I came to rest" in reply.raw


async def test_law_13_a_warning_to_a_person_who_never_wrote_stops_the_robot_of_the_thread(scene: Scene) -> None:
    scene.person("carol")
    async with scene.agent():
        post = scene.world.posts[await running(scene)]
        await scene.post("bob", "@carol stop it, it hits the table!", topic=post.topic_id)
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "stopped"
    assert "**Stopped** by `bob`" in reply.raw


async def test_law_13_only_a_robot_that_is_known_turns_a_stop_away_also_one_whose_account_came_later(
    scene: Scene,
) -> None:
    scene.person("humanoid", kind=AccountKind.ROBOT_AGENT)
    async with scene.agent() as agent:
        later = scene.person("dog3", kind=AccountKind.ROBOT_AGENT)
        post = scene.world.posts[await running(scene)]
        await later.reply(post.topic_id, "Here I am.", key="1")
        for other in ("humanoid", "dog3"):
            await scene.post("bob", f"@{other} stop it!", topic=post.topic_id)
        await scene.final(await scene.post("bob", "@quadruped help"))  # both were received
        async with scene.driver.client() as client:
            assert await client.holder() is not None
        scene.person("dog4", kind=AccountKind.ROBOT_AGENT)  # it never posted before: in doubt the robot stops
        await scene.post("bob", "@dog4 stop it!", topic=post.topic_id)
        assert (await scene.final(post)).card.state == "stopped"  # type: ignore[union-attr]
        await scene.until(lambda: "dog4" in agent.known_robots.names)  # it has been looked up since


@pytest.mark.parametrize("who", ["suspended", "robot", "monitor"])
async def test_law_15_who_may_not_stop_does_not(scene: Scene, who: str) -> None:
    kind = {"robot": AccountKind.ROBOT_AGENT, "monitor": AccountKind.MONITORING_AGENT}.get(who, AccountKind.HUMAN)
    forum = scene.person("mallory", Role.OPERATOR, kind)
    async with scene.agent():
        post = scene.world.posts[await running(scene)]
        said = await scene.post("mallory", "@quadruped stop", topic=post.topic_id)
        if who == "suspended":
            scene.world.suspend("mallory")
            # A post from just before the suspension is judged by the account's current state.
        else:
            await forum.press_stop(ROBOT)
        await scene.state(post, "running")
        help_post = await scene.post("bob", "@quadruped help")
        await scene.final(help_post)
        async with scene.driver.client() as client:
            assert await client.holder() is not None
        assert scene.replies(said) == []
        await scene.post("bob", "@quadruped stop")
        await scene.final(post)


async def test_law_15_many_stops_get_one_folded_reply_and_do_not_block_the_next_command(scene: Scene) -> None:
    async with scene.agent():
        post = scene.world.posts[await running(scene)]
        stops = []
        for n in range(10):
            scene.person(f"shouter{n}", Role.MEMBER)
            stops.append(await scene.post(f"shouter{n}", "stop", topic=post.topic_id))
            if n == 0:
                await scene.final(post)
                stops[0] = await scene.until(lambda: scene.replies(stops[0]) and stops[0])
        stops.append(await scene.post("bob", "@quadruped stop", topic=post.topic_id))
        await scene.until(lambda: "Stops since then: 1" in scene.replies(stops[0])[0].raw)
        assert [len(scene.replies(s)) for s in stops] == [1] + [0] * 10
        later = await scene.post("alice", "@quadruped turn left 30 degrees", topic=post.topic_id)
        assert (await scene.final(later)).card.state == "done"


async def test_law_15_stops_in_many_threads_are_all_answered_and_few_threads_are_remembered(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stopping, "THREADS", 3)
    async with scene.agent() as agent:
        for _ in range(8):
            said = await scene.post("bob", "@quadruped stop")
            await scene.until(lambda said=said: scene.replies(said))
        assert len(agent.stops._replies) <= 3


async def test_law_14_what_is_still_being_read_is_cancelled_too_and_a_later_post_moves(scene: Scene) -> None:
    async with scene.agent():
        first = scene.world.posts[await running(scene)]
        second = await scene.post("alice", "@quadruped walk forward 3 metres")
        stop = await scene.post("bob", "@quadruped stop please!")
        third = await scene.post("alice", "@quadruped turn left 30 degrees")
        states = [(await scene.final(p)).card.state for p in (first, second, third)]
        answer = await scene.until(lambda: scene.replies(stop))
    assert states == ["stopped", "cancelled", "done"]
    assert "ended or cancelled" in answer[0].raw


async def test_law_14_a_stop_at_the_robot_while_it_comes_to_rest_ends_what_was_posted_in_between(
    tmp_path: Path,
) -> None:
    slow = Driver(tmp_path, robot_settings(options={"time_scale": 1, "faults": {"stop_s": 1.5}}), name="slow")
    scene = make_scene(slow, tmp_path)
    try:
        async with scene.agent(), slow.client() as other:
            first = scene.world.posts[await running(scene)]
            await scene.post("bob", "@quadruped stop")
            await until(other.holder, lambda holder: holder is None)
            second = await scene.post("alice", "@quadruped turn left 90 degrees")
            await scene.until(lambda: scene.replies(second))
            beside = await other.stop("somebody at the robot")
            reply = await scene.final(second)
            states = [(await scene.final(first)).card.state, reply.card.state]
            third = await scene.post("alice", "@quadruped wave")
            states.append((await scene.final(third)).card.state)
    finally:
        slow.end()
    assert beside.was_moving, "it still came to rest"
    assert states == ["stopped", "stopped", "done"]
    assert "somebody at the robot" in reply.raw


async def test_law_17_a_halt_holds_until_it_is_released(scene: Scene) -> None:
    async with scene.agent():
        await scene.post("bob", "@quadruped emergency stop!")
        await scene.until(lambda: any("owner releases" in p.raw for p in scene.world.posts.values()))
        refused = await scene.final(await scene.post("alice", "@quadruped turn left 30 degrees"))
        async with scene.driver.client() as client:
            assert (await client.state()).halted
            await client.release("owner")
    assert refused.card.state == "refused"


async def test_law_15_a_stop_goes_past_a_journal_that_cannot_be_written(scene: Scene) -> None:
    async with scene.agent() as agent:
        post = scene.world.posts[await running(scene)]
        fail_disk(agent.journal)
        await scene.post("bob", "@quadruped stop", topic=post.topic_id)
        async with scene.driver.client() as client:
            await until(client.state, lambda state: state.velocity_mps == (0.0, 0.0))
        reply = await scene.final(post)
    assert reply.card.state in ("stopped", "failed")


async def test_law_17_a_driver_that_cannot_be_reached_is_said_plainly(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)

    class DisconnectedClient(type(driver.client())):  # type: ignore[misc]
        """Every call fails; the second channel belongs to a robot without a driver."""

        async def _call(self, *_: object, **__: object) -> object:
            raise RobotUnreachable("no driver")

    async with scene.agent(driver=DisconnectedClient("nobody", tmp_path / "none.sock")):
        post = await scene.post("bob", "@quadruped stop")
        (reply,) = await scene.until(lambda: scene.replies(post))
        assert "could not reach" in reply.raw
        command = await scene.final(await scene.post("alice", "@quadruped wave"))
    assert command.card.state == "failed"
    assert "cannot be used" in command.raw


@pytest.mark.parametrize("hangs", [False, True])
async def test_law_15_a_stop_that_gets_through_on_no_channel_lets_the_lease_lapse_and_the_robot_stands(
    driver: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hangs: bool
) -> None:
    scene, over, never = make_scene(driver, tmp_path), threading.Event(), asyncio.Event()

    class StopFailingClient(DriverClient):
        """A driver client on which everything works but a stop."""

        async def _ask(self, method: str, path: str, body: Any = None, timeout_s: float = 5.0) -> Any:
            if path not in ("/stop", "/halt"):
                return await super()._ask(method, path, body, timeout_s)
            if hangs:
                await never.wait()
            raise RobotUnreachable("no answer")

    def second(*_: object) -> StopResult:
        if hangs:
            over.wait(60)
        raise RobotUnreachable("no answer")

    monkeypatch.setattr("agentrob.agent.stop.replies.stop_robot", second)
    async with scene.agent(driver=StopFailingClient(driver.name, driver.socket)):
        post = await running(scene)
        stop = await scene.post("bob", "stop", topic=scene.world.posts[post].topic_id)
        asked_s = time.monotonic()
        async with scene.driver.client() as client:
            await until(client.state, lambda state: state.velocity_mps == (0.0, 0.0))
        assert time.monotonic() - asked_s < TTL_S + REST_S
        over.set()
        never.set()
        reply = await scene.final(scene.world.posts[post])
        (stop_reply,) = await scene.until(lambda: scene.replies(stop))
    assert "**Stopped** by `bob`" in reply.raw
    assert float(re.findall(r"\| (\d\.\d\d) m \|", reply.raw)[0]) < 3.0
    assert "could not reach" in stop_reply.raw


async def test_an_agent_that_is_ended_stops_its_robot_and_says_so(scene: Scene) -> None:
    async with scene.agent():
        post = scene.world.posts[await running(scene)]
    assert [r.card.state for r in scene.replies(post)] == ["interrupted"]
    async with scene.driver.client() as client:
        assert await client.holder() is None
        assert (await client.state()).velocity_mps == pytest.approx((0.0, 0.0), abs=0.02)
