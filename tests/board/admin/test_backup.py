"""Backup and restore, export, and migrations in both directions."""

from __future__ import annotations

import io
import json
import tarfile
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.board.admin import backup, local_admin
from agentrob.board.db.database import migrate
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.errors import BoardError
from agentrob.model import Role
from tests.board.auth.test_rights import admin_api, jpeg, topic_on
from tests.board.running_board import RunningBoard, running_board


def fill(board: RunningBoard) -> None:
    """Write content of every kind to the forum."""
    op, boss = board.client("op"), admin_api(board)
    image = op.post("/images", files={"file": ("x.jpg", jpeg(33), "image/jpeg")}).json()["id"]
    body = {"board_id": "talk", "title": "Ein Titel 机器人", "body": "words \U0001f916", "images": [image]}
    made = op.post("/topics", json=body, headers={"Idempotency-Key": "k"}).json()
    reply = {"body": "an answer", "reply_to": made["post"]["id"]}
    second = op.post(f"/topics/{made['topic']['id']}/posts", json=reply).json()["post"]["id"]
    op.patch(f"/posts/{second}", json={"body": "a better answer"}).raise_for_status()
    _, hidden = topic_on(board, "robots", "to be hidden")
    boss.post(f"/posts/{hidden}/hide", json={"reason": "why not"}).raise_for_status()
    boss.patch("/admin/robots/quadruped", json={"owner": "op", "camera_days": 9}).raise_for_status()
    op.post("/robots/quadruped/stop").raise_for_status()


def contents(board: RunningBoard) -> list[Any]:
    """Return the forum's content without URLs, which differ between two servers."""
    op = board.client("op")
    found = [op.get("/boards").json()["items"]]
    events = op.get("/changes", params={"after": "0"}).json()["items"]
    found.append([[e["id"], e["kind"], e["at"], e["robot"]] for e in events])
    for topic in sorted({e["post"]["topic_id"] for e in events if e["post"]}, key=int)[:2]:
        posts = op.get(f"/topics/{topic}/posts").json()["items"]
        found.append([[p["id"], p["raw"], p["version"], p["removed"], p["created_at"], p["key"]] for p in posts])
    found.append(op.get("/robots/quadruped/rights", params={"board_id": "talk"}).json())
    for query in ("better", "机器", "Titel"):
        found.append([p["id"] for p in op.get("/search", params={"q": query}).json()["items"]])
        assert len(found[-1]) == 1, query
    return found


def test_a_backup_contains_everything_and_can_be_restored(tmp_path: Path) -> None:
    with running_board(tmp_path / "one") as board:
        fill(board)
        tokens, before = board.tokens, contents(board)
        counts = backup.backup(board.settings, tmp_path / "file")
        image = board.client("op").get("/topics/1/posts").json()["items"][0]["images"][0]["url"].removeprefix(board.url)
        picture = httpx2.get(board.url + image, headers=board.client("op").headers, timeout=60).content
    assert counts["posts"] == 3
    assert (tmp_path / "file").stat().st_mode & 0o777 == 0o600
    fresh = BoardSettings.from_config(BoardConfig(), tmp_path / "two")
    assert backup.restore(fresh, tmp_path / "file")["posts"] == 3
    with running_board(tmp_path / "two", database=fresh.database) as board:
        assert contents(board) == before
        headers = {"Authorization": f"Bearer {tokens['op']}"}
        assert httpx2.get(board.url + image, headers=headers, timeout=60).content == picture, (
            "tokens of before are good"
        )
        key = {"Idempotency-Key": "k"} | headers
        body = {"board_id": "talk", "title": "x", "body": "y"}
        again = httpx2.post(board.url + "/api/v1/topics", json=body, headers=key, timeout=60)
        assert (again.status_code, again.json()["post"]["id"]) == (200, "1")
        assert topic_on(board, "talk")[1] == "4", "new ids come after the old ones"


def test_a_backup_of_a_running_forum_is_a_consistent_snapshot(
    fresh_board: Callable[..., RunningBoard], tmp_path: Path
) -> None:
    board = fresh_board()
    topic, _ = topic_on(board, "talk")
    stop = threading.Event()

    def write() -> None:
        client = board.client("op")
        while not stop.is_set():
            client.post(f"/topics/{topic}/posts", json={"body": "more"}).raise_for_status()

    writer = threading.Thread(target=write)
    writer.start()
    try:
        counts = backup.backup(board.settings, tmp_path / "file")
    finally:
        stop.set()
        writer.join()
    fresh = BoardSettings.from_config(BoardConfig(), tmp_path / "two")
    backup.restore(fresh, tmp_path / "file")
    with running_board(tmp_path / "two", database=fresh.database) as again:
        assert again.client("op").get(f"/topics/{topic}").json()["posts"] == counts["posts"]
        assert len(again.client("op").get("/changes", params={"after": "0"}).json()["items"]) == min(
            100, counts["events"]
        )


