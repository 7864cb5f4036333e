"""A chain of fallbacks: a failing mind is skipped and named, and the rules are the last resort."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from agentrob.config.load import parse
from agentrob.config.minds import MindConfig
from agentrob.errors import ConfigError
from agentrob.minds.extraction.mind import ModelMind
from agentrob.minds.llm.errors import ModelError
from agentrob.minds.llm.fallback import FallbackModel, model_with_fallbacks
from agentrob.minds.llm.model import ConfiguredModel
from agentrob.minds.protocol import Addressee, read
from agentrob.minds.rules import RulesMind
from agentrob.model import Capabilities, Direction, Intent, Op, Primitive
from agentrob.wiring import app
from tests.minds.faulty_server import FaultyServer, called, said

Make = Callable[..., ConfiguredModel]
LISTENER = Addressee(("quadruped",), (), Capabilities("go2", frozenset(Op)))


async def test_the_next_mind_answers_and_the_failed_one_is_named(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, body: (
        handler.send(401, b"{}") if body["model"] == "first" else handler.send(200, json.dumps(said("Here.")).encode())
    )
    url = server.url + "/v1"
    chain = FallbackModel([make(url, "one", model="first"), make(url, "two", model="second")])
    answer = await chain.chat("", "Hello")
    assert (answer.value, answer.mind) == ("Here.", "two")
    assert [(u.mind, u.failed) for u in answer.usage] == [("one", "denied"), ("two", "")]
    await chain.close()


async def test_unusable_output_falls_back_too(server: FaultyServer, make: Make) -> None:
    step = {"action": "move", "direction": "forward", "amount": 1, "unit": "m", "words": "stroll ahead 1 m"}
    wants = {"intent": "command", "steps": [step]}
    server.answer = lambda handler, body: handler.send(
        200, json.dumps(called("answer", wants if body["model"] == "good" else {"intent": "dance"})).encode()
    )
    url = server.url + "/v1"
    mind = ModelMind(FallbackModel([make(url, "weak", model="bad"), make(url, "strong", model="good")]))
    reading = await read(mind, "@quadruped stroll ahead 1 m", LISTENER)
    assert reading.mind == "strong"
    assert reading.fallback == "malformed"
    assert reading.understanding.plan.steps == (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),)
    assert [u.mind for u in reading.usage] == ["weak", "weak", "strong"]
    await mind.close()


async def test_when_no_model_answers_the_rules_do_and_the_reply_says_so(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.send(503, b"{}")
    url = server.url + "/v1"
    mind = ModelMind(FallbackModel([make(url, "one", retries=0), make(url, "two", retries=0)]))
    reading = await read(mind, "@quadruped walk forward 2 m", LISTENER)
    assert (reading.mind, reading.fallback) == ("rules", "server")
    assert reading.understanding == await RulesMind().understand("@quadruped walk forward 2 m", LISTENER)
    assert [(u.mind, u.failed) for u in reading.usage] == [("one", "server"), ("two", "server")]
    await mind.close()


async def test_the_rules_answer_in_time_however_slow_the_models_are(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.hang()
    mind = ModelMind(
        FallbackModel([make(server.url + "/v1", n, timeout_s=60, total_s=60) for n in ("one", "two")]), 0.5
    )
    reading = await read(mind, "@quadruped walk forward 2 m", LISTENER)
    assert (reading.mind, reading.fallback) == ("rules", "timeout")
    assert reading.understanding.intent is Intent.COMMAND
    await mind.close()


async def test_preparing_sends_no_request_and_never_fails(server: FaultyServer, make: Make) -> None:
    mind = ModelMind(FallbackModel([make(server.url + "/v1"), make(server.url, "keyless", key_env="NO_SUCH_VARIABLE")]))
    await mind.prepare()
    assert server.requests == []
    await mind.close()


async def test_a_failed_chain_reports_its_whole_usage(server: FaultyServer, make: Make) -> None:
    server.answer = lambda handler, _: handler.send(401, b"{}")
    url = server.url + "/v1"
    with pytest.raises(ModelError) as caught:
        await FallbackModel([make(url, "one"), make(url, "two")]).chat("", "Hello")
    assert [u.mind for u in caught.value.usage] == ["one", "two"]


async def test_the_rules_mind_is_called_in_the_same_way() -> None:
    reading = await read(RulesMind(), "@quadruped wave", LISTENER)
    assert (reading.mind, reading.usage, reading.fallback) == ("rules", (), "")
    assert reading.understanding.intent is Intent.COMMAND


async def test_a_chain_is_built_from_the_configuration(tmp_path: Path) -> None:
    def local(*fallbacks: str) -> MindConfig:
        return MindConfig(
            provider="compatible", model="m", base_url="http://127.0.0.1:1/v1", fallbacks=fallbacks, retries=0
        )

    minds = {"one": local("two", "rules"), "two": local("one")}
    with pytest.raises(ModelError) as caught:
        await model_with_fallbacks("one", minds, tmp_path / "x.sqlite").chat("", "Hello")
    assert [(u.mind, u.failed) for u in caught.value.usage] == [("one", "unreachable"), ("two", "unreachable")]


async def test_a_configured_mind_works_on_the_command_line_too(server: FaultyServer, tmp_path: Path, key: str) -> None:
    step = {"action": "move", "direction": "forward", "amount": 1, "unit": "m", "words": "stroll ahead 1 m"}
    wants = {"intent": "command", "steps": [step]}
    server.answer = lambda handler, _: handler.send(200, json.dumps(called("answer", wants)).encode())
    clever = {"provider": "compatible", "model": "m", "base_url": server.url, "key_env": "TEST_KEY"}
    config = parse({"data": str(tmp_path), "minds": {"clever": clever}})
    understood = await app.understand("kindly stroll ahead 1 m", "go2", LISTENER.capabilities, "clever", config)
    assert understood.plan.steps == (Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0),)


def test_a_robot_with_a_required_safety_review_needs_a_model() -> None:
    with pytest.raises(ConfigError, match="needs a mind that is a model"):
        parse({"robots": {"quadruped": {"screen": "required"}}})
    assert parse({"robots": {"quadruped": {"screen": "required", "mind": "clever"}}})
