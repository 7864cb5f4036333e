"""Topics, posts, edits, removals and idempotency keys over the JSON API, as an agent or a script uses them."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import httpx2
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.board.running_board import RunningBoard


def new_topic(client: httpx2.Client, body: str = "hello", **fields: object) -> dict:
    answer = client.post("/topics", json={"board_id": "robots", "title": "A topic", "body": body, **fields})
    assert answer.status_code == 201, answer.text
    return answer.json()


def test_a_topic_is_written_and_read_back(board: RunningBoard) -> None:
    op = board.client("op")
    made = new_topic(op, "**walk**")
    topic, post = made["topic"], made["post"]
    assert made["created"] is True
    assert topic["url"].startswith(board.url)
    assert (post["raw"], post["version"], post["author"]["name"]) == ("**walk**", 1, "op")
    assert "<strong>walk</strong>" in post["html"]
    assert op.get(f"/topics/{topic['id']}").json() == topic
    assert op.get(f"/topics/{topic['id']}/posts").json() == {"items": [post], "next": None}
    assert op.get(f"/posts/{post['id']}").json() == post
    assert op.get("/boards/robots/topics").json()["items"][0] == topic


def test_only_visible_accounts_are_mentioned(board: RunningBoard) -> None:
    body = "@Quadruped and @nobody\n\n> @op\n\n`@member` <b>@admin</b>\n\n- @quadruped"
    assert new_topic(board.client("op"), body)["post"]["mentions"] == ["quadruped"]


def test_reusing_a_key_creates_one_post(board: RunningBoard) -> None:
    op = board.client("op")
    topic = new_topic(op)["topic"]
    path, key = f"/topics/{topic['id']}/posts", {"Idempotency-Key": "claim:1"}
    first = op.post(path, json={"body": "one"}, headers=key)
    second = op.post(path, json={"body": "other content"}, headers=key)
    assert (first.status_code, second.status_code) == (201, 200)
    assert second.json() == {"post": first.json()["post"], "created": False}
    assert first.json()["post"]["key"] == "claim:1"
    assert op.get("/posts", params={"key": "claim:1"}).json()["items"] == [first.json()["post"]]


def test_a_key_belongs_to_one_account(board: RunningBoard) -> None:
    op, member = board.client("op"), board.client("member")
    path, key = f"/topics/{new_topic(op)['topic']['id']}/posts", {"Idempotency-Key": "mine"}
    mine = op.post(path, json={"body": "one"}, headers=key).json()["post"]
    assert member.get("/posts", params={"key": "mine"}).json()["items"] == []
    assert member.get(f"/posts/{mine['id']}").json()["key"] is None
    assert member.post(path, json={"body": "two"}, headers=key).status_code == 201


def test_concurrent_requests_with_one_key_create_one_post(board: RunningBoard) -> None:
    path = f"/topics/{new_topic(board.client('op'))['topic']['id']}/posts"

    def write(n: int) -> tuple[int, str]:
        answer = board.client("op").post(path, json={"body": f"try {n}"}, headers={"Idempotency-Key": "race"})
        return answer.status_code, answer.json()["post"]["id"]

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(write, range(16)))
    assert sorted(status for status, _ in answers) == [200] * 15 + [201]
    assert len({post for _, post in answers}) == 1


def test_reusing_a_topics_key_returns_the_first_topic(board: RunningBoard) -> None:
    op, key = board.client("op"), {"Idempotency-Key": "topic-key"}
    fields = {"board_id": "talk", "title": "Once", "body": "x"}
    first = op.post("/topics", json=fields, headers=key)
    second = op.post("/topics", json=fields, headers=key)
    assert second.status_code == 200
    assert second.json() == first.json() | {"created": False}


def test_an_edit_adds_a_version_and_keeps_the_old_text(board: RunningBoard) -> None:
    op = board.client("op")
    post = new_topic(op, "first")["post"]
    edited = op.patch(f"/posts/{post['id']}", json={"body": "second @op"}).json()
    assert (edited["raw"], edited["version"], edited["mentions"]) == ("second @op", 2, ["op"])
    assert edited["edited_at"] > post["created_at"]
    kept = board.services.store.everything.versions
    # The store belongs to the server's thread, which is idle between requests.
    assert [(v.version, v.raw) for v in kept(post["id"])] == [(1, "first")]


def test_edits_of_a_running_status_post_keep_no_versions(board: RunningBoard) -> None:
    robot, op = board.client("quadruped"), board.client("op")
    topic = new_topic(op)["topic"]["id"]
    texts = [("seen", "Seen."), ("waiting", "May I walk 2 m?")] + [("running", f"Step {n}") for n in range(1, 9)]
    texts += [("done", "Done: 2.0 m."), ("done", "Done: 2.00 m.")]
    made: dict[str, Any] = {}
    for state, text in texts:
        body = {"body": text, "card": {"robot": "quadruped", "state": state}}
        if made:
            answer = robot.patch(f"/posts/{made['id']}", json=body).json()
        else:
            made = answer = robot.post(f"/topics/{topic}/posts", json=body).json()["post"]
    assert (answer["raw"], answer["version"]) == ("Done: 2.00 m.", len(texts))
    history = board.browser("op").get(f"/p/{made['id']}/history").text
    assert "May I walk 2 m?" in history
    assert "Done: 2.0 m." in history
    assert "Step" not in history
    assert "Seen." not in history


def test_an_edit_with_a_used_key_is_applied_once(board: RunningBoard) -> None:
    op = board.client("op")
    post = new_topic(op)["post"]
    for body in ("second", "third"):
        answer = op.patch(f"/posts/{post['id']}", json={"body": body}, headers={"Idempotency-Key": "e1"}).json()
        assert (answer["raw"], answer["version"]) == ("second", 2)


def test_only_the_author_edits_a_post_and_admins_hide_it(board: RunningBoard) -> None:
    member, op, admin = board.client("member"), board.client("op"), board.client("admin")
    post = new_topic(member, "rude words")["post"]
    path = f"/posts/{post['id']}"
    assert op.patch(path, json={"body": "x"}).json()["code"] == "not_yours"
    assert admin.patch(path, json={"body": "x"}).status_code == 403
    assert op.delete(path).status_code == 403
    removed = admin.delete(path).json()
    assert removed["removed"] is True
    assert (removed["raw"], removed["html"], removed["mentions"]) == ("", "", [])
    assert admin.delete(path).status_code == 200
    assert member.get(path).json()["raw"] == ""
    assert member.patch(path, json={"body": "again"}).json()["code"] == "removed"
    assert post["topic_id"] not in [t["id"] for t in op.get("/boards/robots/topics").json()["items"]]


def test_paging_returns_each_post_once_in_order(board: RunningBoard) -> None:
    op = board.client("op")
    topic = new_topic(op)["topic"]["id"]
    made = [op.post(f"/topics/{topic}/posts", json={"body": str(n)}).json()["post"]["id"] for n in range(7)]
    seen, cursor = [], None
    while True:
        params = {"limit": 3} | ({"cursor": cursor} if cursor else {})
        page = op.get(f"/topics/{topic}/posts", params=params).json()
        seen += [p["id"] for p in page["items"]]
        if (cursor := page["next"]) is None:
            break
    assert seen[1:] == made


def test_a_post_is_found_on_its_page(board: RunningBoard) -> None:
    op = board.client("op")
    topic = new_topic(op)["topic"]["id"]
    for n in range(6):
        op.post(f"/topics/{topic}/posts", json={"body": str(n)})
    store = board.services.store.everything
    for post in store.posts(topic, None, 50).items:
        page = store.posts(topic, store.cursor_before(post.id, 3), 3)
        assert post.id in [p.id for p in page.items]


def test_topics_are_sorted_by_latest_activity(board: RunningBoard) -> None:
    op = board.client("op")
    first, second = (new_topic(op, board_id="talk")["topic"]["id"] for _ in range(2))
    op.post(f"/topics/{first}/posts", json={"body": "up"})
    page = op.get("/boards/talk/topics", params={"limit": 1}).json()
    after = op.get("/boards/talk/topics", params={"limit": 1, "cursor": page["next"]}).json()
    assert [page["items"][0]["id"], after["items"][0]["id"]] == [first, second]
    assert page["items"][0]["posts"] == 2


def test_a_reply_must_refer_to_a_post_of_its_topic(board: RunningBoard) -> None:
    op = board.client("op")
    here, there = new_topic(op), new_topic(op)
    path = f"/topics/{here['topic']['id']}/posts"
    good = op.post(path, json={"body": "x", "reply_to": here["post"]["id"]})
    assert good.json()["post"]["reply_to"] == here["post"]["id"]
    for wrong in (there["post"]["id"], "999999", "x"):
        assert op.post(path, json={"body": "x", "reply_to": wrong}).json()["code"] == "no_such_post"


def test_only_robot_agents_may_send_cards(board: RunningBoard) -> None:
    robot, op = board.client("quadruped"), board.client("op")
    topic = new_topic(op)["topic"]["id"]
    card = {"robot": "quadruped", "state": "running", "step": 2, "steps": 4}
    post = robot.post(f"/topics/{topic}/posts", json={"body": "on it", "card": card}).json()["post"]
    assert post["card"] == card | {"doing": "", "place": None, "trace_id": "", "until": ""}
    kept = robot.patch(f"/posts/{post['id']}", json={"body": "still"}).json()
    assert kept["card"] == post["card"]
    gone = robot.patch(f"/posts/{post['id']}", json={"body": "done", "card": None}).json()
    assert gone["card"] is None
    refused = op.post(f"/topics/{topic}/posts", json={"body": "me too", "card": card})
    assert (refused.status_code, refused.json()["code"]) == (403, "not_a_robot")


@pytest.mark.parametrize(
    ("path", "code"),
    [
        ("/topics/999", "no_such_topic"),
        ("/topics/abc", "no_such_topic"),
        ("/topics/99999999999999999999999", "no_such_topic"),
        ("/posts/²", "no_such_post"),
        ("/boards/nope/topics", "no_such_board"),
        ("/accounts/nobody", "no_such_account"),
        ("/robots/op", "no_such_robot"),
        ("/changes?after=999999", "no_such_event"),
        ("/nothing", "not_found"),
    ],
)
def test_a_missing_resource_is_a_404_with_a_hint(board: RunningBoard, path: str, code: str) -> None:
    answer = board.client("op").get(path)
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["code"] == code


def test_an_unknown_board_is_answered_with_the_known_ones(board: RunningBoard) -> None:
    answer = board.client("op").post("/topics", json={"board_id": "nope", "title": "x", "body": "y"})
    assert answer.json()["hint"] == "valid: robots, talk"


def test_a_post_of_64_kib_is_accepted_and_a_longer_one_refused(board: RunningBoard) -> None:
    op = board.client("op")
    path = f"/topics/{new_topic(op)['topic']['id']}/posts"
    chinese = "停" * (64 * 1024 // 3)
    assert op.post(path, json={"body": chinese}).status_code == 201
    too_long = op.post(path, json={"body": chinese + "停"})
    assert (too_long.status_code, too_long.json()["code"]) == (413, "post_too_large")
    huge = op.post(path, json={"body": "x" * 600_000})
    assert (huge.status_code, huge.json()["code"]) == (413, "too_large")


def test_a_chunked_body_has_a_size_limit(board: RunningBoard) -> None:
    op = board.client("op")
    chunks = (b" " * 65536 for _ in range(12))
    answer = op.post("/topics", content=chunks, headers={"Content-Type": "application/json"})
    assert answer.status_code == 413


@pytest.mark.parametrize("body", ["", " \n\t", "a\x00b"])
def test_posts_without_visible_text_are_refused(board: RunningBoard, body: str) -> None:
    answer = board.client("op").post("/topics", json={"board_id": "talk", "title": "x", "body": body})
    assert (answer.status_code, answer.json()["code"]) == (422, "not_valid")


def test_a_lone_surrogate_is_refused(board: RunningBoard) -> None:
    raw = b'{"board_id": "talk", "title": "x", "body": "\\ud800"}'
    answer = board.client("op").post("/topics", content=raw, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(body=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=200))
def test_a_posted_text_is_returned_unchanged(board: RunningBoard, body: str) -> None:
    op = board.client("op")
    answer = op.post("/topics", json={"board_id": "talk", "title": "t", "body": body})
    if answer.status_code == 201:
        assert answer.json()["post"]["raw"] == body
    else:
        assert answer.status_code == 422
        assert "\x00" in body or not body.strip()
    op.close()
