"""The event stream and its log: order, resuming, heartbeats, many listeners, and a timely end."""

from __future__ import annotations

import asyncio
import json
import socket
import time
from collections.abc import AsyncIterator, Iterator
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.board.admin import local_admin
from agentrob.board.api.event_stream import encode
from agentrob.board.db.database import open_engine
from agentrob.board.db.reader import Reader, event_number
from agentrob.board.events import hub as events
from agentrob.board.events.hub import Hub
from agentrob.errors import BoardError
from agentrob.model import EventKind, Role
from tests.board.running_board import LIMIT_S, RunningBoard, running_board
from tests.waiting import wait_for


def post_topic(client: httpx2.Client, body: str = "hello") -> dict:
    return client.post("/topics", json={"board_id": "talk", "title": "t", "body": body}).json()


def now(client: httpx2.Client) -> str:
    return client.get("/changes").json()["now"]["id"]


@contextmanager
def stream(client: httpx2.Client, headers: dict[str, str] | None = None, **params: Any) -> Iterator[Iterator[dict]]:
    """Yield the events of an open stream, as dicts with `id` (of the stream), `event` and `data`."""
    with client.stream("GET", "/events", params=params, headers=headers or {}) as response:
        assert response.status_code == 200
        assert response.headers["content-type"].startswith("text/event-stream")
        yield _parsed(response.iter_lines())


def _parsed(lines: Iterator[str]) -> Iterator[dict]:
    fields: dict[str, str] = {}
    for line in lines:
        if line:
            name, _, value = line.partition(": ")
            fields[name] = value
        else:
            if "data" in fields:
                yield fields | {"data": json.loads(fields["data"])}
            fields = {}


def until(events: Iterator[dict], count: int) -> list[dict]:
    """Return the next `count` events that are not heartbeats."""
    found = []
    while len(found) < count:
        event = next(events)
        if event["event"] != "heartbeat":
            found.append(event)
    return found


def test_posts_edits_and_removals_arrive_as_they_happen(board: RunningBoard) -> None:
    op = board.client("op")
    with stream(board.client("quadruped")) as events:
        next_kinds = []
        post = post_topic(op)["post"]
        op.patch(f"/posts/{post['id']}", json={"body": "changed"})
        op.delete(f"/posts/{post['id']}")
        for event in until(events, 3):
            next_kinds.append(event["event"])
            assert event["data"]["kind"] == event["event"]
            assert event["data"]["id"] == event["id"]
            assert event["data"]["post"]["id"] == post["id"]
    assert next_kinds == ["post.created", "post.edited", "post.removed"]


def test_changes_gives_the_same_events_as_the_stream(board: RunningBoard) -> None:
    op = board.client("op")
    start = now(op)
    post_topic(op, "one")
    post_topic(op, "two")
    polled = op.get("/changes", params={"after": start}).json()
    with stream(op, after=start) as events:
        assert [e["data"] for e in until(events, 2)] == polled["items"]
    assert polled["now"]["id"] == polled["items"][-1]["id"]
    assert op.get("/changes", params={"after": start, "limit": 1}).json()["items"] == polled["items"][:1]


def test_a_stream_resumes_after_the_last_id_which_wins_over_after(board: RunningBoard) -> None:
    op = board.client("op")
    start = now(op)
    for n in range(3):
        post_topic(op, f"post {n}")
    second = op.get("/changes", params={"after": start}).json()["items"][1]["id"]
    with stream(op, headers={"Last-Event-ID": second}, after=start) as events:
        (event,) = until(events, 1)
    assert event["data"]["post"]["raw"] == "post 2"


def test_a_post_is_delivered_in_its_current_version(board: RunningBoard) -> None:
    op = board.client("op")
    start = now(op)
    post = post_topic(op, "secret")["post"]
    op.delete(f"/posts/{post['id']}")
    items = op.get("/changes", params={"after": start}).json()["items"]
    assert [e["kind"] for e in items] == ["post.created", "post.removed"]
    assert [e["post"]["raw"] for e in items] == ["", ""]


