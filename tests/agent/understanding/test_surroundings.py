"""The known surroundings of a robot, and the addressee of a post, through the agent: forum, driver, fake robot."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.model import AccountKind, Role
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene
from tests.agent.execution.visual_model import ScriptedLoopModel, running_loop_model
from tests.waiting import until

STAIRS = "A landing. There are stairs 1 m ahead of the robot."
WALK = f"@{ROBOT} walk forward 2 m"


async def run_command(scene: Scene, text: str) -> tuple[str, str]:
    """Return how a post ends and the text of the reply."""
    async with scene.agent() as agent:
        reply = await scene.final(await scene.post("alice", text))
        # The next agent would take it for a waiting command.
        await until(agent.journal.open_claims, lambda claims: not claims)
    assert reply.card is not None
    return reply.card.state, reply.raw


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (WALK, "I would walk into something that is known to be here (`there are stairs 1 m ahead of the robot`)."),
        (f"@{ROBOT} 向前走2米", "据我所知，我要去的地方有东西（`there are stairs 1 m ahead of the robot`）。"),
    ],
)
async def test_law_7_what_is_harmless_elsewhere_is_refused_in_a_scene(
    driver: Driver, tmp_path: Path, text: str, says: str
) -> None:
    state, raw = await run_command(make_scene(driver, tmp_path / "with", scene=STAIRS), text)
    assert state == "refused"
    assert says in raw
    assert "`scene.way.drop`" in raw
    assert (await run_command(make_scene(driver, tmp_path / "without"), text))[0] == "done"


async def test_law_7_what_is_not_understood_is_refused_where_the_scene_makes_it_harm(
    driver: Driver, tmp_path: Path
) -> None:
    text = f"@{ROBOT} put the cup of water on the desk"
    state, raw = await run_command(
        make_scene(driver, tmp_path / "with", scene="An office. A laptop is on the desk."), text
    )
    assert (state, "`scene.electric`" in raw) == ("refused", True)
    assert (await run_command(make_scene(driver, tmp_path / "without"), text))[0] == "asks_back"


@pytest.fixture
def scripted_model() -> Iterator[ScriptedLoopModel]:
    with running_loop_model() as made:
        yield made


async def test_law_7_what_a_camera_model_named_narrows_the_next_command_until_the_robot_has_moved(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedLoopModel
) -> None:
    scene = make_scene(driver, tmp_path, look={"allowed": True}, screen="rules")
    scripted_model.loop_answers = [("finish", {"outcome": "done", "saw": ["stairs 1 m ahead"], "did": ""})]
    read = {"action": "move", "amount": 2, "unit": "m"}
    async with scene.agent(mind=scripted_model.mind(tmp_path)):
        looked = await scene.final(await scene.post("alice", f"@{ROBOT} tell me what you see"))
        scripted_model.extraction = {
            "intent": "command",
            "steps": [{**read, "direction": "forward", "words": "walk forward 2 m"}],
        }
        ahead = await scene.final(await scene.post("alice", WALK))
        scripted_model.extraction = {
            "intent": "command",
            "steps": [{**read, "direction": "left", "words": "walk left 2 m"}],
        }
        aside = await scene.final(await scene.post("alice", f"@{ROBOT} walk left 2 m"))
        scripted_model.extraction = {
            "intent": "command",
            "steps": [{**read, "direction": "forward", "words": "walk forward 2 m"}],
        }
        later = await scene.final(await scene.post("alice", WALK))
    assert [reply.card and reply.card.state for reply in (looked, ahead, aside, later)] == [
        "done", "refused", "done", "done",
    ], "\n\n".join(reply.raw for reply in (looked, ahead, aside, later))  # fmt: skip
    assert "`scene.way.drop`" in ahead.raw


async def test_law_7_of_two_robots_in_a_post_each_is_judged_by_what_is_before_it(scene: Scene) -> None:
    scene.person("humanoid", Role.MEMBER, AccountKind.ROBOT_AGENT)
    state, raw = await run_command(scene, f"@humanoid, there is a wall 1 m in front of you, turn left. {WALK}")
    assert state == "done", raw
    state, raw = await run_command(
        scene, f"@humanoid, turn left. @{ROBOT} there is a wall 1 m in front of you, walk 2 m"
    )
    assert (state, "`way.thing`" in raw) == ("refused", True)
