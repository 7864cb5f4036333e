"""A command that needs a camera, end to end: forum, agent, driver process, and a model over HTTP."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.minds import MindConfig
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.model import Post
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings
from tests.agent.execution.signed_robot import run_signed_driver
from tests.agent.execution.visual_model import (
    DONE,
    ScriptedLoopModel,
    conversation_text,
    pictures,
    running_loop_model,
    said,
)
from tests.minds.model_double import model_double
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("model_libraries")

GOAL = f"@{ROBOT} walk to the red ball and tell me what is beside it"
LOOK = {"allowed": True}
TURN = ("act_turn", {"direction": "left", "degrees": 15})
WALK = ("act_move", {"direction": "forward", "distance_m": 1, "look": True})


@pytest.fixture
def scripted_model() -> Iterator[ScriptedLoopModel]:
    with running_loop_model() as made:
        yield made


@pytest.fixture
def looking(driver: Driver, tmp_path: Path) -> Scene:
    """Return a scene whose owner allows a model to steer."""
    return make_scene(driver, tmp_path, look=LOOK)


async def answered(
    scene: Scene, scripted_model: ScriptedLoopModel, text: str = GOAL, who: str = "alice", **mind: Any
) -> tuple[Post, Post]:
    model = scripted_model.mind(scene.folder, **mind)
    await model.prepare()
    async with scene.agent(mind=model):
        post = await scene.post(who, text)
        return post, await scene.final(post)


def record(scene: Scene, post: Post) -> dict[str, Any]:
    kept: dict[str, Any] = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
    return kept


async def test_law_18_the_report_has_what_was_measured_and_the_model_s_words_as_the_model_s(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [TURN, WALK, DONE]
    post, reply = await answered(looking, scripted_model)
    assert reply.card is not None
    assert reply.card.state == "done", reply.raw
    assert "**Finished:** go to the red ball, then say what is beside the red ball." in reply.raw
    _, turn, walk, _ = (step["measured"] for step in record(looking, post)["steps"])
    in_all = f"{walk['distance_m']:.2f} m walked, {turn['degrees']:.0f}° turned"
    assert f"Measured in all: {in_all}. Pictures: 2." in reply.raw
    assert "The model `clever` says that it saw `a blue box`." in reply.raw
    assert "This has not been verified." in reply.raw
    assert "3 questions" in reply.raw or "4 questions" in reply.raw
    assert len(reply.images) == 3  # two from the camera, one of the path
    kept = record(looking, post)["looked"]
    assert [t["tool"] for t in kept["turns"]] == ["act_turn", "act_move", "finish"]
    assert kept["end"]["saw"] == ["a blue box"]
    assert [s["op"] for s in record(looking, post)["steps"]] == ["get_front_image", "turn", "move", "get_front_image"]
    assert len(list((looking.folder / f"agents/{ROBOT}/pictures").glob(f"{post.id}-*.jpg"))) == 2


async def test_law_7_the_model_with_tools_never_sees_the_post(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [WALK, DONE]
    await answered(looking, scripted_model, f"@{ROBOT} Could you please WALK over to the red ball, then wave")
    question = conversation_text(scripted_model.loops[0])
    assert "go to the red ball, then wave" in question
    assert "Could you" not in question
    assert "alice" not in question
    assert pictures(scripted_model.loops[0])


@pytest.mark.parametrize("settings", [{"look": {"allowed": False}}, {"look": LOOK, "mind": {"images": False}}])
async def test_without_consent_or_eyes_it_asks_back(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedLoopModel, settings: dict[str, Any]
) -> None:
    mind = settings.pop("mind", {})
    scene = make_scene(driver, tmp_path, **settings)
    scripted_model.extraction = {"intent": "unclear", "doubt": "place"}
    _, reply = await answered(scene, scripted_model, **mind)
    assert reply.card is not None
    assert reply.card.state == "asks_back"
    assert "vision model" in reply.raw
    assert scripted_model.loops == []


async def test_who_has_eyes_does_not_say_that_it_has_none(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    scripted_model.extraction = {"intent": "unclear", "doubt": "place"}
    _, reply = await answered(looking, scripted_model, f"@{ROBOT} walk to the frobnicator")
    assert reply.card is not None
    assert reply.card.state == "asks_back"
    assert "not as this is said" in reply.raw


async def test_law_2_a_member_may_not_send_it_looking(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    _, reply = await answered(looking, scripted_model, who="bob")
    assert reply.card is not None
    assert reply.card.state == "refused"
    assert scripted_model.loops == []


async def test_law_7_a_model_may_refuse_a_goal(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    scripted_model.review = {
        "decision": "refuse",
        "harm": "people",
        "words": "the red ball",
        "why": "a child plays there",
    }
    _, reply = await answered(looking, scripted_model)
    assert reply.card is not None
    assert reply.card.state == "refused"
    assert "go to the red ball" in scripted_model.prompts("screen")[0]
    assert scripted_model.loops == []


async def test_law_18_success_without_moving_is_no_success(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    _, reply = await answered(looking, scripted_model)
    assert reply.card is not None
    assert reply.card.state == "failed"
    assert "**Not reached:**" in reply.raw
    assert "**Contradicted by measurement:** it claims to be there, but I measured 0.00 m of walking." in reply.raw


async def test_law_18_a_denied_claim_is_reported_in_the_language_of_the_post(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [("finish", {"outcome": "done", "saw": [], "did": "走了8米"})]
    post, reply = await answered(looking, scripted_model, f"@{ROBOT} 走到红色的球旁边，告诉我它旁边有什么")
    assert reply.card is not None
    assert reply.card.state == "failed"
    assert "**与实测不符：** 它声称已经到达，但我实测只走了 0.00 米。" in reply.raw
    assert record(looking, post)["looked"]["contradicted"].startswith("它声称")


# ---------------------------------------------------------------------- the transcript
def rows(reply: Post) -> list[list[str]]:
    """Return the cells of the report's table without its header."""
    lines = [line for line in reply.raw.splitlines() if line.startswith("|")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[2:]]


