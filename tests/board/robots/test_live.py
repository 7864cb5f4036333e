"""Live maps and replays: who sees them, what viewers receive, and what robots' agents may send."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta
from functools import partial
from typing import Any

import httpx2
import pytest

from agentrob.board.admin import moderation, retention
from agentrob.board.events import poses
from agentrob.board.robots import geometry, live, replays
from agentrob.config.board import BoardRetentionConfig
from agentrob.model import EventKind
from tests.board.robots.test_robots import _listen
from tests.board.running_board import RunningBoard
from tests.waiting import wait_for

MAP = {
    "room": "lab",
    "size_m": [8, 6],
    "fence": [[-2, -2], [2, -2], [2, 2], [-2, 2]],
    "things": [{"name": "table", "at_m": [1, -2], "size_m": [1.2, 0.7], "colour": "#996940"}],
    "pose": [0.5, 1.0, 1.57],
    "geometry": "",
}
CARD = {"model": "go2", "boards": ["robots"], "map": MAP}
REPLAY = {
    "version": 1,
    "robot": "quadruped",
    "map": MAP,
    "geometry": "",
    "plan": [[0, 0], [1, 0]],
    "steps": [[0, "move forward 1 m"]],
    "t": [0, 100, 100],
    "pose": [[0, 500, 500], [0, 10, -10], [0, 0, 0]],
    "body": [],
}


def packed(replay: dict[str, Any]) -> bytes:
    return gzip.compress(json.dumps(replay).encode())


def messages(response: httpx2.Response) -> Iterator[dict[str, Any]]:
    """The data of a stream's events."""
    for line in response.iter_lines():
        if line.startswith("data: "):
            yield json.loads(line.removeprefix("data: "))


def show(robot: httpx2.Client, x: float, **more: Any) -> dict[str, Any]:
    answer = robot.put("/robots/quadruped/pose", json={"pose": [x, 0, 0], **more})
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


