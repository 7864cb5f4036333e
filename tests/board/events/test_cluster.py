"""Several server processes serve one forum on one PostgreSQL database; each sees what the others accepted, also after
one of them was killed."""

from __future__ import annotations

import json
import re
import statistics
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import httpx2
import pytest
from sqlalchemy import create_engine, select, text

from agentrob.board.admin import local_admin, serving_lock
from agentrob.board.auth import attempts
from agentrob.board.auth.attempts import PER_NAME
from agentrob.board.db import schema as db
from agentrob.board.db.database import WRITING_LOCK, migrate
from agentrob.board.events.hub import PROVEN_S
from agentrob.errors import BoardError
from tests.board.auth.test_rights import jpeg
from tests.board.board_processes import BoardProcess, Forum, forum_of, fresh_postgres
from tests.board.events.test_streams import now, post_topic, stream, until
from tests.board.events.test_webhooks import receiver
from tests.board.robots.test_robots import picture, pictures
from tests.board.running_board import LIMIT_S
from tests.waiting import wait_for

pytestmark = pytest.mark.slow
#: A stop must reach the agent within this time.
STOP_S = 0.25


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    with fresh_postgres() as url:
        yield url


@pytest.fixture(scope="module")
def forum(server: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Forum]:
    """Serve a forum with two processes that start at the same time on an empty database."""
    with forum_of(server, tmp_path_factory.mktemp("forum")) as made:
        yield made


# -------------------------------------------------------------------- starting
def test_two_processes_that_start_together_create_the_database_once(forum: Forum) -> None:
    for process in forum.processes:
        boards = forum.as_("op", process).get("/boards").json()["items"]
        assert [b["id"] for b in boards] == ["robots", "talk"]
    engine = create_engine(forum.settings.database)
    with engine.connect() as connection:
        assert connection.execute(text("SELECT count(*) FROM alembic_version")).scalar_one() == 1
    engine.dispose()


def test_a_served_forum_cannot_be_restored_or_migrated(forum: Forum) -> None:
    with (
        pytest.raises(BoardError, match="served by other processes") as caught,
        serving_lock.exclusive_access(forum.settings),
    ):
        pass
    assert caught.value.code == "already_served"
    with pytest.raises(BoardError, match="another process serves the forum"):
        migrate(forum.settings, "0004_meanings")
    migrate(forum.settings)


def test_a_process_with_a_wrong_clock_is_refused(forum: Forum, monkeypatch: pytest.MonkeyPatch) -> None:
    """Law 5: the age of a post is judged by the clock of the process that accepted it."""
    with serving_lock.serve_database(forum.settings):
        pass
    behind = time.time() - 3.0
    monkeypatch.setattr(serving_lock, "time", SimpleNamespace(time=lambda: behind))
    with pytest.raises(BoardError, match="behind the database's"), serving_lock.serve_database(forum.settings):
        pass


# -------------------------------------------------------------------- events and reads
def test_events_of_both_processes_come_in_one_order(forum: Forum) -> None:
    op = [forum.as_("op", process) for process in forum.processes]
    topic = post_topic(op[0])["topic"]["id"]
    start, count = now(op[0]), 30

    def write(number: int) -> str:
        answer = op[number % 2].post(f"/topics/{topic}/posts", json={"body": str(number)})
        return str(answer.raise_for_status().json()["post"]["id"])

    with stream(forum.as_("member", forum.b), after=start) as at_b, stream(forum.as_("member", forum.a)) as at_a:
        with ThreadPoolExecutor(4) as pool:
            written = sorted(pool.map(write, range(count)), key=int)
        told = [[e["data"]["post"]["id"] for e in until(events, count)] for events in (at_a, at_b)]
    assert told == [written, written]
    changes = op[0].get("/changes", params={"after": start}).json()
    assert [e["post"]["id"] for e in changes["items"]] == written


def test_a_key_used_on_both_processes_creates_one_post(forum: Forum) -> None:
    """Law 6: an agent's claim uses such a key, so no post is claimed twice."""
    clients = [forum.as_("quadruped", process) for process in forum.processes]
    topic = post_topic(clients[0])["topic"]["id"]

    def write(number: int) -> tuple[int, str]:
        key = {"Idempotency-Key": f"claim:{number // 4}"}
        answer = clients[number % 2].post(f"/topics/{topic}/posts", json={"body": "x"}, headers=key)
        return answer.status_code, answer.json()["post"]["id"]

    with ThreadPoolExecutor(4) as pool:
        answers = list(pool.map(write, range(40)))
    for n in range(10):
        same = answers[4 * n : 4 * n + 4]
        assert sorted(status for status, _ in same) == [200, 200, 200, 201]
        assert len({post for _, post in same}) == 1


