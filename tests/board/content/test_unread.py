"""Unread posts over the API, by board and by topic: pages and API agree, and read positions never go back."""

from __future__ import annotations

from typing import Any

import httpx2
import pytest

from agentrob.board.admin import local_admin
from agentrob.board.content import unread
from agentrob.model import Role
from tests.board.auth.test_rights import admin_api, new_board
from tests.board.content.test_tags import api_client
from tests.board.running_board import RunningBoard, running_board


@pytest.fixture
def newcomer(board: RunningBoard, request: pytest.FixtureRequest) -> httpx2.Client:
    """Return the client of an account without unread posts."""
    name = f"n-{abs(hash(request.node.name)) % 10**8}"
    board.add(name)
    return board.client(name)


def topic_on(board: RunningBoard, where: str, by: str = "op") -> tuple[str, str]:
    made = api_client(board, by).post("/topics", json={"board_id": where, "title": "t", "body": "words"}).json()
    return made["topic"]["id"], made["post"]["id"]


def more(board: RunningBoard, topic: str, by: str = "op") -> str:
    answer = api_client(board, by).post(f"/topics/{topic}/posts", json={"body": "more"})
    return str(answer.json()["post"]["id"])


def new(client: httpx2.Client, **asked: Any) -> dict[str, tuple[int, str]]:
    """Return for each topic the number of unread posts and the first of them."""
    page = client.get("/unread", params=asked).raise_for_status().json()
    return {item["topic"]["id"]: (item["new"], item["first_post_id"]) for item in page["items"]}


def test_posts_of_others_are_unread_by_topic_and_by_board(board: RunningBoard, newcomer: httpx2.Client) -> None:
    assert new(newcomer) == {}
    (talk, first), (robots, asked) = topic_on(board, "talk"), topic_on(board, "robots")
    more(board, talk, "member")
    newcomer.post(f"/topics/{robots}/posts", json={"body": "mine"}).raise_for_status()
    assert new(newcomer) == {robots: (1, asked), talk: (2, first)}
    assert list(new(newcomer)) == [robots, talk], "latest activity first"
    assert new(newcomer, board_id="talk") == {talk: (2, first)}
    page = newcomer.get("/unread", params={"limit": 1}).json()
    assert [item["topic"]["id"] for item in page["items"]] == [robots]
    assert list(new(newcomer, cursor=page["next"])) == [talk]
    assert newcomer.get("/unread", params={"board_id": "nowhere"}).status_code == 404


def test_a_topic_is_marked_read_up_to_a_post_and_never_back(board: RunningBoard, newcomer: httpx2.Client) -> None:
    topic, first = topic_on(board, "talk")
    second, third = more(board, topic), more(board, topic)

    def read(**body: str) -> dict[str, Any]:
        answer: dict[str, Any] = newcomer.put(f"/topics/{topic}/read", json=body).raise_for_status().json()
        return answer

    answer = read(up_to=first)
    assert (answer["topic"]["id"], answer["new"], answer["first_post_id"]) == (topic, 2, second)
    assert new(newcomer) == {topic: (2, second)}
    assert read(up_to=second)["first_post_id"] == third
    assert read(up_to=first)["first_post_id"] == third, "never less than before"
    assert (read()["new"], read()["first_post_id"], new(newcomer)) == (0, None, {})
    assert read(up_to="9" * 18)["new"] == 0
    later = more(board, topic)
    assert new(newcomer) == {topic: (1, later)}, "a number of the future hides nothing"
    assert newcomer.put("/topics/999999/read", json={}).status_code == 404


def test_a_board_or_all_boards_are_marked_read_up_to_the_listed_posts(
    board: RunningBoard, newcomer: httpx2.Client
) -> None:
    (talk, _), (robots, asked) = topic_on(board, "talk"), topic_on(board, "robots")
    up_to = newcomer.get("/unread").json()["up_to"]
    later = more(board, talk)
    assert new(newcomer)[talk][0] == 2
    still = newcomer.put("/unread", json={"up_to": up_to, "board_id": "talk"}).raise_for_status().json()
    assert [(item["topic"]["id"], item["first_post_id"]) for item in still["items"]] == [(talk, later)]
    assert new(newcomer) == {talk: (1, later), robots: (1, asked)}
    newcomer.put("/unread", json={"up_to": still["up_to"], "board_id": "talk"}).raise_for_status()
    assert new(newcomer) == {robots: (1, asked)}
    newcomer.put("/unread", json={"up_to": "0"}).raise_for_status()
    assert new(newcomer) == {robots: (1, asked)}
    newcomer.put("/unread", json={"up_to": still["up_to"]}).raise_for_status()
    assert new(newcomer) == {}


def test_api_and_pages_share_read_positions(board: RunningBoard) -> None:
    board.add("both")
    client, browser = board.client("both"), board.browser("both")
    (one, _), (two, _) = topic_on(board, "talk"), topic_on(board, "talk")
    assert 'class="count"' in browser.get("/unread").text
    browser.get(f"/t/{one}")
    assert list(new(client)) == [two]
    client.put(f"/topics/{two}/read", json={}).raise_for_status()
    assert 'class="count"' not in browser.get("/unread").text


def test_read_positions_set_by_api_survive_a_killed_server(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    async def killed(*_: object) -> None:
        """Discard the read positions of pages, as when the server is killed."""

    monkeypatch.setattr(unread.ReadPositions, "write", killed)
    for n in range(2):
        with running_board(tmp_path) as board:
            board.have("keeper", role=Role.MEMBER)
            client = board.client("keeper")
            if n == 0:
                topic, _ = topic_on(board, "talk")
                second = more(board, topic)
                client.put(f"/topics/{topic}/read", json={}).raise_for_status()
            assert new(client) == {}
            client.put(f"/topics/{topic}/read", json={"up_to": "0"}).raise_for_status()
            assert new(client) == {}, "also where the mark was not asked for before"
    assert second


def test_unreadable_posts_are_neither_listed_nor_marked(board: RunningBoard, newcomer: httpx2.Client) -> None:
    where = new_board(board, "closed-unread", read_role="operator", post_role="operator")
    topic, _ = topic_on(board, where)
    assert new(newcomer) == {}
    assert newcomer.get("/unread", params={"board_id": where}).status_code == 404
    assert newcomer.put("/unread", json={"up_to": "0", "board_id": where}).status_code == 404
    assert newcomer.put(f"/topics/{topic}/read", json={}).status_code == 404
    assert list(new(admin_api(board), board_id=where)) == [topic]


def test_a_read_only_token_may_mark_posts_read_and_a_browser_needs_its_csrf_token(board: RunningBoard) -> None:
    topic, _ = topic_on(board, "talk")
    account = board.add("reading")
    client = board.client()
    client.headers["Authorization"] = f"Bearer {local_admin.issue_token(board.settings, account, 'r', ('read',))}"
    assert client.put(f"/topics/{topic}/read", json={}).status_code == 200
    answer = board.browser("reading").put(f"/api/v1/topics/{topic}/read", json={})
    assert (answer.status_code, answer.json()["code"]) == (403, "bad_csrf")
