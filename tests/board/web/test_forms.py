"""Pages without scripts: every function of the forum works with links and forms."""

from __future__ import annotations

import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing

import pytest
from structlog.testing import capture_logs

from agentrob.board.admin import local_admin
from agentrob.board.web.forms import title_of
from agentrob.errors import BoardError
from tests.board.web.forum_site import CARD, PASSWORD, Site, running_site


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True) as site:
        site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()
        yield site


@pytest.fixture
def topic(site: Site) -> str:
    """Post a new topic as alice; return its id."""
    body = {"board_id": "robots", "title": "A walk", "body": "@quadruped walk"}
    return str(site.api("alice").post("/topics", json=body).json()["topic"]["id"])


@pytest.mark.parametrize(
    ("command", "title"),
    [
        ("@quadruped walk forward 1 m", "Walk forward 1 m"),
        ("@quadruped and @humanoid: wave", "Wave"),
        ("@quadruped向前走两米", "向前走两米"),
        ("@quadruped", "@quadruped"),
    ],
)
def test_the_title_of_a_command_is_what_it_says_to_the_robots(command: str, title: str) -> None:
    assert title_of(command) == title


# -------------------------------------------------------------------- signing in
def test_signing_in_returns_to_the_requested_page(site: Site, topic: str) -> None:
    visitor = site.browser()
    page = visitor.get(f"/t/{topic}")
    assert page.url.path == "/sign-in"
    arrived = visitor.send("/sign-in", f"/sign-in?next=/t/{topic}", name="bob", password=PASSWORD)
    assert arrived.url.path == f"/t/{topic}"
    assert "A walk" in arrived.text


def test_a_wrong_password_is_reported_and_the_name_kept(site: Site) -> None:
    page = site.browser().send("/sign-in", name="bob", password="not this one")
    assert page.status_code == 401
    assert "That name or password is wrong." in page.text
    assert 'value="bob"' in page.text
    assert "not this one" not in page.text


@pytest.mark.parametrize(
    "elsewhere", ["https://evil.test/", "//evil.test/", "/\\evil.test", "/%0d%0aX: y", "javascript:x"]
)
def test_signing_in_never_leads_to_another_site(site: Site, elsewhere: str) -> None:
    visitor = site.browser("bob")
    page = visitor.client.get("/sign-in", params={"next": elsewhere}, follow_redirects=False)
    assert page.headers["location"].startswith("/")
    assert not page.headers["location"].startswith(("//", "/\\"))


def test_a_one_time_link_is_used_up_by_its_button_only(site: Site) -> None:
    link = site.link("alice")
    first = site.browser()
    assert first.get(link).status_code == first.get(link).status_code == 200
    assert first.send(link).url.path == "/"
    assert "alice" in first.get("/").text
    late = site.browser().send(link)
    assert late.status_code == 404
    assert "used before or has expired" in late.text


def test_signing_up_creates_a_member_and_explains_the_role(site: Site) -> None:
    visitor = site.browser()
    refused = visitor.send("/sign-up", name="Carol!", password="correct horse")
    assert refused.status_code == 422
    assert "2 to 32 of a-z" in refused.text
    assert visitor.send("/sign-up", name="carol", password="correct horse").url.path == "/"
    assert "member: can read, write, and stop robots" in visitor.get("/u/carol").text
    assert "only operators may command them" in visitor.get("/b/robots/new").text


def test_signing_out_ends_the_session(site: Site) -> None:
    visitor = site.browser("bob")
    assert visitor.send("/sign-out", "/u/bob").url.path == "/sign-in"
    assert visitor.get("/").url.path == "/sign-in"


# -------------------------------------------------------------------- writing
def test_a_topic_and_a_reply_by_form(site: Site) -> None:
    visitor = site.browser("bob")
    page = visitor.send("/b/robots/new", title="  Hello \n there ", body="**Hi** @quadruped\r\nand 你好")
    assert page.url.path.startswith("/t/")
    assert '<h1 dir="auto">Hello there</h1>' in page.text
    assert '<a href="/u/quadruped" class="mention"' in page.text
    replied = visitor.send(f"{page.url.path}/reply", page.url.path, body="A reply")
    assert replied.url.path == page.url.path
    assert "#post-" in str(replied.history[-1].headers["location"])
    assert replied.text.count("<article") == 2