def test_a_post_hidden_on_one_process_is_hidden_on_the_other_at_once(forum: Forum) -> None:
    admin, reader = forum.as_("admin", forum.a), forum.as_("member", forum.b)
    made = post_topic(forum.as_("op", forum.a), "the words")
    topic, post = made["topic"]["id"], made["post"]["id"]
    shown = lambda: reader.get(f"/topics/{topic}/posts").json()["items"][0]  # noqa: E731
    with stream(forum.as_("member", forum.b)) as events:
        for _ in range(10):
            assert [shown()["raw"] for _ in range(3)] == ["the words"] * 3, "until it is hot"
            admin.post(f"/posts/{post}/hide", json={"reason": "x"}).raise_for_status()
            assert (shown()["removed"], shown()["raw"]) == (True, "")
            admin.post(f"/posts/{post}/show", json={}).raise_for_status()
        kinds = [e["event"] for e in until(events, 20)]
    assert kinds == ["post.removed", "post.edited"] * 10


def test_a_right_revoked_on_one_process_is_revoked_on_the_other_at_once(forum: Forum) -> None:
    admin = forum.as_("admin", forum.a)
    forum.add("leaver")
    leaver = forum.as_("leaver", forum.b)
    topic = post_topic(leaver)["topic"]["id"]
    get = lambda: leaver.get(f"/topics/{topic}/posts").status_code  # noqa: E731
    change = lambda path, **new: admin.patch(f"/admin/{path}", json=new).raise_for_status()  # noqa: E731
    assert [get() for _ in range(3)] == [200] * 3
    change("boards/talk", read_role="moderator", post_role="moderator")
    assert get() == 404
    change("boards/talk", read_role="guest", post_role="member")
    assert [get() for _ in range(3)] == [200] * 3
    change("accounts/leaver", suspended=True)
    assert get() == 403
    local_admin.revoke_tokens(forum.settings, local_admin.find_account(forum.settings, "leaver"))
    assert get() == 401


# -------------------------------------------------------------------- stops
def test_law_14_a_stop_on_one_process_is_heard_on_the_other_in_a_quarter_of_a_second(forum: Forum) -> None:
    member = forum.as_("member", forum.a)
    took = []
    with stream(forum.as_("quadruped", forum.b), heartbeat=0.25) as events:
        for _ in range(9):
            pressed_s = time.monotonic()
            member.post("/robots/quadruped/stop").raise_for_status()
            (stop,) = until(events, 1)
            took.append(time.monotonic() - pressed_s)
            assert (stop["event"], stop["data"]["account"]["name"]) == ("robot.stop", "member")
    assert statistics.median(took) < STOP_S, took


def kinds(client: httpx2.Client, after: str) -> list[str]:
    return [e["kind"] for e in client.get("/changes", params={"after": after}).json()["items"]]


def test_law_15_a_stop_that_cannot_be_written_is_heard_on_the_other_process(forum: Forum) -> None:
    op = forum.as_("op", forum.a)
    newest = now(op)
    engine = create_engine(forum.settings.database, isolation_level="AUTOCOMMIT")
    with (
        stream(forum.as_("quadruped", forum.b), heartbeat=0.25) as events,
        engine.connect() as hung,
        ThreadPoolExecutor(1) as pool,
    ):
        next(events)
        hung.execute(text(f"SELECT pg_advisory_lock({WRITING_LOCK})"))
        try:
            pressed_s = time.monotonic()
            pressing = pool.submit(op.post, "/robots/quadruped/stop")
            (stop,) = until(events, 1)
            took = time.monotonic() - pressed_s
            pressing.result(LIMIT_S).raise_for_status()
        finally:
            hung.execute(text(f"SELECT pg_advisory_unlock({WRITING_LOCK})"))
        assert (stop["event"], stop["data"]["robot"]) == ("robot.stop", "quadruped")
        assert (stop["data"]["account"]["name"], stop["id"]) == ("op", newest)
        assert took < 0.25, "before who pressed was answered"
        wait_for(lambda: kinds(op, newest) == ["robot.stop"])
        post_topic(op)
        assert until(events, 1)[0]["event"] == "post.created", "nobody hears it again when it was written after all"
    engine.dispose()


