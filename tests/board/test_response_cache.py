"""Cached responses of hot topics are never stale: no cache outlives an edit, a hidden post or a revoked right."""

from __future__ import annotations

import threading
import tracemalloc
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

import httpx2
import pytest

from agentrob.board import response_cache
from agentrob.board.admin import local_admin, management, moderation
from agentrob.board.api.models import Paged, Serializer
from agentrob.board.auth import accounts, visibility
from agentrob.board.content import writes
from agentrob.board.db.database import open_engine
from agentrob.board.db.reader import Reader
from agentrob.board.db.writer import Transaction
from agentrob.board.response_cache import TopicCache
from agentrob.model import AccountKind, Role
from tests.board.auth.test_rights import admin_api, jpeg, new_board, topic_on
from tests.board.events.test_streams import now, stream, until
from tests.board.running_board import LIMIT_S, RunningBoard
from tests.board.security.test_endpoint_rights import bearer


def elsewhere(board: RunningBoard, job: Callable[[Transaction], Any]) -> Any:
    """Change the database like another process, without notifying this server."""
    with local_admin.writing(board.settings) as connection:
        return job(Transaction(connection))


def fresh(board: RunningBoard, topic: str, viewer: str) -> dict[str, Any]:
    """Read the database's current content without any cache."""
    engine = open_engine(board.settings, writes=False)
    with engine.connect() as connection:
        reader = Reader(connection)
        shape = Serializer(board.settings.base_url, reader.account(viewer))
        page = reader.posts(topic, None, 50)
        made = Paged(items=tuple(map(shape.post, page.items)), next=page.next).model_dump(mode="json")
    engine.dispose()
    return made


def test_every_change_of_a_topic_is_shown_at_once(board: RunningBoard) -> None:
    """Make each change through this server and through another process, after reads have made the topic hot."""
    boss = admin_api(board)
    topic, first = topic_on(board, "talk", "as it was")
    author = board.client("author")
    robot = board.client("quadruped")
    image = robot.post("/images", files={"file": ("x.jpg", jpeg(77), "image/jpeg")}).json()["id"]
    card = {"robot": "quadruped", "state": "running"}
    status = robot.post(f"/topics/{topic}/posts", json={"body": "on it", "card": card, "images": [image]}).json()
    status_id = status["post"]["id"]
    shell = local_admin.find_account(board.settings, "admin")
    board.add("talker", display_name="Tal Ker")
    said = board.client("talker").post(f"/topics/{topic}/posts", json={"body": "my words"}).json()["post"]["id"]
    later = datetime.now(UTC) + timedelta(days=3)

    def promoted(t: Transaction) -> Any:
        return management.change_account(t.connection, "shell", "talker", role=Role.OPERATOR)

    actions: list[Callable[[], Any]] = [
        lambda: author.patch(f"/posts/{first}", json={"body": "changed"}).raise_for_status(),
        lambda: author.post(f"/topics/{topic}/posts", json={"body": "and more"}).raise_for_status(),
        lambda: robot.patch(f"/posts/{status_id}", json={"body": "done", "card": card | {"state": "done"}}),
        lambda: boss.post(f"/posts/{said}/hide", json={"reason": "x"}).raise_for_status(),
        lambda: boss.post(f"/posts/{said}/show", json={}).raise_for_status(),
        lambda: elsewhere(board, lambda t: writes.remove(t, shell, said)),
        lambda: elsewhere(board, lambda t: moderation.show(t, shell, said)),
        lambda: boss.patch("/admin/accounts/talker", json={"display_name": "Other"}).raise_for_status(),
        lambda: elsewhere(board, promoted),
        lambda: boss.patch("/admin/accounts/talker", json={"suspended": True}).raise_for_status(),
        lambda: boss.post(f"/topics/{topic}/move", json={"board_id": "robots"}).raise_for_status(),
        lambda: boss.patch("/admin/robots/quadruped", json={"camera_days": 1}).raise_for_status(),
        lambda: elsewhere(board, lambda t: moderation.expire_pictures(t, later)),
        lambda: boss.delete("/admin/accounts/talker/content").raise_for_status(),
        lambda: author.delete(f"/posts/{first}").raise_for_status(),
    ]  # fmt: skip
    readers = {name: board.client(name) for name in ("op", "author", "quadruped")}
    seen = []
    for n, action in enumerate(actions):
        for name, client in readers.items():
            for _ in range(3):
                assert client.get(f"/topics/{topic}/posts").json() == fresh(board, topic, name), n
        action()
        seen.append(readers["op"].get(f"/topics/{topic}/posts").text)
        for name, client in readers.items():
            assert client.get(f"/topics/{topic}/posts").json() == fresh(board, topic, name), n
    unchanged = [n for n in range(1, len(seen)) if seen[n] == seen[n - 1]]
    assert unchanged == [11], "each action but the setting of the days changes what is shown"