def test_submitting_the_same_form_twice_creates_one_post(site: Site, topic: str) -> None:
    visitor = site.browser("bob")
    text = visitor.get(f"/t/{topic}").text
    form = text[text.index('id="reply"') :]
    hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form))
    for body in ("same", "same", "other"):
        visitor.client.post(f"/t/{topic}/reply", data=hidden | {"body": body})
    assert visitor.get(f"/t/{topic}").text.count("<article") == 3


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
def test_a_refused_post_shows_the_reason_and_keeps_the_text(
    site: Site, fields: dict[str, str], status: int, said: str
) -> None:
    page = site.browser("bob").send("/b/robots/new", **fields)
    assert page.status_code == status
    assert said.lower() in page.text.lower()
    assert "kept text" in page.text


def test_a_reply_after_the_session_ended_keeps_the_text(site: Site, topic: str) -> None:
    visitor = site.browser("bob")
    csrf = visitor.csrf(f"/t/{topic}")
    visitor.send("/sign-out", "/u/bob")
    page = visitor.client.post(f"/t/{topic}/reply", data={"csrf": csrf, "body": "a long text"})
    assert page.status_code in (401, 403)
    assert ">a long text</textarea>" in page.text


def test_only_the_author_may_edit_and_the_history_keeps_the_old_text(site: Site, topic: str) -> None:
    visitor = site.browser("bob")
    post = re.findall(r'data-post="(\d+)"', visitor.send(f"/t/{topic}/reply", f"/t/{topic}", body="first words").text)[
        -1
    ]
    edited = visitor.send(f"/p/{post}/edit", body="second words")
    assert "second words" in edited.text
    assert "first words" not in edited.text
    assert "first words" in visitor.get(f"/p/{post}/history").text
    other = site.browser("alice")
    assert other.get(f"/p/{post}/edit").status_code == 403
    assert f'href="/p/{post}/edit"' not in other.get(f"/t/{topic}").text
    forged = other.client.post(f"/p/{post}/edit", data={"csrf": other.csrf(f"/t/{topic}"), "body": "mine now"})
    assert forged.status_code == 403
    assert site.api("bob").get(f"/posts/{post}").json()["raw"] == "second words"


def test_a_removed_post_shows_a_note_instead_of_its_text(site: Site, topic: str) -> None:
    visitor = site.browser("bob")
    post = re.findall(r'data-post="(\d+)"', visitor.send(f"/t/{topic}/reply", f"/t/{topic}", body="secret words").text)[
        -1
    ]
    assert site.browser("alice").client.post(f"/p/{post}/remove", data={"csrf": "x"}).status_code == 403
    visitor.send(f"/p/{post}/edit", body="secret words and more")
    page = visitor.send(f"/p/{post}/remove")
    assert "This post was removed." in page.text
    assert "secret words" not in page.text
    assert visitor.get(f"/p/{post}/raw").text == ""
    assert "secret words" not in visitor.get(f"/p/{post}/history").text


def test_a_long_topic_is_paged_and_permalinks_find_the_right_page(site: Site, topic: str) -> None:
    api = site.api("alice")
    ids = [api.post(f"/topics/{topic}/posts", json={"body": f"number {n}"}).json()["post"]["id"] for n in range(60)]
    visitor = site.browser("bob")
    first = visitor.get(f"/t/{topic}")
    assert first.text.count("<article") == 50
    assert "data-last" not in first.text
    far = visitor.get(f"/p/{ids[-1]}")
    assert f'id="post-{ids[-1]}"' in far.text
    assert far.text.count("<article") == 11
    assert "data-last" in far.text
    assert "First page" in far.text


def test_raw_markdown_is_plain_text(site: Site, topic: str) -> None:
    post = site.api("alice").post(f"/topics/{topic}/posts", json={"body": "<b>**x**</b>"}).json()["post"]["id"]
    page = site.browser("bob").get(f"/p/{post}/raw")
    assert page.text == "<b>**x**</b>"
    assert page.headers["content-type"].startswith("text/plain")
    assert page.headers["x-content-type-options"] == "nosniff"


