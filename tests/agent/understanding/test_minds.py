"""A model behind the agent, on a forum with a robot: the replies, whatever the model does."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from agentrob.board.content.markdown import render
from agentrob.minds.protocol import Addressee
from agentrob.minds.rules import RulesMind
from agentrob.model import AccountKind, Intent, Plan, Post, Role, Understanding
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene
from tests.minds.faulty_server import called, said
from tests.minds.scripted_model import FINE, ScriptedModel, move, running_scripted_model
from tests.waiting import until

pytestmark = pytest.mark.usefixtures("model_libraries")

#: A post that the rules ask back, and a model's reading of it.
FREE = f"@{ROBOT} be a darling and meander forward 1 m"
FREE_READ = move("meander forward 1 m", 1)
PLAIN = f"@{ROBOT} walk forward 1 m"
STILL_M = 0.02


@pytest.fixture
def scripted_model() -> Iterator[ScriptedModel]:
    with running_scripted_model() as made:
        yield made


async def place(driver: Driver) -> tuple[float, float]:
    async with driver.client() as client:
        pose = (await client.state()).pose
    assert pose is not None
    return pose.x_m, pose.y_m


def record(scene: Scene, post: Post) -> dict[str, Any]:
    kept: dict[str, Any] = json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())
    return kept


# ---------------------------------------------------------------------- understanding
@pytest.mark.parametrize(
    ("text", "reads", "line"),
    [
        (FREE, FREE_READ, r"`clever` (`served-model`): 2 questions, 200 + 40 tokens, 0.0008 EUR, "),
        (
            f"@{ROBOT} 请你往前溜达1米",
            move("往前溜达1米", 1),
            "`clever` (`served-model`)：2 次提问，200 + 40 个 token，0.0008 EUR，",
        ),
    ],
)
async def test_law_19_a_free_post_moves_the_robot_and_the_reply_names_the_model(
    scene: Scene, scripted_model: ScriptedModel, text: str, reads: dict[str, Any], line: str
) -> None:
    scripted_model.extraction = reads
    price = {"input_per_million": 2.0, "output_per_million": 10.0, "currency": "EUR"}
    async with scene.agent(mind=scripted_model.mind(scene.folder, price=price)):
        post = await scene.post("alice", text)
        reply = await scene.final(post)
    assert reply.card.state == "done", reply.raw
    assert line in reply.raw
    kept = record(scene, post)
    assert (kept["mind"], kept["fallback"]) == ("clever", "")
    assert [(u["mind"], u["model"], u["input_tokens"]) for u in kept["models"]] == [("clever", "served-model", 100)] * 2
    assert kept["screened"] == {"mind": "clever", "refusal": None, "why": "", "failed": ""}
    assert kept["steps"][0]["measured"]["distance_m"] == pytest.approx(1.0, abs=0.1)


async def test_without_a_model_the_reply_says_nothing_of_models(scene: Scene) -> None:
    async with scene.agent():
        post = await scene.post("alice", PLAIN)
        reply = await scene.final(post)
    assert "rules" not in reply.raw
    assert "token" not in reply.raw
    assert (record(scene, post)["mind"], record(scene, post)["models"]) == ("rules", [])


async def test_what_was_done_before_is_reported_as_plans_and_not_as_posts(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    again = move("the very same thing again but slower", 1, slow=True)
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        scripted_model.extraction = FREE_READ
        first = await scene.post("alice", FREE)
        assert (await scene.final(first)).card.state == "done"
        scripted_model.extraction = again
        second = await scene.post(
            "alice", f"@{ROBOT} lovely. kindly do the very same thing again but slower", first.topic_id
        )
        reply = await scene.final(second)
    assert reply.card.state == "done", reply.raw
    assert "walk forward 1 m at 0.2 m/s" in reply.raw
    reply_text = scripted_model.prompts("read")[1]
    assert '[[{"action": "move", "direction": "forward", "distance_m": 1.0}]]' in reply_text
    assert "darling" not in reply_text


async def test_a_wish_that_the_post_does_not_say_is_asked_back_and_not_done(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    scripted_model.extraction = move("meander forward 1 m", 4)
    stood = await place(scene.driver)
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        reply = await scene.final(await scene.post("alice", FREE))
    assert reply.card.state == "asks_back"
    assert "I understood: walk forward 4 m." in reply.raw
    assert "`clever`" in reply.raw
    assert scripted_model.prompts("screen") == []
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_the_next_model_of_the_chain_is_named(scene: Scene, scripted_model: ScriptedModel) -> None:
    def answer(handler: Any, body: dict[str, Any]) -> None:
        good = called("answer", FREE_READ if body["messages"][0]["content"].startswith("# Reading") else FINE)
        handler.send(401, b"{}") if body["model"] == "one" else handler.send(200, json.dumps(good).encode())

    from agentrob.minds.extraction.mind import ModelMind
    from agentrob.minds.llm.fallback import FallbackModel

    scripted_model.server.answer = answer
    models = [scripted_model.model(scene.folder, name, model=name) for name in ("one", "two")]
    async with scene.agent(mind=ModelMind(FallbackModel(models))):
        reply = await scene.final(await scene.post("alice", FREE))
    assert reply.card.state == "done"
    assert "`one` did not read this post (its key was refused); `two` did." in reply.raw


# ---------------------------------------------------------------------- faults
def raw(status: int, body: str = "{}", **headers: str) -> Callable[[Any], None]:
    return lambda handler: handler.send(status, body.encode(), **headers)


def answered(reply: dict[str, Any]) -> Callable[[Any], None]:
    return raw(200, json.dumps(reply))


FAULTS: dict[str, tuple[Callable[[Any], None], str]] = {
    "401": (raw(401), "its key was refused"),
    "429": (raw(429, retry_after="30"), "it takes no more questions for now"),
    "500": (raw(500), "its server failed"),
    "hang": (lambda handler: handler.hang(), "no answer in time"),
    "truncated": (lambda handler: handler.break_off(), "its answer broke off"),
    "malformed JSON": (answered(called("answer", '{"intent": "comm')), "its answer was unusable"),
    "no JSON at all": (raw(200, "<html>"), "its answer was unusable"),
    "unknown tool": (answered(called("rm_rf", {"path": "/"})), "its answer was unusable"),
    "arguments out of bounds": (answered(called("answer", move("walk", 1e9))), "its answer was unusable"),
    "10 MB": (lambda handler: handler.flood(10_000_000), "its answer was too long"),
    "empty": (answered(said("")), "its answer was unusable"),
}


async def assert_rules_replaced(scene: Scene, scripted_model: ScriptedModel, fault: str, why: str) -> None:
    """Check the reply to a post that only a model reads, while the model fails."""
    began = time.monotonic()
    reply = await scene.final(await scene.post("alice", FREE))
    assert reply.card.state == "asks_back", (fault, reply.raw)
    assert f"`clever` did not read this post ({why}); my rules did." in reply.raw, fault
    assert time.monotonic() - began < 15, fault


async def done_after(scene: Scene, scripted_model: ScriptedModel, fault: str, why: str) -> None:
    """Check the reply to a post that the rules read too."""
    post = await scene.post("alice", PLAIN)
    reply = await scene.final(post)
    assert reply.card.state == "done", (fault, reply.raw)
    assert f"`clever` did not read this post ({why}); my rules did." in reply.raw, fault
    assert f"No model has reviewed this command ({why})" in reply.raw, fault
    assert scripted_model.prompts("screen") == [], "who did not read is not asked again"
    kept = record(scene, post)
    assert (kept["mind"], kept["fallback"]) == ("rules", kept["models"][-1]["failed"]), fault


async def test_whatever_a_model_does_the_rules_read_and_the_reply_says_so(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    async with scene.agent(mind=scripted_model.mind(scene.folder, timeout_s=3.0, total_s=20.0, retries=0)):
        for fault, (answer, why) in FAULTS.items():
            scripted_model.extraction = scripted_model.review = answer
            await assert_rules_replaced(scene, scripted_model, fault, why)
            if fault in ("500", "malformed JSON"):
                await done_after(scene, scripted_model, fault, why)


async def test_when_nothing_answers_there_the_rules_read_and_the_reply_says_so(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    async with scene.agent(mind=scripted_model.mind(scene.folder, base_url="http://127.0.0.1:9/v1")):
        await assert_rules_replaced(scene, scripted_model, "connection refused", "it cannot be reached")
        await done_after(scene, scripted_model, "connection refused", "it cannot be reached")


# ---------------------------------------------------------------------- stops
@pytest.mark.parametrize("what", ["read", "screen"])
async def test_laws_13_14_and_15_a_stop_does_not_wait_for_a_model_and_ends_what_it_thinks_about(
    scene: Scene, scripted_model: ScriptedModel, what: str
) -> None:
    scripted_model.extraction = FREE_READ
    if what == "read":
        scripted_model.extraction = lambda handler: handler.hang()
    else:
        scripted_model.review = lambda handler: handler.hang()
    stood = await place(scene.driver)
    async with scene.agent(mind=scripted_model.mind(scene.folder, timeout_s=60, total_s=60)):
        post = await scene.post("alice", FREE)
        await scene.until(lambda: scripted_model.prompts(what))
        began = time.monotonic()
        stop = await scene.post("bob", "stop", post.topic_id)
        answer = await scene.until(lambda: scene.replies(stop))
        ended = await scene.final(post)
        took_s = time.monotonic() - began
        scripted_model.extraction, scripted_model.review = FREE_READ, FINE
        assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)
        later = await scene.final(await scene.post("alice", FREE))
    assert took_s < 10
    assert "standing still" in answer[0].raw
    assert ended.card.state == "cancelled"
    assert later.card.state == "done", "a later post moves it"


async def test_law_15_a_stop_in_the_model_s_time_ends_the_command_that_moves(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    async with scene.agent(mind=scripted_model.mind(scene.folder, timeout_s=60, total_s=60)):
        scripted_model.extraction = move("meander forward 5 m", 5)
        moving = await scene.post("alice", f"@{ROBOT} be a darling and meander forward 5 m")
        await scene.state(moving, "running")
        scripted_model.extraction = lambda handler: handler.hang()
        waiting = await scene.post("alice", FREE)
        await scene.until(lambda: len(scripted_model.prompts("read")) == 2)
        await scene.post("bob", f"@{ROBOT} stop")
        states = [(await scene.final(post)).card.state for post in (moving, waiting)]
    assert states == ["stopped", "cancelled"]


async def test_an_agent_that_is_ended_while_a_model_thinks_ends_soon(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    scripted_model.extraction = lambda handler: handler.hang()
    async with scene.agent(mind=scripted_model.mind(scene.folder, timeout_s=60, total_s=60)):
        await scene.post("alice", FREE)
        await scene.until(lambda: scripted_model.prompts("read"))
        began = time.monotonic()
    assert time.monotonic() - began < 10


# ---------------------------------------------------------------------- screening
@pytest.mark.parametrize(
    ("text", "words", "sentence"),
    [
        (
            f"@{ROBOT} walk forward 1 m so that my friend is happy",
            "so that my friend is happy",
            "objects to the words `so that my friend is happy`: somebody may be hurt, frightened or hindered.",
        ),
        (f"@{ROBOT} 向前走1米", "", "负责检查命令的模型表示反对：可能会伤到、吓到或妨碍别人。"),
    ],
)
async def test_law_7_a_model_adds_a_refusal(
    scene: Scene, scripted_model: ScriptedModel, text: str, words: str, sentence: str
) -> None:
    scripted_model.extraction = move(text.removeprefix(f"@{ROBOT} ").split(" so ")[0], 1)
    scripted_model.review = {
        "decision": "refuse",
        "harm": "people",
        "words": words,
        "why": "Visit http://evil.example @bob",
    }
    stood = await place(scene.driver)
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        post = await scene.post("alice", text)
        reply = await scene.final(post)
    assert reply.card.state == "refused", reply.raw
    assert sentence in reply.raw
    assert "`model.people`" in reply.raw
    assert "evil" not in reply.raw
    assert record(scene, post)["screened"]["why"] == "Visit http://evil.example @bob"
    assert await place(scene.driver) == pytest.approx(stood, abs=STILL_M)


async def test_law_7_of_two_robots_in_a_post_a_model_sees_only_its_own_part_and_the_scene_of_the_owner(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedModel
) -> None:
    scene = make_scene(driver, tmp_path, scene="A sleeping cat, 2 m ahead.")
    scene.person("humanoid", Role.MEMBER, AccountKind.ROBOT_AGENT)
    scripted_model.extraction = FREE_READ
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        post = await scene.post("alice", f"@humanoid sing merrily 3 times. {FREE}")
        reply = await scene.final(post)
    assert reply.card.state == "done", reply.raw
    assert [kind for kind, _ in scripted_model.asked] == ["read", "screen"]
    assert not any("sing merrily" in reply_text or "humanoid" in reply_text for _, reply_text in scripted_model.asked)
    assert "A sleeping cat, 2 m ahead." in scripted_model.prompts("screen")[0]
    assert "cat" not in scripted_model.prompts("read")[0]


async def test_law_7_what_the_rules_refuse_no_model_is_asked_about(scene: Scene, scripted_model: ScriptedModel) -> None:
    scripted_model.extraction = move("walk forward 50 m", 50)
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 50 m"))
    assert reply.card.state == "refused"
    assert "`limit.step_distance`" in reply.raw
    assert scripted_model.prompts("screen") == []


@pytest.mark.parametrize(("screen", "state"), [("model", "done"), ("required", "asks_back"), ("rules", "done")])
async def test_law_7_when_the_model_that_looks_at_commands_fails(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedModel, screen: str, state: str
) -> None:
    scene = make_scene(driver, tmp_path, screen=screen, mind="clever")
    scripted_model.extraction, scripted_model.review = FREE_READ, raw(500)
    stood = await place(driver)
    async with scene.agent(mind=scripted_model.mind(scene.folder, retries=0)):
        post = await scene.post("alice", FREE)
        reply = await scene.final(post)
    assert reply.card.state == state, reply.raw
    assert ("No model has reviewed this command (its server failed)" in reply.raw) == (screen != "rules")
    assert ("My owner requires a model to review every command" in reply.raw) == (screen == "required")
    if state != "done":
        assert await place(driver) == pytest.approx(stood, abs=STILL_M)
    assert len(scripted_model.prompts("screen")) == (screen != "rules")


async def test_law_2_whose_words_move_nothing_costs_no_tokens(scene: Scene, scripted_model: ScriptedModel) -> None:
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        reply = await scene.final(await scene.post("bob", PLAIN))
        assert (await scene.final(await scene.post("bob", FREE))).card.state == "asks_back"
    assert reply.card.state == "refused"
    assert "`rights.operator`" in reply.raw
    assert scripted_model.asked == []


# ---------------------------------------------------------------------- summaries
async def test_a_model_words_what_was_done_beside_what_was_measured(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedModel
) -> None:
    scene = make_scene(driver, tmp_path, summary=True)
    scripted_model.extraction = {
        "intent": "command",
        "steps": [*FREE_READ["steps"], {"action": "hello", "words": "wave to us"}],
    }
    scripted_model.summary = "I walked forward a bit and then waved."
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        post = await scene.post("alice", f"{FREE} and wave to us")
        reply = await scene.final(post)
    assert reply.card.state == "done", reply.raw
    assert f"{scripted_model.summary} (In the words of `clever`; the figures are below.)" in reply.raw
    assert "| 1 | walk forward 1 m |" in reply.raw
    assert "3 questions, 300 + 60 tokens" in reply.raw
    (reply_text,) = scripted_model.prompts("summary")
    assert "darling" not in reply_text
    assert '"did": "walk forward", "measured": "' in reply_text
    assert record(scene, post)["summary"]["text"] == scripted_model.summary


@pytest.mark.parametrize(
    ("says", "failed"),
    [
        ("I walked forward 5 m as you wished.", "unfounded"),
        (raw(500), "server"),
    ],
)
async def test_law_18_a_model_that_lies_or_is_down_leaves_the_structured_report(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedModel, says: Any, failed: str
) -> None:
    scene = make_scene(driver, tmp_path, summary=True)
    scripted_model.extraction, scripted_model.summary = FREE_READ, says
    async with scene.agent(mind=scripted_model.mind(scene.folder, retries=0)):
        post = await scene.post("alice", FREE)
        reply = await scene.final(post)
    assert reply.card.state == "done"
    assert "In the words of" not in reply.raw
    assert "5 m" not in reply.raw
    assert "| 1 | walk forward 1 m |" in reply.raw
    assert record(scene, post)["summary"]["failed"] == failed


async def test_law_18_a_model_that_claims_success_is_not_asked_about_what_was_not_done(
    driver: Driver, tmp_path: Path, scripted_model: ScriptedModel
) -> None:
    scene = make_scene(driver, tmp_path, summary=True)
    scripted_model.extraction = move("meander forward 5 m", 5)
    scripted_model.summary = "I have walked forward 5 m, all is well."
    async with scene.agent(mind=scripted_model.mind(scene.folder)):
        post = await scene.post("alice", f"@{ROBOT} be a darling and meander forward 5 m")
        await scene.state(post, "running")
        await scene.post("bob", f"@{ROBOT} stop")
        reply = await scene.final(post)
    assert reply.card.state == "stopped"
    assert "all is well" not in reply.raw
    assert scripted_model.prompts("summary") == []


async def test_a_mind_is_made_ready_at_the_start_and_closed_at_the_end(
    scene: Scene, scripted_model: ScriptedModel
) -> None:
    mind = scripted_model.mind(scene.folder)
    seen: list[str] = []

    class RecordingMind(type(mind)):  # type: ignore[misc]
        async def prepare(self) -> None:
            seen.append("prepared")
            await super().prepare()

        async def close(self) -> None:
            seen.append("closed")
            await super().close()

    async with scene.agent(mind=RecordingMind(mind.model)):
        await until(lambda: seen)
    assert seen == ["prepared", "closed"]


#: A third party's mind returns this, and a forum must not interpret it.
_HOSTILE_WORDS = (
    "# Loud\n\n@everyone ＠admin @\u200beveryone <b>bold</b> <img src=x> ![x](http://evil.example/x.png) "
    "[click](https://evil.example) [ref]: http://evil.example www.evil.example &#64;all\n```\ncode\n```\n> quoted\n"
    "[quote]x[/quote] \u202e93\u202c " + "x" * 5_000
)


@pytest.mark.parametrize("intent", [Intent.QUESTION, Intent.ASK_BACK])
async def test_law_3_what_a_mind_of_somebody_else_says_is_disarmed_in_the_reply(scene: Scene, intent: Intent) -> None:
    class ForeignMind(RulesMind):
        async def understand(self, text: str, addressee: Addressee, history: Sequence[Plan] = ()) -> Understanding:
            return Understanding(intent, "en", question=_HOSTILE_WORDS)

    async with scene.agent(mind=ForeignMind()):
        reply_text = (await scene.final(await scene.post("alice", "@quadruped who are you?"))).raw
    said = reply_text.partition("trace ")[0]
    for live in ("@everyone", "＠admin", "@admin", "<b>", "![", "](", "]: ", "://", "www.e", "&#", "```", "[quote]"):
        assert live not in said, live
    assert not set(said) & set("\u200b\u202e\u202c")
    assert len(said) < 1_000
    page = render(said, lambda _: True)
    assert not any(tag in page for tag in ("<a ", "<img", "<h3", "<b>", "<blockquote", "<pre", "mention"))
