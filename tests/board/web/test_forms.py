"""Pages without scripts: everything that people do on the forum works by links and forms."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing

import pytest
from structlog.testing import capture_logs

from agentrob.board.admin import local_admin
from agentrob.errors import BoardError
from tests.board.web.page_world import CARD, PASSWORD, World, running_world


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with running_world(tmp_path_factory.mktemp("board"), sign_up=True) as world:
        world.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        yield world


@pytest.fixture
def topic(world: World) -> str:
    """Post a new topic as alice; return its id."""
    body = {"board_id": "robots", "title": "A walk", "body": "@quadruped walk"}
    return str(world.api("alice").post("/topics", json=body).json()["topic"]["id"])


# -------------------------------------------------------------------- coming in
def test_who_is_signed_out_is_sent_to_sign_in_and_then_back(world: World, topic: str) -> None:
    surfer = world.browser()
    page = surfer.get(f"/t/{topic}")
    assert page.url.path == "/sign-in"
    arrived = surfer.send("/sign-in", f"/sign-in?next=/t/{topic}", name="bob", password=PASSWORD)
    assert arrived.url.path == f"/t/{topic}"
    assert "A walk" in arrived.text


def test_a_wrong_password_is_said_and_the_name_is_kept(world: World) -> None:
    page = world.browser().send("/sign-in", name="bob", password="not this one")
    assert page.status_code == 401
    assert "That name or password is wrong." in page.text
    assert 'value="bob"' in page.text
    assert "not this one" not in page.text


@pytest.mark.parametrize(
    "elsewhere", ["https://evil.test/", "//evil.test/", "/\\evil.test", "/%0d%0aX: y", "javascript:x"]
)
def test_signing_in_never_leads_to_another_site(world: World, elsewhere: str) -> None:
    surfer = world.browser("bob")
    page = surfer.client.get("/sign-in", params={"next": elsewhere}, follow_redirects=False)
    assert page.headers["location"].startswith("/")
    assert not page.headers["location"].startswith(("//", "/\\"))


def test_a_one_time_link_is_spent_by_its_button_only(world: World) -> None:
    link = world.link("alice")
    first = world.browser()
    assert first.get(link).status_code == first.get(link).status_code == 200
    assert first.send(link).url.path == "/"
    assert "alice" in first.get("/").text
    late = world.browser().send(link)
    assert late.status_code == 404
    assert "used before or has expired" in late.text


def test_signing_up_makes_a_member_who_is_told_what_that_means(world: World) -> None:
    surfer = world.browser()
    refused = surfer.send("/sign-up", name="Carol!", password="correct horse")
    assert refused.status_code == 422
    assert "2 to 32 of a-z" in refused.text
    assert surfer.send("/sign-up", name="carol", password="correct horse").url.path == "/"
    assert "member: looks, writes, stops" in surfer.get("/u/carol").text
    assert "commands are for operators" in surfer.get("/b/robots/new").text


def test_signing_out_ends_the_session(world: World) -> None:
    surfer = world.browser("bob")
    assert surfer.send("/sign-out", "/u/bob").url.path == "/sign-in"
    assert surfer.get("/").url.path == "/sign-in"


# -------------------------------------------------------------------- writing
def test_a_topic_and_a_reply_by_form(world: World) -> None:
    surfer = world.browser("bob")
    page = surfer.send("/b/robots/new", title="  Hello \n there ", body="**Hi** @quadruped\r\nand 你好")
    assert page.url.path.startswith("/t/")
    assert '<h1 dir="auto">Hello there</h1>' in page.text
    assert '<a href="/u/quadruped" class="mention"' in page.text
    replied = surfer.send(f"{page.url.path}/reply", page.url.path, body="A reply")
    assert replied.url.path == page.url.path
    assert "#post-" in str(replied.history[-1].headers["location"])
    assert replied.text.count("<article") == 2


def test_the_same_form_sent_twice_is_one_post_and_another_text_another_post(world: World, topic: str) -> None:
    surfer = world.browser("bob")
    text = surfer.get(f"/t/{topic}").text
    form = text[text.index('id="reply"') :]
    hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form))
    for body in ("same", "same", "other"):
        surfer.client.post(f"/t/{topic}/reply", data=hidden | {"body": body})
    assert surfer.get(f"/t/{topic}").text.count("<article") == 3


@pytest.mark.parametrize(
    ("fields", "status", "said"),
    [
        ({"title": "", "body": "kept text"}, 422, "A topic needs a title."),
        ({"title": "x" * 201, "body": "kept text"}, 422, "at most 200 characters"),
        ({"title": "kept text", "body": " \n"}, 422, "A post needs a text."),
        ({"title": "kept text", "body": "好" * 30_000}, 413, "At most 64 KiB."),
        ({"title": "t", "body": "kept text", "csrf": "forged"}, 403, "load the page again"),
    ],
)
def test_what_cannot_be_posted_is_said_and_nothing_typed_is_lost(
    world: World, fields: dict[str, str], status: int, said: str
) -> None:
    page = world.browser("bob").send("/b/robots/new", **fields)
    assert page.status_code == status
    assert said.lower() in page.text.lower()
    assert "kept text" in page.text


def test_a_reply_after_the_session_ended_gives_the_text_back(world: World, topic: str) -> None:
    surfer = world.browser("bob")
    csrf = surfer.csrf(f"/t/{topic}")
    surfer.send("/sign-out", "/u/bob")
    page = surfer.client.post(f"/t/{topic}/reply", data={"csrf": csrf, "body": "a long text"})
    assert page.status_code in (401, 403)
    assert ">a long text</textarea>" in page.text


def test_editing_keeps_the_earlier_text_and_is_for_the_author_only(world: World, topic: str) -> None:
    surfer = world.browser("bob")
    post = re.findall(r'data-post="(\d+)"', surfer.send(f"/t/{topic}/reply", f"/t/{topic}", body="first words").text)[
        -1
    ]
    edited = surfer.send(f"/p/{post}/edit", body="second words")
    assert "second words" in edited.text
    assert "first words" not in edited.text
    assert "first words" in surfer.get(f"/p/{post}/history").text
    other = world.browser("alice")
    assert other.get(f"/p/{post}/edit").status_code == 403
    assert f'href="/p/{post}/edit"' not in other.get(f"/t/{topic}").text
    forged = other.client.post(f"/p/{post}/edit", data={"csrf": other.csrf(f"/t/{topic}"), "body": "mine now"})
    assert forged.status_code == 403
    assert world.api("bob").get(f"/posts/{post}").json()["raw"] == "second words"


def test_a_removed_post_leaves_a_note_and_no_text(world: World, topic: str) -> None:
    surfer = world.browser("bob")
    post = re.findall(r'data-post="(\d+)"', surfer.send(f"/t/{topic}/reply", f"/t/{topic}", body="secret words").text)[
        -1
    ]
    assert world.browser("alice").client.post(f"/p/{post}/remove", data={"csrf": "x"}).status_code == 403
    surfer.send(f"/p/{post}/edit", body="secret words and more")
    page = surfer.send(f"/p/{post}/remove")
    assert "This post was removed." in page.text
    assert "secret words" not in page.text
    assert surfer.get(f"/p/{post}/raw").text == ""
    assert "secret words" not in surfer.get(f"/p/{post}/history").text


def test_a_long_topic_has_pages_and_permalinks_that_find_theirs(world: World, topic: str) -> None:
    api = world.api("alice")
    ids = [api.post(f"/topics/{topic}/posts", json={"body": f"number {n}"}).json()["post"]["id"] for n in range(60)]
    surfer = world.browser("bob")
    first = surfer.get(f"/t/{topic}")
    assert first.text.count("<article") == 50
    assert "data-last" not in first.text
    far = surfer.get(f"/p/{ids[-1]}")
    assert f'id="post-{ids[-1]}"' in far.text
    assert far.text.count("<article") == 11
    assert "data-last" in far.text
    assert "First page" in far.text


def test_raw_markdown_is_plain_text(world: World, topic: str) -> None:
    post = world.api("alice").post(f"/topics/{topic}/posts", json={"body": "<b>**x**</b>"}).json()["post"]["id"]
    page = world.browser("bob").get(f"/p/{post}/raw")
    assert page.text == "<b>**x**</b>"
    assert page.headers["content-type"].startswith("text/plain")
    assert page.headers["x-content-type-options"] == "nosniff"


# -------------------------------------------------------------------- robots
def stops(world: World, after: str) -> list[tuple[str, str]]:
    events = world.api("quadruped").get("/changes", params={"after": after}).json()["items"]
    return [(e["robot"], e["account"]["name"]) for e in events if e["kind"] == "robot.stop"]


def now(world: World) -> str:
    return str(world.api("quadruped").get("/changes").json()["now"]["id"])


def test_anybody_signed_in_stops_a_robot_by_a_plain_form(world: World) -> None:
    before = now(world)
    page = world.browser("bob").send("/robots/quadruped/stop", "/robots/quadruped")
    assert page.url.path == "/robots/quadruped"
    assert "Stop sent to <strong>@quadruped</strong>" in page.text
    assert stops(world, before) == [("quadruped", "bob")]


def test_a_running_command_has_a_stop_button_in_the_thread(world: World, topic: str) -> None:
    card = {"robot": "quadruped", "state": "running", "step": 2, "steps": 4, "doing": "turning"}
    robot = world.api("quadruped")
    post = robot.post(f"/topics/{topic}/posts", json={"body": "Running.", "card": card}).json()["post"]["id"]
    surfer = world.browser("bob")
    shown = surfer.get(f"/p/{post}/fragment").text
    assert "step 2 of 4: turning" in shown
    assert ">running<" in shown
    before = now(world)
    form = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', shown))
    page = surfer.client.post("/robots/quadruped/stop", data=form)
    assert page.url.path == f"/t/{topic}"
    assert "Stop sent to" in page.text
    assert stops(world, before) == [("quadruped", "bob")]
    robot.patch(f"/posts/{post}", json={"body": "Done.", "card": card | {"state": "done", "step": 4}})
    assert "/stop" not in surfer.get(f"/p/{post}/fragment").text


def test_a_link_cannot_make_a_page_say_that_a_robot_was_stopped(world: World, topic: str) -> None:
    other = world.browser("alice").send("/robots/quadruped/stop", "/robots/quadruped")
    for done in ("stop.quadruped.1.x", "", "..", str(other.url.params["done"])):
        page = world.browser("bob").client.get(f"/t/{topic}", params={"done": done})
        assert page.status_code == 200
        assert "Stop sent" not in page.text


def test_no_stop_without_the_forms_token_or_for_what_is_no_robot(world: World) -> None:
    before = now(world)
    bob = world.browser("bob")
    csrf = bob.csrf("/robots/quadruped")
    assert bob.client.post("/robots/quadruped/stop").status_code == 403
    assert bob.client.post("/robots/alice/stop", data={"csrf": csrf}).status_code == 404
    assert world.browser().client.post("/robots/quadruped/stop").status_code in (401, 403)
    assert stops(world, before) == []


def test_only_operators_reset_the_room(world: World) -> None:
    before = now(world)
    bob, alice = world.browser("bob"), world.browser("alice")
    assert "Reset the room" not in bob.get("/robots/quadruped").text
    forged = bob.client.post("/robots/quadruped/reset", data={"csrf": bob.csrf("/robots/quadruped")})
    assert forged.status_code == 403
    assert "to be reset" in alice.send("/robots/quadruped/reset", "/robots/quadruped").text
    events = world.api("quadruped").get("/changes", params={"after": before}).json()["items"]
    assert [(e["kind"], e["account"]["name"]) for e in events] == [("robot.reset", "alice")]


def test_a_suspended_account_cannot_stop(world: World) -> None:
    mallory = world.board.add("mallory")
    surfer = world.browser("mallory")
    csrf = surfer.csrf("/robots/quadruped")
    local_admin.change_account(world.settings, mallory, suspended=True)
    before = now(world)
    assert surfer.client.post("/robots/quadruped/stop", data={"csrf": csrf}).status_code in (401, 403)
    assert stops(world, before) == []


def test_a_robots_page_tells_what_it_is_and_can(world: World) -> None:
    world.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()  # it is here now
    text = world.browser("bob").get("/robots/quadruped").text
    for said in ("idle", "83 %", "take a photo", "0.5 m/s", "10 m, 60 s", "go2"):
        assert said in text
    assert world.browser("bob").get("/u/quadruped").url.path == "/robots/quadruped"


# -------------------------------------------------------------------- errors and files
@pytest.mark.parametrize("path", ["/nothing", "/t/999999", "/t/x", "/p/0", "/b/none", "/u/nobody", "/robots/none"])
def test_what_is_not_there_is_a_page_that_says_what_to_do(world: World, path: str) -> None:
    page = world.browser("bob").get(path)
    assert page.status_code == 404
    assert "<h1>Not found</h1>" in page.text
    assert 'href="/"' in page.text
    assert "/api/" not in page.text


def test_a_broken_cursor_is_an_error_page(world: World, topic: str) -> None:
    assert world.browser("bob").get(f"/t/{topic}?after=zz").status_code == 422


def test_errors_of_the_server_are_pages_too(world: World) -> None:
    async def broken(kind: str) -> None:
        if kind == "busy":
            raise BoardError(503, "unavailable", "the disk is full")
        if kind == "wrong":
            raise RuntimeError("a mistake of ours with a secret in it")
        raise BoardError(429, "too_fast", "too many posts", retry_after_s=7.2)

    world.board.app.add_api_route("/broken/{kind}", broken)
    surfer = world.browser("bob")
    busy, fast = surfer.get("/broken/busy"), surfer.get("/broken/fast")
    assert (busy.status_code, fast.status_code) == (503, 429)
    assert "The disk is full." in busy.text
    wrong = surfer.get("/broken/wrong")
    assert wrong.status_code == 500
    assert "<h1>Something broke here</h1>" in wrong.text
    assert "a secret" not in wrong.text
    assert "Wait 8 seconds, then try again." in fast.text
    assert fast.headers["retry-after"] == "8"


def test_an_error_of_the_database_does_not_sign_anybody_out(world: World) -> None:
    surfer = world.browser("bob")
    with closing(sqlite3.connect(str(world.settings.database_path))) as other:
        other.execute("ALTER TABLE sessions RENAME TO away")
        try:
            broken = surfer.get("/")
        finally:
            other.execute("ALTER TABLE away RENAME TO sessions")
    assert broken.status_code == 503
    assert "set-cookie" not in broken.headers
    assert surfer.get("/").status_code == 200
    assert surfer.get("/u/bob").url.path == "/u/bob", "still signed in"


def test_the_log_tells_no_secret_of_a_one_time_link(world: World) -> None:
    secret = world.link("bob").removeprefix("/enter/")
    surfer = world.browser()
    csrf = surfer.csrf(f"/enter/{secret}")
    with closing(sqlite3.connect(str(world.settings.database_path))) as other:
        other.execute("ALTER TABLE links RENAME TO away")
        try:
            with capture_logs() as logs:
                broken = surfer.client.post(f"/enter/{secret}", data={"csrf": csrf})
        finally:
            other.execute("ALTER TABLE away RENAME TO links")
    assert broken.status_code == 503
    assert [entry["path"] for entry in logs if "path" in entry] == ["/enter/…"]


def test_too_many_attempts_to_sign_in_say_how_long_to_wait(world: World) -> None:
    surfer = world.browser()
    tries = [surfer.send("/sign-in", name="nobody", password="wrong word") for _ in range(11)]
    assert [t.status_code for t in tries] == [401] * 10 + [429]
    assert re.search(r"Wait \d+ seconds", tries[-1].text)


def test_static_files_are_kept_for_long_under_the_hash_of_their_content(world: World) -> None:
    surfer = world.browser()
    found = re.search(r'href="(/static/[0-9a-f]{12}/board\.css)"', surfer.get("/sign-in").text)
    assert found
    answer = surfer.get(found[1])
    assert "immutable" in answer.headers["cache-control"]
    assert answer.headers["content-type"].startswith("text/css")
    assert surfer.get("/static/0/board.css").headers["cache-control"] == "no-cache"
    assert surfer.get("/static/0/..%2fpages.py").status_code == 404
    assert surfer.get("/favicon.ico").headers["content-type"].startswith("image/svg")
