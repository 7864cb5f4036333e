"""The second opinion through the agent: it makes the robot ask, and where it fails the rules decide."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

import pytest

from agentrob.semantic.encoder import EncoderError
from tests.agent.agent_scene import ROBOT, Driver, make_scene


def fails(_: str) -> bool:
    raise EncoderError("its process has ended")


@pytest.mark.parametrize(
    ("suspects", "state"), [(lambda text: "walk" in text, "asks_back"), (lambda _: False, "done"), (fails, "done")]
)
async def test_law_7_what_is_suspected_is_asked_back(
    driver: Driver, tmp_path: Path, suspects: Callable[[str], bool], state: str
) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent(suspects=suspects), asyncio.timeout(60):
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 1 m"))
    assert reply.card is not None
    assert reply.card.state == state
    assert ("might be dangerous" in reply.raw) is (state == "asks_back")


async def test_only_the_words_for_the_robot_are_judged(driver: Driver, tmp_path: Path) -> None:
    heard: list[str] = []
    scene = make_scene(driver, tmp_path)
    async with scene.agent(suspects=lambda text: bool(heard.append(text))), asyncio.timeout(60):
        await scene.final(await scene.post("alice", f"@{ROBOT} walk forward 1 m"))
    assert [text.strip() for text in heard] == ["walk forward 1 m"]