def test_restore_refuses_to_overwrite_data(fresh_board: Callable[..., RunningBoard], tmp_path: Path) -> None:
    board = fresh_board()
    backup.backup(board.settings, tmp_path / "file")
    with pytest.raises(BoardError, match="accounts already"):
        backup.restore(board.settings, tmp_path / "file")
    with pytest.raises(BoardError, match="exists already"):
        backup.backup(board.settings, tmp_path / "file")
    assert board.client("op").get("/me").status_code == 200


@pytest.mark.parametrize("damage", ["cut", "no tar", "row missing", "foreign picture", "other version"])
def test_a_damaged_backup_changes_nothing(
    fresh_board: Callable[..., RunningBoard], tmp_path: Path, damage: str
) -> None:
    board = fresh_board()
    fill(board)
    backup.backup(board.settings, tmp_path / "file")
    bad = tmp_path / "bad"
    if damage == "cut":
        bad.write_bytes((tmp_path / "file").read_bytes()[:-2000])
    elif damage == "no tar":
        bad.write_bytes(b"not a tar")
    else:
        spoil(tmp_path / "file", bad, damage)
    fresh = BoardSettings.from_config(BoardConfig(), tmp_path / "two")
    with pytest.raises(BoardError) as caught:
        backup.restore(fresh, bad)
    assert caught.value.status == 422
    local_admin.bootstrap(fresh)
    with pytest.raises(BoardError):
        local_admin.find_account(fresh, "op")


def spoil(good: Path, bad: Path, damage: str) -> None:
    with tarfile.open(good) as old, tarfile.open(bad, "w:gz") as new:
        for member in old:
            content = old.extractfile(member).read()  # type: ignore[union-attr]
            if damage == "row missing" and member.name == "tables/posts.jsonl":
                content = content.split(b"\n", 1)[1]
            if damage == "foreign picture" and member.name.startswith("pictures/"):
                content = jpeg(99)
            if damage == "other version" and member.name == "manifest.json":
                content = json.dumps(json.loads(content) | {"revision": "9999"}).encode()
            member.size = len(content)
            new.addfile(member, io.BytesIO(content))


def test_an_export_contains_all_posts_and_no_secrets(fresh_board: Callable[..., RunningBoard], tmp_path: Path) -> None:
    board = fresh_board()
    fill(board)
    assert backup.export(board.settings, tmp_path / "all") == 2
    assert backup.export(board.settings, tmp_path / "mine", "op") == 2
    assert backup.export(board.settings, tmp_path / "none", "member") == 0
    with tarfile.open(tmp_path / "all") as tar:
        names = tar.getnames()
        words = b"".join(tar.extractfile(n).read() for n in names if n.endswith(".json")).decode()  # type: ignore[union-attr]
    assert "a better answer" in words
    assert not [w for w in ("to be hidden", "argon2", "hash", "token") if w in words]
    assert len([n for n in names if n.startswith("pictures/")]) == 1


def test_migrations_up_and_down_keep_all_data(tmp_path: Path) -> None:
    settings = BoardSettings.from_config(BoardConfig(), tmp_path)
    if "sqlite" in settings.database:
        settings = replace(settings, busy_timeout_s=2.0)
    with running_board(tmp_path, database=settings.database) as board:
        fill(board)
        before = contents(board)
        board.add("modest", role=Role.GUEST)
        board.add("keeper", role=Role.MODERATOR)
        reading = local_admin.issue_token(
            board.settings, local_admin.find_account(board.settings, "op"), "look", ["read"]
        )
    migrate(settings, "0001")
    migrate(settings)
    with running_board(tmp_path, database=settings.database) as board:
        after = contents(board)
        assert after[1:4] == before[1:4]
        roles = [local_admin.find_account(board.settings, n).role for n in ("modest", "keeper", "op")]
        assert roles == [Role.MEMBER, Role.OPERATOR, Role.OPERATOR]
        headers = {"Authorization": f"Bearer {reading}"}
        assert httpx2.get(board.url + "/api/v1/me", headers=headers, timeout=60).status_code == 401, (
            "narrow tokens become void"
        )


def test_a_downgrade_that_would_open_a_board_is_refused(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    admin_api(board).patch(
        "/admin/boards/talk", json={"read_role": "operator", "post_role": "operator"}
    ).raise_for_status()
    with pytest.raises(BoardError, match="keep a board to operators"):
        migrate(board.settings, "0001", alone=True)
    with pytest.raises(BoardError, match="no revision"):
        migrate(board.settings, "nonsense", alone=True)
    assert board.client("op").get("/boards").status_code == 200
