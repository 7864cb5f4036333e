"""Limits and their error responses; moderation and its audit log; and erasing an account."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import httpx2
import pytest

from agentrob.board import access
from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts, attempts
from agentrob.board.settings import NO_LIMITS, BoardSettings
from agentrob.config.board import BoardConfig, BoardLimitsConfig
from agentrob.config.load import parse
from agentrob.errors import BoardError, ConfigError
from agentrob.model import Role
from tests.board.auth.test_rights import admin_api, jpeg, topic_on
from tests.board.running_board import RunningBoard


@pytest.fixture(scope="module")
def strict(tmp_path_factory: pytest.TempPathFactory) -> Any:
    from tests.board.running_board import running_board

    limits = BoardLimitsConfig(posts=6, commands=2, uploads=2, sign_ups=2)
    with running_board(tmp_path_factory.mktemp("strict"), limits=limits) as made:
        yield made


def assert_too_many(answer: httpx2.Response, code: str) -> None:
    """Check that the response names the limit and when to try again."""
    problem = answer.json()
    assert (answer.status_code, problem["code"]) == (429, code)
    assert 3000 < int(answer.headers["retry-after"]) <= 3600
    assert re.search(r"in (59|60) minutes", problem["detail"])


def test_commands_and_posts_per_hour_are_limited_and_stops_are_not(strict: RunningBoard) -> None:
    op = strict.client("op")
    topic = op.post("/topics", json={"board_id": "robots", "title": "t", "body": "@quadruped wave"}).json()["topic"][
        "id"
    ]
    say: Callable[[str], httpx2.Response] = lambda body: op.post(f"/topics/{topic}/posts", json={"body": body})  # noqa: E731
    assert say("@quadruped wave again").status_code == 201
    assert_too_many(say("@quadruped and again"), "too_many_commands")
    assert say("only words").status_code == 201, "what is no command is no command"
    for n in range(3):
        assert say(f"words {n}").status_code == 201
    assert_too_many(say("more words"), "too_many_posts")
    assert_too_many(op.post("/topics", json={"board_id": "talk", "title": "t", "body": "b"}), "too_many_posts")
    for stop in ("@quadruped stop", "stop", "停"):
        assert say(stop).status_code == 201
    assert op.post("/robots/quadruped/stop").status_code == 200
    assert strict.client("member").post(f"/topics/{topic}/posts", json={"body": "mine"}).status_code == 201


def test_a_robot_s_own_posts_are_not_counted(strict: RunningBoard) -> None:
    topic, _ = topic_on(strict, "talk")
    robot = strict.client("quadruped")
    assert {robot.post(f"/topics/{topic}/posts", json={"body": f"{n}"}).status_code for n in range(10)} == {201}


def test_a_retry_with_a_used_key_is_answered_beyond_the_limit(strict: RunningBoard) -> None:
    strict.add("repeater")
    client, key = strict.client("repeater"), {"Idempotency-Key": "once"}
    first = client.post("/topics", json={"board_id": "talk", "title": "t", "body": "0"}, headers=key).json()
    for n in range(5):
        client.post("/topics", json={"board_id": "talk", "title": "t", "body": str(n)}).raise_for_status()
    assert client.post("/topics", json={"board_id": "talk", "title": "t", "body": "x"}).status_code == 429
    again = client.post("/topics", json={"board_id": "talk", "title": "t", "body": "0"}, headers=key)
    assert (again.status_code, again.json()["post"]["id"]) == (200, first["post"]["id"])


def test_uploads_per_hour_are_limited(strict: RunningBoard) -> None:
    strict.add("painter", role=Role.OPERATOR)
    send = lambda shade: strict.client("painter").post(  # noqa: E731
        "/images", files={"file": ("x.jpg", jpeg(shade), "image/jpeg")}
    )
    assert [send(n).status_code for n in range(2)] == [201, 201]
    assert_too_many(send(3), "too_many_uploads")


def test_edits_and_tag_changes_share_a_limit_that_excludes_edits_into_a_stop(strict: RunningBoard) -> None:
    strict.add("tagger")
    client, words = strict.client("tagger"), {"board_id": "talk", "title": "t", "body": "b"}
    made = client.post("/topics", json=words).json()
    topic, post = f"/topics/{made['topic']['id']}/tags", f"/posts/{made['post']['id']}"
    for n in range(3):
        assert client.patch(post, json={"body": f"b{n}"}).status_code == 200
        assert client.put(topic, json={"tags": [f"tag {n}"]}).status_code == 200
    assert_too_many(client.put(topic, json={"tags": ["another"]}), "too_many_changes")
    assert_too_many(client.patch(post, json={"body": "another"}), "too_many_changes")
    assert client.put(topic, json={"tags": ["tag 2"]}).json()["tags"] == ["tag-2"], "they are that already"
    assert client.patch(post, json={"body": "@quadruped stop"}).status_code == 200
    browser = strict.browser("tagger")
    (secret,) = [c.value for c in browser.cookies.jar]
    page = browser.post(f"/t/{made['topic']['id']}/tags", data={"csrf": access.csrf_token(str(secret)), "tags": "mine"})
    assert page.status_code == 429
    assert "edited posts and chosen tags 6 times within the last hour" in page.text
    assert 'value="mine"' in page.text


def test_a_robot_s_own_edits_are_not_counted(strict: RunningBoard) -> None:
    robot = strict.client("quadruped")
    made = robot.post("/topics", json={"board_id": "talk", "title": "t", "body": "b"}).json()["post"]["id"]
    assert {robot.patch(f"/posts/{made}", json={"body": f"{n}"}).status_code for n in range(8)} == {200}


def test_successful_sign_ups_from_one_address_are_limited(strict: RunningBoard) -> None:
    sign_up = lambda name, address: strict.run(  # noqa: E731
        access.sign_up(strict.services, name, "long enough", address)
    )
    for _ in range(3):
        with pytest.raises(BoardError, match="already"):
            sign_up("op", "10.1.1.1")
    assert sign_up("newcomer1", "10.1.1.1")
    assert sign_up("newcomer2", "10.1.1.1")
    with pytest.raises(BoardError) as caught:
        sign_up("newcomer3", "10.1.1.1")
    assert (caught.value.status, caught.value.code) == (429, "too_many_sign_ups")
    assert sign_up("newcomer3", "10.2.2.2")


def test_the_limit_of_sign_ups_resets_after_an_hour(strict: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [accounts.now_us()]
    monkeypatch.setattr(attempts, "now_us", lambda: now[0])
    with local_admin.writing(strict.settings) as connection:
        attempts.record_sign_up(connection, "a", 1)
        now[0] += 3599_000_000
        with pytest.raises(BoardError):
            attempts.record_sign_up(connection, "a", 1)
        now[0] += 1_000_000
        attempts.record_sign_up(connection, "a", 1)
        attempts.record_sign_up(connection, "b", 0)


def test_the_page_names_the_limit_and_keeps_the_text(strict: RunningBoard) -> None:
    strict.add("writer")
    browser = strict.browser("writer")
    for n in range(6):
        strict.client("writer").post("/topics", json={"board_id": "talk", "title": "t", "body": str(n)})
    (secret,) = [c.value for c in browser.cookies.jar]
    form = {"csrf": access.csrf_token(str(secret)), "title": "t", "body": "my long text", "key": "k"}
    page = browser.post("/b/talk/new", data=form)
    assert page.status_code == 429
    assert "written 6 posts within the last hour" in page.text
    assert "my long text" in page.text


def test_a_public_forum_has_default_limits_and_a_local_one_has_none(tmp_path: Any) -> None:
    made = [
        BoardSettings.from_config(BoardConfig(listen=listen, base_url=url), tmp_path).limits
        for listen, url in [("127.0.0.1:1", ""), ("0.0.0.0:1", ""), ("127.0.0.1:1", "https://forum.example.org")]
    ]
    assert made == [NO_LIMITS, BoardLimitsConfig(), BoardLimitsConfig()]


# -------------------------------------------------------------------- moderation
def test_hidden_posts_are_visible_to_moderators_only(board: RunningBoard) -> None:
    topic, post = topic_on(board, "talk", "first words")
    board.client("author").patch(f"/posts/{post}", json={"body": "rude words"}).raise_for_status()
    boss = admin_api(board)
    hidden = boss.post(f"/posts/{post}/hide", json={"reason": "rude"}).json()
    assert (hidden["removed"], hidden["raw"]) == (True, "")
    assert "rude words" not in board.client("op").get(f"/topics/{topic}/posts").text
    assert board.client("op").get(f"/posts/{post}/hidden").status_code == 403
    kept = boss.get(f"/posts/{post}/hidden").json()
    assert (kept["post"]["raw"], kept["versions"]) == ("rude words", ["first words"])
    shown = boss.post(f"/posts/{post}/show", json={"reason": "not so rude"}).json()
    assert (shown["removed"], shown["raw"], shown["version"]) == (False, "rude words", 4)
    assert boss.get(f"/topics/{topic}").json()["posts"] == 1


def test_a_moderator_cannot_show_a_post_that_its_author_removed(board: RunningBoard) -> None:
    made = board.client("op").post("/topics", json={"board_id": "talk", "title": "t", "body": "b"}).json()["post"]["id"]
    board.client("op").delete(f"/posts/{made}").raise_for_status()
    assert admin_api(board).post(f"/posts/{made}/show", json={}).json()["code"] == "removed"


def test_a_locked_topic_accepts_only_stops_and_posts_of_robots_and_moderators(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk")
    own = board.client("op").post(f"/topics/{topic}/posts", json={"body": "mine"}).json()["post"]["id"]
    boss = admin_api(board)
    assert boss.post(f"/topics/{topic}/lock", json={"locked": True, "reason": "heated"}).json()["locked"] is True
    write = lambda name, body: board.client(name).post(f"/topics/{topic}/posts", json={"body": body}).status_code  # noqa: E731
    assert [write("op", "x"), write("op", "stop"), write("quadruped", "done"), write("admin", "x")] == [
        *(403, 201, 201, 201),
    ]
    assert board.client("op").patch(f"/posts/{own}", json={"body": "changed"}).json()["code"] == "locked"
    boss.post(f"/topics/{topic}/lock", json={"locked": False}).raise_for_status()
    assert write("op", "x") == 201


def test_a_moved_topic_keeps_all_its_posts(board: RunningBoard) -> None:
    topic, post = topic_on(board, "talk")
    moved = admin_api(board).post(f"/topics/{topic}/move", json={"board_id": "robots", "reason": "belongs there"})
    assert moved.json()["board_id"] == "robots"
    assert board.client("op").get(f"/posts/{post}").json()["board_id"] == "robots"
    assert admin_api(board).post(f"/topics/{topic}/move", json={"board_id": "nowhere"}).status_code == 404


def test_every_moderation_is_in_the_audit_log(board: RunningBoard) -> None:
    topic, post = topic_on(board, "talk")
    boss = admin_api(board)
    boss.post(f"/posts/{post}/hide", json={"reason": "because"})
    boss.post(f"/topics/{topic}/lock", json={"locked": True})
    boss.post(f"/topics/{topic}/move", json={"board_id": "robots"})
    boss.patch("/admin/accounts/member", json={"role": "operator"})
    boss.patch("/admin/accounts/member", json={"role": "member"})
    found = boss.get("/admin/audit", params={"limit": 5}).json()
    told = [(e["actor"], e["action"], e["target"]) for e in found["items"]]
    assert told == [
        *[("admin", "account.change", "account:member")] * 2,
        *[("admin", "topic.move", f"topic:{topic}"), ("admin", "topic.lock", f"topic:{topic}")],
        ("admin", "post.hide", f"post:{post}"),
    ]
    assert found["items"][1]["detail"] == {"before": {"role": "member"}, "role": "operator"}
    assert found["items"][4]["detail"] == {"author": "author", "reason": "because"}
    older = boss.get("/admin/audit", params={"cursor": found["next"], "limit": 1}).json()["items"]
    assert int(older[0]["id"]) < int(found["items"][4]["id"])
    of = boss.get("/admin/audit", params={"target": f"post:{post}"}).json()["items"]
    assert {e["target"] for e in of} == {f"post:{post}"}


# -------------------------------------------------------------------- erasing
def test_erasing_an_account_deletes_its_texts_and_pictures(board: RunningBoard) -> None:
    board.add("leaving", role=Role.OPERATOR)
    client, other = board.client("leaving"), board.client("op")
    send = lambda who, shade: who.post(  # noqa: E731
        "/images", files={"file": ("x.jpg", jpeg(shade), "image/jpeg")}
    ).json()["id"]
    mine, shared, theirs = send(client, 11), send(client, 12), send(other, 12)
    body = {"board_id": "talk", "title": "My private title", "body": "my private words", "images": [mine, shared]}
    made = client.post("/topics", json=body).json()
    topic, post = made["topic"]["id"], made["post"]["id"]
    client.patch(f"/posts/{post}", json={"body": "my later words"}).raise_for_status()
    answer = other.post(f"/topics/{topic}/posts", json={"body": "an answer", "reply_to": post, "images": [theirs]})
    gone = admin_api(board).delete("/admin/accounts/leaving/content").json()
    assert gone == {"posts": 1, "pictures": 2}
    assert client.get("/me").status_code == 200, "the account stays"
    everywhere = "\n".join(map(str, board.run(board.services.store.do(_dump))))
    assert not [w for w in ("private", "my later words") if w in everywhere]
    files = {p.name for p in board.settings.images_dir.glob("*/*")}
    digests = [board.services.store.reader.image(theirs)[1]]
    assert set(digests) <= files, "what somebody else uploaded too stays"
    assert other.get(f"/posts/{answer.json()['post']['id']}").json()["reply_to"] == post
    assert admin_api(board).post(f"/posts/{post}/show", json={}).status_code == 409
    assert admin_api(board).delete("/admin/accounts/leaving/content").json() == {"posts": 0, "pictures": 0}


def _dump(t: Any) -> list[Any]:
    from sqlalchemy import select

    from agentrob.board.db import schema

    return [row for table in schema.metadata.sorted_tables for row in t.connection.execute(select(table))]


# -------------------------------------------------------------------- behind a proxy
def test_forwarded_addresses_are_accepted_from_trusted_proxies_only(tmp_path: Any) -> None:
    def trusted(**board: Any) -> tuple[str, ...]:
        return BoardSettings.from_config(BoardConfig(**board), tmp_path).trusted_proxies

    assert trusted() == ()
    assert trusted(base_url="https://forum.example.org") == ("127.0.0.1", "::1")
    assert trusted(base_url="https://forum.example.org", trusted_proxies=("10.0.0.0/24",)) == ("10.0.0.0/24",)
    with pytest.raises(ConfigError, match="addresses or networks"):
        parse({"board": {"trusted_proxies": ["anybody"]}})


@pytest.mark.parametrize(("proxies", "held"), [((), True), (("127.0.0.1",), False)])
def test_a_forged_forwarded_header_does_not_bypass_the_throttle(
    fresh_board: Callable[..., RunningBoard], proxies: tuple[str, ...], held: bool
) -> None:
    board = fresh_board(trusted_proxies=proxies)
    browser = board.browser()
    csrf = re.search(r'name="csrf" value="([^"]*)"', browser.get("/sign-in").text)
    assert csrf
    with local_admin.writing(board.settings) as connection:
        for n in range(29):
            attempts.record(connection, f"name{n}", "127.0.0.1")
    statuses = []
    for n in range(2):
        form = {"csrf": csrf[1], "name": f"who{n}", "password": "wrong words"}
        answer = browser.post("/sign-in", data=form, headers={"X-Forwarded-For": f"10.0.0.{n}"})
        statuses.append(answer.status_code)
    assert statuses == ([401, 429] if held else [401, 401])


# -------------------------------------------------------------------- accounts
def test_the_last_admin_cannot_be_demoted(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    boss = admin_api(board)
    assert boss.patch("/admin/accounts/admin", json={"role": "member"}).json()["code"] == "last_admin"
    assert boss.patch("/admin/accounts/admin", json={"suspended": True}).json()["code"] == "last_admin"
    boss.patch("/admin/accounts/op", json={"role": "admin"}).raise_for_status()
    assert boss.patch("/admin/accounts/admin", json={"role": "member"}).status_code == 200
    assert boss.get("/admin/accounts").status_code == 403, "and is none from now on"


def test_a_password_link_works_once_and_ends_earlier_sessions(board: RunningBoard) -> None:
    account = board.add("forgetful", password="the old password")
    old = board.browser("forgetful")
    assert old.get("/api/v1/me").status_code == 200
    link = admin_api(board).post("/admin/accounts/forgetful/link", json={}).json()["url"].removeprefix(board.url)
    browser = board.browser()
    assert browser.get(link).status_code == 200, "looking uses nothing up"
    csrf = re.search(r'name="csrf" value="([^"]*)"', browser.get(link).text)
    assert csrf
    form = {"csrf": csrf[1], "password": "the new password"}
    assert board.browser().post(link, data=form).status_code == 403, "not without the form's own cookie"
    assert browser.post(link, data=form | {"password": "short"}).status_code == 422
    assert browser.post(link, data=form).status_code == 303
    assert old.get("/api/v1/me").status_code == 401
    assert board.browser().post(link, data=form).status_code in (403, 404)
    assert board.run(access.sign_in(board.services, "forgetful", "the new password", "10.9.9.9"))
    with pytest.raises(BoardError):
        board.run(access.sign_in(board.services, "forgetful", "the old password", "10.9.9.9"))
    with pytest.raises(BoardError):  # a link for one purpose does not work for another
        board.run(access.enter(board.services, local_admin.issue_link(board.settings, account)[7:] + "x"))


def test_an_invitation_grants_its_role_to_its_number_of_accounts(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(sign_up=False)
    link = admin_api(board).post("/admin/invites", json={"role": "operator", "uses": 2}).json()["url"]
    secret = link.rpartition("/")[2]
    join = lambda name: board.run(access.sign_up(board.services, name, "long enough", "10.0.0.1", secret))  # noqa: E731
    assert join("first")
    with pytest.raises(BoardError, match="already"):
        join("first")
    assert join("second"), "what failed used nothing up"
    with pytest.raises(BoardError) as caught:
        join("third")
    assert caught.value.code == "no_such_invite"
    assert board.client("op").get("/accounts/second").json()["role"] == "operator"
    assert admin_api(board).post("/admin/invites", json={"role": "admin"}).status_code == 422
