"""Laws 2, 9 and 17: who may release a locked robot and set its home from its page, and when a press of a button
counts."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.forums.memory.forum import MemoryForum
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, EventKind, Plan, RobotState, Role, Understanding
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings, set_home
from tests.waiting import until


@pytest.fixture
def owned(driver: Driver, tmp_path: Path) -> Iterator[Scene]:
    """Return a scene whose robot is owned by olga, a mere member, and release the robot after the test."""
    scene = make_scene(driver, tmp_path, owner="olga")
    scene.person("olga", Role.MEMBER)
    yield scene

    async def release() -> None:
        async with driver.client() as client:
            await client.release("the end of a test")

    asyncio.run(release())


async def locked(scene: Scene, by: str = "bob") -> dict[str, Any]:
    """Lock the robot by the button; return the lock on its card."""
    await scene.world.sign_in(by).press_estop(ROBOT)
    return await scene.until(lambda: (scene.world.robots.get(ROBOT) or {}).get("lock"))


async def press_result(scene: Scene, by: str) -> dict[str, Any]:
    """Return the result of an account's press, as the robot's card shows it."""

    def last() -> dict[str, Any] | None:
        card = (scene.world.robots.get(ROBOT) or {}).get("last_action")
        return card if card and card["by"] == by else None

    return await scene.until(last)


async def state(scene: Scene) -> RobotState:
    async with scene.driver.client() as client:
        return await client.state()


async def ended(scene: Scene, name: str, text: str) -> str:
    reply = await scene.final(await scene.post(name, text))
    assert reply.card is not None
    return reply.card.state


async def test_law_17_the_emergency_stop_button_locks_and_the_owner_s_button_releases(owned: Scene) -> None:
    async with owned.agent():
        running = await owned.post("alice", "@quadruped walk forward 5 metres slowly, then walk back 5 metres slowly")
        await owned.state(running, "running")
        await owned.until(lambda: (owned.world.robots.get(ROBOT) or {}).get("state") == "walking")
        lock = await locked(owned)
        assert (lock["by"], lock["why"]) == ("bob", "an emergency stop")
        assert lock["at"]
        stopped = await owned.final(running)
        assert "**Stopped** by `bob`" in stopped.raw
        assert re.search(r"Locked by `bob` \d+ seconds? ago: an emergency stop\.", stopped.raw)
        refused = await owned.final(await owned.post("alice", "@quadruped wave"))
        assert refused.card is not None
        assert refused.card.state == "refused"
        assert re.search(r"Halted by bob \d+ seconds? ago: an emergency stop\.", refused.raw)
        for said in (
            "My owner (`olga`) or an admin releases me with the button Release on [my page](memory:/robots/quadruped), "
            "or with `agentrob release quadruped` on my machine.",
        ):
            assert said in refused.raw
        asked = await owned.final(await owned.post("alice", "@quadruped status"))
        assert re.search(r"Locked by `bob` \d+ seconds? ago", asked.raw)
        assert "UTC" not in stopped.raw + refused.raw + asked.raw
        assert "agentrob release quadruped" in asked.raw
        await owned.world.sign_in("olga").press_release(ROBOT)
        card = await press_result(owned, "olga")
        assert (card["action"], card["done"]) == ("release", True)
        assert re.fullmatch(r"It had been locked by bob for \d+ seconds?\.", card["message"])
        await owned.until(lambda: owned.world.robots[ROBOT]["lock"] is None)
        assert await ended(owned, "alice", "@quadruped wave") == "done"


#: Law 2: whose press of Release and "Set home here" counts.
WHO = [
    ("olga", Role.MEMBER, AccountKind.HUMAN, True),  # its owner
    ("root", Role.ADMIN, AccountKind.HUMAN, True),
    ("guest", Role.GUEST, AccountKind.HUMAN, False),
    ("bob", Role.MEMBER, AccountKind.HUMAN, False),  # who locked it
    ("alice", Role.OPERATOR, AccountKind.HUMAN, False),
    ("mod", Role.MODERATOR, AccountKind.HUMAN, False),
    ("planner", Role.ADMIN, AccountKind.COMMANDING_AGENT, False),
    ("humanoid", Role.ADMIN, AccountKind.ROBOT_AGENT, False),
    ("watcher", Role.ADMIN, AccountKind.MONITORING_AGENT, False),
]


@pytest.mark.parametrize(("name", "role", "kind", "may"), WHO, ids=[w[0] for w in WHO])
async def test_law_2_only_the_owner_and_admins_release_and_home(
    owned: Scene, name: str, role: Role, kind: AccountKind, may: bool
) -> None:
    forum = owned.person(name, role, kind)
    owned.world.set_role(name, role)
    async with owned.agent():
        await locked(owned)
        await forum.press_release(ROBOT)
        if kind in (AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT):  # ignored
            await owned.final(await owned.post("alice", "@quadruped help"))
            assert owned.world.robots[ROBOT]["last_action"] is None
        else:
            card = await press_result(owned, name)
            assert card["done"] is may
            assert may or "Only the robot's owner and admins may release it" in card["message"]
        assert (await state(owned)).halted is not may


async def test_law_2_who_is_no_owner_any_more_when_it_is_heard_releases_nothing(owned: Scene) -> None:
    root = owned.person("root", Role.ADMIN)
    async with owned.agent() as agent:
        await locked(owned)
        account = await root.me()
        owned.world.set_role("root", Role.MEMBER)
        owned.world.emit(EventKind.ROBOT_RELEASE, robot=ROBOT, account=account)
        assert not (await press_result(owned, "root"))["done"]
        owned.world.suspend("olga")
        await _press_with_stale_account(owned, agent, "olga")
        assert (await state(owned)).halted


async def _press_with_stale_account(scene: Scene, agent: RobotAgent, name: str) -> None:
    """Return a press by an account that the event still calls unsuspended."""
    from dataclasses import replace

    account = replace(scene.world.accounts[name], suspended=False)
    scene.world.emit(EventKind.ROBOT_RELEASE, robot=ROBOT, account=account)
    card = await press_result(scene, name)
    assert not card["done"]


async def test_law_17_an_old_press_releases_nothing(owned: Scene) -> None:
    async with owned.agent():
        await locked(owned)
        owned.world.clock_offset_s = -60.0
        await owned.world.sign_in("olga").press_release(ROBOT)
        owned.world.clock_offset_s = 0.0
        card = await press_result(owned, "olga")
        assert not card["done"]
        assert "pressed more than 30 s before" in card["message"]
        assert (await state(owned)).halted


async def test_law_17_a_press_while_the_agent_was_away_counts_only_while_it_is_fresh(owned: Scene) -> None:
    async with owned.agent():
        await locked(owned)
    owned.world.clock_offset_s = -3600.0
    await owned.world.sign_in("olga").press_release(ROBOT)
    owned.world.clock_offset_s = 0.0
    async with owned.agent():
        assert not (await press_result(owned, "olga"))["done"]
        assert (await state(owned)).halted
        await owned.world.sign_in("olga").press_release(ROBOT)
        await owned.until(lambda: owned.world.robots[ROBOT]["lock"] is None)
        assert await ended(owned, "alice", "@quadruped wave") == "done"


async def test_law_17_a_lock_that_came_after_the_press_stays(owned: Scene) -> None:
    async with owned.agent():
        await locked(owned)
        owned.world.clock_offset_s = -5.0  # pressed before, received after
        await owned.world.sign_in("olga").press_release(ROBOT)
        owned.world.clock_offset_s = 0.0
        card = await press_result(owned, "olga")
        assert not card["done"]
        assert "locked after this release was requested" in card["message"]
        assert (await state(owned)).halted


async def test_law_17_a_double_press_is_one_release(owned: Scene) -> None:
    async with owned.agent():
        await locked(owned)
        olga = owned.world.sign_in("olga")
        await olga.press_release(ROBOT)
        await olga.press_release(ROBOT)
        card = await owned.until(
            lambda: (t := (owned.world.robots[ROBOT]["last_action"] or {})) and "was not locked" in t["message"] and t
        )
        assert card["done"]
        assert not (await state(owned)).halted
        assert await ended(owned, "alice", "@quadruped wave") == "done"


async def test_law_17_a_lost_driver_is_reported_and_the_lock_is_still_there_when_it_comes_back(tmp_path: Path) -> None:
    first = Driver(tmp_path, robot_settings(), name="lost")
    scene = make_scene(first, tmp_path, owner="olga")
    scene.person("olga", Role.MEMBER)
    try:
        async with scene.agent():
            await locked(scene)
            first.process.kill()
            first.process.wait(60)
            await scene.world.sign_in("olga").press_release(ROBOT)
            card = await press_result(scene, "olga")
            assert not card["done"]
            assert "start one with: agentrob driver lost" in card["message"]
            second = Driver(tmp_path, robot_settings(), name="lost")
            try:
                assert await ended(scene, "alice", "@quadruped wave") == "refused"
                await scene.world.sign_in("olga").press_release(ROBOT)
                await scene.until(lambda: scene.world.robots[ROBOT]["lock"] is None)
                assert await ended(scene, "alice", "@quadruped wave") == "done"
            finally:
                second.end()
    finally:
        first.end()


class WaitingMind(RulesMind):
    """A mind that waits until the gate is opened and then understands nothing."""

    def __init__(self) -> None:
        self.asked, self.gate = asyncio.Event(), asyncio.Event()

    async def understand(self, text: str, addressee: Addressee, history: tuple[Plan, ...] = ()) -> Understanding:
        self.asked.set()
        await self.gate.wait()
        return await super().understand(text, addressee, history)


@pytest.mark.parametrize("how", ["button", "at the machine"])
async def test_laws_14_and_17_what_was_posted_before_a_release_does_not_move_after_it(owned: Scene, how: str) -> None:
    mind = WaitingMind()
    async with owned.agent(mind=mind):
        await locked(owned)
        before = (await state(owned)).pose
        waiting = await owned.post("alice", "@quadruped walk forward 1 metre")
        await mind.asked.wait()
        await owned.world.wait(0.05)
        if how == "button":
            await owned.world.sign_in("olga").press_release(ROBOT)
            await press_result(owned, "olga")
        else:
            async with owned.driver.client() as client:
                assert await client.release("olga at the shell") is not None
        mind.gate.set()
        reply = await owned.final(waiting)
        assert reply.card is not None
        assert reply.card.state == "cancelled"
        assert ("have been released since" if how == "button" else "release of olga at the shell") in reply.raw
        assert (await state(owned)).pose == before
        assert await ended(owned, "alice", "@quadruped wave") == "done"


async def test_law_9_the_report_of_a_fall_says_how_its_home_is_set_again(tmp_path: Path) -> None:
    options = {"faults": {"fallen": True, "after_m": 0.5}}
    driver = Driver(tmp_path, robot_settings(home_on_start=False, options=options), name="falls")
    scene = make_scene(driver, tmp_path, owner="olga", home_on_start=False)
    try:
        await set_home(driver, "olga")
        async with scene.agent():
            fell = await scene.final(await scene.post("alice", "@quadruped walk forward 1 metre"))
            assert fell.card is not None
            assert fell.card.state == "failed"
            assert "My owner (`olga`) or an admin sets my home, where I stand, with the button" in fell.raw
    finally:
        driver.end()


async def test_law_9_a_robot_without_home_says_how_it_is_set_and_the_owner_s_button_sets_it(tmp_path: Path) -> None:
    homeless = Driver(tmp_path, robot_settings(home_on_start=False), name="homeless")
    scene = make_scene(homeless, tmp_path, owner="olga", home_on_start=False)
    scene.person("olga", Role.MEMBER)
    try:
        async with scene.agent():
            refused = await scene.final(await scene.post("alice", "@quadruped walk forward 1 metre"))
            assert refused.card is not None
            assert refused.card.state == "refused"
            assert (
                "My owner (`olga`) or an admin sets my home, where I stand, with the button Set home here on "
                "[my page](memory:/robots/quadruped), or with `agentrob home quadruped` on my machine." in refused.raw
            )
            zh = await scene.final(await scene.post("alice", "@quadruped 前进一米"))
            assert "agentrob home quadruped" in zh.raw
            assert "Set home here" in (await scene.final(await scene.post("alice", "@quadruped status"))).raw
            await scene.until(lambda: scene.world.robots[ROBOT]["homed"] is False)
            await scene.world.sign_in("alice").press_home(ROBOT)
            assert not (await press_result(scene, "alice"))["done"]
            await scene.world.sign_in("olga").press_home(ROBOT)
            card = await press_result(scene, "olga")
            assert (card["action"], card["done"]) == ("home", True)
            await scene.until(lambda: scene.world.robots[ROBOT]["homed"] is True)
            walk = await scene.post("alice", "@quadruped walk forward 3 metres, then walk back 3 metres")
            await scene.state(walk, "running")
            async with homeless.client() as client:
                await until(client.state, lambda state: any(state.velocity_mps or ()))
            await scene.world.sign_in("olga").press_home(ROBOT)
            await scene.until(lambda: not scene.world.robots[ROBOT]["last_action"]["done"])
            assert "cannot set home" in scene.world.robots[ROBOT]["last_action"]["message"]
            reply = await scene.final(walk)
            assert reply.card is not None
            assert reply.card.state == "done", "a press on home does not disturb what moves"
    finally:
        homeless.end()


class ForumWithoutPages:
    """A forum without pages of robots, as NodeBB and Discourse are."""

    def __init__(self, forum: MemoryForum) -> None:
        self._forum = forum

    def __getattr__(self, name: str) -> Any:
        if name in ("robot_page", "publish_robot", "publish_frame"):
            raise AttributeError(name)
        return getattr(self._forum, name)


@pytest.mark.parametrize(
    ("text", "how"),
    [
        ("@quadruped emergency stop", "My owner releases me with `agentrob release quadruped` on my machine."),
        ("@quadruped 急停", "我的主人可在我的主机上运行 `agentrob release quadruped` 来解除。"),
    ],
    ids=["en", "zh"],
)
async def test_law_17_where_the_forum_has_no_buttons_the_reply_names_the_command(
    owned: Scene, text: str, how: str
) -> None:
    forum = ForumWithoutPages(owned.world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT))
    async with owned.agent(forum=forum):
        stop = await owned.post("bob", text)
        (reply,) = await owned.until(lambda: owned.replies(stop))
        assert how in reply.raw
        assert "Release" not in reply.raw


class SlowPages(MemoryForum):
    """A forum that never answers where the page of a robot is."""

    async def robot_page(self, robot: str) -> str:
        await asyncio.Event().wait()
        raise AssertionError


async def test_law_17_the_reply_names_the_page_without_a_link_if_the_forum_does_not_answer(owned: Scene) -> None:
    owned.world.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
    async with owned.agent(forum=SlowPages(owned.world, ROBOT)):
        stop = await owned.post("bob", "@quadruped emergency stop")
        (reply,) = await owned.until(lambda: owned.replies(stop))
        assert "with the button Release on my page, or with `agentrob release quadruped`" in reply.raw
