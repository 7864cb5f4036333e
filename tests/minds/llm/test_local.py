"""A slow, self-hosted model: its timeouts are respected, and it is called rarely and never unnecessarily."""

from __future__ import annotations

import asyncio
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config.load import parse
from agentrob.config.minds import MindConfig
from agentrob.errors import ConfigError
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.chat import Image, UserMessage
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.protocol import Addressee
from agentrob.minds.safety_review import review_command
from agentrob.model import Capabilities, Direction, Intent, Op, Plan, Primitive
from tests.minds.faulty_server import called
from tests.minds.scripted_model import ScriptedModel, move, running_scripted_model

pytestmark = pytest.mark.usefixtures("model_libraries")

GO2 = Capabilities("go2", frozenset(Op))
LISTENER = Addressee(("robot",), (), GO2)
PLAN = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),))
FREE, FREE_READ = "be a darling and meander forward 1 m", move("meander forward 1 m", 1)
TABLE = {"provider": "compatible", "model": "m", "base_url": "http://127.0.0.1:9/v1"}


@pytest.fixture
def scripted_model() -> Iterator[ScriptedModel]:
    with running_scripted_model() as made:
        yield made


def events(*chunks: dict[str, Any]) -> bytes:
    return b"".join(b"data: " + json.dumps(chunk).encode() + b"\n\n" for chunk in chunks)


def chunk(delta: dict[str, Any], finish: str | None = None) -> dict[str, Any]:
    choice = {"index": 0, "delta": delta, "finish_reason": finish}
    return {"id": "c", "object": "chat.completion.chunk", "created": 0, "model": "served", "choices": [choice]}


def begin_stream(handler: Any) -> None:
    handler.send_response(200)
    handler.send_header("content-type", "text/event-stream")
    handler.send_header("connection", "close")
    handler.end_headers()


def streamed(value: dict[str, Any]) -> Any:
    """Return a fault that streams a tool call."""
    (call,) = called("answer", value)["choices"][0]["message"]["tool_calls"]

    def answer(handler: Any) -> None:
        begin_stream(handler)
        delta = {"role": "assistant", "tool_calls": [{"index": 0, **call}]}
        handler.wfile.write(events(chunk(delta), chunk({}, "tool_calls")) + b"data: [DONE]\n\n")

    return answer


def test_a_local_mind_has_its_own_timeouts_and_keeps_configured_ones() -> None:
    local = MindConfig.model_validate({**TABLE, "kind": "local"})
    assert (local.timeout_s, local.total_s, local.concurrency) == (60, 120, 1)
    slower = MindConfig.model_validate({**TABLE, "kind": "local", "timeout_s": 90})
    assert (slower.timeout_s, slower.total_s) == (90, 120)
    hosted = MindConfig.model_validate(TABLE)
    assert (hosted.timeout_s, hosted.total_s) == (15, 25)


def test_a_configured_timeout_is_respected_and_a_chain_that_is_too_slow_is_refused(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    assert scripted_model.mind(tmp_path, total_s=200.0).limit_s == 200.0
    minds = {"one": {**TABLE, "total_s": 200, "fallbacks": ["two"]}, "two": {**TABLE, "total_s": 200}}
    with pytest.raises(ConfigError, match=r"total_s of minds.one and its fallbacks .* 400 s; valid: at most 300 s"):
        parse({"minds": minds})


async def test_the_rules_come_first_and_a_model_reads_what_they_ask_back(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    scripted_model.extraction = FREE_READ
    mind = ModelMind(scripted_model.model(tmp_path), rules_first=True)
    plain = await mind.read("@robot walk forward 1 m", LISTENER)
    assert (plain.mind, plain.understanding.plan.steps) == ("rules", PLAN.steps)
    assert scripted_model.asked == []
    free = await mind.read(f"@robot {FREE}", LISTENER)
    assert (free.mind, free.understanding.intent) == ("clever", Intent.COMMAND)
    assert len(scripted_model.asked) == 1
    await mind.close()


async def test_requests_to_a_local_server_share_one_prompt_that_is_preloaded(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    model = scripted_model.model(tmp_path, kind="local")
    mind = ModelMind(model)
    scripted_model.server.answer = lambda handler, _: streamed(FREE_READ)(handler)
    await mind.warm(GO2)
    reading = await mind.read(f"@robot {FREE}", LISTENER)
    scripted_model.server.answer = lambda handler, _: streamed({"decision": "fine"})(handler)
    screened = await review_command(model, FREE, PLAN, GO2, "en")
    await mind.close()
    assert reading.understanding.intent is Intent.COMMAND
    assert (screened.refusal, screened.failed) == (None, "")
    told = [[message["content"] for message in body["messages"]] for body in scripted_model.server.requests]
    assert len({system for system, *_ in told}) == 1, "one prefix, which the server keeps"
    assert [said.splitlines()[0] for _, said in told[1:]] == [
        "Task: Reading posts",
        "Task: Looking at a command before a robot does it",
    ]
    assert all(body["stream"] for body in scripted_model.server.requests)


async def test_a_hosted_model_is_not_warmed_up(scripted_model: ScriptedModel, tmp_path: Path) -> None:
    mind = scripted_model.mind(tmp_path)
    await mind.warm(GO2)
    await mind.close()
    assert scripted_model.server.requests == []


async def test_a_timed_out_request_is_disconnected_and_not_repeated(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    hung_up = threading.Event()

    def never_ends(handler: Any, _: Any) -> None:
        begin_stream(handler)
        try:
            while not scripted_model.server.released.wait(0.05):
                handler.wfile.write(events(chunk({"content": "hm "})))
                handler.wfile.flush()
        except OSError:
            hung_up.set()

    scripted_model.server.answer = never_ends
    model = scripted_model.model(tmp_path, kind="local", timeout_s=1.0, total_s=10.0, retries=3)
    with pytest.raises(ModelError) as fault:
        await model.chat("You are slow.", "Count to a million.")
    await model.close()
    assert fault.value.kind == "timeout"
    assert await asyncio.to_thread(hung_up.wait, 10)
    assert len(scripted_model.server.requests) == 1


async def test_a_server_that_fails_on_a_picture_is_not_asked_again_with_one(
    scripted_model: ScriptedModel, tmp_path: Path
) -> None:
    scripted_model.server.answer = lambda handler, _: handler.send(500, b"{}")
    model = scripted_model.model(tmp_path, retries=3)
    for _ in range(2):
        with pytest.raises(ModelError, match="picture") as fault:
            await model.turn("You see.", [UserMessage("What is this?", (Image(b"\xff\xd8"),))], [])
        assert fault.value.kind == "rejected"
    await model.close()
    assert len(scripted_model.server.requests) == 1
