"""Old events and idempotency keys are deleted; what people wrote stays."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Any

import pytest
from sqlalchemy import text

from agentrob.board.admin import retention
from agentrob.board.db.database import open_engine
from agentrob.config.board import BoardRetentionConfig
from tests.board.running_board import LIMIT_S, RunningBoard
from tests.board.web.browser_windows import jpeg

KEEP = BoardRetentionConfig(events=4)
Boards = Callable[..., RunningBoard]


def count(board: RunningBoard, table: str) -> int:
    engine = open_engine(board.settings, writes=False)
    with engine.connect() as connection:
        found: int = connection.execute(text(f"SELECT count(*) FROM {table}")).scalar_one()
    engine.dispose()
    return found


def at(board: RunningBoard, job: Any, days: float, keep: BoardRetentionConfig = KEEP) -> bool:
    """Run a retention job as if this many days had passed; return whether it may have more to delete."""
    now = datetime.now(UTC) + timedelta(days=days)
    more: bool = board.run(board.services.store.do(partial(job, keep=keep, now=now)))
    return more


def write(board: RunningBoard, times: int, client: str = "op") -> list[dict[str, Any]]:
    op = board.client(client)
    bodies = [{"board_id": "talk", "title": "t", "body": f"post {n}"} for n in range(times)]
    return [op.post("/topics", json=body).json()["post"] for body in bodies]


def test_old_events_beyond_the_limit_are_deleted_and_recent_readers_can_resume(fresh_board: Boards) -> None:
    board = fresh_board()
    op = board.client("op")
    start = op.get("/changes").json()["now"]["id"]
    posts = write(board, 10)
    heard = [e["id"] for e in op.get("/changes", params={"after": start}).json()["items"]]
    at(board, retention.prune_events, days=29)
    assert count(board, "events") == 10
    at(board, retention.prune_events, days=31)
    assert count(board, "events") == 4
    for gone in (heard[2], heard[2].split("-")[0]):  # an id as it is, and as earlier versions of the board issued it
        for path in ("/changes", "/events"):
            answer = op.get(path, params={"after": gone})
            assert (answer.status_code, answer.json()["code"]) == (404, "no_such_event")
    left = op.get("/changes", params={"after": heard[6]}).json()
    assert [e["id"] for e in left["items"]] == heard[7:]
    assert left["now"]["id"] == heard[-1]
    assert len(op.get("/changes", params={"after": "0"}).json()["items"]) == 4
    at(board, retention.prune_events, days=400, keep=BoardRetentionConfig(events=1))
    assert op.get("/changes").json()["now"]["id"] == heard[-1]  # ids continue after the newest one
    write(board, 1)
    assert len(op.get("/changes", params={"after": heard[-1]}).json()["items"]) == 1
    assert [op.get(f"/posts/{post['id']}").json()["raw"] for post in posts] == [f"post {n}" for n in range(10)]


def test_a_cached_page_is_stale_once_the_events_of_its_topic_are_deleted(fresh_board: Boards) -> None:
    board = fresh_board()
    op, visitor = board.client("op"), board.browser("op")
    (post,) = write(board, 1)
    write(board, 1)
    at(board, retention.prune_events, days=31, keep=BoardRetentionConfig(events=1))
    assert "post 0" in visitor.get(f"/t/{post['topic_id']}").text
    op.post(f"/topics/{post['topic_id']}/posts", json={"body": "another one"})
    write(board, 1)
    at(board, retention.prune_events, days=31, keep=BoardRetentionConfig(events=1))
    assert "another one" in visitor.get(f"/t/{post['topic_id']}").text


def test_idempotency_keys_expire_after_a_week(fresh_board: Boards) -> None:
    board = fresh_board()
    op, robot = board.client("op"), board.client("quadruped")
    (post,) = write(board, 1)
    key = {"Idempotency-Key": "k1"}
    picture = {"file": ("a.jpg", jpeg(1), "image/jpeg")}
    edit = partial(op.patch, f"/posts/{post['id']}", json={"body": "edited"}, headers=key)
    edit().raise_for_status()
    first = robot.post("/images", files=picture, headers=key).json()["id"]
    op.post("/robots/quadruped/stop", headers=key).raise_for_status()
    assert count(board, "used_keys") == 3
    at(board, retention.prune_keys, days=6.9)
    assert count(board, "used_keys") == 3
    assert edit().json()["version"] == 2
    assert robot.post("/images", files=picture, headers=key).json()["id"] == first
    at(board, retention.prune_keys, days=7.1)
    assert count(board, "used_keys") == 0
    assert edit().json()["version"] == 3


def test_retention_deletes_in_small_batches(fresh_board: Boards, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(retention, "EVERY_S", 0.01)
    monkeypatch.setattr(retention, "AT_ONCE", 3)
    monkeypatch.setattr(retention, "_us", lambda now, ago: 2**62)  # everything counts as old
    board = fresh_board(retention=BoardRetentionConfig(events=2))
    write(board, 20)

    async def until_little() -> None:
        async with asyncio.timeout(LIMIT_S):
            while count(board, "events") > 2:
                await board.services.store.do(lambda t: None)

    board.run(until_little())
    write(board, 1)
    board.run(until_little())