# -------------------------------------------------------------------- robots
def stops(site: Site, after: str) -> list[tuple[str, str]]:
    events = site.api("quadruped").get("/changes", params={"after": after}).json()["items"]
    return [(e["robot"], e["account"]["name"]) for e in events if e["kind"] == "robot.stop"]


def now(site: Site) -> str:
    return str(site.api("quadruped").get("/changes").json()["now"]["id"])


def test_anybody_signed_in_stops_a_robot_by_a_plain_form(site: Site) -> None:
    before = now(site)
    page = site.browser("bob").send("/robots/quadruped/stop", "/robots/quadruped")
    assert page.url.path == "/robots/quadruped"
    assert "Stop sent to <strong>@quadruped</strong>" in page.text
    assert stops(site, before) == [("quadruped", "bob")]


def test_a_running_command_has_a_stop_button_in_the_thread(site: Site, topic: str) -> None:
    card = {"robot": "quadruped", "state": "running", "step": 2, "steps": 4, "doing": "turning"}
    robot = site.api("quadruped")
    post = robot.post(f"/topics/{topic}/posts", json={"body": "Running.", "card": card}).json()["post"]["id"]
    visitor = site.browser("bob")
    shown = visitor.get(f"/p/{post}/fragment").text
    assert "step 2 of 4: turning" in shown
    assert ">running<" in shown
    before = now(site)
    form = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', shown))
    page = visitor.client.post("/robots/quadruped/stop", data=form)
    assert page.url.path == f"/t/{topic}"
    assert "Stop sent to" in page.text
    assert stops(site, before) == [("quadruped", "bob")]
    robot.patch(f"/posts/{post}", json={"body": "Done.", "card": card | {"state": "done", "step": 4}})
    assert "/stop" not in visitor.get(f"/p/{post}/fragment").text


def test_a_link_cannot_fake_the_message_that_a_robot_was_stopped(site: Site, topic: str) -> None:
    other = site.browser("alice").send("/robots/quadruped/stop", "/robots/quadruped")
    for done in ("stop.quadruped.1.x", "", "..", str(other.url.params["done"])):
        page = site.browser("bob").client.get(f"/t/{topic}", params={"done": done})
        assert page.status_code == 200
        assert "Stop sent" not in page.text


def test_a_stop_requires_the_csrf_token_and_an_existing_robot(site: Site) -> None:
    before = now(site)
    bob = site.browser("bob")
    csrf = bob.csrf("/robots/quadruped")
    assert bob.client.post("/robots/quadruped/stop").status_code == 403
    assert bob.client.post("/robots/alice/stop", data={"csrf": csrf}).status_code == 404
    assert site.browser().client.post("/robots/quadruped/stop").status_code in (401, 403)
    assert stops(site, before) == []


def test_only_operators_may_reset_the_room(site: Site) -> None:
    before = now(site)
    bob, alice = site.browser("bob"), site.browser("alice")
    assert "Reset the room" not in bob.get("/robots/quadruped").text
    forged = bob.client.post("/robots/quadruped/reset", data={"csrf": bob.csrf("/robots/quadruped")})
    assert forged.status_code == 403
    assert bob.get("/robots/quadruped/reset").status_code == 403
    assert "return to where they began" in alice.get("/robots/quadruped/reset").text, "it is confirmed first"
    assert "to be reset" in alice.send("/robots/quadruped/reset").text
    events = site.api("quadruped").get("/changes", params={"after": before}).json()["items"]
    assert [(e["kind"], e["account"]["name"]) for e in events] == [("robot.reset", "alice")]


def test_a_suspended_account_cannot_stop(site: Site) -> None:
    mallory = site.board.add("mallory")
    visitor = site.browser("mallory")
    csrf = visitor.csrf("/robots/quadruped")
    local_admin.change_account(site.settings, mallory, suspended=True)
    before = now(site)
    assert visitor.client.post("/robots/quadruped/stop", data={"csrf": csrf}).status_code in (401, 403)
    assert stops(site, before) == []