def test_law_16_a_process_that_cannot_hear_the_others_sends_no_heartbeat(forum: Forum) -> None:
    """An agent treats silence as the loss of its stop channel. The heartbeat resumes by itself."""
    patient = forum.as_("quadruped", forum.b)
    patient.timeout = httpx2.Timeout(LIMIT_S, read=2.0)
    with stream(patient, heartbeat=0.25) as events:
        assert [next(events)["event"] for _ in range(3)] == ["heartbeat"] * 3
        with forum.database_blocked():
            gone_s = time.monotonic()
            last_s = gone_s
            try:
                while next(events)["event"] == "heartbeat":
                    last_s = time.monotonic()
                pytest.fail("nothing but beats can come")
            except httpx2.ReadTimeout:
                pass
            assert last_s - gone_s < PROVEN_S + 1.0
            assert forum.as_("op", forum.b).post("/robots/quadruped/stop").status_code == 503
    again = forum.as_("quadruped", forum.b)
    wait_for(lambda: again.get("/changes").status_code == 200)
    with stream(again, heartbeat=0.25) as events:
        assert [next(events)["event"] for _ in range(3)] == ["heartbeat"] * 3
        wait_for(lambda: forum.as_("op", forum.a).post("/robots/quadruped/stop").status_code == 200)
        assert until(events, 1)[0]["event"] == "robot.stop"


# -------------------------------------------------------------------- signing in
def test_a_session_is_valid_on_both_processes(forum: Forum) -> None:
    local_admin.create_account(forum.settings, "ann", password="correct horse")
    with httpx2.Client(timeout=LIMIT_S) as browser:
        sign_in(browser, forum.a.url, "ann", "correct horse")
        assert [browser.get(p.url + "/api/v1/me").json()["name"] for p in forum.processes] == ["ann", "ann"]


def test_read_positions_reach_the_other_process(forum: Forum) -> None:
    topic = post_topic(forum.as_("op", forum.a))["topic"]["id"]
    here, there = (forum.as_("member", process) for process in forum.processes)

    def new(client: httpx2.Client) -> list[str]:
        return [item["topic"]["id"] for item in client.get("/unread").json()["items"]]

    assert topic in new(here)
    assert topic in new(there)
    here.put(f"/topics/{topic}/read", json={}).raise_for_status()
    assert topic not in new(here)
    wait_for(lambda: topic not in new(there))


def test_password_guesses_are_counted_across_processes(forum: Forum) -> None:
    local_admin.create_account(forum.settings, "eve", password="correct horse")
    with httpx2.Client(timeout=LIMIT_S) as browser:
        urls = [p.url for p in forum.processes]
        statuses = [sign_in(browser, urls[n % 2], "eve", "wrong words") for n in range(PER_NAME)]
        assert statuses == [401] * PER_NAME
        assert [sign_in(browser, url, "eve", "correct horse") for url in urls] == [429, 429]
    with local_admin.writing(forum.settings) as connection:
        attempts.clear(connection, "eve", "127.0.0.1")
        connection.execute(db.attempts.delete())


def sign_in(browser: httpx2.Client, url: str, name: str, password: str) -> int:
    page = browser.get(url + "/sign-in").text
    csrf = re.search(r'name="csrf" value="([^"]*)"', page)
    assert csrf
    return browser.post(url + "/sign-in", data={"csrf": csrf[1], "name": name, "password": password}).status_code


# -------------------------------------------------------------------- robots
def test_a_robots_presence_on_one_process_is_seen_on_the_other(forum: Forum) -> None:
    robot, viewer = forum.as_("quadruped", forum.a), forum.as_("member", forum.b)
    card = {"model": "go2", "state": "idle", "battery_percent": 81.5, "odd": "机器\u0000人"}
    robot.put("/robots/quadruped", json={"card": card}).raise_for_status()
    wait_for(lambda: viewer.get("/robots/quadruped").json()["card"] == card)
    seen = [forum.as_("member", p).get("/robots/quadruped").json()["seen_at"] for p in forum.processes]
    assert all(seen)
    first, second = picture(64, 48), picture(32, 24)
    path = "/robots/quadruped/frame"
    assert robot.put(path, content=first).json() == {"viewers": 0}
    wait_for(lambda: viewer.get("/robots/quadruped/frame.jpg").content == first)
    with viewer.stream("GET", "/robots/quadruped/camera.mjpg") as stream_at_b:
        wait_for(lambda: robot.put(path, content=second).json() == {"viewers": 1})
        shown = pictures(stream_at_b)
        while next(shown) != second:
            pass
        robot.put(path, content=first)
        while next(shown) != first:
            pass
    wait_for(lambda: robot.put(path, content=first).json() == {"viewers": 0})
    assert forum.as_("member", forum.a).get("/robots/quadruped").json()["viewers"] == 0


