"""Every operation can be requested by a post in both languages, and the reply and all pages name it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from agentrob.agent.reporting.report import doing
from agentrob.board.robots.view import op_in_words
from agentrob.language.messages.catalog import can_say
from agentrob.language.messages.plan_text import step_sentence
from agentrob.language.registry import known as languages
from agentrob.minds.visual_loop.tools import tools_of
from agentrob.model import BUILT_IN, Capabilities, Direction, Language, Mandate, Op, Primitive
from agentrob.model.estimate import step_seconds
from agentrob.model.operations.built_in import LONGEST_S
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.unitree.g1 import CAPABILITIES as G1
from agentrob.robots.unitree.go2 import CAPABILITIES as GO2
from tests.agent.agent_scene import ROBOT, Driver, make_scene

LANGUAGES: list[Language] = ["en", "zh"]
_AMOUNTS = {
    Op.MOVE: {"direction": Direction.FORWARD, "distance_m": 0.2},
    Op.TURN: {"direction": Direction.LEFT, "degrees": 20.0},
}
STEPS = [Primitive(op, **_AMOUNTS.get(op, {})) for op in Op]  # type: ignore[arg-type]
#: An operation that a third party's robot may have; nothing in the agent knows its name.
FOREIGN = Primitive("wag_tail")  # type: ignore[arg-type]


@pytest.mark.parametrize("robot", [None, GO2, G1], ids=["fake", "go2", "g1"])
async def test_every_operation_of_every_robot_is_answered_in_both_languages(
    robot: Capabilities | None, driver: Driver, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    everything = DriverClient.capabilities

    async def narrowed(driver: DriverClient) -> Capabilities:  # the fake robot supports this one
        return (
            replace(await everything(driver), model=robot.model, ops=robot.ops) if robot else await everything(driver)
        )

    monkeypatch.setattr(DriverClient, "capabilities", narrowed)
    ops = robot.ops if robot else frozenset(Op)
    scene = make_scene(driver, tmp_path)
    async with scene.agent():
        for language in LANGUAGES:
            for step in STEPS:
                reply = await scene.final(await scene.post("alice", f"@{ROBOT} {step_sentence(step, language)}"))
                assert reply.card is not None
                assert "internal error" not in reply.raw
                instead = Primitive(Op.HELLO) if step.op is Op.SHAKE and step.op not in ops else step
                if instead.op in ops:
                    assert (step.op, reply.card.state) == (step.op, "done")
                    assert f"| 1 | {doing(instead, language)} |" in reply.raw
                else:
                    assert (step.op, reply.card.state) == (step.op, "refused")


@pytest.mark.parametrize("op", Op)
def test_every_operation_has_its_own_sentence_wherever_operations_are_reported(op: Op) -> None:
    assert can_say(f"label.{op}")
    for language in LANGUAGES:
        assert f"step.{op}" in languages()[language].sentences
    assert BUILT_IN[op].name == op
    mandate = Mandate({op: 1}, distance_m=1.0, degrees=90.0, steps=1)
    tool, _ = tools_of(mandate, Capabilities("all", frozenset(Op)))
    assert tool.description
    assert "_" not in op_in_words(op)


@pytest.mark.parametrize("language", LANGUAGES)
def test_an_operation_that_nobody_here_knows_is_reported_by_its_name(language: Language) -> None:
    assert doing(FOREIGN, language) == "wag tail"
    assert step_sentence(FOREIGN, language) == "wag tail"
    assert op_in_words("wag_tail") == "wag tail"
    assert step_seconds(FOREIGN, GO2) == LONGEST_S
