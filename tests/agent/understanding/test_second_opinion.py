"""The second opinion through the agent: it makes the robot ask back; if it fails, the rules decide, logged once."""

from __future__ import annotations

import asyncio
import threading
import time
from pathlib import Path

import pytest
from structlog.testing import capture_logs

from agentrob.agent.understanding.second_opinion import Classify, SecondOpinion
from agentrob.semantic.encoder import EncoderError
from tests.agent.agent_scene import ROBOT, Driver, make_scene


def fails(_text: str, _language: str) -> bool:
    raise EncoderError("its process has ended")


def breaks(_text: str, _language: str) -> bool:
    raise ValueError("a defect")


def warnings(logs: list[dict[str, str]]) -> list[dict[str, str]]:
    return [line for line in logs if "harm classifier" in line["event"] and line["log_level"] == "warning"]


@pytest.mark.parametrize(
    ("classify", "state"),
    [(lambda text, _: "walk" in text, "asks_back"), (lambda *_: False, "done"), (fails, "done"), (breaks, "done")],
)
async def test_law_7_what_is_suspected_is_asked_back(
    driver: Driver, tmp_path: Path, classify: Classify, state: str
) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent(opinion=SecondOpinion(classify)), asyncio.timeout(60):
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} please walk 1 m ahead"))
    assert reply.card is not None
    assert reply.card.state == state
    assert ("might be dangerous" in reply.raw) is (state == "asks_back")


async def test_what_the_robot_offers_instead_is_done_without_another_opinion(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path)
    async with scene.agent(opinion=SecondOpinion(lambda *_: True)), asyncio.timeout(60):
        asked = await scene.final(await scene.post("alice", f"@{ROBOT} please walk 1 m ahead"))
        offered = asked.raw.split("post `")[1].split("`")[0]
        done = await scene.final(await scene.post("alice", f"@{ROBOT} {offered}"))
    assert done.card is not None
    assert done.card.state == "done"


async def test_only_the_words_for_the_robot_are_judged_and_the_model_is_loaded_before_the_first_post(
    driver: Driver, tmp_path: Path
) -> None:
    heard: list[tuple[str, str]] = []
    loaded = threading.Event()

    def listens(text: str, language: str) -> bool:
        loaded.set()
        return bool(heard.append((text.strip(), language)))

    scene = make_scene(driver, tmp_path)
    async with scene.agent(opinion=SecondOpinion(listens)), asyncio.timeout(60):
        assert await asyncio.to_thread(loaded.wait, 30)
        del heard[:]
        await scene.final(await scene.post("alice", f"@{ROBOT} please walk 1 m ahead"))
    assert heard == [("please walk 1 m ahead", "en")]


async def test_a_failure_is_logged_once_and_so_is_its_end() -> None:
    answers = iter([fails, fails, lambda *_: True, fails])

    def answer(text: str, language: str) -> bool:
        return next(answers)(text, language)

    opinion = SecondOpinion(answer)
    with capture_logs() as logs:
        assert [await opinion.suspects("x", "en") for _ in range(4)] == [None, None, True, None]
    assert len(warnings(logs)) == 2
    assert [line["log_level"] for line in logs] == ["warning", "info", "warning"]
    opinion.close()
    assert await opinion.suspects("x", "en") is None


async def test_a_classifier_that_takes_long_delays_one_command_only_and_its_loading_is_waited_for() -> None:
    go_on = threading.Event()

    def waits(text: str, _language: str) -> bool:
        return text != "quick" and go_on.wait(30)

    opinion = SecondOpinion(waits, go_on.set, limit_s=0.2, load_s=20)
    begun_s = time.monotonic()
    assert await opinion.suspects("slow", "en") is None
    assert await opinion.suspects("quick", "en") is None
    assert time.monotonic() - begun_s < 10
    go_on.set()
    late = opinion._late
    assert late is not None
    await asyncio.wrap_future(late)
    assert await opinion.suspects("quick", "en") is False
    go_on.clear()
    warming = asyncio.create_task(opinion.warm())
    await asyncio.sleep(0)
    first = asyncio.create_task(opinion.suspects("quick", "en"))
    await asyncio.sleep(0.5)  # longer than its limit
    go_on.set()
    assert await first is False
    await warming
    opinion.close()
