"""One command, one slow mind or one failing task of an agent does not affect the others."""

from __future__ import annotations

import asyncio
import io
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from agentrob.agent.agent import RobotAgent
from agentrob.agent.media.recorder import Recorder
from agentrob.agent.understanding import extract
from agentrob.config.robots import RecordingConfig
from agentrob.errors import ForumNotFound
from agentrob.forums.memory.forum import MemoryForum
from agentrob.minds.isolated import IsolatedMind
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, ActionResult, Plan, Understanding
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings, serving
from tests.agent.media.test_recorder import jpeg, report, walked  # noqa: F401 (walked is a fixture)

TURN = f"@{ROBOT} turn left 30 degrees"


class SlowMind:
    """Reads like the rules, but never finishes a post that says "ponder"; `given_up` counts the cancelled readings."""

    name = "slow"

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.given_up = 0
        self._never = asyncio.Event()

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        self.asked.append(text)
        if "ponder" in text:
            try:
                await self._never.wait()
            except asyncio.CancelledError:
                self.given_up += 1
                raise
        return await RulesMind().understand(text, addressee, history)


async def test_any_number_of_slow_thoughts_holds_up_no_motion(scene: Scene) -> None:
    scene.person("carol")
    mind = SlowMind()
    async with scene.agent(mind=mind):
        for number in range(40):
            await scene.post("alice", f"@{ROBOT} ponder {number}")
        await scene.until(lambda: len(mind.asked) == 40)
        posted_s = time.monotonic()
        reply = await scene.final(await scene.post("carol", TURN))
        assert reply.card
        assert reply.card.state == "done", reply.raw
        assert time.monotonic() - posted_s < 4.0
    assert mind.given_up == 40


async def test_a_claim_that_is_refused_ends_the_thought_about_it(scene: Scene) -> None:
    class RefusingForum(MemoryForum):
        async def reply(self, *args: Any, **kwargs: Any) -> Any:
            raise ForumNotFound("the topic is gone")

    mind = SlowMind()
    async with scene.agent(mind=mind, forum=RefusingForum(scene.world, ROBOT)):
        await scene.post("alice", f"@{ROBOT} ponder")
        await scene.until(lambda: mind.given_up == 1)


async def test_whose_account_is_over_its_limit_costs_no_thought_of_a_mind(driver: Any, tmp_path: Any) -> None:
    scene = make_scene(driver, tmp_path, rates={"commands_per_hour": 1, "cooldown_s": 0, "waiting": 2})
    mind = SlowMind()
    async with scene.agent(mind=mind):
        await scene.final(await scene.post("alice", TURN))
        assert len(mind.asked) == 1
        refused = await scene.final(await scene.post("alice", TURN))
        assert refused.card
        assert refused.card.state == "refused"
        assert "`rate.hour`" in refused.raw
        assert len(mind.asked) == 1
        scene.person("carol")
        for number in range(6):
            await scene.post("carol", f"@{ROBOT} ponder {number}")
        last = await scene.final(await scene.post("carol", f"@{ROBOT} battery?"))
        assert last.card
        assert last.card.state == "answered", "the rules still answer"
        assert len(mind.asked) <= 1 + 3


async def test_a_failure_of_what_only_shows_things_does_not_end_the_agent(scene: Scene) -> None:
    class CardRefusingForum(MemoryForum):
        shown = 0

        async def publish_robot(self, name: str, card: Any) -> Any:
            type(self).shown += 1
            raise TypeError("a card that cannot be shown")

    async with scene.agent(forum=CardRefusingForum(scene.world, ROBOT)):
        await scene.until(lambda: CardRefusingForum.shown >= 2)
        reply = await scene.final(await scene.post("alice", TURN))
        assert reply.card
        assert reply.card.state == "done"
        stop = await scene.post("alice", f"@{ROBOT} stop")
        assert (await scene.until(lambda: scene.replies(stop)))[0].raw


async def test_a_command_keeps_its_film_while_the_next_one_moves(
    walked: tuple[ActionResult, ...],  # noqa: F811
    tmp_path: Any,
) -> None:
    recorder = Recorder(tmp_path, RecordingConfig(view="room"))
    for post, color in (("7", "red"), ("8", "blue")):
        with recorder.filming(post):
            recorder.see(jpeg(color))
    webp = await recorder.animation(report(walked, "7"))
    webp = webp or await recorder.late("7")
    assert webp
    with Image.open(io.BytesIO(webp)) as picture:
        red, _, blue = picture.convert("RGB").resize((1, 1)).getpixel((0, 0))  # type: ignore[misc]
    assert red > blue


class HangingMind(SlowMind):
    """Blocks its thread for good on "hang"."""

    name = "hanging"
    release = threading.Event()

    async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
        if "hang" in text:
            self.release.wait()
        return await super().understand(text, addressee, history)


async def test_a_mind_that_hangs_delays_no_stop_and_no_other_robot(
    scene: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(extract, "LIMIT_S", 0.5)
    (tmp_path / "other").mkdir()
    other = Driver(tmp_path / "other", robot_settings(), "humanoid")
    try:
        world = scene.world
        humanoid = world.sign_in("humanoid", kind=AccountKind.ROBOT_AGENT)
        agent = RobotAgent("humanoid", other.settings, humanoid, other.client(), RulesMind(), tmp_path / "humanoid")
        async with scene.agent(mind=IsolatedMind(HangingMind)), serving(agent):
            hung = await scene.post("alice", f"@{ROBOT} turn left and hang about")
            turned = await scene.post("alice", "@humanoid turn left 30 degrees")
            done = lambda: [p for p in world.posts.values() if p.reply_to == turned.id and "Done" in p.raw]  # noqa: E731
            await scene.until(done, limit_s=30)
            stop = await scene.post("alice", f"@{ROBOT} stop")
            assert "Stopped" in (await scene.until(lambda: scene.replies(stop), limit_s=30))[0].raw
            assert (await scene.final(hung)).card
            again = await scene.final(await scene.post("alice", TURN))
            assert again.card
            assert again.card.state == "done", again.raw
    finally:
        HangingMind.release.set()
        other.end()
