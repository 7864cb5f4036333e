"""Workers as processes of their own: they drain, and offer metrics."""

from __future__ import annotations

import asyncio
import urllib.request

import pytest
from typer.testing import CliRunner

from agentrob.cli.main import cli
from agentrob.wiring import app
from tests.agent.agent_process import Poster
from tests.agent.agent_scene import ROBOT
from tests.board.running_board import RunningBoard
from tests.host_numbers import free_port
from tests.waiting import until
from tests.worker.worker_processes import LIMIT_S, Workers, until_state


@pytest.mark.parametrize("arguments", [("--all",), (ROBOT,)], ids=["worker", "agent"])
async def test_what_moves_is_finished_and_what_waits_is_left_to_the_next_worker(
    workers: Workers, board: RunningBoard, arguments: tuple[str, ...]
) -> None:
    with Poster(board, "op") as op:
        with workers.running(*arguments) as process:
            moving = await op.post(f"@{ROBOT} walk 2 m")
            await until_state(op, moving, "running")
            waiting = await op.post(f"@{ROBOT} wave")
            await until_state(op, waiting, "queued")
            lines = await asyncio.to_thread(list, app.drain_workers([ROBOT]))
            assert [line.rpartition(": ")[2] for line in lines] == [f"draining; it serves {ROBOT}", "ended"]
            assert await asyncio.to_thread(process.wait, LIMIT_S) == 0
        assert await op.states(moving) == ["done"]
        assert await op.states(waiting) == ["queued"]
        with workers.running(*arguments):
            assert await op.final(waiting) == ["done"]


async def test_a_stop_is_obeyed_while_a_worker_drains(workers: Workers, board: RunningBoard) -> None:
    with workers.running("--all") as process, Poster(board, "op") as op:
        moving = await op.post(f"@{ROBOT} walk 5 m")
        await until_state(op, moving, "running")
        lines = app.drain_workers([])
        assert "draining" in next(lines)
        await op.post(f"@{ROBOT} stop")
        assert "ended" in await asyncio.to_thread(next, lines)
        assert await asyncio.to_thread(process.wait, LIMIT_S) == 0
        assert "stopped" in await op.states(moving)


def test_without_a_worker_it_says_so(workers: Workers) -> None:
    asked = CliRunner().invoke(cli, ["agent", "drain", "rex"])
    assert asked.exit_code == 1
    assert "no worker on this machine serves rex" in str(asked.exception)


@pytest.mark.parametrize("arguments", [("--all",), (ROBOT,)], ids=["worker", "agent"])
async def test_it_offers_metrics_where_it_is_told_to(
    workers: Workers, board: RunningBoard, arguments: tuple[str, ...]
) -> None:
    listen = f"127.0.0.1:{free_port()}"
    with workers.running(*arguments, "--name", "lab-1", "--metrics", listen), Poster(board, "op") as op:
        assert await op.final(await op.post(f"@{ROBOT} wave")) == ["done"]
        counted = f'agentrob_commands_total{{robot="{ROBOT}",status="done"}} 1.0'
        text = await until(lambda: asyncio.to_thread(scrape, listen), lambda text: counted in text, limit_s=LIMIT_S)
        assert "agentrob_robots_served 1.0" in text
        card = (await asyncio.to_thread(board.client("op").get, f"/robots/{ROBOT}")).json()["card"]
        assert card["worker"] == "lab-1"


def scrape(listen: str) -> str:
    with urllib.request.urlopen(f"http://{listen}/metrics", timeout=LIMIT_S) as answer:
        return str(answer.read().decode())
