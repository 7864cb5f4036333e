"""Who may read, post and command on which board; and that no cache outlives an edit or a revoked right."""

from __future__ import annotations

from collections.abc import Callable
from datetime import UTC, datetime, timedelta

import httpx2
import pytest

from agentrob.board.admin import local_admin, management, moderation
from agentrob.board.auth import rights
from agentrob.board.auth.rights import MaintenanceWindow, RobotSettings, hours_from_words
from agentrob.errors import BoardError
from agentrob.model import Role
from tests.board.running_board import RunningBoard

ROLES = ("guest", "member", "operator", "moderator", "admin")


def admin_api(board: RunningBoard) -> httpx2.Client:
    """Return an API client of an admin, with a token of scope `admin`."""
    account = local_admin.find_account(board.settings, "admin")
    token = local_admin.issue_token(board.settings, account, "chief", ("write", "admin"))
    client = board.client()
    client.headers["Authorization"] = f"Bearer {token}"
    return client


def client_with_role(board: RunningBoard, role: str) -> httpx2.Client:
    name = f"some-{role}"
    if name not in board.tokens:
        board.add(name, role=Role(role))
    return board.client(name)


def new_board(board: RunningBoard, name: str, **roles: str) -> str:
    boss = admin_api(board)
    if boss.post("/admin/boards", json={"id": name, "name": name, **roles}).status_code == 409:
        boss.patch(f"/admin/boards/{name}", json=roles).raise_for_status()
    return name


def topic_on(board: RunningBoard, where: str, body: str = "words") -> tuple[str, str]:
    """Start a topic as an admin other than the one that moderates."""
    if "author" not in board.tokens:
        board.have("author", role=Role.ADMIN)
    made = (
        board.client("author")
        .post("/topics", json={"board_id": where, "title": f"About {body}"[:100], "body": body})
        .json()
    )
    return made["topic"]["id"], made["post"]["id"]


# -------------------------------------------------------------------- boards
@pytest.mark.parametrize("least", ROLES[1:])
def test_a_board_exists_only_for_accounts_that_may_read_it(board: RunningBoard, least: str) -> None:
    where = new_board(board, f"read-{least}", read_role=least, post_role=max(least, "member", key=ROLES.index))
    before = board.client("admin").get("/changes").json()["now"]["id"]
    secret = f"a secret for {least}"
    topic, post = topic_on(board, where, secret)
    paths = [f"/topics/{topic}", f"/topics/{topic}/posts", f"/posts/{post}", f"/boards/{where}/topics"]
    for role in ROLES:
        client, reads = client_with_role(board, role), ROLES.index(role) >= ROLES.index(least)
        assert {client.get(path).status_code for path in paths} == {200 if reads else 404}, role
        assert (where in [b["id"] for b in client.get("/boards").json()["items"]]) is reads
        assert (secret in client.get("/changes", params={"after": before}).text) is reads
        browser = board.browser(f"some-{role}")
        pages = ["/", f"/b/{where}", f"/t/{topic}", f"/p/{post}/raw", f"/p/{post}/history", "/u/author"]
        shown = [path for path in pages if secret in browser.get(path).text]
        assert bool(shown) is reads, (role, shown)


def test_many_events_on_a_closed_board_do_not_delay_other_readers(board: RunningBoard) -> None:
    where = new_board(board, "noisy", read_role="admin", post_role="admin")
    topic, _ = topic_on(board, where)
    before = board.client("admin").get("/changes").json()["now"]["id"]
    for n in range(5):
        board.client("admin").post(f"/topics/{topic}/posts", json={"body": str(n)})
    topic_on(board, "talk", "for all")
    items = board.client("member").get("/changes", params={"after": before, "limit": 2}).json()["items"]
    assert [e["post"]["raw"] for e in items] == ["for all"]