def test_a_robots_page_shows_its_model_and_operations(site: Site) -> None:
    site.api("quadruped").put("/robots/quadruped", json={"card": CARD}).raise_for_status()  # it is here now
    text = site.browser("bob").get("/robots/quadruped").text
    for said in ("idle", "83 %", "take a photo", "0.5 m/s", "10 m, 60 s", "go2"):
        assert said in text
    assert site.browser("bob").get("/u/quadruped").url.path == "/robots/quadruped"


# -------------------------------------------------------------------- errors and files
@pytest.mark.parametrize("path", ["/nothing", "/t/999999", "/t/x", "/p/0", "/b/none", "/u/nobody", "/robots/none"])
def test_a_missing_page_says_what_to_do(site: Site, path: str) -> None:
    page = site.browser("bob").get(path)
    assert page.status_code == 404
    assert "<h1>Not found</h1>" in page.text
    assert 'href="/"' in page.text
    assert "/api/" not in page.text


def test_a_broken_cursor_is_an_error_page(site: Site, topic: str) -> None:
    assert site.browser("bob").get(f"/t/{topic}?after=zz").status_code == 422


def test_server_errors_are_html_pages(site: Site) -> None:
    async def broken(kind: str) -> None:
        if kind == "busy":
            raise BoardError(503, "unavailable", "the disk is full")
        if kind == "wrong":
            raise RuntimeError("a mistake of ours with a secret in it")
        raise BoardError(429, "too_fast", "too many posts", retry_after_s=7.2)

    site.board.app.add_api_route("/broken/{kind}", broken)
    visitor = site.browser("bob")
    busy, fast = visitor.get("/broken/busy"), visitor.get("/broken/fast")
    assert (busy.status_code, fast.status_code) == (503, 429)
    assert "The disk is full." in busy.text
    wrong = visitor.get("/broken/wrong")
    assert wrong.status_code == 500
    assert "<h1>Something broke here</h1>" in wrong.text
    assert "a secret" not in wrong.text
    assert "Wait 8 seconds, then try again." in fast.text
    assert fast.headers["retry-after"] == "8"


def test_a_database_error_does_not_sign_out(site: Site) -> None:
    visitor = site.browser("bob")
    with closing(sqlite3.connect(str(site.settings.database_path))) as other:
        other.execute("ALTER TABLE sessions RENAME TO away")
        try:
            broken = visitor.get("/")
        finally:
            other.execute("ALTER TABLE away RENAME TO sessions")
    assert broken.status_code == 503
    assert "set-cookie" not in broken.headers
    assert visitor.get("/").status_code == 200
    assert visitor.get("/u/bob").url.path == "/u/bob", "still signed in"


def test_the_log_contains_no_one_time_links(site: Site) -> None:
    secret = site.link("bob").removeprefix("/enter/")
    visitor = site.browser()
    csrf = visitor.csrf(f"/enter/{secret}")
    with closing(sqlite3.connect(str(site.settings.database_path))) as other:
        other.execute("ALTER TABLE links RENAME TO away")
        try:
            with capture_logs() as logs:
                broken = visitor.client.post(f"/enter/{secret}", data={"csrf": csrf})
        finally:
            other.execute("ALTER TABLE away RENAME TO links")
    assert broken.status_code == 503
    assert [entry["path"] for entry in logs if "path" in entry] == ["/enter/…"]


def test_too_many_sign_in_attempts_show_how_long_to_wait(site: Site) -> None:
    visitor = site.browser()
    tries = [visitor.send("/sign-in", name="nobody", password="wrong word") for _ in range(11)]
    assert [t.status_code for t in tries] == [401] * 10 + [429]
    assert re.search(r"Wait \d+ seconds", tries[-1].text)


def test_static_files_have_a_content_hash_and_long_cache_lifetime(site: Site) -> None:
    visitor = site.browser()
    found = re.search(r'href="(/static/[0-9a-f]{12}/board\.css)"', visitor.get("/sign-in").text)
    assert found
    answer = visitor.get(found[1])
    assert "immutable" in answer.headers["cache-control"]
    assert answer.headers["content-type"].startswith("text/css")
    assert visitor.get("/static/0/board.css").headers["cache-control"] == "no-cache"
    assert visitor.get("/static/0/..%2fpages.py").status_code == 404
    assert visitor.get("/favicon.ico").headers["content-type"].startswith("image/svg")
