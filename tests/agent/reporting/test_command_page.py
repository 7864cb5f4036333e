"""The record that an agent sends of a finished command: the board's page of the command shows it, without people's
words."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.media.image_store import Link
from agentrob.agent.media.pictures import Picture
from agentrob.agent.reporting import command_page as publish
from agentrob.agent.reporting.command_page import MOST_BYTES, public
from agentrob.errors import ForumUnreachable
from agentrob.robots.driver.client import DriverClient
from tests.agent.agent_process import Poster, RunningBoard
from tests.agent.agent_scene import ROBOT, Driver
from tests.agent.laws.test_laws_board import serving_on
from tests.board.running_board import running_board

DRAWS = True


@pytest.fixture(scope="module")
def board(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningBoard]:
    with running_board(tmp_path_factory.mktemp("board")) as made:
        yield made


async def test_a_finished_command_has_a_page_with_what_was_asked_and_measured(
    board: RunningBoard, driver: Driver, tmp_path: Path
) -> None:
    async with serving_on(board, DriverClient(driver.name, driver.socket), tmp_path):
        with Poster(board, "op") as op:
            topic = await op.post(f"@{ROBOT} walk forward 0.5 metres, please, my dear")
            assert await op.final(topic) == ["done"]
            posts = board.client("op").get(f"/topics/{topic}/posts").json()["items"]
            # Before the report, so that its pictures have captions at once.
            (item,) = board.client("op").get(f"/commands/{posts[0]['id']}").json()["items"]
    record = item["record"]
    assert (item["robot"], item["reply_id"], record["status"]) == (ROBOT, posts[1]["id"], "done")
    assert record["steps"][0]["asked"]["distance_m"] == 0.5
    assert record["verdict"]["rule"]
    assert record["trace_id"] == posts[1]["card"]["trace_id"]
    assert "my dear" not in str(record)
    assert str(tmp_path) not in str(record)
    address = f"{board.url}/c/{posts[0]['id']}"
    assert f"[trace `{record['trace_id']}`]({address})" in posts[1]["raw"]
    assert f'href="{address}"' in posts[1]["html"]
    page = board.browser("op").get(f"/c/{posts[0]['id']}").text
    assert "0.50 m" in page
    assert record["trace_id"] in page


def test_a_record_too_long_to_send_leaves_out_what_the_model_was_told() -> None:
    facts = {
        "text": "words",
        "author": {},
        "recording": "/home/x",
        "status": "done",
        "looked": {"goal": "x" * MOST_BYTES},
    }
    pictures = (Picture("step", b"", 2), Picture("path", b""))
    assert public(facts, pictures) == {
        "status": "done",
        "looked": None,
        "shortened": True,
        "pictures": [{"kind": "step", "step": 2}, {"kind": "path", "step": 0}],
    }


class ForumWithPages:
    """A forum that has pages of commands, or claims to."""

    def __init__(self, address: str | Exception | None) -> None:
        self.address = address

    async def command_page(self, post_id: str) -> str:
        if self.address is None:
            await asyncio.Event().wait()
        if isinstance(self.address, Exception):
            raise self.address
        return str(self.address)

    async def publish_record(self, post_id: str, reply_id: str | None, record: dict[str, Any]) -> None: ...


@pytest.mark.parametrize(
    ("forum", "address"),
    [
        (ForumWithPages("https://forum.example/c/7"), "https://forum.example/c/7"),
        (object(), ""),
        (ForumWithPages(ForumUnreachable("away")), ""),
        (ForumWithPages(None), ""),
        (ForumWithPages("javascript:alert(1)"), ""),
        (ForumWithPages("https://a.example/) @bob **now**"), ""),
    ],
)
async def test_a_report_links_to_the_page_of_its_command_only_where_the_forum_says_at_once_that_it_has_one(
    forum: object, address: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(publish, "PAGE_S", 0.05)
    assert await publish.page_of(forum, "7") == address
    assert await publish.page_of(forum, "7", hurry=True) == ""


def test_pictures_that_are_kept_elsewhere_are_sent_as_links() -> None:
    kept_at = datetime(2026, 11, 21, tzinfo=UTC)
    pictures = (
        Picture("path", b""),
        Picture("recording", b"", link=Link("https://bucket.example/a", kept_at, 86_400.0)),
    )
    record = publish.public({"status": "done"}, pictures)
    assert record["pictures"] == [{"kind": "path", "step": 0}]
    assert record["links"] == [
        {"kind": "recording", "step": 0, "url": "https://bucket.example/a", "until": "2026-11-22T00:00:00+00:00"}
    ]
