"""Minds end to end against the HTTP double of both APIs: extraction, a tool loop with images, a summary."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, ConfigDict, Field

from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.chat import Image, Message, Tool, ToolResult, UserMessage
from agentrob.minds.llm.fallback import FallbackModel
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.minds.protocol import Addressee
from agentrob.model import Capabilities, Direction, Intent, Op, Plan, Primitive
from tests.minds.model_double import Double

Make = Callable[..., ConfiguredModel]
Start = Callable[[list[dict[str, Any]]], Double]
LISTENER = Addressee(("quadruped",), ("humanoid",), Capabilities("go2", frozenset(Op)))
DIALECTS = [("openai", "/v1"), ("ark", "/v1"), ("compatible", "/v1"), ("anthropic", ""), ("anthropic", "/v1")]


class Walk(BaseModel):
    model_config = ConfigDict(extra="forbid")
    distance_m: Annotated[float, Field(gt=0, le=5)]


class Look(BaseModel):
    model_config = ConfigDict(extra="forbid")


TOOLS = [Tool("act_move", "Walks forward.", Walk), Tool("get_front_image", "Takes a picture.", Look)]


def wants(match: str, *steps: dict[str, Any]) -> dict[str, Any]:
    """Return a fixture: the double answers a post with these words with this extraction."""
    answer = {"intent": "command", "steps": list(steps)}
    usage = {"prompt_tokens": 30, "completion_tokens": 9, "input_tokens": 30, "output_tokens": 9}
    call = {"name": "answer", "arguments": answer}
    return {"match": {"userMessage": match}, "response": {"toolCalls": [call], "usage": usage}}


@pytest.mark.parametrize(("provider", "path"), DIALECTS)
async def test_a_post_in_free_words_becomes_a_plan(double: Start, make: Make, provider: str, path: str) -> None:
    post = "@quadruped would you kindly amble backwards by half a metre and, after that, snap a picture"
    steps = [
        {
            "action": "move",
            "direction": "backward",
            "amount": 0.5,
            "unit": "m",
            "words": "amble backwards by half a metre",
        },
        {"action": "get_front_image", "words": "snap a picture"},
    ]
    running = double([wants("amble backwards", *steps)])
    mind = ModelMind(FallbackModel([make(running.url + path, provider=provider)]))
    reading = await mind.read(post, LISTENER)
    assert reading.understanding.intent is Intent.COMMAND
    assert reading.understanding.plan == Plan(
        (Primitive(Op.MOVE, Direction.BACKWARD, distance_m=0.5), Primitive(Op.GET_FRONT_IMAGE))
    )
    assert (reading.mind, reading.fallback) == ("clever", "")
    (usage,) = reading.usage
    assert (usage.input_tokens, usage.output_tokens) == (30, 9)
    await mind.close()


@pytest.mark.parametrize(("provider", "path"), DIALECTS)
async def test_a_tool_loop_with_images(double: Start, make: Make, provider: str, path: str) -> None:
    running = double(
        [
            {
                "match": {"toolResultContains": "measured 1.4", "turnIndex": 2},
                "response": {"content": "Beside it stands a box."},
            },
            {
                "match": {"userMessage": "red ball", "hasToolResult": False, "turnIndex": 0},
                "response": {"toolCalls": [{"name": "get_front_image", "arguments": {}}]},
            },
            {
                "match": {"userMessage": "Image of get_front_image", "turnIndex": 1},
                "response": {"toolCalls": [{"name": "act_move", "arguments": {"distance_m": 1.5}}]},
            },
        ]
    )
    model = make(running.url + path, provider=provider)
    talk: list[Message] = [UserMessage("Find the red ball.", (Image(b"\xff\xd8\xff"),))]
    seen: list[Any] = []
    for _ in range(5):
        answer = await model.turn("You drive a robot.", talk, TOOLS)
        talk.append(answer.value)
        if not answer.value.calls:
            break
        (call,) = answer.value.calls
        seen.append(call.arguments)
        picture = (Image(b"\xff\xd8\xfe"),) if call.name == "get_front_image" else ()
        talk.append(ToolResult(call, "measured 1.4 m" if call.name == "act_move" else "taken", picture))
    assert seen == [Look(), Walk(distance_m=1.5)]
    assert answer.value.text == "Beside it stands a box."
    await model.close()


@pytest.mark.parametrize(("provider", "path"), DIALECTS)
async def test_a_summary(double: Start, make: Make, provider: str, path: str) -> None:
    running = double([{"match": {"userMessage": "walked 2"}, "response": {"content": "It walked 2.0 m."}}])
    model = make(running.url + path, provider=provider)
    assert (await model.chat("Summarise.", "walked 2.0 m")).value == "It walked 2.0 m."
    (entry,) = running.journal()
    assert "tools" not in entry["body"]
    await model.close()


async def test_the_model_gets_its_part_of_the_post_as_data_and_the_history_as_plans(double: Start, make: Make) -> None:
    step = {
        "action": "move",
        "direction": "forward",
        "amount": 1,
        "unit": "m",
        "slow": True,
        "words": "same again but slower this time",
    }
    running = double([wants("but slower", step)])
    mind = ModelMind(FallbackModel([make(running.url + "/v1")]))
    history = [Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),))]
    reading = await mind.read("@humanoid secret words @quadruped same again but slower this time", LISTENER, history)
    assert reading.understanding.plan.steps == (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0, speed_mps=0.2),)
    (entry,) = running.journal()
    system, user = entry["body"]["messages"]
    assert "quadruped robot" in system["content"]
    assert "same again but slower this time" not in system["content"]
    assert "secret words" not in json.dumps(entry["body"])
    assert '[[{"action": "move", "direction": "forward", "distance_m": 1.0}]]' in user["content"]
    await mind.close()


async def test_invented_content_is_asked_back_and_not_executed(double: Start, make: Make) -> None:
    step = {"action": "move", "direction": "forward", "amount": 50, "unit": "m", "words": "amble forward 50 cm"}
    running = double([wants("amble", step)])
    mind = ModelMind(FallbackModel([make(running.url + "/v1")]))
    understood = await mind.understand("@quadruped pray amble forward 50 cm dear", LISTENER)
    assert understood.intent is Intent.ASK_BACK
    assert "I understood: walk forward 50 m." in understood.question
    await mind.close()