def test_an_id_that_was_never_issued_is_an_error(board: RunningBoard) -> None:
    answer = board.client("op").get("/events", params={"after": "99999"})
    assert (answer.status_code, answer.json()["code"]) == (404, "no_such_event")


def test_an_id_of_another_history_is_an_error_even_if_its_number_exists(board: RunningBoard) -> None:
    op = board.client("op")
    post_topic(op)
    number, mark = now(op).split("-")
    for other in (f"{number}-{int(mark, 16) + 1:x}", f"{number}-0", f"{int(number) + 1}-{mark}", f"0-{mark}"):
        for answer in (
            op.get("/changes", params={"after": other}),
            op.get("/events", params={"after": other}),
            op.get("/events", headers={"Last-Event-ID": other}),
        ):
            assert (answer.status_code, answer.json()["code"]) == (404, "no_such_event"), other


def test_ids_issued_by_earlier_versions_are_accepted(board: RunningBoard) -> None:
    op = board.client("op")
    start = now(op)
    post_topic(op, "one")
    asked = {"after": start.split("-")[0]}
    assert [e["post"]["raw"] for e in op.get("/changes", params=asked).json()["items"]] == ["one"]
    with stream(op, **asked) as events:
        assert until(events, 1)[0]["data"]["post"]["raw"] == "one"


def test_heartbeats_come_when_nothing_happens(board: RunningBoard) -> None:
    with stream(board.client("op"), heartbeat=0.25) as events:
        started = time.monotonic()
        beats = [next(events) for _ in range(4)]
        took = time.monotonic() - started
    assert [b["event"] for b in beats] == ["heartbeat"] * 4
    assert all("id" not in b and b["data"]["id"] == "" for b in beats)
    assert 0.5 < took < 3


@pytest.mark.parametrize("heartbeat", ["0.2", "31", "nan", "x"])
def test_the_heartbeat_interval_is_limited(board: RunningBoard, heartbeat: str) -> None:
    assert board.client("op").get("/events", params={"heartbeat": heartbeat}).status_code == 422


def test_a_stream_of_one_topic_has_only_events_of_that_topic(board: RunningBoard) -> None:
    op = board.client("op")
    topic = post_topic(op)["topic"]["id"]
    start = now(op)
    op.post("/robots/quadruped/stop")
    post_topic(op, "elsewhere")
    with stream(op, topic_id=topic, after=start) as events:
        post_topic(op, "elsewhere again")
        op.post(f"/topics/{topic}/posts", json={"body": "here"})
        assert until(events, 1)[0]["data"]["post"]["raw"] == "here"
    assert op.get("/events", params={"topic_id": "99999"}).status_code == 404


def test_keys_in_events_are_shown_to_their_owner_only(board: RunningBoard) -> None:
    op = board.client("op")
    with stream(op) as mine, stream(board.client("member")) as others:
        fields = {"board_id": "talk", "title": "t", "body": "b"}
        op.post("/topics", json=fields, headers={"Idempotency-Key": "own-key"})
        assert until(mine, 1)[0]["data"]["post"]["key"] == "own-key"
        assert until(others, 1)[0]["data"]["post"]["key"] is None


@asynccontextmanager
async def raw_stream(board: RunningBoard, who: str = "op", **params: str) -> AsyncIterator[asyncio.StreamReader]:
    query = "&".join(f"{k}={v}" for k, v in params.items())
    reader, writer = await asyncio.open_connection("127.0.0.1", board.settings.port)
    request = f"GET /api/v1/events?{query} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {board.tokens[who]}"
    writer.write(request.encode() + b"\r\n\r\n")
    await reader.readuntil(b"retry: 1000\n\n")
    try:
        yield reader
    finally:
        writer.close()