def test_law_15_whoever_may_read_a_board_may_post_a_stop_there(board: RunningBoard) -> None:
    where = new_board(board, "writers", post_role="operator")
    topic, _ = topic_on(board, where)
    for role, words in {"guest": 403, "member": 403, "operator": 201}.items():
        client = client_with_role(board, role)
        assert client.post(f"/topics/{topic}/posts", json={"body": "hello"}).status_code == words
        assert client.post(f"/topics/{topic}/posts", json={"body": "@quadruped stop!"}).status_code == 201
    new = {"board_id": "talk", "title": "x", "body": "y"}
    assert client_with_role(board, "guest").post("/topics", json=new).status_code == 403


def test_public_reading_shows_only_boards_open_to_guests(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(public_read=True)
    new_board(board, "inside", read_role="member")
    topic, _ = topic_on(board, "inside")
    anybody = board.client()
    assert [b["id"] for b in anybody.get("/boards").json()["items"]] == ["robots", "talk"]
    assert anybody.get(f"/topics/{topic}").status_code == 404
    assert board.client("member").get(f"/topics/{topic}").status_code == 200


def test_an_open_stream_ends_when_the_right_to_read_is_revoked(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("agentrob.board.events.streams.RECHECK_S", 0.05)
    board.add("leaver", role=Role.OPERATOR)
    where = new_board(board, "lab", read_role="operator", post_role="operator")
    with board.client("leaver").stream("GET", "/events", params={"heartbeat": 1}) as response:
        lines = response.iter_lines()
        next(lines)
        local_admin.change_account(board.settings, local_admin.find_account(board.settings, "leaver"), role=Role.MEMBER)
        assert "lab" not in [b["id"] for b in board.client("leaver").get("/boards").json()["items"]]
        rest = list(lines)  # until the server ends it
    topic_on(board, where, "for operators")
    assert not any("for operators" in line for line in rest)


# -------------------------------------------------------------------- cached reads
def test_reads_reflect_edits_hidden_posts_and_revoked_rights_at_once(board: RunningBoard) -> None:
    topic, post = topic_on(board, "talk", "first")
    account = board.add("passing", role=Role.MEMBER)
    reader, author, boss = board.client("passing"), board.client("author"), admin_api(board)

    def seen() -> str:
        answer = reader.get(f"/topics/{topic}/posts")
        return str(answer.json()["items"][0]["raw"]) if answer.status_code == 200 else f"{answer.status_code}"

    for n in range(20):
        author.patch(f"/posts/{post}", json={"body": f"text {n}"}).raise_for_status()
        assert [seen(), seen()] == [f"text {n}"] * 2
    boss.post(f"/posts/{post}/hide", json={"reason": "x"}).raise_for_status()
    assert seen() == ""
    boss.post(f"/posts/{post}/show", json={}).raise_for_status()
    assert seen() == "text 19"
    boss.patch("/admin/boards/talk", json={"read_role": "operator", "post_role": "operator"}).raise_for_status()
    assert seen() == "404"
    boss.patch("/admin/boards/talk", json={"read_role": "guest", "post_role": "member"}).raise_for_status()
    assert seen() == "text 19"
    local_admin.change_account(board.settings, account, suspended=True)  # as another process would
    assert seen() == "403"
    local_admin.change_account(board.settings, account, suspended=False)
    assert seen() == "text 19"
    local_admin.revoke_tokens(board.settings, account)
    assert seen() == "401"


# -------------------------------------------------------------------- robots
def test_an_agent_can_read_its_robots_rights(board: RunningBoard) -> None:
    boss = admin_api(board)
    board.add("keeper", role=Role.OPERATOR)
    told = {"owner": "keeper", "command": {"risky": "owner"}, "approval": ["move"], "release": "nobody"}
    assert boss.patch("/admin/robots/quadruped", json=told).status_code == 200
    found = board.client("quadruped").get("/robots/quadruped/rights", params={"board_id": "robots"}).json()
    assert found["owner"] == "keeper"
    assert found["command"] == {"photo": "operator", "gesture": "operator", "move": "operator", "risky": "owner"}
    assert (found["approval"], found["release"], found["command_role"]) == (["move"], "nobody", "operator")
    assert board.client("keeper").patch("/admin/robots/quadruped", json={"approval": []}).status_code == 200
    assert board.client("keeper").patch("/admin/robots/quadruped", json={"owner": "op"}).status_code == 403
    assert board.client("op").patch("/admin/robots/quadruped", json={"approval": []}).status_code == 403
    assert boss.patch("/admin/robots/quadruped", json={"owner": "quadruped"}).status_code == 409


def test_law_2_no_setting_lets_a_role_below_operator_command(board: RunningBoard) -> None:
    boss = admin_api(board)
    for word in ("guest", "member", "everybody", ""):
        assert boss.patch("/admin/robots/quadruped", json={"command": {"move": word}}).status_code == 422
        assert boss.patch("/admin/boards/talk", json={"command_role": word}).status_code == 422
    with local_admin.writing(board.settings) as connection:
        for change in ({"command": {"move": "member"}}, {"approve": "guest"}, {"release": "member"}):
            with pytest.raises(BoardError):
                management.change_robot(connection, "shell", "quadruped", **change)


def test_camera_pictures_are_visible_to_the_configured_role_only(board: RunningBoard) -> None:
    boss, robot = admin_api(board), board.client("quadruped")
    picture = jpeg()
    robot.put("/robots/quadruped/frame", content=picture, headers={"Content-Type": "image/jpeg"}).raise_for_status()
    image = robot.post("/images", files={"file": ("x.jpg", picture, "image/jpeg")}).json()
    topic, _ = topic_on(board, "talk")
    robot.post(f"/topics/{topic}/posts", json={"body": "look", "images": [image["id"]]}).raise_for_status()
    boss.patch("/admin/robots/quadruped", json={"camera_role": "operator"}).raise_for_status()
    robot.put("/robots/quadruped/frame", content=picture, headers={"Content-Type": "image/jpeg"}).raise_for_status()
    for name, status in {"member": 403, "op": 200, "quadruped": 200}.items():
        client = board.client(name)
        found = [client.get(f"/robots/quadruped/{p}").status_code for p in ("frame.jpg",)]
        found.append(httpx2.get(f"{board.url}/images/{image['id']}", headers=client.headers, timeout=60).status_code)
        assert found == [status] * 2, name
    assert board.client("member").get("/robots/quadruped/camera.mjpg").status_code == 403
    boss.patch("/admin/robots/quadruped", json={"camera_role": "guest"}).raise_for_status()
    assert (
        httpx2.get(f"{board.url}/images/{image['id']}", headers=board.client("member").headers, timeout=60).status_code
        == 200
    )


def test_camera_pictures_expire(board: RunningBoard) -> None:
    robot, folder = board.client("quadruped"), board.settings.images_dir
    image = robot.post("/images", files={"file": ("x.jpg", jpeg(7), "image/jpeg")}).json()["id"]
    topic, _ = topic_on(board, "talk")
    post = robot.post(f"/topics/{topic}/posts", json={"body": "look", "images": [image]}).json()["post"]["id"]
    admin_api(board).patch("/admin/robots/quadruped", json={"camera_days": 2}).raise_for_status()
    digest = board.services.store.reader.image(image)[1]
    path = folder / digest[:2] / digest

    def expire(after: timedelta) -> None:
        at = datetime.now(UTC) + after
        gone = board.run(board.services.store.do(lambda t: moderation.expire_pictures(t, at)))
        board.run(board.services.store.do(lambda t: moderation.take_away(t, folder, gone)))

    expire(timedelta(hours=47))
    assert path.exists()
    expire(timedelta(hours=49))
    assert not path.exists()
    assert httpx2.get(f"{board.url}/images/{image}", headers=robot.headers, timeout=60).status_code == 404
    assert robot.get(f"/posts/{post}").json()["images"] == []
    gone = robot.patch(f"/posts/{post}", json={"body": "look", "images": [image]})
    assert (gone.status_code, gone.json()["code"]) == (404, "no_such_image")
    for n in (8, 9):  # the post can still be edited, and shows new pictures
        more = robot.post("/images", files={"file": ("x.jpg", jpeg(n), "image/jpeg")}).json()["id"]
        edited = robot.patch(f"/posts/{post}", json={"body": f"look {n}", "images": [more]})
        assert (edited.status_code, edited.json().get("images", [{}])[-1].get("id")) == (200, more), edited.text
    assert len(edited.json()["images"]) == 2
    admin_api(board).patch("/admin/robots/quadruped", json={"camera_days": 0}).raise_for_status()


def test_the_reset_button_is_for_accounts_that_may_command_the_robot(board: RunningBoard) -> None:
    boss = admin_api(board)
    until = (datetime.now(UTC) + timedelta(hours=1)).isoformat()
    for change, status in [
        ({"command": {"move": "admin"}}, 403),
        ({"command": {"move": "operator"}}, 200),
        ({"closed": [{"until": until}]}, 403),
        ({"closed": []}, 200),
    ]:
        boss.patch("/admin/robots/quadruped", json=change).raise_for_status()
        answer = board.client("op").post("/robots/quadruped/reset")
        assert answer.status_code == status
        if "closed" in change and status == 403:
            assert answer.json()["detail"] == "this robot is in maintenance for another 1 hour"
        assert client_with_role(board, "guest").post("/robots/quadruped/stop").status_code == 200, "a stop is for all"


# -------------------------------------------------------------------- maintenance hours
@pytest.mark.parametrize(
    ("words", "at", "until"),
    [
        ("mon-fri 09:00-12:00", "2026-11-23T10:00Z", "2026-11-23T12:00Z"),
        ("mon-fri 09:00-12:00", "2026-11-22T10:00Z", None),
        ("mon-fri 09:00-12:00", "2026-11-23T12:00Z", None),
        ("fri-mon 22:00-06:00", "2026-11-23T05:59Z", "2026-11-23T06:00Z"),
        ("sun 22:00-06:00", "2026-11-23T05:59Z", "2026-11-23T06:00Z"),
        ("mon 22:00-06:00", "2026-11-23T05:59Z", None),
        ("mon 09:00-12:00 Europe/Berlin", "2026-11-23T08:30Z", "2026-11-23T11:00Z"),
        ("mon 09:00-12:00 Europe/Berlin", "2026-07-20T07:30Z", "2026-07-20T10:00Z"),
        ("mon 09:00-12:00; mon 12:00-13:00", "2026-11-23T10:00Z", "2026-11-23T13:00Z"),
        ("until 2026-12-01T00:00Z moving house", "2026-11-23T10:00Z", "2026-12-01T00:00Z"),
        ("until 2026-11-01T00:00Z", "2026-11-23T10:00Z", None),
        ("", "2026-11-23T10:00Z", None),
    ],
)
def test_maintenance_hours(words: str, at: str, until: str | None) -> None:
    kept = RobotSettings(closed=hours_from_words(words))
    assert kept.closed_until(datetime.fromisoformat(at)) == (datetime.fromisoformat(until) if until else None)
    assert hours_from_words(rights.hours_in_words(kept.closed)) == kept.closed


def test_a_robot_in_permanent_maintenance_is_answered_in_bounded_time() -> None:
    always = RobotSettings(
        closed=(MaintenanceWindow(start="00:00", end="12:00"), MaintenanceWindow(start="12:00", end="00:00"))
    )
    now = datetime(2026, 11, 23, 10, 0, tzinfo=UTC)
    until = always.closed_until(now)
    assert until is not None
    assert until - now > timedelta(days=399)


@pytest.mark.parametrize("words", ["mon", "mon 9-12", "mon 09:00-25:00", "xyz 09:00-10:00", "mon 09:00-10:00 Mars/X"])
def test_invalid_hours_are_refused_with_an_example(words: str) -> None:
    with pytest.raises(BoardError) as caught:
        hours_from_words(words)
    assert caught.value.hint


def jpeg(shade: int = 90) -> bytes:
    import io

    from PIL import Image

    file = io.BytesIO()
    Image.new("RGB", (64, 48), (shade, 90, 90)).save(file, "JPEG")
    return file.getvalue()