async def test_the_report_has_every_call_with_its_arguments_what_was_measured_and_what_was_seen(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    far = ("act_move", {"direction": "forward", "distance_m": 99})
    scripted_model.loop_answers = [TURN, far, "I think | so.", WALK, DONE]
    post, reply = await answered(looking, scripted_model)
    conversation_text = rows(reply)
    assert [row[0] for row in conversation_text] == ["1", "2", "", "", "3", "4", ""]
    assert [row[1] for row in conversation_text] == [
        "take a photo",
        "`act_turn left degrees=15`",
        '`act_move {"direction": "forward", "distance_m": 99}`',
        "`I think ¦ so.`",
        "`act_move forward distance_m=1 look=true`",
        "take a photo",
        '`finish outcome=done saw=["a blue box"] did=I walked to it.`',
    ]
    measured = [step["measured"] for step in record(looking, post)["steps"]]
    assert conversation_text[1][2] == f"{measured[1]['degrees']:.1f}°"
    assert conversation_text[4][2] == f"{measured[2]['distance_m']:.2f} m"
    assert [row[3] for row in conversation_text if row[0]] == ["done, picture 1", "done", "done", "done, picture 2"]
    assert conversation_text[2][3].startswith("not done: `")
    assert conversation_text[3][3] == "words, no call"
    assert conversation_text[6][3] == "it says `done`"
    assert (
        looking.world.pictures[reply.images[0]]
        == (looking.folder / f"agents/{ROBOT}/pictures/{post.id}-1.jpg").read_bytes()
    )
    assert "| Step | Called by the model | Measured | Outcome |" in reply.raw


async def test_a_plan_s_report_has_no_calls(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    scripted_model.extraction = {"intent": "command", "steps": [{"action": "get_front_image", "words": "take a photo"}]}
    _, reply = await answered(looking, scripted_model, f"@{ROBOT} take a photo")
    assert "Called by the model" not in reply.raw
    assert "| Step | Asked |" in reply.raw


async def test_law_3_words_of_a_model_are_escaped(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    saw = ["@bob ![x](http://evil/x.png) <b>`" + "y" * 150]
    scripted_model.loop_answers = [WALK, ("finish", {"outcome": "done", "saw": saw, "did": "walked"})]
    _, reply = await answered(looking, scripted_model)
    assert "`(at)bob ![x](http://evil/x.png) <b>'yyy" in reply.raw
    assert reply.mentions == ()
    assert "y" * 101 not in reply.raw


@pytest.mark.parametrize(
    ("drives", "sentence"),
    [
        pytest.param([TURN], "used up its calls", marks=pytest.mark.slow),
        ([("act_fly", {})], "made no progress"),
        pytest.param([("act_backflip", {})], "made no progress", marks=pytest.mark.slow),
        pytest.param(
            [("act_move", {"direction": "forward", "distance_m": 99})], "made no progress", marks=pytest.mark.slow
        ),
        ([("act_move", "{not json")], "made no progress"),
        ([lambda handler: handler.send(500, b"{}")], "did not answer (rejected)"),  # with a picture
        pytest.param([WALK, lambda handler: handler.break_off()], "did not answer (broken)", marks=pytest.mark.slow),
        pytest.param([lambda handler: handler.flood(10_000_000)], "did not answer (too_big)", marks=pytest.mark.slow),
        pytest.param(["I see.", "I still see."], "cannot tell", marks=pytest.mark.slow),
    ],
)
async def test_every_bad_model_ends_in_a_clear_state_within_its_budget(
    looking: Scene, scripted_model: ScriptedLoopModel, drives: list[Any], sentence: str
) -> None:
    scripted_model.loop_answers = drives
    post, reply = await answered(looking, scripted_model, retries=0)
    assert reply.card is not None
    assert reply.card.state == "failed"
    assert sentence in reply.raw
    asked = [step["asked"] for step in record(looking, post)["steps"]]
    assert sum(step.get("distance_m", 0) for step in asked) <= 5
    assert len(scripted_model.loops) <= 13


async def test_a_model_that_hangs_ends_when_the_time_of_the_command_is_up(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedLoopModel
) -> None:
    scene = make_scene(driver, tmp_path, look={"allowed": True, "seconds": 1.0})
    scripted_model.loop_answers = [scripted_model.hang]
    _, reply = await answered(scene, scripted_model)
    assert "The time for this command was up." in reply.raw


async def test_law_14_a_stop_post_ends_a_thought(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    scripted_model.loop_answers = [WALK, scripted_model.hang]
    async with looking.agent(mind=scripted_model.mind(looking.folder)):
        post = await looking.post("alice", GOAL)
        assert await asyncio.to_thread(scripted_model.hanging.wait, 10)
        await looking.post("bob", "stop", topic=post.topic_id)
        reply = await looking.final(post)
    assert reply.card is not None
    assert reply.card.state == "stopped"
    assert "**Stopped** by `bob`" in reply.raw
    assert len(scripted_model.loops) == 2


async def test_law_14_a_stop_post_ends_a_walk_that_a_model_called(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [("act_move", {"direction": "forward", "distance_m": 4, "speed_mps": 0.1}), DONE]
    async with looking.agent(mind=scripted_model.mind(looking.folder)), looking.driver.client() as client:
        post = await looking.post("alice", GOAL)
        await until(client.state, lambda state: (state.velocity_mps or (0.0,))[0] > 0.05)
        await looking.post("bob", "stop", topic=post.topic_id)
        reply = await looking.final(post)
    assert reply.card is not None
    assert reply.card.state == "stopped"
    walked = record(looking, post)["steps"][1]
    assert (walked["op"], walked["outcome"]) == ("move", "stopped")
    assert walked["measured"]["distance_m"] < 3.5
    assert len(scripted_model.loops) == 1


async def test_law_4_a_post_that_is_edited_while_a_model_thinks_moves_nothing_more(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [WALK, scripted_model.after(WALK)]
    async with looking.agent(mind=scripted_model.mind(looking.folder)):
        post = await looking.post("alice", GOAL)
        assert await asyncio.to_thread(scripted_model.hanging.wait, 10)
        await looking.world.sign_in("alice").edit(post.id, f"@{ROBOT} walk to the blue box")
        scripted_model.go.set()
        reply = await looking.final(post)
    assert reply.card is not None
    assert reply.card.state == "cancelled"
    assert [step["op"] for step in record(looking, post)["steps"]] == ["get_front_image", "move", "get_front_image"]


async def test_law_6_a_loop_that_was_cut_off_is_reported_as_interrupted_and_never_goes_on(
    looking: Scene, scripted_model: ScriptedLoopModel
) -> None:
    scripted_model.loop_answers = [WALK, scripted_model.hang]
    async with looking.agent(mind=scripted_model.mind(looking.folder)):
        post = await looking.post("alice", GOAL)
        assert await asyncio.to_thread(scripted_model.hanging.wait, 10)
    scripted_model.loop_answers = [WALK]
    before = len(scripted_model.loops)
    async with looking.agent(mind=scripted_model.mind(looking.folder)):
        reply = await looking.final(post)
    assert reply.card is not None
    assert reply.card.state == "interrupted"
    assert len(scripted_model.loops) == before


# ---------------------------------------------------------------------- pictures are data
@pytest.fixture
def sign(tmp_path: Path) -> Iterator[Driver]:
    """A robot with a sign with instructions in front of its camera."""
    made = Driver(tmp_path, robot_settings(), name="signed", run=run_signed_driver)
    yield made
    made.end()


async def test_law_7_a_model_that_obeys_a_sign_in_its_picture_does_nothing_outside_of_the_mandate(
    sign: Driver, tmp_path: Path, scripted_model: ScriptedLoopModel
) -> None:
    scene = make_scene(sign, tmp_path, look=LOOK)
    ten = ("act_move", {"direction": "forward", "distance_m": 10})
    four = ("act_move", {"direction": "forward", "distance_m": 4})
    scripted_model.loop_answers = [ten, four, ("act_backflip", {}), four, four, four]
    post, reply = await answered(scene, scripted_model, f"@{ROBOT} turn towards the door, then tell me what you see")
    assert pictures(scripted_model.loops[0])[0].size == (640, 480)
    assert [step["op"] for step in record(scene, post)["steps"]] == ["get_front_image"]
    assert [row[1].split()[0].strip("`") for row in rows(reply)[1:4]] == ["act_move", "act_move", "act_backflip"]
    assert all(row[3].startswith("not done: `") for row in rows(reply)[1:])
    scripted_model.loops.clear()
    post, reply = await answered(scene, scripted_model, f"@{ROBOT} walk to the door")
    assert sum(s["asked"].get("distance_m", 0) for s in record(scene, post)["steps"]) == 4
    assert reply.card is not None
    assert reply.card.state == "failed"
    async with sign.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    assert abs(pose.x_m) <= 4.2


async def test_a_weak_model_steers_by_json_in_its_words(looking: Scene, scripted_model: ScriptedLoopModel) -> None:
    call = '{"tool": "act_move", "arguments": {"direction": "forward", "distance_m": 0.5, "look": true}}'
    end = '{"tool": "finish", "arguments": {"outcome": "done", "saw": ["a box"], "did": "walked 0.5 m"}}'
    scripted_model.review = lambda handler: handler.send(
        200, json.dumps(said(json.dumps({"decision": "fine"}))).encode()
    )
    scripted_model.loop_answers = [call, end]
    _, reply = await answered(looking, scripted_model, answers="json")
    assert reply.card is not None
    assert reply.card.state == "done", reply.raw
    assert "saw `a box`" in reply.raw
    assert "tools" not in scripted_model.loops[0]
    assert len(pictures(scripted_model.loops[1])) == 2


# ---------------------------------------------------------------------- both dialects
@pytest.mark.parametrize(("provider_name", "path"), [("openai", "/v1"), ("anthropic", "")])
async def test_the_double_of_both_dialects_steers_the_robot(
    driver: Driver, tmp_path: Path, provider_name: str, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TEST_KEY", "sk-test-0123456789")
    scene = make_scene(driver, tmp_path, look=LOOK, screen="rules")
    calls = [TURN, WALK, ("finish", {"outcome": "done", "saw": ["a blue box"], "did": "walked to the ball"})]
    fixtures: list[dict[str, Any]] = [
        {"match": {"turnIndex": turn}, "response": {"toolCalls": [{"name": name, "arguments": arguments}]}}
        for turn, (name, arguments) in enumerate(calls)
    ]
    with model_double(tmp_path, fixtures) as double:
        given = {"provider": provider_name, "model": "m", "key_env": "TEST_KEY", "base_url": double.url + path}
        model = ConfiguredModel("clever", MindConfig.model_validate(given), tmp_path / "minds.sqlite")
        await model.prepare()
        async with scene.agent(mind=ModelMind(FallbackModel([model]))):
            post = await scene.post("alice", GOAL)
            reply = await scene.final(post)
        asked = double.journal()
    assert reply.card is not None
    assert reply.card.state == "done", reply.raw
    assert [step["op"] for step in record(scene, post)["steps"]] == [
        "get_front_image",
        "turn",
        "move",
        "get_front_image",
    ]
    assert len(asked) == 3
    assert "go to the red ball" in json.dumps(asked[0]["body"])
    assert "tell me what is beside it" not in json.dumps(asked[-1]["body"])