async def test_two_hundred_listeners_receive_all_events_in_order(board: RunningBoard) -> None:
    posts = 20
    async with AsyncExitStack() as stack:
        people = [board.add(f"reader{n}").name for n in range(5)] * 40
        readers = [await stack.enter_async_context(raw_stream(board, who, heartbeat="30")) for who in people]
        op = board.client("op")
        made = await asyncio.to_thread(lambda: [post_topic(op, str(n))["post"]["raw"] for n in range(posts)])

        async def heard(reader: asyncio.StreamReader) -> list[str]:
            found = []
            while len(found) < posts:
                line = await reader.readline()
                if line.startswith(b"data: "):
                    found.append(json.loads(line[6:])["post"]["raw"])
            return found

        async with asyncio.timeout(LIMIT_S):
            everybody = await asyncio.gather(*map(heard, readers))
    assert everybody == [made] * 200


def test_a_disconnected_listener_is_removed(board: RunningBoard) -> None:
    hub = board.services.hub
    wait_for(lambda: hub.listeners == 0)
    with stream(board.client("op"), heartbeat=0.25) as events:
        next(events)
        assert hub.listeners == 1
    wait_for(lambda: hub.listeners == 0)


def test_a_slow_listener_is_disconnected_and_can_resume_without_a_gap(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.board.events.hub.MAX_PENDING", 10)
    op = board.client("op")
    start = now(op)
    listener = board.services.hub.listen(role=Role.MEMBER)
    topic = post_topic(op)["topic"]["id"]
    wanted = 30
    for n in range(wanted):
        op.post(f"/topics/{topic}/posts", json={"body": str(n)})
    board.services.hub.leave(listener)
    assert listener.closed
    with stream(op, after=start) as events:
        assert [e["data"]["post"]["raw"] for e in until(events, wanted + 1)][1:] == [str(n) for n in range(wanted)]


def test_a_listener_with_a_full_socket_is_disconnected(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    """The task that sends to a socket nobody reads is cancelled and leaves nothing in memory."""
    monkeypatch.setattr("agentrob.board.events.hub.MAX_PENDING", 10)
    hub = board.services.hub
    wait_for(lambda: hub.listeners == 0)
    with socket.socket() as stalled:
        stalled.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        stalled.connect(("127.0.0.1", board.settings.port))
        ask = f"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {board.tokens['op']}\r\n\r\n"
        stalled.sendall(ask.encode())
        wait_for(lambda: hub.listeners == 1)
        (listener,) = hub._listeners
        op = board.client("op")
        topic = post_topic(op)["topic"]["id"]
        for _ in range(200):
            op.post(f"/topics/{topic}/posts", json={"body": "x" * 60_000})
            if listener.closed:
                break
        wait_for(lambda: hub.listeners == 0)
        assert not listener._pending


async def test_an_error_while_receiving_ends_the_stream(board: RunningBoard) -> None:
    hub = board.services.hub
    wait_for(lambda: hub.listeners == 0)
    reader, writer = await asyncio.open_connection("127.0.0.1", board.settings.port)
    head = f"GET /api/v1/events HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {board.tokens['op']}\r\n"
    writer.write(head.encode() + b"Transfer-Encoding: chunked\r\n\r\n")
    async with asyncio.timeout(LIMIT_S):
        await reader.readuntil(b"retry: 1000\n\n")
        assert hub.listeners == 1
        writer.write(b"100000\r\n" + b"x" * 0x100000)  # more than a request may have
        await asyncio.to_thread(wait_for, lambda: hub.listeners == 0)
    writer.close()


def test_one_account_cannot_use_up_all_streams(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.board.events.hub.MAX_PER_ACCOUNT", 2)
    greedy = [board.services.hub.listen(None, "1") for _ in range(2)]
    with pytest.raises(BoardError, match="this account has too many event streams") as caught:
        board.services.hub.listen(None, "1")
    assert (caught.value.status, caught.value.code) == (429, "too_many_streams")
    with stream(board.client("quadruped"), heartbeat=0.25) as events:
        assert next(events)["event"] == "heartbeat"
    board.services.hub.leave(greedy.pop())
    greedy.append(board.services.hub.listen(None, "1"))
    for listener in greedy:
        board.services.hub.leave(listener)


def test_the_server_shuts_down_soon_although_streams_are_open(tmp_path: Path) -> None:
    ended: list[float] = []
    with running_board(tmp_path) as board:
        streams = [board.client("op").stream("GET", "/events") for _ in range(5)]
        streams.append(board.client("op").stream("GET", "/robots/quadruped/camera.mjpg"))
        opened = [s.__enter__() for s in streams]
        started = time.monotonic()
        board.server.should_exit = True
        for response in opened:
            for _ in response.iter_bytes():
                pass  # until the server ends it, whole
        ended.append(time.monotonic() - started)
        for s in streams:
            s.__exit__(None, None, None)
    assert ended[0] < 1.5


def test_a_revoked_right_ends_the_stream(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    account = board.add("leaver")
    with stream(board.client("leaver"), heartbeat=0.25) as events:
        next(events)
        local_admin.change_account(board.settings, account, suspended=True)
        assert all(e["event"] == "heartbeat" for e in events)


def test_robot_events_name_the_account_that_pressed(board: RunningBoard) -> None:
    op = board.client("op")
    start = now(op)
    op.post("/robots/quadruped/stop")
    op.post("/robots/quadruped/reset")
    items = op.get("/changes", params={"after": start}).json()["items"]
    assert [(e["kind"], e["robot"], e["account"]["name"]) for e in items] == [
        (EventKind.ROBOT_STOP, "quadruped", "op"),
        (EventKind.ROBOT_RESET, "quadruped", "op"),
    ]


def test_law_16_a_hub_must_prove_delivery_again_after_a_moment(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a restore from a backup all streams end, and resuming one is an error."""
    post_topic(board.client("op"))
    engine = open_engine(board.settings, writes=False)
    with engine.connect() as connection:
        hub = Hub(partial(encode, board.url))
        hub.start(Reader(connection))
        newest, listener = event_number(hub.last_id), hub.listen()
        assert hub.delivers_stops, "the only process hears itself"
        hub.proven(newest)
        assert (hub.delivers_stops, listener.closed) == (True, False)
        monkeypatch.setattr(events, "PROVEN_S", 0.0)
        assert not hub.delivers_stops
        hub.proven(newest - 1)
        assert not listener.closed, "we wrote one while it was asked"
        hub._last += 1
        hub.proven(newest)
        assert (listener.closed, hub.last_id) == (True, now(board.client("op")))
    engine.dispose()


def test_law_13_a_stop_in_a_board_that_was_added_later_is_delivered(board: RunningBoard) -> None:
    admin = board.client("admin")
    with stream(board.client("quadruped"), heartbeat=0.25) as events:
        next(events)
        admin.post("/admin/boards", json={"id": "lab", "name": "Lab"}).raise_for_status()
        post = {"board_id": "lab", "title": "t", "body": "@quadruped stop"}
        written = admin.post("/topics", json=post).raise_for_status().json()["post"]
        (event,) = until(events, 1)
    assert event["data"]["post"]["id"] == written["id"]


def test_a_stream_follows_who_may_read_a_board(board: RunningBoard) -> None:
    admin = board.client("admin")
    admin.post("/admin/boards", json={"id": "attic", "name": "Attic"}).raise_for_status()

    def write(text: str, role: str) -> str:
        admin.patch("/admin/boards/attic", json={"read_role": role, "post_role": role}).raise_for_status()
        content = {"board_id": "attic", "title": "t", "body": text}
        return admin.post("/topics", json=content).raise_for_status().json()["post"]["raw"]

    with stream(board.client("member"), heartbeat=0.25) as events:
        next(events)
        write("closed", "moderator")
        opened = write("opened", "member")
        write("closed again", "operator")
        last = admin.post("/topics", json={"board_id": "robots", "title": "t", "body": "last"}).json()["post"]["raw"]
        assert [event["data"]["post"]["raw"] for event in until(events, 2)] == [opened, last]


def test_a_changed_role_ends_the_stream(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    account = board.add("climber")
    with stream(board.client("climber"), heartbeat=0.25) as events:
        next(events)
        local_admin.change_account(board.settings, account, role=Role.OPERATOR)
        assert all(e["event"] == "heartbeat" for e in events)
