"""`agentrob agent serve` as in production: board, driver and served agent are separate processes."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.config.load import Config
from agentrob.model import AccountKind, Role
from agentrob.process.child import Child, terminate_all
from agentrob.wiring import app
from tests.agent.agent_scene import WIDE

TOKEN = "the-token-of-the-planner"


@dataclass
class Processes:
    """The running processes, and requests to the service."""

    children: list[Child]
    http: httpx2.Client
    board: httpx2.Client

    def call(self, method: str, path: str, body: Any = None, **headers: str) -> httpx2.Response:
        sent = {"Authorization": f"Bearer {TOKEN}", **headers}
        return self.http.request(method, f"/api/v1/robots/quadruped{path}", json=body, headers=sent)


@pytest.fixture
def processes(tmp_path: Path) -> Iterator[Processes]:
    robot = {
        "model": "fake", "domain": int(os.environ["AGENTROB_TEST_DOMAIN"]), "simulated": True, "home_on_start": True,
        "fence": WIDE, "options": {"time_scale": 2, "room": [-1000, 1000, -1000, 1000]},
    }  # fmt: skip
    caller = {"token_env": "T", "scopes": ["look", "preview", "command", "stop"], "forum_token_env": "F"}
    facts = {"data": str(tmp_path / "data"), "board": {"listen": "127.0.0.1:0"}, "robots": {"quadruped": robot}}
    Config.model_validate(facts).write(tmp_path / "board.toml")
    children = [Child("board", ["board", "serve", "-c", str(tmp_path / "board.toml")], tmp_path / "board.log")]
    try:
        url = children[0].wait_ready()["url"]
        facts |= {
            "forum": {"url": url},
            "service": {"listen": "127.0.0.1:0", "tokens": {"planner": caller}},
        }
        config = Config.model_validate(facts)
        config.write(tmp_path / "agentrob.toml")
        app.board_account(config, "quadruped", AccountKind.ROBOT_AGENT, Role.MEMBER)
        app.board_account(config, "planner", AccountKind.COMMANDING_AGENT, Role.OPERATOR)
        secrets = {
            "AGENTROB_TOKEN": app.board_token(config, "quadruped"), "F": app.board_token(config, "planner"), "T": TOKEN,
            "AGENTROB_RUNTIME": str(tmp_path),
        }  # fmt: skip
        for name, words in (("driver", ["driver"]), ("agent", ["agent", "serve"])):
            arguments = [*words, "quadruped", "-c", str(tmp_path / "agentrob.toml")]
            children.append(Child(name, arguments, tmp_path / f"{name}.log", secrets))
            children[-1].wait_ready()
        ready = children[-1].ready
        assert ready is not None
        headers = {"Authorization": f"Bearer {secrets['F']}"}
        with (
            httpx2.Client(base_url=ready["url"], timeout=100, trust_env=False) as http,
            httpx2.Client(base_url=url + "/api/v1", timeout=100, trust_env=False, headers=headers) as board,
        ):
            yield Processes(children, http, board)
    finally:
        terminate_all(children)


@pytest.mark.slow
def test_a_command_over_http_is_a_post_on_the_board_and_a_stop_ends_it(processes: Processes) -> None:
    answer = processes.call("POST", "/commands", {"text": "turn left 30 degrees"}, **{"Idempotency-Key": "one"})
    assert answer.status_code == 201, answer.text
    command = answer.json()["command"]
    ended = processes.call("GET", f"/commands/{command['id']}?wait_s=20").json()
    assert (ended["state"], ended["author"]) == ("done", "planner")
    post = processes.board.get(f"/posts/{command['id']}").json()
    assert (post["author"]["name"], post["raw"]) == ("planner", "@quadruped turn left 30 degrees")
    said = processes.board.get(f"/topics/{command['topic']}/posts").json()["items"][1]
    assert (said["author"]["name"], said["card"]["trace_id"]) == ("quadruped", ended["trace_id"])

    walk = processes.call("POST", "/commands", {"text": "walk forward 5 m", "topic": command["topic"]}).json()[
        "command"
    ]
    until_s = time.monotonic() + 60
    while processes.call("GET", "").json()["state"] != "walking":
        assert time.monotonic() < until_s
    stopped = processes.call("POST", "/stop").json()
    assert stopped["confirmed"]
    assert stopped["ended"] == 1
    assert processes.call("GET", f"/commands/{walk['id']}?wait_s=20").json()["state"] == "stopped"
    processes.children[-1].end()
    assert processes.children[-1].process.wait(60) == 0
