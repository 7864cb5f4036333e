"""Robot pages with data from the agents, buttons that anybody may press, and pictures."""

from __future__ import annotations

import io
import sqlite3
import struct
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

import httpx2
import pytest
from PIL import Image

from agentrob.board.admin import local_admin, management
from agentrob.board.content import images
from agentrob.board.db.records import StoredEvent
from agentrob.board.db.writer import Transaction
from agentrob.board.events import cluster_messages, presence
from agentrob.board.events.hub import Listener
from agentrob.board.events.presence import LIVE_FOR
from agentrob.board.robots import actions
from agentrob.errors import BoardError
from agentrob.model import AccountKind, EventKind, Role
from tests.board.running_board import LIMIT_S, RunningBoard
from tests.waiting import wait_for


def picture(width: int = 64, height: int = 48, kind: str = "JPEG", **options: object) -> bytes:
    out = io.BytesIO()
    Image.new("RGB", (width, height), (200, 100, 50)).save(out, format=kind, **options)
    return out.getvalue()


# -------------------------------------------------------------------- cards and buttons
def test_a_robot_is_listed_before_its_agent_sends_a_card(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    (robot,) = board.client("op").get("/robots").json()["items"]
    assert robot.pop("url").endswith("/robots/quadruped")
    assert robot == {"name": "quadruped", "card": {}, "seen_at": None, "viewers": 0, "has_frame": False}


def test_a_card_is_returned_unchanged(board: RunningBoard) -> None:
    card = {"model": "go2", "ops": ["move"], "battery_percent": 81.5, "something_new": {"a": [1, None]}}
    assert board.client("quadruped").put("/robots/quadruped", json={"card": card}).status_code == 200
    seen = board.client("member").get("/robots/quadruped").json()
    assert seen["card"] == card
    assert seen["seen_at"] is not None


def test_robots_are_listed_with_or_without_their_cards(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    assert board.client("quadruped").put("/robots/quadruped", json={"card": {"model": "go2"}}).status_code == 200
    (with_card,) = board.client("member").get("/robots").json()["items"]
    (without,) = board.client("member").get("/robots?cards=false").json()["items"]
    assert with_card["card"] == {"model": "go2"}
    assert without == with_card | {"card": {}}


@pytest.mark.parametrize(
    ("card", "status", "code"),
    [
        *[('{"a": NaN}', 422, "bad_card"), ('{"a": [-Infinity]}', 422, "bad_card")],
        *[('{"a": 1' + "0" * 400 + "}", 422, "bad_card"), ('{"a": {"b": "\\ud800"}}', 422, "bad_card")],
        ('{"a": ' + "[" * 300 + "]" * 300 + "}", 422, "bad_card"),
        ('{"a": "' + "x" * 16_384 + '"}', 413, "card_too_large"),
    ],
)
def test_an_invalid_card_is_refused(board: RunningBoard, card: str, status: int, code: str) -> None:
    robot = board.client("quadruped")
    robot.put("/robots/quadruped", json={"card": {"model": "go2"}})
    headers = {"Content-Type": "application/json"}
    answer = robot.put("/robots/quadruped", content=f'{{"card": {card}}}', headers=headers)
    assert (answer.status_code, answer.json()["code"]) == (status, code)
    assert robot.get("/robots/quadruped").json()["card"] == {"model": "go2"}


@pytest.mark.parametrize(("who", "name"), [("op", "quadruped"), ("admin", "quadruped"), ("quadruped", "humanoid")])
def test_only_the_robots_own_agent_may_send_its_card(board: RunningBoard, who: str, name: str) -> None:
    client = board.client(who)
    assert client.put(f"/robots/{name}", json={"card": {}}).json()["code"] == "not_this_robot"
    assert client.put(f"/robots/{name}/frame", content=picture()).json()["code"] == "not_this_robot"


@pytest.mark.parametrize("who", ["member", "op", "admin", "quadruped"])
def test_law_15_everybody_may_stop_as_often_as_they_like(board: RunningBoard, who: str) -> None:
    client = board.client(who)
    before = client.get("/changes").json()["now"]["id"]
    answers = [client.post("/robots/quadruped/stop").json() for _ in range(60)]
    assert {(a["kind"], a["robot"], a["account"]["name"]) for a in answers} == {("robot.stop", "quadruped", who)}

    def written() -> int:  # on a busy machine some events are sent before they are written
        items = client.get("/changes", params={"after": before, "limit": 100}).json()["items"]
        return sum((e["kind"], e["account"]["name"]) == ("robot.stop", who) for e in items if e["account"])

    wait_for(lambda: written() == 60)


def test_law_15_a_stop_that_cannot_be_written_is_delivered_before_the_response(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The person who pressed the button waits until the event is written; the robot is stopped before."""
    assert (actions.TELL_S, actions.WRITE_S) == (0.05, 0.25)
    monkeypatch.setattr(actions, "WRITE_S", 2.0)
    op, held, go_on = board.client("op"), threading.Event(), threading.Event()

    def hold(_: Transaction) -> None:
        held.set()
        assert go_on.wait(LIMIT_S)

    newest = op.get("/changes").json()["now"]["id"]
    with ThreadPoolExecutor(2) as pool, board.client("quadruped").stream("GET", "/events") as response:
        lines = response.iter_lines()
        next(lines)
        holding = pool.submit(board.run, board.services.store.do(hold))
        assert held.wait(LIMIT_S)
        start = time.monotonic()
        try:
            pressing = pool.submit(op.post, "/robots/quadruped/stop")
            told = [next(line for line in lines if line.startswith(word)) for word in ("event: robot", "id")]
            told_s = time.monotonic() - start
            pressed = pressing.result(LIMIT_S)
            took_s = time.monotonic() - start
            assert op.get("/changes", params={"after": newest}).json()["items"] == [], "not written, and told"
        finally:
            go_on.set()
        holding.result(LIMIT_S)
        written = lambda: [e["kind"] for e in op.get("/changes", params={"after": newest}).json()["items"]]  # noqa: E731
        wait_for(lambda: written() == ["robot.stop"])
        op.post("/topics", json={"board_id": "talk", "title": "t", "body": "b"}).raise_for_status()
        heard = next(line for line in lines if line.startswith("event") and not line.endswith("heartbeat"))
        assert heard == "event: post.created", "the stop is not told again when it was written after all"
    assert (pressed.status_code, pressed.json()["kind"]) == (200, "robot.stop")
    assert told == ["event: robot.stop", f"id: {newest}"]
    assert told_s < 1.0 < actions.WRITE_S <= took_s < 3.0, "nobody waited for the writer"


def test_a_stop_with_a_used_key_is_one_event(board: RunningBoard) -> None:
    op, key = board.client("op"), {"Idempotency-Key": "stop-1"}
    first, second = (op.post("/robots/quadruped/stop", headers=key).json() for _ in range(2))
    assert first == second


def test_a_stop_by_cookie_needs_the_csrf_token(board: RunningBoard) -> None:
    answer = board.browser("op").post("/api/v1/robots/quadruped/stop")
    assert (answer.status_code, answer.json()["code"]) == (403, "bad_csrf")


def test_operators_may_reset_the_room_and_members_may_not(board: RunningBoard) -> None:
    assert board.client("op").post("/robots/quadruped/reset").json()["kind"] == "robot.reset"
    assert board.client("member").post("/robots/quadruped/reset").json()["code"] == "not_operator"


# -------------------------------------------------------------------- emergency stop, release, home
def kinds(board: RunningBoard, after: str) -> list[tuple[str, str]]:
    items = board.client("quadruped").get("/changes", params={"after": after, "limit": 100}).json()["items"]
    return [(e["kind"], e["account"]["name"]) for e in items if e["robot"] == "quadruped"]


@pytest.mark.parametrize("who", ["member", "op", "admin", "quadruped"])
def test_law_17_everybody_may_press_emergency_stop(board: RunningBoard, who: str) -> None:
    before = board.client(who).get("/changes").json()["now"]["id"]
    answer = board.client(who).post("/robots/quadruped/estop").json()
    assert (answer["kind"], answer["robot"], answer["account"]["name"]) == ("robot.estop", "quadruped", who)
    wait_for(lambda: kinds(board, before) == [("robot.estop", who)])


def test_law_15_an_emergency_stop_works_with_an_unwritable_database(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def stuck(*_: object, **__: object) -> None:
        raise BoardError(503, "busy", "locked")

    monkeypatch.setattr(board.services.store, "record", stuck)
    with board.client("quadruped").stream("GET", "/events") as response:
        lines = response.iter_lines()
        next(lines)
        assert board.client("member").post("/robots/quadruped/estop").json()["kind"] == "robot.estop"
        assert next(line for line in lines if line.startswith("event: robot")) == "event: robot.estop"


def test_law_15_an_emergency_stop_reaches_the_other_processes(board: RunningBoard) -> None:
    hub = board.services.hub
    for kind in (EventKind.ROBOT_STOP, EventKind.ROBOT_ESTOP):
        pressed = StoredEvent("", kind, datetime.now(UTC), robot="quadruped")
        heard = cluster_messages.event_from_json(cluster_messages.event_to_json(pressed), hub)
        assert (heard.kind, heard.robot) == (kind, "quadruped")
    with pytest.raises(ValueError, match="no event that is announced"):
        cluster_messages.event_from_json(
            cluster_messages.event_to_json(replace(pressed, kind=EventKind.ROBOT_RELEASE)), hub
        )


@pytest.mark.parametrize("action", ["release", "home"])
def test_law_2_only_the_owner_and_admins_may_release_and_set_home(
    fresh_board: Callable[..., RunningBoard], action: str
) -> None:
    board = fresh_board()
    board.have("mod", role=Role.MODERATOR)
    board.have("olga")
    board.have("planner", kind=AccountKind.COMMANDING_AGENT, role=Role.ADMIN)
    admin = board.client("admin")
    before = admin.get("/changes").json()["now"]["id"]
    for who in ("member", "op", "mod", "olga", "planner", "quadruped"):
        answer = board.client(who).post(f"/robots/quadruped/{action}")
        assert (answer.status_code, answer.json()["code"]) == (403, "not_owner"), who
        assert f"agentrob {action} quadruped" in answer.json()["hint"]
    assert kinds(board, before) == []
    board.client("quadruped").put("/robots/quadruped", json={"card": {"owner": "olga"}}).raise_for_status()
    for who in ("olga", "admin"):
        answer = board.client(who).post(f"/robots/quadruped/{action}", headers={"Idempotency-Key": "twice"})
        again = board.client(who).post(f"/robots/quadruped/{action}", headers={"Idempotency-Key": "twice"})
        assert (answer.status_code, answer.json()["kind"]) == (200, f"robot.{action}")
        assert again.json() == answer.json(), "a double press under one key is one event"
    assert kinds(board, before) == [(f"robot.{action}", "olga"), (f"robot.{action}", "admin")]
    rows = admin_client(board).get("/admin/audit", params={"target": "robot:quadruped"}).json()["items"]
    assert [(r["actor"], r["action"]) for r in rows[:2]] == [("admin", f"robot.{action}"), ("olga", f"robot.{action}")]


def admin_client(board: RunningBoard) -> httpx2.Client:
    """Return the API as an admin with a token for administration."""
    client = board.client()
    token = local_admin.issue_token(
        board.settings, local_admin.find_account(board.settings, "admin"), scopes=("read", "write", "admin")
    )
    client.headers["Authorization"] = f"Bearer {token}"
    return client


def test_law_2_with_release_disabled_not_even_an_admin_may_release(
    fresh_board: Callable[..., RunningBoard],
) -> None:
    board = fresh_board()
    changed = admin_client(board).patch("/admin/robots/quadruped", json={"release": "nobody"})
    assert changed.status_code == 200, changed.text
    assert board.client("admin").post("/robots/quadruped/release").json()["code"] == "not_owner"


def test_an_unknown_robot_is_answered_with_the_known_ones(board: RunningBoard) -> None:
    answer = board.client("op").post("/robots/rover/stop").json()
    assert (answer["status"], answer["hint"]) == (404, "valid: quadruped")


# -------------------------------------------------------------------- the live picture
def test_the_last_picture_is_kept_in_memory(board: RunningBoard) -> None:
    robot, op = board.client("quadruped"), board.client("op")
    jpeg = picture()
    assert robot.put("/robots/quadruped/frame", content=jpeg).json() == {"viewers": 0}
    got = op.get("/robots/quadruped/frame.jpg")
    assert (got.content, got.headers["content-type"], got.headers["cache-control"]) == (jpeg, "image/jpeg", "no-store")
    assert op.get("/robots/quadruped").json()["has_frame"] is True


@pytest.mark.parametrize("frame", [b"", b"GIF89a", b"\xff\xd8\xff\xe0 not really", picture(kind="PNG")])
def test_a_frame_that_is_not_a_jpeg_is_refused(board: RunningBoard, frame: bytes) -> None:
    answer = board.client("quadruped").put("/robots/quadruped/frame", content=frame)
    assert (answer.status_code, answer.json()["code"]) == (415, "bad_frame")


def pictures(response: httpx2.Response) -> Iterator[bytes]:
    """Split a multipart stream into its parts by their lengths."""
    data = b""
    for chunk in response.iter_raw():
        data += chunk
        while (at := data.find(b"\r\n\r\n")) >= 0:
            length = int(data[:at].lower().split(b"content-length: ")[1].split(b"\r\n")[0])
            if len(data) < at + 4 + length:
                break
            yield data[at + 4 : at + 4 + length]
            data = data[at + 4 + length :]


def test_viewers_are_counted_and_see_each_new_picture(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    robot, op = board.client("quadruped"), board.client("op")
    first, second = picture(64, 48), picture(32, 24)
    path = "/robots/quadruped/frame"
    with op.stream("GET", "/robots/quadruped/camera.mjpg") as one:
        assert one.headers["content-type"].startswith("multipart/x-mixed-replace; boundary=")
        assert robot.put(path, content=first).json() == {"viewers": 1}
        with board.client("member").stream("GET", "/robots/quadruped/camera.mjpg") as two:
            shown, other = pictures(one), pictures(two)
            assert next(shown) == first
            assert robot.put(path, content=second).json() == {"viewers": 2}
            assert (next(shown), next(other)) == (second, second), "the other came after the first"
    wait_for(lambda: board.services.presence.robot("quadruped").viewers == 0)


def viewer_events(board: RunningBoard) -> tuple[Listener, Callable[[], list[str]]]:
    """Subscribe on the server itself; return the listener, and a function that lists robots whose camera was opened."""
    listener = board.run(_listen(board))

    def heard() -> list[str]:
        happened = [h.event for h in listener._pending]
        return [str(e.robot) for e in happened if e.kind is EventKind.ROBOT_WATCH and e.account is None]

    return listener, heard


async def _listen(board: RunningBoard) -> Listener:
    return board.services.hub.listen(role=None)


def test_opening_and_closing_the_camera_writes_nothing(fresh_board: Callable[..., RunningBoard]) -> None:
    """Guests may open the camera: the robot's agent is notified, but not a hundred times."""
    board = fresh_board(public_read=True)
    stranger, op = board.client(), board.client("op")
    _, heard = viewer_events(board)
    before, begun_s = op.get("/changes").json()["now"]["id"], time.monotonic()
    for _ in range(100):
        with stranger.stream("GET", "/robots/quadruped/camera.mjpg") as response:
            assert response.status_code == 200
        wait_for(lambda: board.services.presence.robot("quadruped").viewers == 0)
    assert op.get("/changes", params={"after": before}).json()["items"] == [], "reading leaves no events"
    told = len(heard())
    assert 1 <= told <= 1 + (time.monotonic() - begun_s) / presence.WATCH_EVERY_S


def test_a_late_timer_does_not_tell_the_agent_twice(fresh_board: Callable[..., RunningBoard]) -> None:
    """On a busy machine the next viewer may come before the timer that tells of the one before it."""
    board = fresh_board()
    _, heard = viewer_events(board)

    async def open_before_the_timer() -> None:
        robot = board.services.presence.robot("quadruped")
        board.services.presence.look("quadruped", 1)
        actions.watch(board.services, "quadruped")
        actions.watch(board.services, "quadruped")
        assert robot.call is not None
        timer, robot.called_s = robot.call, 0.0
        actions.watch(board.services, "quadruped")
        assert timer.cancelled()

    board.run(open_before_the_timer())
    assert heard() == ["quadruped"] * 2


def test_an_agent_that_missed_a_viewer_learns_of_it_with_its_next_card(
    fresh_board: Callable[..., RunningBoard], monkeypatch: pytest.MonkeyPatch
) -> None:
    board = fresh_board()
    robot = board.client("quadruped")
    with board.client("op").stream("GET", "/robots/quadruped/camera.mjpg") as shown:
        wait_for(lambda: board.services.presence.robot("quadruped").viewers == 1)
        _, heard = viewer_events(board)  # the agent starts to listen only now
        monkeypatch.setattr(presence, "WATCH_EVERY_S", 0.0)
        robot.put("/robots/quadruped", json={"card": {}}).raise_for_status()
        assert heard() == ["quadruped"]
        robot.put("/robots/quadruped/frame", content=picture()).raise_for_status()
        assert next(pictures(shown)) == picture()
        robot.put("/robots/quadruped", json={"card": {}}).raise_for_status()
        assert heard() == ["quadruped"], "it shows pictures already"


def test_an_old_frame_is_not_shown(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    board.client("quadruped").put("/robots/quadruped/frame", content=picture())
    op = board.client("op")
    assert op.get("/robots/quadruped/frame.jpg").status_code == 200
    board.services.presence.robot("quadruped").frame_s -= LIVE_FOR.total_seconds()
    assert op.get("/robots/quadruped/frame.jpg").json()["code"] == "no_such_picture"
    assert op.get("/robots/quadruped").json()["has_frame"] is False


def test_a_revoked_right_ends_the_live_picture(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    account = board.add("onlooker")
    with board.client("onlooker").stream("GET", "/robots/quadruped/camera.mjpg") as response:
        local_admin.change_account(board.settings, account, suspended=True)
        assert list(pictures(response)) == [], "it ends, and whole"
    wait_for(lambda: board.services.presence.robot("quadruped").viewers == 0)


def test_a_card_must_name_its_own_robot(board: RunningBoard) -> None:
    """A card shows a robot's name and stop button, so it must name its sender, also in an edit or a record."""
    robot, op = board.client("quadruped"), board.client("op")
    made = op.post("/topics", json={"board_id": "talk", "title": "t", "body": "go"}).json()
    path, post = f"/topics/{made['topic']['id']}/posts", made["post"]["id"]
    mine, other = ({"robot": name, "state": "running"} for name in ("quadruped", "humanoid"))
    status = robot.post(path, json={"body": "mine", "card": mine}).json()["post"]["id"]
    refused = [
        robot.post(path, json={"body": "x", "card": other}),
        robot.patch(f"/posts/{status}", json={"body": "x", "card": other}),
        robot.put(f"/commands/{post}", json={"reply_id": status, "record": {"robot": "humanoid", "status": "done"}}),
    ]
    assert [(r.status_code, r.json()["code"]) for r in refused] == [(403, "not_this_robot")] * 3
    assert "'humanoid'" in refused[0].json()["detail"]
    assert robot.get(f"/posts/{status}").json()["raw"] == "mine"
    assert (
        robot.put(f"/commands/{post}", json={"reply_id": status, "record": {"robot": "quadruped"}}).status_code == 200
    )


@pytest.mark.sqlite
def test_law_1_a_stored_card_that_names_another_robot_is_not_shown(board: RunningBoard) -> None:
    """Earlier versions of the board accepted such cards, so databases may contain them."""
    robot, op = board.client("quadruped"), board.client("op")
    made = op.post("/topics", json={"board_id": "talk", "title": "t", "body": "go"}).json()["topic"]
    card = {"robot": "quadruped", "state": "running"}
    status = robot.post(f"/topics/{made['id']}/posts", json={"body": "mine", "card": card}).json()["post"]
    assert status["card"]["robot"] == "quadruped"
    with closing(sqlite3.connect(str(board.settings.database_path))) as database, database:
        forged = '{"robot": "humanoid", "state": "running"}'
        database.execute("UPDATE posts SET card = ? WHERE id = ?", (forged, int(status["id"])))
    shown = op.get(f"/topics/{made['id']}/posts").json()["items"]
    assert [p["card"] for p in shown] == [None, None]
    with board.browser("op") as page:
        assert "/robots/humanoid/stop" not in page.get(f"/t/{made['id']}").text


@pytest.mark.parametrize("lost", ["camera_role raised", "viewer demoted", "viewer no longer owner"])
def test_a_revoked_right_to_the_camera_ends_the_live_picture(
    fresh_board: Callable[..., RunningBoard], monkeypatch: pytest.MonkeyPatch, lost: str
) -> None:
    """The server checks the right to view again; the stream continues for viewers who still have it."""
    board = fresh_board()
    account = board.add("onlooker", role=Role.OPERATOR)
    first: dict[str, dict[str, Any]] = {
        "camera_role raised": {"camera_role": Role.OPERATOR},
        "viewer demoted": {"camera_role": Role.OPERATOR},
        "viewer no longer owner": {"camera_role": Role.ADMIN, "owner": "onlooker"},
    }
    change_robot(board, **first[lost])
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    robot, path = board.client("quadruped"), "/robots/quadruped/camera.mjpg"
    with board.client("admin").stream("GET", path) as other, board.client("onlooker").stream("GET", path) as response:
        wait_for(lambda: board.services.presence.robot("quadruped").viewers == 2)
        if lost == "camera_role raised":
            change_robot(board, camera_role=Role.MODERATOR)
        elif lost == "viewer demoted":
            local_admin.change_account(board.settings, account, role=Role.MEMBER)
        else:
            change_robot(board, owner="")
        assert list(pictures(response)) == [], "it ends, and whole"
        robot.put("/robots/quadruped/frame", content=picture()).raise_for_status()
        assert next(pictures(other)) == picture()
    assert board.client("onlooker").get("/robots/quadruped/frame.jpg").status_code == 403


def change_robot(board: RunningBoard, **changes: Any) -> None:
    with local_admin.writing(board.settings) as connection:
        management.change_robot(connection, "shell", "quadruped", **changes)


# -------------------------------------------------------------------- images in posts
def upload(client: httpx2.Client, data: bytes, **headers: str) -> httpx2.Response:
    return client.post("/images", files={"file": ("any name.jpg", data)}, headers=headers)


@pytest.mark.parametrize(("kind", "media_type"), [("JPEG", "image/jpeg"), ("PNG", "image/png")])
def test_a_picture_can_be_attached_to_a_post(board: RunningBoard, kind: str, media_type: str) -> None:
    robot = board.client("quadruped")
    data = picture(kind=kind)
    image = upload(robot, data).json()
    assert (image["width"], image["height"]) == (64, 48)
    body = {"board_id": "talk", "title": "t", "body": "look", "images": [image["id"]]}
    post = robot.post("/topics", json=body).json()["post"]
    assert post["images"] == [image]
    got = board.client("member").get(image["url"])
    assert (got.content, got.headers["content-type"]) == (data, media_type)
    assert board.client().get(image["url"]).status_code in (303, 401)
    more = upload(robot, picture(10, 10)).json()
    edited = robot.patch(f"/posts/{post['id']}", json={"body": "look", "images": [more["id"]]}).json()
    assert edited["images"] == [image, more]


def test_a_picture_of_a_removed_post_is_gone(board: RunningBoard) -> None:
    op = board.client("op")
    image = upload(op, picture()).json()
    assert board.client("member").get(image["url"]).status_code == 404, "nobody's business before it is posted"
    post = op.post("/topics", json={"board_id": "talk", "title": "t", "body": "x", "images": [image["id"]]}).json()[
        "post"
    ]
    assert board.client("member").get(image["url"]).status_code == 200
    op.delete(f"/posts/{post['id']}")
    assert board.client("member").get(image["url"]).status_code == 404


def test_only_the_uploader_may_attach_a_picture(board: RunningBoard) -> None:
    image = upload(board.client("quadruped"), picture()).json()
    body = {"board_id": "talk", "title": "t", "body": "x", "images": [image["id"]]}
    assert board.client("op").post("/topics", json=body).json()["code"] == "no_such_image"
    assert board.client("quadruped").post("/topics", json=body | {"images": ["x"]}).json()["code"] == "no_such_image"


def test_an_upload_with_a_used_key_is_one_image(board: RunningBoard) -> None:
    op = board.client("op")
    first, second = (upload(op, picture(n, n), **{"Idempotency-Key": "img"}) for n in (5, 6))
    assert (first.status_code, second.status_code) == (201, 200)
    assert first.json() == second.json()


def test_members_may_not_upload(board: RunningBoard) -> None:
    answer = upload(board.client("member"), picture())
    assert (answer.status_code, answer.json()["code"]) == (403, "no_uploads")


@pytest.mark.parametrize("data", [b"", b"<svg onload=alert(1)>", picture()[:200], b"GIF89a" + b"0" * 100])
def test_a_file_that_is_not_a_picture_is_refused(board: RunningBoard, data: bytes) -> None:
    answer = upload(board.client("op"), data)
    assert (answer.status_code, answer.json()["code"]) == (415, "bad_image")


def test_pictures_are_limited_in_bytes_and_pixels(board: RunningBoard) -> None:
    too_big = upload(board.client("op"), b"\xff\xd8" + b"0" * images.MAX_BYTES)
    assert too_big.status_code == 413
    bomb = io.BytesIO()
    Image.new("1", (6000, 6000)).save(bomb, format="PNG")
    answer = upload(board.client("op"), bomb.getvalue())
    assert (answer.status_code, answer.json()["code"]) == (413, "image_too_large")


def moving(frames: int = 5, kind: str = "WEBP", size: tuple[int, int] = (32, 24), **options: object) -> bytes:
    out = io.BytesIO()
    first, *others = (Image.new("RGB", size, (40 * k % 256, 100, 50)) for k in range(frames))
    first.save(out, format=kind, save_all=True, append_images=others, duration=100, **options)
    return out.getvalue()


@pytest.mark.parametrize("kind", ["WEBP", "GIF"])
def test_an_animation_is_served_unchanged(board: RunningBoard, kind: str) -> None:
    op, data = board.client("op"), moving(kind=kind)
    image = upload(op, data)
    assert (image.status_code, image.json()["width"]) == (201, 32)
    shown = op.get(image.json()["url"])
    assert (shown.headers["content-type"], shown.content) == (f"image/{kind.lower()}", data)


@pytest.mark.parametrize("frames", [images.MAX_FRAMES + 1, 60])
def test_an_animation_is_limited_in_frames_and_total_pixels(frames: int) -> None:
    data = moving(frames, "GIF", (4, 4))
    if frames <= images.MAX_FRAMES:  # small frames on a large screen are as large to whoever shows them
        data = data[:6] + struct.pack("<HH", 1400, 1200) + data[10:]
    with pytest.raises(BoardError) as refused:
        images.check(data)
    assert (refused.value.status, refused.value.code) == (413, "image_too_large")


def test_a_broken_animation_or_one_with_metadata_is_refused() -> None:
    exif = Image.Exif()
    exif[0x013B] = "Jane Doe"
    for data in (moving(20)[:-40], moving(exif=exif)):
        with pytest.raises(BoardError) as refused:
            images.check(data)
        assert (refused.value.status, refused.value.code) == (415, "bad_image")
    image, data = images.check(picture(64, 48, kind="WEBP", exif=exif))
    assert b"Jane" not in data
    assert image.media_type == "image/webp"


def test_location_and_owner_in_exif_are_removed() -> None:
    exif = Image.Exif()
    exif[0x013B] = "Jane Doe"
    exif[0x0112] = 6  # rotated
    image, data = images.check(picture(64, 48, exif=exif))
    assert b"Jane" not in data
    assert (image.width, image.height) == (48, 64)
    with Image.open(io.BytesIO(data)) as upright:
        assert upright.size == (48, 64)


def test_data_after_the_end_of_a_picture_is_removed() -> None:
    out = io.BytesIO()
    first, second = (Image.new("RGB", (64, 48), colour) for colour in ("red", "blue"))
    first.save(out, format="MPO", save_all=True, append_images=[second])
    image, data = images.check(out.getvalue())
    assert (image.width, image.height, image.media_type) == (64, 48, "image/jpeg")
    with Image.open(io.BytesIO(data)) as plain:
        assert plain.format == "JPEG"


def test_a_folder_that_cannot_be_written_is_503(tmp_path: object) -> None:
    from pathlib import Path

    blocked = Path(str(tmp_path)) / "file"
    blocked.write_text("in the way")
    with pytest.raises(BoardError) as caught:
        images.keep(blocked, b"x")
    assert caught.value.status == 503