@pytest.fixture
def board(fresh_board: Callable[..., RunningBoard]) -> RunningBoard:
    made = fresh_board()
    made.client("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
    return made


# -------------------------------------------------------------------- poses
def test_viewers_receive_the_poses_and_the_way_of_a_command(board: RunningBoard) -> None:
    robot = board.client("quadruped")
    assert show(robot, 0) == {"viewers": 0, "every_s": poses.MAP_EVERY_S, "body": False}
    with board.client("member").stream("GET", "/poses?robots=quadruped") as stream:
        told = messages(stream)
        assert next(told) == {"robot": "quadruped", "plan": [], "trail": [[0.0, 0.0]]}
        assert next(told)["pose"] == [0.0, 0.0, 0.0]
        assert (
            show(robot, 0.5, plan=[[0, 0], [1, 0]], trail=[[0, 0], [0.5, 0]], body=[0.3, 1, 0, 0, 0, 0.7])["viewers"]
            == 1
        )
        assert next(told) == {"robot": "quadruped", "plan": [[0.0, 0.0], [1.0, 0.0]], "trail": [[0.0, 0.0], [0.5, 0.0]]}
        seen = next(told)
        assert seen["pose"] == [0.5, 0.0, 0.0]
        assert "body" not in seen, "the map needs no joint angles"
    wait_for(lambda: board.services.presence.poses.robot("quadruped").viewers == 0)
    assert show(robot, 1)["viewers"] == 0


def test_the_3d_view_also_receives_the_body_and_more_often(board: RunningBoard) -> None:
    robot = board.client("quadruped")
    with board.client("member").stream("GET", "/poses?robots=quadruped&body=1") as stream:
        answer = show(robot, 1, body=[0.3, 1, 0, 0, 0, 0.7])
        assert answer == {"viewers": 1, "every_s": poses.BODY_EVERY_S, "body": True}
        told = next(one for one in messages(stream) if "pose" in one)
        assert told["body"] == [0.3, 1.0, 0.0, 0.0, 0.0, 0.7]


def test_a_viewer_that_does_not_read_misses_poses_and_nothing_is_queued(board: RunningBoard) -> None:
    tracker = board.services.presence.poses

    async def look_at_three() -> tuple[bytes, int]:
        channel = tracker.enter(("quadruped",), False, None)
        try:
            for x in (1.0, 2.0, 3.0):
                tracker.show("quadruped", {"pose": [x, 0, 0], "body": []})
            return channel.now(), len(channel.waiters)
        finally:
            tracker.leave(channel, None)

    newest, waiting = board.run(look_at_three())
    assert newest.count(b'"pose"') == 1
    assert b"[3.0," in newest
    assert waiting == 0
    assert not tracker._channels


def test_the_robots_agent_is_told_of_viewers_and_again_if_it_missed_that(board: RunningBoard) -> None:
    listener = board.run(_listen(board))

    def told() -> int:
        return sum(h.event.kind is EventKind.ROBOT_POSES for h in listener._pending)

    robot = board.client("quadruped")
    with board.client("member").stream("GET", "/poses?robots=quadruped"):
        wait_for(lambda: told() == 1)
        board.services.presence.poses.robot("quadruped").called_s -= 10
        robot.put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        wait_for(lambda: told() == 2)
        show(robot, 1)
        board.services.presence.poses.robot("quadruped").called_s -= 10
        robot.put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        assert told() == 2, "it sends poses"


@pytest.mark.parametrize(
    ("frame", "status"),
    [
        ({"pose": [0, 0]}, 422),
        ({"pose": [0, 0, "x"]}, 422),
        ({"pose": [0, 1e9, 0]}, 422),
        ({"pose": [0, 0, 0], "body": [0] * 81}, 422),
        ({"pose": [0, 0, 0], "more": 1}, 422),
    ],
)
def test_a_malformed_pose_is_refused(board: RunningBoard, frame: dict[str, Any], status: int) -> None:
    assert board.client("quadruped").put("/robots/quadruped/pose", json=frame).status_code == status


def test_only_the_robots_own_agent_sends_its_poses(board: RunningBoard) -> None:
    answer = board.client("op").put("/robots/quadruped/pose", json={"pose": [0, 0, 0]})
    assert (answer.status_code, answer.json()["code"]) == (403, "not_this_robot")


def test_a_stream_names_robots_that_there_are(board: RunningBoard) -> None:
    member = board.client("member")
    assert member.get("/poses?robots=").status_code == 422
    assert member.get("/poses?robots=" + ",".join(["quadruped"] * 21)).status_code == 422
    unknown = member.get("/poses?robots=quadruped,nobody")
    assert unknown.status_code == 404
    assert "quadruped" in unknown.text


# -------------------------------------------------------------------- rights
def test_the_map_is_for_readers_of_the_robots_boards_also_while_it_is_open(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    member, admin = board.client("member"), board.client("admin")
    assert member.get("/robots/quadruped/map").json()["map"]["room"] == "lab"
    assert "map" not in member.get("/robots/quadruped").json()["card"], "the card is for all readers"
    with member.stream("GET", "/poses?robots=quadruped") as stream:
        assert stream.status_code == 200
        admin.patch(
            "/admin/boards/robots", json={"read_role": "moderator", "post_role": "moderator"}
        ).raise_for_status()
        assert list(stream.iter_lines())[-1] == "", "the stream has ended"
    for path in ("/poses?robots=quadruped", "/robots/quadruped/map"):
        answer = member.get(path)
        assert (answer.status_code, answer.json()["code"]) == (403, "no_map")
    assert admin.get("/robots/quadruped/map").status_code == 200


# -------------------------------------------------------------------- replays
def command(board: RunningBoard) -> str:
    new = {"board_id": "robots", "title": "Walk", "body": "@quadruped walk 1 m"}
    answer = board.client("op").post("/topics", json=new)
    return str(answer.json()["post"]["id"])


def test_a_replay_is_kept_and_can_be_read_by_readers_of_its_post(board: RunningBoard) -> None:
    post, robot, member = command(board), board.client("quadruped"), board.client("member")
    path = f"/commands/{post}/replay"
    assert member.get(path, params={"robot": "quadruped"}).status_code == 404
    assert robot.put(path, content=packed(REPLAY)).status_code == 200
    assert member.get(path, params={"robot": "quadruped"}).json() == REPLAY
    plain = member.get(path, params={"robot": "quadruped"}, headers={"Accept-Encoding": "identity"})
    assert "content-encoding" not in plain.headers
    assert plain.json() == REPLAY
    later = REPLAY | {"plan": []}
    robot.put(path, content=packed(later)).raise_for_status()
    assert member.get(path, params={"robot": "quadruped"}).json() == later, "a later one replaces it"
    board.client("op").delete(f"/posts/{post}").raise_for_status()
    assert member.get(path, params={"robot": "quadruped"}).status_code == 404, "a removed post has no replay"


@pytest.mark.parametrize(
    ("sent", "code"),
    [
        (b"no gzip", "bad_replay"),
        (gzip.compress(b"[1]"), "bad_replay"),
        (gzip.compress(b"{}"), "bad_replay"),
        (packed(REPLAY)[:-9], "bad_replay"),
        (gzip.compress(b" " * (replays.MOST_TEXT + 1)), "bad_replay"),
        (b"x" * (replays.MOST_BYTES + 1), "replay_too_large"),
    ],
    # The bytes hold the second in which they were compressed; as an id they would differ between the workers of a run.
    ids=["not gzip", "a list", "empty", "cut off", "too much text", "too many bytes"],
)
def test_what_is_no_replay_is_refused(board: RunningBoard, sent: bytes, code: str) -> None:
    answer = board.client("quadruped").put(f"/commands/{command(board)}/replay", content=sent)
    assert answer.json()["code"] == code
    assert "gzipped" in answer.json()["hint"]


def test_people_publish_no_replays(board: RunningBoard) -> None:
    answer = board.client("op").put(f"/commands/{command(board)}/replay", content=packed(REPLAY))
    assert (answer.status_code, answer.json()["code"]) == (403, "not_a_robot")


def test_old_replays_are_deleted_and_those_of_erased_accounts(board: RunningBoard) -> None:
    post, robot = command(board), board.client("quadruped")
    robot.put(f"/commands/{post}/replay", content=packed(REPLAY)).raise_for_status()
    keep, do = BoardRetentionConfig(replay_days=30), board.services.store.do
    assert board.run(do(partial(retention.prune_replays, keep=keep))) is False
    found = partial(replays.replay_of, board.services.store.everything, post, "quadruped")
    assert found() is not None
    board.run(do(partial(retention.prune_replays, keep=keep, now=datetime.now(UTC) + timedelta(days=31))))
    assert found() is None
    robot.put(f"/commands/{post}/replay", content=packed(REPLAY)).raise_for_status()
    board.run(do(lambda t: moderation.erase(t, "admin", "op")))
    assert not board.services.store.everything.rows(replays.db.replays.select())


def test_the_final_map_of_a_replay_shows_the_whole_path(board: RunningBoard) -> None:
    shown = replays.final_map(packed(REPLAY))
    assert shown is not None
    assert shown.measured == "0.00,-0.00 0.50,-0.01 1.00,-0.00"
    assert shown.plan == "0.00,-0.00 1.00,-0.00"
    for broken in ({"pose": [[0]]}, {"pose": 1}, {"map": None}, {"pose": [[], [], []]}, {"plan": [1]}):
        assert replays.final_map(packed(REPLAY | broken)) is None


# -------------------------------------------------------------------- shapes
def test_the_shape_of_a_robot_is_stored_by_its_content_and_cached_for_ever(board: RunningBoard) -> None:
    shape = gzip.compress(b"\0\0\0\0shape")
    name = board.client("quadruped").put("/robots/quadruped/geometry", content=shape).json()["name"]
    answer = board.client("member").get(f"/geometry/{name}")
    assert answer.content == b"\0\0\0\0shape"
    assert "immutable" in answer.headers["cache-control"]
    assert board.client("member").get("/geometry/" + "0" * 32).status_code == 404
    assert board.client("member").get("/geometry/..%2f..%2fboard").status_code == 404
    assert board.client().get(f"/geometry/{name}").status_code == 401
    answer = board.client("quadruped").put("/robots/quadruped/geometry", content=b"no gzip")
    assert (answer.status_code, answer.json()["code"]) == (422, "bad_geometry")
    assert board.client("op").put("/robots/quadruped/geometry", content=shape).status_code == 403


def test_only_the_newest_shapes_are_kept(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(geometry, "MOST_FILES", 2)
    names = [geometry.store(tmp_path, gzip.compress(bytes([n]))) for n in range(4)]
    assert len([name for name in names if geometry.read(tmp_path, name)]) == 2
    assert geometry.read(tmp_path, names[-1])


# -------------------------------------------------------------------- maps
@pytest.mark.parametrize("told", [None, 1, "map", [], {}, {"room": 3}, {"room": ""}])
def test_what_is_no_map_is_not_shown(told: object) -> None:
    assert live.map_view(told) is None


def test_malformed_parts_of_a_map_are_left_out() -> None:
    things = [{"at_m": [0, 0]}, {"at_m": "ab", "radius_m": 1}, 3, {"at_m": [1, 2], "radius_m": 1, "colour": "url(x)"}]
    broken = {
        "room": "a",
        "size_m": [8, float("nan")],
        "fence": [[1, "x"], [1e9, 0], [1, 2]],
        "things": things,
        "pose": [1, 2],
    }
    shown = live.map_view(broken | {"geometry": "../x"})
    assert shown is not None
    assert (shown.size, shown.pose, shown.geometry) == (None, None, "")
    assert shown.fence == "1.00,-2.00"
    assert [(thing.x, thing.y, thing.colour) for thing in shown.things] == [(1.0, -2.0, "#9aa4b0")]


def test_robots_of_one_room_share_a_map_and_its_things_are_drawn_once() -> None:
    lab, own = live.map_view(MAP), live.map_view(MAP | {"room": "@c"})
    rooms = live.rooms([("c", own), ("a", lab), ("b", lab), ("d", None)])
    assert [[name for name, _ in room.robots] for room in rooms] == [["a", "b"], ["c"]]
    assert len(rooms[0].things) == 1
    assert rooms[0].box == "-4.30 -3.30 8.60 6.60"


def test_a_fence_that_is_partly_behind_walls_is_a_closed_line_inside_them() -> None:
    near = live.WALL_M

    def box(*corners: tuple[float, float]) -> set[tuple[float, float]]:
        return {(round(x, 6), round(y, 6)) for x, y in live.inside(corners, (8, 6))}

    inner = ((-2.0, -2.0), (2.0, -2.0), (2.0, 2.0), (-2.0, 2.0))
    assert live.inside(inner, (8, 6)) == list(inner)
    right = 4 - near
    assert box((1, -2), (9, -2), (9, 2), (1, 2)) == {(1, -2), (right, -2), (right, 2), (1, 2)}
    around = {(x, y) for x in (-right, right) for y in (near - 3, 3 - near)}
    assert box((-9, -9), (9, -9), (9, 9), (-9, 9)) == around
    assert box((5, 5), (9, 5), (9, 9), (5, 9)) == set()
    corner = box((2, 1), (6, 1), (6, 5), (2, 5))
    assert corner == {(2, 1), (right, 1), (right, 3 - near), (2, 3 - near)}
    (room,) = live.rooms([("rex", live.map_view(MAP | {"fence": [[1, -2], [9, -2], [9, 2], [1, 2]]}))])
    assert room.robots[0][1].fence.count(",") == 4
