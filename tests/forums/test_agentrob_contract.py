"""The board adapter fulfils the contract on a real board: real sockets, real SQLite."""

from __future__ import annotations

import asyncio
import io
from collections.abc import AsyncIterator, Iterator
from pathlib import Path

import pytest
from PIL import Image

from agentrob.board.admin import local_admin
from agentrob.config.forum import ForumConfig
from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumUnreachable
from agentrob.forums.agentrob.forum import BoardForum
from agentrob.forums.contract import ForumContract, KeyedEditsContract, World
from agentrob.forums.protocol import Event, Forum, RobotPages
from agentrob.model import AccountKind, EventKind, Role
from tests.board.running_board import RunningBoard, running_board


class BoardWorld:
    """The contract's interface to a running board."""

    def __init__(self, board: RunningBoard) -> None:
        self.board = board
        self.forums: list[BoardForum] = []

    async def sign_in(
        self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER
    ) -> BoardForum:
        if name not in self.board.tokens:
            await asyncio.to_thread(self.board.add, name, kind=kind, role=role)
        return self.at(self.board.url, self.board.tokens[name])

    def at(self, url: str, token: str) -> BoardForum:
        self.forums.append(BoardForum(ForumConfig(url=url), token))
        return self.forums[-1]

    async def suspend(self, name: str) -> None:
        account = local_admin.find_account(self.board.settings, name)
        await asyncio.to_thread(local_admin.change_account, self.board.settings, account, suspended=True)

    async def remove(self, post_id: str) -> None:
        with self.board.client("admin") as client:
            (await asyncio.to_thread(client.delete, f"/posts/{post_id}")).raise_for_status()

    async def unreachable(self) -> Forum:
        return self.at("http://127.0.0.1:9", "token")

    async def close(self) -> None:
        for forum in self.forums:
            await forum.close()


@pytest.fixture
def running(tmp_path: Path) -> Iterator[RunningBoard]:
    with running_board(tmp_path) as board:
        yield board


@pytest.fixture
async def world(running: RunningBoard) -> AsyncIterator[BoardWorld]:
    made = BoardWorld(running)
    yield made
    await made.close()


class TestBoardForum(ForumContract, KeyedEditsContract):
    @pytest.fixture
    async def world(self, running: RunningBoard) -> AsyncIterator[World]:
        made = BoardWorld(running)
        yield made
        await made.close()


async def test_a_wrong_token_is_denied(world: BoardWorld) -> None:
    with pytest.raises(ForumDenied):
        await world.at(world.board.url, "wrong").me()


async def test_the_robot_page_shows_card_and_picture_and_counts_viewers(world: BoardWorld) -> None:
    robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    assert isinstance(robot, RobotPages)
    await robot.publish_robot("quadruped", {"model": "fake", "state": "idle"})
    picture = io.BytesIO()
    Image.new("RGB", (64, 48), "grey").save(picture, "JPEG")
    assert await robot.publish_frame("quadruped", picture.getvalue()) == 0
    with world.board.client("op") as client:
        shown = (await asyncio.to_thread(client.get, "/robots/quadruped")).json()
        frame = await asyncio.to_thread(client.get, "/robots/quadruped/frame.jpg")
    assert shown["card"]["state"] == "idle"
    assert frame.content == picture.getvalue()


async def test_buttons_become_events_with_the_account_that_pressed(world: BoardWorld) -> None:
    robot, op = await world.sign_in("quadruped"), await world.sign_in("op")
    await robot.publish_robot("quadruped", {"model": "fake", "can_reset": True})
    after, _ = await robot.now()
    await op.press_stop("quadruped")
    await op.press_reset("quadruped")
    await op.press_estop("quadruped")
    with pytest.raises(ForumDenied, match="only the robot's owner"):
        await op.press_release("quadruped")
    await robot.publish_robot("quadruped", {"owner": "op"})
    await op.press_release("quadruped")
    await op.press_home("quadruped")
    assert (await robot.robot_page("quadruped")).endswith("/robots/quadruped")
    events = await robot.changes(after)
    assert [(e.kind, e.robot, e.account and e.account.name) for e in events] == [
        (EventKind.ROBOT_STOP, "quadruped", "op"),
        (EventKind.ROBOT_RESET, "quadruped", "op"),
        (EventKind.ROBOT_ESTOP, "quadruped", "op"),
        (EventKind.ROBOT_RELEASE, "quadruped", "op"),
        (EventKind.ROBOT_HOME, "quadruped", "op"),
    ]


async def test_a_picture_is_fetched_from_this_board_only(world: BoardWorld) -> None:
    op = await world.sign_in("op")
    with pytest.raises(ForumError, match="not a picture of this board"):
        await op.download("http://127.0.0.2:1/images/1")


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (b"HTTP/1.1 429 Too Many\r\nRetry-After: 7\r\nContent-Length: 0\r\n\r\n", ForumLimited),
        (b"HTTP/1.1 503 Busy\r\nContent-Length: 5\r\n\r\nproxy", ForumUnreachable),
        (b"HTTP/1.1 500 Oops\r\nContent-Length: 0\r\n\r\n", ForumUnreachable),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\nhuh?", ForumError),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}", ForumError),
        (b"nonsense\r\n\r\n", ForumUnreachable),
    ],
)
async def test_every_response_of_a_defective_server_becomes_a_forum_error(
    answer: bytes, error: type[ForumError], world: BoardWorld
) -> None:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(answer)
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    forum = world.at(f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}", "token")
    with pytest.raises(error) as raised:
        await forum.post("1")
    if isinstance(raised.value, ForumLimited):
        assert raised.value.retry_after_s == 7
    server.close()


async def test_the_stream_ends_with_unreachable_when_the_board_stops(tmp_path: Path) -> None:
    with running_board(tmp_path) as board:
        forum = BoardForum(ForumConfig(url=board.url), board.tokens["op"])
        stream = forum.stream((await forum.now())[0], 0.25)
        await anext(stream)
        board.server.should_exit = True
        with pytest.raises(ForumUnreachable):
            await asyncio.wait_for(_drain(stream), 60)
    await forum.close()


async def _drain(stream: AsyncIterator[Event]) -> None:
    async for _ in stream:
        pass
