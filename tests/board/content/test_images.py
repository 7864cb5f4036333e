"""The files of pictures: one that a post shows is never deleted, and a missing one is reported."""

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


def take_away(board: RunningBoard, digest: str) -> int:
    """Run as `agentrob board expire` does, in a separate process."""
    with local_admin.writing(board.settings) as connection:
        return moderation.take_away(Transaction(connection), board.settings.images_dir, [digest])


@pytest.mark.parametrize("there_before", [False, True])
def test_a_picture_whose_like_is_taken_away_meanwhile_is_kept(
    board: RunningBoard, there_before: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same picture of another account expires just after this one was written and before the database knows."""
    data, keep, taken = picture(10 + there_before), images.keep, list[int]()
    if there_before:
        keep(board.settings.images_dir, data)

    def and_then_it_expires(folder: Path, content: bytes) -> Path:
        kept = keep(folder, content)
        if not taken:
            taken.append(take_away(board, kept.name))
        return kept

    monkeypatch.setattr(images, "keep", and_then_it_expires)
    image = posted(board, "op", data)
    assert taken == [1], "it was taken away once"
    shown = board.browser("member").get(f"/images/{image}")
    assert (shown.status_code, shown.content) == (200, data)
    assert take_away(board, file_of(board, image).name) == 0, "a post shows it"


def test_a_picture_that_is_always_taken_away_is_refused_and_no_post_shows_it(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    keep = images.keep

    def and_then_it_expires(folder: Path, content: bytes) -> Path:
        kept = keep(folder, content)
        take_away(board, kept.name)
        return kept

    monkeypatch.setattr(images, "keep", and_then_it_expires)
    files = {"file": ("x", picture(20), "image/jpeg")}
    answer = board.client("op").post("/images", files=files)
    assert (answer.status_code, answer.json()["code"]) == (503, "storage")


@pytest.mark.parametrize("moves", [False, True])
def test_a_picture_whose_file_is_missing_is_said_to_be_so(board: RunningBoard, moves: bool) -> None:
    data = picture(30, "GIF", 3) if moves else picture(30)
    image, browser = posted(board, "op", data), board.browser("member")
    file_of(board, image).unlink()
    for path in (f"/images/{image}", f"/images/{image}/small"):
        answer = browser.get(path)
        assert answer.status_code == 404, path
        assert "file of this picture is gone" in answer.text
