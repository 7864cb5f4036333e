"""Files of pictures: a file that a post shows is never deleted, and a missing file is reported."""

from __future__ import annotations

import io
from pathlib import Path

import pytest
from PIL import Image

from agentrob.board.admin import local_admin, moderation
from agentrob.board.content import images
from agentrob.board.db.writer import Transaction
from tests.board.running_board import RunningBoard


def picture(shade: int, kind: str = "JPEG", frames: int = 1) -> bytes:
    file = io.BytesIO()
    first, *others = (Image.new("RGB", (48, 36), (shade, 40 * k, 90)) for k in range(frames))
    more = {"save_all": True, "append_images": others, "duration": 100} if others else {}
    first.save(file, kind, **more)
    return file.getvalue()


def posted(board: RunningBoard, who: str, data: bytes) -> str:
    """Post the picture; return its id."""
    client = board.client(who)
    image = client.post("/images", files={"file": ("x", data, "application/octet-stream")})
    image.raise_for_status()
    body = {"board_id": "talk", "title": "A picture", "body": "look", "images": [image.json()["id"]]}
    client.post("/topics", json=body).raise_for_status()
    return str(image.json()["id"])


def file_of(board: RunningBoard, image: str) -> Path:
    return images.path_of(board.settings.images_dir, board.services.store.reader.image(image)[1])


def expire_file(board: RunningBoard, digest: str) -> int:
    """Delete a picture's file as `agentrob board expire` does, without the server."""
    with local_admin.writing(board.settings) as connection:
        return moderation.take_away(Transaction(connection), board.settings.images_dir, [digest])


@pytest.mark.parametrize("there_before", [False, True])
def test_a_picture_is_kept_although_an_identical_one_expires_meanwhile(
    board: RunningBoard, there_before: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another account's copy expires after this upload has written the file and before it has written the database."""
    data, keep, taken = picture(10 + there_before), images.keep, list[int]()
    if there_before:
        keep(board.settings.images_dir, data)

    def keep_then_expire(folder: Path, content: bytes) -> Path:
        kept = keep(folder, content)
        if not taken:
            taken.append(expire_file(board, kept.name))
        return kept

    monkeypatch.setattr(images, "keep", keep_then_expire)
    image = posted(board, "op", data)
    assert taken == [1], "it was taken away once"
    shown = board.browser("member").get(f"/images/{image}")
    assert (shown.status_code, shown.content) == (200, data)
    assert expire_file(board, file_of(board, image).name) == 0, "a post shows it"


def test_an_upload_whose_file_keeps_disappearing_is_refused(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep = images.keep

    def keep_then_expire(folder: Path, content: bytes) -> Path:
        kept = keep(folder, content)
        expire_file(board, kept.name)
        return kept

    monkeypatch.setattr(images, "keep", keep_then_expire)
    files = {"file": ("x", picture(20), "image/jpeg")}
    answer = board.client("op").post("/images", files=files)
    assert (answer.status_code, answer.json()["code"]) == (503, "storage")


@pytest.mark.parametrize("moves", [False, True])
def test_a_missing_picture_file_is_reported(board: RunningBoard, moves: bool) -> None:
    data = picture(30, "GIF", 3) if moves else picture(30)
    image, browser = posted(board, "op", data), board.browser("member")
    file_of(board, image).unlink()
    for path in (f"/images/{image}", f"/images/{image}/small"):
        answer = browser.get(path)
        assert answer.status_code == 404, path
        assert "file of this picture is gone" in answer.text