def test_a_hot_page_is_current_and_personal(board: RunningBoard) -> None:
    topic, post = topic_on(board, "talk", "first words")
    page = lambda name: board.browser(name).get(f"/t/{topic}").text  # noqa: E731
    for name in ("op", "author", "op", "author"):
        assert "first words" in page(name)
    edit = f'href="/p/{post}/edit"'
    assert (edit in page("author"), edit in page("op")) == (True, False)
    board.client("author").patch(f"/posts/{post}", json={"body": "second words"}).raise_for_status()
    assert [("<p>first words" in page(n), "<p>second words" in page(n)) for n in ("op", "author")] == [
        (False, True)
    ] * 2
    shell = local_admin.find_account(board.settings, "admin")
    elsewhere(board, lambda t: writes.remove(t, shell, post))
    assert not [n for n in ("op", "author") if "<p>second words" in page(n)]


def test_a_robots_posts_show_its_current_owner(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk", "whose is it?")
    board.client("quadruped").post(f"/topics/{topic}/posts", json={"body": "mine"}).raise_for_status()
    browser = board.browser("op")
    for owner in ("op", "member"):
        admin_api(board).patch("/admin/robots/quadruped", json={"owner": owner}).raise_for_status()
        assert f'class="owner">of <a class="quiet" href="/u/{owner}">' in browser.get(f"/t/{topic}").text


def test_the_stop_buttons_of_a_hot_page_are_each_viewer_s_own(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk", "go")
    card = {"robot": "quadruped", "state": "running"}
    board.client("quadruped").post(f"/topics/{topic}/posts", json={"body": "on it", "card": card}).raise_for_status()
    pages = [board.browser("op").get(f"/t/{topic}").text for _ in range(2)]
    tokens = [{part.split('"')[0] for part in page.split('name="csrf" value="')[1:]} for page in pages]
    assert all(len(found) == 1 for found in tokens)
    assert tokens[0] != tokens[1]


@pytest.mark.parametrize("by_page", [False, True], ids=["api", "page"])
@pytest.mark.parametrize("lost", ["suspended", "closed board", "moved away", "revoked", "signed out"])
def test_a_revoked_right_takes_effect_at_once_on_a_hot_topic(board: RunningBoard, lost: str, by_page: bool) -> None:
    name = f"{lost.replace(' ', '-')}-{'page' if by_page else 'api'}"
    account = board.add(name, role=Role.OPERATOR)
    where = new_board(board, f"hot-{len(name)}", read_role="operator", post_role="operator")
    closed = new_board(board, "admins-only", read_role="admin", post_role="admin")
    topic, _ = topic_on(board, where, "not for everybody")
    shell = local_admin.find_account(board.settings, "admin")
    if by_page:
        client, path = board.browser(name), f"/t/{topic}"
    else:
        client, path = board.client(name), f"/topics/{topic}/posts"
    for _ in range(3):
        assert client.get(path).status_code == 200
    action: dict[str, Callable[[Transaction], Any]] = {
        "suspended": lambda t: management.change_account(t.connection, "shell", name, suspended=True),
        "closed board": lambda t: management.change_board(
            t.connection, "shell", where, read_role=Role.ADMIN, post_role=Role.ADMIN
        ),
        "moved away": lambda t: moderation.move(t, shell, topic, closed),
        "revoked": lambda t: accounts.revoke_tokens(t.connection, account),
        "signed out": lambda t: accounts.end_sessions(t.connection, account),
    }
    elsewhere(board, action[lost])
    answer = client.get(path)
    if (lost, by_page) in (("revoked", True), ("signed out", False)):
        assert answer.status_code == 200, "a session is no token, and a token no session"
    else:
        assert answer.status_code in (303, 401, 403, 404)
        assert "not for everybody" not in answer.text


def test_an_expired_session_shows_no_hot_topic(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    topic, _ = topic_on(board, "talk")
    browser = board.browser("op")
    assert browser.get(f"/api/v1/topics/{topic}/posts").status_code == 200
    monkeypatch.setattr(response_cache, "REPEAT_S", 0.0)
    browser = board.browser("op")
    assert [browser.get(f"/api/v1/topics/{topic}/posts").status_code for _ in range(2)] == [200, 200]
    late = accounts.now_us() + (accounts.SESSION_DAYS + 1) * 86_400_000_000
    monkeypatch.setattr(accounts, "now_us", lambda: late)
    assert browser.get(f"/api/v1/topics/{topic}/posts").status_code == 401


def test_responses_are_never_shared_between_accounts(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk", "for those inside")
    path, good = f"/topics/{topic}/posts", board.client("op")
    assert [good.get(path).status_code for _ in range(3)] == [200] * 3
    assert board.client().get(path).status_code == 401
    assert bearer(board, "agentrob_" + "x" * 43).get(path).status_code == 401
    key = {"Idempotency-Key": "mine"}
    board.client("op").post(f"/topics/{topic}/posts", json={"body": "keyed"}, headers=key).raise_for_status()
    keys = {n: board.client(n).get(path).json()["items"][-1]["key"] for n in ("op", "author", "op")}
    assert keys == {"op": "mine", "author": None}
    assert [good.get(path, params={"limit": n}).status_code for n in (1, 0, 1, 101)] == [200, 422, 200, 422]
    assert len(good.get(path, params={"limit": 1}).json()["items"]) == 1


def test_the_topic_cache_has_a_size_limit(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk")
    kept = TopicCache(
        max_kept=100 + 3 * response_cache.ENTRY_BYTES
    )  # three entries of 30 bytes, and the overhead of each
    reader = board.services.store.everything  # read on the board's own loop
    made: list[int] = []

    def ask(n: int, size: int = 30) -> int:
        return board.run(_of(kept, reader, topic, n, lambda: (made.append(n) or n, size)))

    assert [ask(n) for n in (1, 2, 3, 1, 4)] == [1, 2, 3, 1, 4]
    assert made == [1, 2, 3, 4], "1 was kept"
    assert [ask(1), ask(2)] == [1, 2]
    assert made == [1, 2, 3, 4, 2], "2 was the least lately used"
    ask(9, size=1000 + 3 * response_cache.ENTRY_BYTES)
    assert len(kept._kept) == 0, "what is too large by itself is not kept"


async def _of(kept: TopicCache, reader: Reader, topic: str, asked: int, make: Any) -> int:
    visibility.set_readable_boards(frozenset({"talk"}))
    return kept.of(reader, topic, asked, make)


def test_writes_of_another_process_reach_open_streams(board: RunningBoard) -> None:
    """Law 4: a robot's agent hears of a command that an admin hid on the command line, before any other event."""
    _topic, post = topic_on(board, "talk", "hidden soon")
    client: httpx2.Client = board.client("op")
    account = local_admin.find_account(board.settings, "admin")
    with stream(client, after=now(client), heartbeat=30) as events:
        later = threading.Timer(0.2, elsewhere, (board, lambda t: writes.remove(t, account, post)))
        later.start()
        (told,) = until(events, 1)
        later.join(LIMIT_S)
    assert (told["event"], told["data"]["post"]["id"], told["data"]["post"]["raw"]) == ("post.removed", post, "")
    assert told["data"]["post"]["author"]["kind"] == AccountKind.HUMAN


@pytest.mark.sqlite  # where several processes may serve the database, no answers are kept
def test_the_response_cache_has_a_size_limit_for_any_requests(fresh_board: Callable[..., RunningBoard]) -> None:
    """Cookies, queries and sessions may have any size and number: cache keys take memory too, so the limit counts
    them."""
    board = fresh_board(public_read=True)
    topic, _ = topic_on(board, "talk")
    stranger, path = httpx2.Client(base_url=board.url, timeout=60), f"/api/v1/topics/{topic}/posts"
    kept = response_cache_of(board)

    def ask(n: int, **headers: str) -> None:
        assert stranger.get(path, params={"limit": 1, "x": f"{n}" * 500}, headers=headers).status_code == 200

    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        for n in range(400):
            ask(n, Cookie=f"{board.settings.cookie}={n:043}; other={'x' * 30_000}")
        grown = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert len(kept._answers) == 400, "each was kept"
    assert grown < 400 * response_cache.ENTRY_BYTES + 2_000_000
    assert kept._size >= 400 * response_cache.ENTRY_BYTES


@pytest.mark.parametrize("cursor", ["0" * 60_000 + "1", " 1", "+1", "0x1", "1_0", "A"])
def test_a_cursor_that_was_never_issued_is_refused(board: RunningBoard, cursor: str) -> None:
    """The cursor is part of a cache key, so an arbitrary one could take any amount of memory."""
    topic, _ = topic_on(board, "talk")
    assert board.browser("op").get(f"/t/{topic}", params={"after": cursor}).status_code == 422


@pytest.mark.sqlite  # where several processes may serve the database, responses are not cached
def test_other_cookies_do_not_change_the_cache_key(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk")
    browser, path = board.browser("op"), f"/api/v1/topics/{topic}/posts"
    session = browser.cookies[board.settings.cookie]
    kept = response_cache_of(board)
    for n in range(3):
        cookie = f"{board.settings.cookie}={session}; other={n}"
        assert httpx2.get(board.url + path, headers={"Cookie": cookie}, timeout=60).status_code == 200
    assert len(kept._answers) == 1


def response_cache_of(board: RunningBoard) -> response_cache.ResponseCache:
    """Return the running server's response cache, emptied."""
    layer: Any = board.app.middleware_stack
    while not isinstance(layer, response_cache.ResponseCache):
        layer = layer.app
    layer._answers, layer._size = {}, 0
    return layer
