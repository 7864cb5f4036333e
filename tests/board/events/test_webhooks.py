"""The board's own webhooks: signed, with ids only, retried, and accepted by an agent's service."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path
from queue import Queue

import pytest

from agentrob.config.service import HookOutConfig
from agentrob.errors import ConfigError
from agentrob.process import webhooks
from agentrob.service.webhooks import verify
from tests.board.running_board import LIMIT_S, RunningBoard, running_board

SECRET = "the-secret-of-board-and-agent"
Got = Queue[tuple[dict[str, str], bytes]]


@contextmanager
def receiver(*answers: int) -> Iterator[tuple[str, Got]]:
    """Run a receiver that answers with these statuses in order, and with the last one from then on."""
    got: Got = Queue()
    left = list(answers)

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            length = int(self.headers["Content-Length"])
            body = self.rfile.read(length)
            if len(body) < length:  # the sender was killed while it wrote
                return
            got.put(({k.lower(): v for k, v in self.headers.items()}, body))
            self.send_response(left.pop(0) if len(left) > 1 else left[0])
            self.end_headers()

        def log_message(self, *_: object) -> None:
            """Log nothing."""

    server = HTTPServer(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/hook", got
    finally:
        server.shutdown()
        server.server_close()


@contextmanager
def board_with_webhook(folder: Path, url: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[RunningBoard]:
    monkeypatch.setenv("HOOK_SECRET", SECRET)
    with running_board(folder, hooks={"agent": HookOutConfig(url=url, secret_env="HOOK_SECRET")}) as board:
        yield board


def test_a_webhook_is_signed_and_contains_only_ids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with receiver(200) as (url, got), board_with_webhook(tmp_path, url, monkeypatch) as board:
        op = board.client("op")
        wrote = op.post(
            "/topics", json={"board_id": "robots", "title": "T", "body": "@quadruped a private word"}
        ).json()
        headers, body = got.get(timeout=LIMIT_S)
        op.post("/robots/quadruped/stop")
        _, stop = got.get(timeout=LIMIT_S)
    verify("standard", body, headers, SECRET)
    said = json.loads(body)
    assert said["type"] == "post.created"
    assert said["data"].pop("event")
    assert said["data"] == {"post": wrote["post"]["id"], "topic": wrote["topic"]["id"], "board": "robots"}
    assert json.loads(stop)["data"]["robot"] == "quadruped"


def test_a_refused_delivery_is_retried_under_the_same_id(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(webhooks, "PAUSES_S", (0.01, 0.01))
    with receiver(500, 204) as (url, got), board_with_webhook(tmp_path, url, monkeypatch) as board:
        board.client("op").post("/topics", json={"board_id": "robots", "title": "T", "body": "hello"})
        (first, body), (second, again) = got.get(timeout=LIMIT_S), got.get(timeout=LIMIT_S)
    assert body == again
    assert first["webhook-id"] == second["webhook-id"]


def test_an_unreachable_receiver_delays_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with board_with_webhook(tmp_path, "http://127.0.0.1:9/hook", monkeypatch) as board:
        op = board.client("op")
        for n in range(3):
            answer = op.post("/topics", json={"board_id": "robots", "title": f"T{n}", "body": "hello"})
            assert answer.status_code == 201


def test_a_webhook_without_its_secret_is_refused_by_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("NO_SECRET", raising=False)
    hooks = {"agent": HookOutConfig(url="http://127.0.0.1:9/", secret_env="NO_SECRET")}
    with pytest.raises(ConfigError, match="NO_SECRET"), running_board(tmp_path, hooks=hooks):
        pass
