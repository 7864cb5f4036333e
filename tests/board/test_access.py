"""Access: signing in, tokens, sessions, CSRF, one-time links, suspension, and allowed origins."""

from __future__ import annotations

import re
import sqlite3
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import httpx2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import select
from starlette.responses import Response

from agentrob.board import access
from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts, attempts
from agentrob.board.auth.attempts import HOUR_S, PER_ADDRESS, PER_NAME, SLOWEST_S, WINDOW_S
from agentrob.board.db import schema as db
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.config.load import load
from agentrob.errors import BoardError, ConfigError
from agentrob.model import Role
from tests.board.running_board import RunningBoard

READS = ["/me", "/boards", "/boards/robots/topics", "/posts?key=x", "/changes", "/events", "/robots", "/accounts/op"]


@pytest.mark.parametrize("path", READS)
def test_every_read_requires_sign_in(board: RunningBoard, path: str) -> None:
    answer = board.client().get(path)
    assert (answer.status_code, answer.json()["code"]) == (401, "not_signed_in")
    assert answer.headers["www-authenticate"] == "Bearer"


def test_public_read_opens_reading_only(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(public_read=True)
    anybody = board.client()
    assert anybody.get("/boards").status_code == 200
    assert anybody.get("/posts", params={"key": "x"}).json() == {"items": []}
    assert anybody.post("/robots/quadruped/stop").status_code == 401
    assert anybody.post("/topics", json={"board_id": "talk", "title": "x", "body": "y"}).status_code == 401


@pytest.mark.parametrize("header", ["Bearer wrong", "Bearer", "Basic b3A6", "", "Bearer \xff"])
def test_a_bad_token_is_never_an_anonymous_reader(fresh_board: Callable[..., RunningBoard], header: str) -> None:
    board = fresh_board(public_read=True)
    answer = board.client().get("/boards", headers={"Authorization": header.encode("latin-1")})
    assert (answer.status_code, answer.json()["code"]) == (401, "bad_token")


def test_me_returns_the_caller(board: RunningBoard) -> None:
    me = board.client("quadruped").get("/me").json()
    assert (me["name"], me["kind"], me["role"], me["suspended"]) == ("quadruped", "robot_agent", "member", False)


def test_a_suspended_account_may_only_read_its_own_state(board: RunningBoard) -> None:
    account = board.add("rowdy", role=Role.OPERATOR)
    rowdy = board.client("rowdy")
    browser = board.browser("rowdy")
    assert rowdy.get("/boards").status_code == 200
    local_admin.change_account(board.settings, account, suspended=True)
    assert rowdy.get("/boards").json()["code"] == "suspended"
    assert rowdy.post("/robots/quadruped/stop").json()["code"] == "suspended"
    assert rowdy.get("/me").json()["suspended"] is True
    assert browser.get("/api/v1/me").status_code == 401


def test_a_suspension_can_be_lifted(board: RunningBoard) -> None:
    account = board.add("forgiven")
    client = board.client("forgiven")
    local_admin.change_account(board.settings, account, suspended=True)
    assert client.get("/boards").status_code == 403
    local_admin.change_account(board.settings, account, suspended=False)
    assert client.get("/boards").status_code == 200


def test_revoked_tokens_are_refused_and_other_tokens_stay_valid(board: RunningBoard) -> None:
    account = board.add("program")
    tokens = {"": board.tokens["program"]}
    tokens |= {label: local_admin.issue_token(board.settings, account, label) for label in ("lost", "kept")}

    def open_with() -> list[str]:
        asks = {label: {"Authorization": f"Bearer {token}"} for label, token in tokens.items()}
        return [label for label, ask in asks.items() if board.client().get("/me", headers=ask).status_code == 200]

    assert local_admin.revoke_tokens(board.settings, account, "lost") == 1
    assert open_with() == ["", "kept"]
    assert local_admin.revoke_tokens(board.settings, account, "lost") == 0, "once is enough"
    assert local_admin.revoke_tokens(board.settings, account) == 2
    assert open_with() == []
    assert board.client("op").get("/me").status_code == 200, "those of others stay"


def test_writing_with_a_cookie_requires_the_csrf_token(board: RunningBoard) -> None:
    browser = board.browser("op")
    (secret,) = browser.cookies.jar
    fields = {"board_id": "talk", "title": "x", "body": "y"}
    path = "/api/v1/topics"
    assert browser.get("/api/v1/me").json()["name"] == "op"
    assert browser.post(path, json=fields).json()["code"] == "bad_csrf"
    assert browser.post(path, json=fields, headers={"X-CSRF-Token": "guess"}).json()["code"] == "bad_csrf"
    token = access.csrf_token(str(secret.value))
    assert browser.post(path, json=fields, headers={"X-CSRF-Token": token}).status_code == 201


def test_a_bearer_token_needs_no_csrf_token(board: RunningBoard) -> None:
    client = board.client("op")
    assert client.post("/topics", json={"board_id": "talk", "title": "x", "body": "y"}).status_code == 201


@pytest.mark.parametrize(
    "headers", [{"Origin": "https://evil.example"}, {"Origin": "null"}, {"Sec-Fetch-Site": "cross-site"}]
)
def test_another_site_cannot_write(board: RunningBoard, headers: dict[str, str]) -> None:
    browser = board.browser("op")
    (secret,) = browser.cookies.jar
    token = {"X-CSRF-Token": access.csrf_token(str(secret.value))}
    answer = browser.post("/api/v1/topics", json={}, headers=token | headers)
    assert (answer.status_code, answer.json()["code"]) == (403, "foreign_origin")


def test_under_https_requests_from_http_pages_are_refused(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board(base_url="https://localhost")
    path = f"http://127.0.0.1:{board.settings.port}/api/v1/topics"
    headers = {"Host": "localhost", "Origin": "http://localhost"}
    assert httpx2.post(path, headers=headers, timeout=60).json()["code"] == "foreign_origin"
    assert httpx2.post(path, headers=headers | {"Origin": "https://localhost"}, timeout=60).status_code == 401
    assert "Strict-Transport-Security" in httpx2.get(path, headers=headers, timeout=60).headers


@pytest.mark.parametrize("host", ["evil.example", "", "127.0.0.1.evil.example", "[", "x:y"])
def test_an_unknown_host_name_is_refused(board: RunningBoard, host: str) -> None:
    answer = board.client("op").get("/boards", headers={"Host": host})
    assert answer.status_code in (400, 421)


def test_localhost_is_accepted(board: RunningBoard) -> None:
    assert board.client("op").get("/boards", headers={"Host": f"localhost:{board.settings.port}"}).status_code == 200


def test_security_headers_are_sent(board: RunningBoard) -> None:
    for path in ("/api/v1/boards", "/nothing", "/sign-in"):
        headers = board.browser().get(path).headers
        assert "unsafe-inline" not in headers["content-security-policy"]
        assert "frame-ancestors 'none'" in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"
        assert headers["referrer-policy"] == "same-origin"


# -------------------------------------------------------------------- passwords and links
def test_signing_in_by_password(board: RunningBoard) -> None:
    board.add("alice", password="correct horse")
    session = board.run(access.sign_in(board.services, " Alice ", "correct horse", "10.0.0.1"))
    browser = board.browser()
    browser.cookies.set(board.settings.cookie, str(session), domain="127.0.0.1")
    assert browser.get("/api/v1/me").json()["name"] == "alice"


@pytest.mark.parametrize(
    ("name", "password"), [("bob", "wrong"), ("nobody", "x"), ("quadruped", ""), ("bob", "\ud800")]
)
def test_a_wrong_name_and_a_wrong_password_get_the_same_answer(board: RunningBoard, name: str, password: str) -> None:
    if board.services.store.reader.account("bob") is None:
        board.add("bob", password="right password")
    with pytest.raises(BoardError) as caught:
        board.run(access.sign_in(board.services, name, password, "10.0.0.2"))
    assert (caught.value.status, str(caught.value)) == (401, "that name or password is wrong")


def tried(board: RunningBoard, name: str, address: str, times: int = 1) -> None:
    """Record failed sign-in attempts, whichever process received them."""
    with local_admin.writing(board.settings) as connection:
        for _ in range(times):
            attempts.record(connection, name, address)


def test_too_many_guesses_are_refused_with_the_time_to_wait(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [accounts.now_us()]
    monkeypatch.setattr(attempts, "now_us", lambda: now[0])
    tried(board, " Guessed", "1.1.1.1", PER_NAME)
    with pytest.raises(BoardError) as caught:
        tried(board, "guessed ", "1.1.1.1")
    assert (caught.value.status, caught.value.retry_after_s) == (429, WINDOW_S)
    tried(board, "other", "1.1.1.1")
    tried(board, "guessed", "2.2.2.2")
    now[0] += int(WINDOW_S * 1_000_000)
    tried(board, "guessed", "1.1.1.1")


def test_password_guesses_do_not_lock_the_owner_out(board: RunningBoard) -> None:
    """After guesses from 50 addresses, each up to its limit, the owner can sign in from another address."""
    board.add("owner", password="correct horse")
    for n in range(50):
        tried(board, "owner", f"10.1.{n}.1", PER_NAME)
        with pytest.raises(BoardError):
            board.run(access.sign_in(board.services, "owner", "correct horse", f"10.1.{n}.1"))
    begun_s = time.monotonic()
    assert board.run(access.sign_in(board.services, "owner", "correct horse", "10.2.0.1"))
    assert time.monotonic() - begun_s >= SLOWEST_S, "guessing from many addresses is slow"
    begun_s = time.monotonic()
    board.add("neighbour", password="correct horse")
    assert board.run(access.sign_in(board.services, "neighbour", "correct horse", "10.2.0.1"))
    assert time.monotonic() - begun_s < SLOWEST_S, "others are not slowed"


def test_an_ipv6_network_counts_as_one_address(board: RunningBoard) -> None:
    """Providers give each customer 2^64 IPv6 addresses, so a /64 network counts as one address."""
    for n in range(PER_NAME):
        tried(board, "netted", f"2001:db8:1:2::{n + 1:x}")
    with pytest.raises(BoardError):
        tried(board, "netted", "2001:db8:1:2:ffff::1")
    tried(board, "netted", "2001:db8:1:3::1")


def test_guessing_names_from_one_address_is_limited(board: RunningBoard) -> None:
    for n in range(PER_ADDRESS):
        tried(board, f"name{n}", "3.3.3.3")
    with pytest.raises(BoardError):
        tried(board, "one-more", "3.3.3.3")
    tried(board, "one-more", "4.4.4.4")


def test_sign_ups_do_not_block_each_other(board: RunningBoard) -> None:
    for n in range(PER_NAME * 2):
        tried(board, "", f"10.9.0.{n}")
    tried(board, "", "5.5.5.5", PER_ADDRESS)
    with pytest.raises(BoardError):
        tried(board, "", "5.5.5.5")


def test_a_correct_password_resets_the_count(board: RunningBoard) -> None:
    board.add("forgetting", password="correct horse")
    for _ in range(2):
        tried(board, "forgetting", "10.8.0.1", PER_NAME - 1)
        assert board.run(access.sign_in(board.services, "forgetting", "correct horse", "10.8.0.1"))


def test_attempts_are_stored_for_an_hour_without_names_and_addresses(
    board: RunningBoard, monkeypatch: pytest.MonkeyPatch
) -> None:
    tried(board, "somebody", "6.6.6.6")
    with local_admin.writing(board.settings) as connection:
        rows = connection.execute(select(db.attempts).order_by(db.attempts.c.id.desc()).limit(3)).all()
        assert not [row for row in rows if "somebody" in row.key or "6.6.6.6" in row.key]
        later = accounts.now_us() + int(HOUR_S * 1_000_000)
        monkeypatch.setattr(attempts, "now_us", lambda: later)
        attempts.record(connection, "", "7.7.7.7")
        left = set(connection.execute(select(db.attempts.c.key)).scalars())
    assert left.isdisjoint(row.key for row in rows)


def test_a_one_time_link_signs_in_once(board: RunningBoard) -> None:
    account = local_admin.find_account(board.settings, "member")
    secret = local_admin.issue_link(board.settings, account).removeprefix("/enter/")
    assert board.run(access.enter(board.services, secret))
    with pytest.raises(BoardError) as caught:
        board.run(access.enter(board.services, secret))
    assert caught.value.status == 404


@pytest.mark.sqlite
def test_a_one_time_link_expires(board: RunningBoard) -> None:
    account = local_admin.find_account(board.settings, "member")
    secret = local_admin.issue_link(board.settings, account).removeprefix("/enter/")
    with sqlite3.connect(str(board.settings.database_path)) as database:
        database.execute("UPDATE links SET expires_us = expires_us - 600000000")
    database.close()
    with pytest.raises(BoardError):
        board.run(access.enter(board.services, secret))


@pytest.mark.sqlite
def test_the_database_holds_no_secret(board: RunningBoard) -> None:
    account = local_admin.find_account(board.settings, "member")
    secrets = [board.tokens["op"], local_admin.issue_link(board.settings, account).removeprefix("/enter/")]
    with sqlite3.connect(str(board.settings.database_path)) as database:
        dump = "\n".join(database.iterdump())
    database.close()
    assert not [s for s in secrets if s in dump]


def test_cookies_are_secure_under_https(board: RunningBoard) -> None:
    secure = replace(board.services, settings=replace(board.settings, base_url="https://forum.example.org"))
    response = Response()
    access.set_session(response, secure, "secret")
    cookie = response.headers["set-cookie"]
    assert cookie.startswith("__Host-agentrob_")
    assert all(word in cookie for word in ("Secure", "HttpOnly", "SameSite=lax", "Path=/"))


def test_sign_up_creates_members_and_can_be_disabled(
    board: RunningBoard, fresh_board: Callable[..., RunningBoard]
) -> None:
    assert board.run(access.sign_up(board.services, "Newcomer", "long enough", "10.0.0.3"))
    newcomer = board.services.store.reader.account("newcomer")
    assert newcomer is not None
    assert newcomer.role is Role.MEMBER
    closed = fresh_board(sign_up=False)
    with pytest.raises(BoardError) as caught:
        closed.run(access.sign_up(closed.services, "newcomer", "long enough", "10.0.0.3"))
    assert caught.value.code == "sign_up_off"


# -------------------------------------------------------------------- names and settings
@given(st.text(max_size=40))
def test_a_name_must_be_ascii(name: str) -> None:
    try:
        taken = accounts.checked_name(name)
    except BoardError as e:
        taken = e.code
    assert taken == "bad_name" or re.fullmatch(r"[a-z][a-z0-9_-]{1,31}", taken)


@pytest.mark.parametrize("name", ["оp", "ｏｐ", "o", "1op", "op op", "a" * 33, "op\u200b", "\u212aelvin", ""])
def test_look_alike_names_are_refused(name: str) -> None:
    with pytest.raises(BoardError):
        accounts.checked_name(name)


def test_names_are_unique_whatever_their_case(board: RunningBoard) -> None:
    with pytest.raises(BoardError) as caught:
        local_admin.create_account(board.settings, "OP")
    assert (caught.value.status, caught.value.code) == (409, "name_taken")


def sign_up_by_itself(folder: Path, **config: str) -> bool:
    return BoardSettings.from_config(BoardConfig(**config), folder).sign_up


def test_sign_up_is_on_by_default_only_on_loopback(tmp_path: Path) -> None:
    found = [sign_up_by_itself(tmp_path, listen=x) for x in ("127.0.0.1:1", "[::1]:1", "0.0.0.0:1", "192.168.1.2:1")]
    assert found == [True, True, False, False]


@pytest.mark.parametrize(
    ("base_url", "on"),
    [
        *[("https://forum.example.org", False), ("http://192.168.1.2:8088", False), ("https://localhost.evil", False)],
        *[("http://localhost:8088", True), ("http://[::1]:8088", True), ("https://127.0.0.1", True)],
    ],
)
def test_sign_up_is_off_by_default_behind_a_reverse_proxy(tmp_path: Path, base_url: str, on: bool) -> None:
    assert sign_up_by_itself(tmp_path, listen="127.0.0.1:8088", base_url=base_url) is on
    config = BoardConfig(listen="127.0.0.1:8088", base_url=base_url, sign_up=True)
    assert BoardSettings.from_config(config, tmp_path).sign_up, "who says so, gets it"


@pytest.mark.parametrize("listen", ["", "8088", "host:", "host:port", "host:70000"])
def test_a_wrong_listen_address_is_named_with_an_example(tmp_path: Path, listen: str) -> None:
    path = tmp_path / "agentrob.toml"
    path.write_text(f'[board]\nlisten = "{listen}"\n', encoding="utf-8")
    with pytest.raises(ConfigError, match=r"board\.listen.*is not host:port, for example 127\.0\.0\.1:8088"):
        load(path)