def test_poses_sent_to_one_process_reach_the_viewers_of_the_other(forum: Forum) -> None:
    robot, path = forum.as_("quadruped", forum.a), "/robots/quadruped/pose"
    robot.put("/robots/quadruped", json={"card": {"boards": ["robots"]}}).raise_for_status()
    wait_for(lambda: forum.as_("member", forum.b).get("/robots/quadruped").json()["card"] != {})
    with forum.as_("member", forum.b).stream("GET", "/poses?robots=quadruped") as stream:
        lines = (line for line in stream.iter_lines() if '"pose"' in line)
        wait_for(lambda: robot.put(path, json={"pose": [0, 0, 0]}).json()["viewers"] == 1)
        robot.put(path, json={"pose": [1.5, 0, 0], "plan": [[0, 0]] * 200, "trail": [[0, 0]] * 500}).raise_for_status()
        assert any("[1.5,0.0,0.0]" in line for line in lines), "also with a way that a notification cannot hold"
    wait_for(lambda: robot.put(path, json={"pose": [0, 0, 0]}).json()["viewers"] == 0)


def test_camera_frames_are_deleted_from_the_database_when_no_longer_live(forum: Forum) -> None:
    forum.as_("quadruped", forum.a).put("/robots/quadruped/frame", content=picture()).raise_for_status()
    engine = create_engine(forum.settings.database, isolation_level="AUTOCOMMIT")
    kept = select(db.stage.c.frame).where(db.stage.c.frame.is_not(None))
    with engine.connect() as connection:
        wait_for(lambda: connection.execute(kept).first() is not None)
        connection.execute(text("UPDATE stage SET shown_us = shown_us - 20000000"))
        wait_for(lambda: connection.execute(kept).first() is None)
    engine.dispose()


def test_a_picture_posted_on_one_process_is_served_by_the_other(forum: Forum) -> None:
    op = forum.as_("op", forum.a)
    image = op.post("/images", files={"file": ("x.jpg", jpeg(7), "image/jpeg")}).json()["id"]
    op.post("/topics", json={"board_id": "talk", "title": "t", "body": "see", "images": [image]}).raise_for_status()
    headers = {"Authorization": f"Bearer {forum.tokens['member']}"}
    got = [httpx2.get(f"{p.url}/images/{image}", headers=headers, timeout=60) for p in forum.processes]
    assert [g.status_code for g in got] == [200, 200]
    assert got[0].content == got[1].content


# -------------------------------------------------------------------- when one dies
def test_when_one_process_is_killed_the_other_takes_over(server: str, tmp_path: Path) -> None:
    with receiver(200) as (url, got), forum_of(server, tmp_path, hooks={"agent": (url, "secret-of-both")}) as forum:
        wait_for(lambda: any("has_the_duties" in p.logged for p in forum.processes))
        assert sum("has_the_duties" in p.logged for p in forum.processes) == 1
        lead, other = sorted(forum.processes, key=lambda p: "has_the_duties" not in p.logged)
        for process in forum.processes:
            post_topic(forum.as_("op", process))
        told = [json.loads(got.get(timeout=LIMIT_S)[1]) for _ in range(2)]
        assert len({t["data"]["post"] for t in told}) == 2, "each is told once, wherever it was written"
        acknowledged = _killed_while_writing(forum, lead, other)
        wait_for(lambda: "has_the_duties" in other.logged)
        with stream(forum.as_("member", other), after=acknowledged.pop("start")) as events:
            post = post_topic(forum.as_("op", other), "the last")["post"]["id"]
            ids = []
            while not ids or ids[-1] != post:
                ids.append(until(events, 1)[0]["data"]["post"]["id"])
        assert ids == sorted(set(ids), key=int), "each once and in order"
        assert set(acknowledged.values()) <= set(ids), "nothing that was acknowledged is lost"
        said = set[str]()
        while not {"board.changed", post} <= said:
            what = json.loads(got.get(timeout=LIMIT_S)[1])
            said.add(what["data"].get("post") or what["type"])


def _killed_while_writing(forum: Forum, lead: BoardProcess, other: BoardProcess) -> dict[str, str]:
    """Return the posts that `lead` acknowledged before it was killed, and the event before them."""
    writer = forum.as_("op", lead)
    found = {"start": now(forum.as_("op", other))}
    topic = post_topic(writer)["topic"]["id"]
    enough = threading.Event()

    def write() -> None:
        for number in range(10_000):
            try:
                answer = writer.post(f"/topics/{topic}/posts", json={"body": str(number)})
            except httpx2.HTTPError:
                return
            found[str(number)] = answer.json()["post"]["id"]
            if number == 20:
                enough.set()

    thread = threading.Thread(target=write)
    thread.start()
    assert enough.wait(LIMIT_S)
    lead.kill()
    thread.join(LIMIT_S)
    started_s = time.monotonic()
    post_topic(forum.as_("op", other), "soon after")
    assert time.monotonic() - started_s < 2.0, "the dead one keeps nobody waiting"
    return found
