"""From the configuration to the thread: board, agent, robot, and a double of both providers' APIs over HTTP."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.config.forum import ForumConfig
from agentrob.config.load import Config
from agentrob.config.load import parse as parse_config
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.wiring import app
from tests.agent.agent_process import Poster, RunningBoard
from tests.agent.agent_scene import ROBOT, Driver, robot_settings, serving
from tests.board.running_board import running_board
from tests.minds.model_double import Double, model_double
from tests.minds.scripted_model import FINE, move

pytestmark = pytest.mark.usefixtures("model_libraries")

USAGE = {"prompt_tokens": 30, "completion_tokens": 9, "input_tokens": 30, "output_tokens": 9}
HARM = {"decision": "refuse", "harm": "surveillance", "words": "with neighbours sunbathing"}
WORDS = "Off I went, forward."


def fixture(system: str, post: str, response: dict[str, Any]) -> dict[str, Any]:
    """Return the double's answer to one kind of question about a post with these words."""
    return {"match": {"systemMessage": system, "userMessage": post}, "response": {**response, "usage": USAGE}}


def answer(value: dict[str, Any]) -> dict[str, Any]:
    return {"toolCalls": [{"name": "answer", "arguments": value}]}


FIXTURES = [
    fixture("Looking at a command", "neighbour", answer(HARM)),
    fixture("Looking at a command", "amble", answer(FINE)),
    fixture("Wording a robot", "walk forward", {"content": WORDS}),
    fixture("Reading posts", "amble forward 1 m", answer(move("amble forward 1 m", 1))),
]


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as made:
        yield made


@pytest.fixture(scope="module")
def double(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Double]:
    with model_double(tmp_path_factory.mktemp("double"), FIXTURES) as running:
        yield running


def configured(double: Double, dialect: str, folder: Path) -> Config:
    robot = robot_settings().model_dump(mode="json")
    return parse_config(
        {
            "data": str(folder),
            "robots": {ROBOT: {**robot, "mind": "clever", "summary": True}},
            "minds": {
                "clever": {
                    "provider": dialect,
                    "model": "gpt-5-mini" if dialect == "openai" else "claude-haiku-5-5",
                    "base_url": double.url + ("/v1" if dialect == "openai" else ""),
                    "key_env": "TEST_KEY",
                }
            },
        }
    )


async def thread(board: RunningBoard, topic: str) -> str:
    with_token = board.client("op")
    items = (await asyncio.to_thread(with_token.get, f"/topics/{topic}/posts")).json()["items"]
    return "\n".join(item["raw"] for item in items[1:])


@pytest.mark.parametrize("dialect", ["openai", "anthropic"])
async def test_a_configured_model_reads_looks_and_words_on_the_board(
    board: RunningBoard,
    double: Double,
    driver: Driver,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    dialect: str,
) -> None:
    monkeypatch.setenv("TEST_KEY", "sk-test-0123456789")
    config = configured(double, dialect, tmp_path)
    settings = config.robot(ROBOT)
    forum = BoardForum(ForumConfig(url=board.url), board.tokens[ROBOT])
    mind = app.make_mind(settings.mind, config)
    agent = RobotAgent(ROBOT, settings, forum, driver.client(), mind, tmp_path)
    async with serving(agent):
        with Poster(board, "op") as op:
            topic = await op.post(f"@{ROBOT} pray amble forward 1 m, dear")
            assert await op.final(topic) == ["done"], await thread(board, topic)
            said = await thread(board, topic)
            assert f"{WORDS} (In the words of `clever`; the figures are below.)" in said
            assert "| 1 | walk forward 1 m |" in said
            assert "3 questions, 90 + 27 tokens" in said
            topic = await op.post(f"@{ROBOT} pray amble forward 1 m with neighbours sunbathing")
            assert await op.final(topic) == ["refused"], await thread(board, topic)
            said = await thread(board, topic)
            assert "objects to the words `with neighbours sunbathing`: somebody is to be watched or followed." in said
            assert "`model.surveillance`" in said
