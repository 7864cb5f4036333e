"""Approvals on the board: who may decide in the thread, and notifications of a thread that was read."""

from __future__ import annotations

import re

import httpx2
import pytest

from agentrob.model import Role
from tests.board.running_board import RunningBoard

BUTTON = 'value="approve"'


def waiting_command(board: RunningBoard, **more: str) -> tuple[str, str, str]:
    """Post a command by `op` that waits for an approval; return its topic, its post and the robot's status post."""
    made = (
        board.client("op").post("/topics", json={"board_id": "robots", "title": "t", "body": "@quadruped flip"}).json()
    )
    topic, post = made["topic"]["id"], made["post"]["id"]
    card = {"robot": "quadruped", "state": "waiting"} | more
    told = {"body": "This waits for an approval.", "reply_to": post, "card": card}
    key = {"Idempotency-Key": f"claim:{post}"}
    answer = board.client("quadruped").post(f"/topics/{topic}/posts", json=told, headers=key)
    return topic, post, str(answer.json()["post"]["id"])


def submit_decision(browser: httpx2.Client, page: str, do: str) -> httpx2.Response:
    """Submit the approval form of a page, like a browser without scripts."""
    form = re.search(r'<form class="approve-form".*?</form>', page, re.DOTALL)
    assert form
    fields = dict(re.findall(r'name="(\w+)" value="([^"]*)"', form[0].partition("<button")[0]))
    action = re.search(r'action="([^"]+)"', form[0])
    assert action
    return browser.post(action[1], data=fields | {"do": do})


def test_approvers_see_the_approval_buttons_until_a_decision(board: RunningBoard) -> None:
    topic, post, status = waiting_command(board)
    admin, path = board.browser("admin"), f"/t/{topic}"
    for name in ("member", "op"):  # op gave the command
        assert BUTTON not in board.browser(name).get(path).text
    page = admin.get(path).text
    assert BUTTON in page
    assert BUTTON in admin.get(f"/p/{status}/fragment").text, "also where scripts put it in"
    assert submit_decision(admin, page, "approve").status_code == 303
    said = board.client("op").get(f"/topics/{topic}/posts").json()["items"][-1]
    assert (said["raw"], said["reply_to"], said["author"]["name"]) == ("@quadruped approve", post, "admin")
    for gone in (path, f"/c/{post}", f"/p/{status}/fragment"):
        assert BUTTON not in admin.get(gone).text, "it is decided, though its agent has not said so yet"


def test_a_run_of_a_schedule_that_waits_has_approval_buttons(board: RunningBoard) -> None:
    """Its status post is a further reply to the schedule's post, with a key of its own."""
    made = board.client("op").post("/topics", json={"board_id": "robots", "title": "t", "body": "@quadruped flip"})
    topic, post = made.json()["topic"]["id"], made.json()["post"]["id"]
    for key, state in ((f"claim:{post}", "answered"), (f"claim:{post}@1", "done"), (f"claim:{post}@2", "waiting")):
        told = {"body": "Told.", "reply_to": post, "card": {"robot": "quadruped", "state": state}}
        board.client("quadruped").post(f"/topics/{topic}/posts", json=told, headers={"Idempotency-Key": key})
    board.client("quadruped").post(f"/topics/{topic}/posts", json={"body": "That was the last.", "reply_to": post})
    admin, path = board.browser("admin"), f"/t/{topic}"
    page = admin.get(path).text
    assert page.count(BUTTON) == 1
    assert submit_decision(admin, page, "approve").status_code == 303
    assert BUTTON not in admin.get(path).text


@pytest.mark.parametrize("decision", ["approve", "deny"])
def test_approving_and_denying_are_two_calls_of_the_api_that_write_the_same_reply(
    board: RunningBoard, decision: str
) -> None:
    topic, post, _ = waiting_command(board)
    path, body = f"/commands/{post}/{decision}", {"robot": "quadruped"}
    assert board.client("op").post(path, json=body).status_code == 403, "op asked for it"
    admin, key = board.client("admin"), {"Idempotency-Key": decision}
    assert [admin.post(path, json=body, headers=key).status_code for _ in range(2)] == [201, 200]
    said = board.client("op").get(f"/topics/{topic}/posts").json()["items"][2:]
    assert [(p["raw"], p["reply_to"], p["author"]["name"]) for p in said] == [(f"@quadruped {decision}", post, "admin")]


def test_the_deadline_of_an_approval_is_shown_in_the_readers_time_zone(board: RunningBoard) -> None:
    _, post, status = waiting_command(board, until="2026-11-22T21:14:05+01:00")
    board.client("quadruped").put("/robots/quadruped", json={"card": {"line": [post]}}).raise_for_status()
    shown = 'until <time datetime="2026-11-22T20:14:05.000Z"'
    for path in (f"/p/{status}/fragment", f"/c/{post}", "/robots/quadruped/fragment", "/notifications"):
        assert board.browser("admin").get(path).text.count(shown) == 1, path
    queue = board.browser("admin").get("/robots/quadruped/fragment").text.partition("<h2>Queue</h2>")[2]
    assert "waits for approval" in queue
    card = {"robot": "quadruped", "state": "expired", "until": "2026-11-22T21:14:05+01:00"}
    board.client("quadruped").patch(f"/posts/{status}", json={"body": "Too late.", "card": card}).raise_for_status()
    assert shown not in board.browser("admin").get(f"/p/{status}/fragment").text


@pytest.mark.parametrize("until", ["", "soon", "2026-11-22T21:14:05", "0001-01-01T00:00:00+14:00", "<b>"])
def test_an_invalid_deadline_is_not_shown(board: RunningBoard, until: str) -> None:
    _, _, status = waiting_command(board, until=until)
    answer = board.browser("admin").get(f"/p/{status}/fragment")
    assert (answer.status_code, "until" in answer.text) == (200, False)


def test_unknown_fields_of_a_newer_agents_card_are_ignored(board: RunningBoard) -> None:
    topic, post, status = waiting_command(board, until="2026-11-22T20:14:05+00:00", mood="x" * 5_000)
    kept = board.client("op").get(f"/posts/{status}").json()
    assert kept["reply_to"] == post
    assert kept["card"]["until"] == "2026-11-22T20:14:05+00:00"
    assert "mood" not in kept["card"]
    told = {"body": "x", "card": {"robot": "quadruped", "state": "waiting", "until": "2" * 41}}
    assert board.client("quadruped").post(f"/topics/{topic}/posts", json=told).status_code == 422


def test_approvers_are_notified_while_the_command_waits(board: RunningBoard) -> None:
    """Approvers are also notified if the status post (first the claim) is edited to `waiting`.

    The notification is withdrawn when the command has ended.
    """
    board.add("watcher", role=Role.MODERATOR)
    topic, _, status = waiting_command(board)

    def notifications() -> dict[str, list[str]]:
        items = {n: board.client(n).get("/notifications").json()["items"] for n in ("watcher", "admin", "member", "op")}
        return {n: [i["kind"] for i in found if i["id"] == status] for n, found in items.items()}

    def set_state(state: str) -> None:
        card = {"robot": "quadruped", "state": state}
        board.client("quadruped").patch(f"/posts/{status}", json={"body": state, "card": card}).raise_for_status()

    asked = {"watcher": ["approve"], "admin": ["approve"], "member": [], "op": ["reply"]}
    assert notifications() == asked
    page = board.browser("watcher").get("/notifications").text
    assert "waits for your approval" in page
    assert f'href="/p/{status}"' in page
    set_state("running")
    assert notifications() == asked | {"watcher": [], "admin": []}
    set_state("waiting")
    assert notifications() == asked
    assert BUTTON in board.browser("watcher").get(f"/t/{topic}").text


def test_an_expired_command_has_no_approval_buttons(board: RunningBoard) -> None:
    topic, _, status = waiting_command(board)
    card = {"robot": "quadruped", "state": "expired"}
    board.client("quadruped").patch(f"/posts/{status}", json={"body": "Too late.", "card": card}).raise_for_status()
    assert BUTTON not in board.browser("admin").get(f"/t/{topic}").text


def test_the_command_page_is_reached_from_the_robots_report(board: RunningBoard) -> None:
    _, post, status = waiting_command(board)
    browser = board.browser("op")
    moved = browser.get(f"/c/{status}")
    assert (moved.status_code, moved.headers["location"]) == (303, f"/c/{post}")
    page = browser.get(f"/c/{status}", follow_redirects=True).text
    assert re.search(r"Asked by <a[^>]*>op</a>", page)


def test_reading_a_thread_clears_its_notifications(board: RunningBoard) -> None:
    board.add("reading")
    browser = board.browser("reading")
    topics = []
    for _ in range(2):
        made = (
            board.client("op").post("/topics", json={"board_id": "talk", "title": "t", "body": "@reading look"}).json()
        )
        topics.append(made["topic"]["id"])
    count = lambda: len(board.client("reading").get("/notifications").json()["items"])  # noqa: E731
    fresh = lambda: [n["read"] for n in board.client("reading").get("/notifications").json()["items"]]  # noqa: E731
    assert (count(), fresh()) == (2, [False, False])
    assert ">2<" in browser.get("/notifications/count").text
    assert browser.get(f"/t/{topics[1]}").status_code == 200
    board.run(board.services.marks.write(board.services.store))  # as every few seconds
    assert fresh() == [True, False], "of the other thread it is still news"
    assert ">1<" in browser.get("/notifications/count").text


def test_the_menu_counts_what_waits_for_the_viewers_approval(board: RunningBoard) -> None:
    board.add("keeper", role=Role.MODERATOR)
    keeper = board.browser("keeper")
    assert "Approvals</span></a>" in keeper.get("/").text, "shown to who may approve, also if nothing waits"
    assert "No command waits for your approval" in keeper.get("/approvals").text
    _, _, first = waiting_command(board)
    _, _, second = waiting_command(board)
    shown = 'Approvals <span class="count">2'
    assert shown in keeper.get("/").text
    page = keeper.get("/approvals")
    assert shown in page.text
    assert [page.text.index(f'href="/p/{status}"') for status in (first, second)] == sorted(
        page.text.index(f'href="/p/{status}"') for status in (first, second)
    ), "the oldest first"
    answer = submit_decision(keeper, page.text, "deny")
    assert answer.headers["location"].startswith("/approvals?done=")
    listed = keeper.get("/approvals?part=list").text
    assert f'href="/p/{first}"' not in listed
    assert f'href="/p/{second}"' in listed
    assert keeper.get("/approvals?part=count").text.startswith('Approvals <span class="count">1')
    for name in ("op", "member"):
        assert ">Approvals" not in board.browser(name).get("/").text
        assert "You may not approve commands" in board.browser(name).get("/approvals").text
    closed = {"robot": "quadruped", "state": "expired"}
    board.client("quadruped").patch(f"/posts/{second}", json={"body": "Too late.", "card": closed}).raise_for_status()
    assert f'href="/p/{second}"' not in keeper.get("/approvals").text


def test_opening_a_thread_reads_its_notifications_at_once(board: RunningBoard) -> None:
    board.add("starter", role=Role.MODERATOR)
    client, browser = board.client("starter"), board.browser("starter")
    made = client.post("/topics", json={"board_id": "talk", "title": "t", "body": "words"}).json()["topic"]["id"]
    other = client.post("/topics", json={"board_id": "talk", "title": "u", "body": "words"}).json()["topic"]["id"]
    for topic in (made, other):
        board.client("op").post(f"/topics/{topic}/posts", json={"body": "an answer"}).raise_for_status()
    bell = 'Notifications <span class="count">'
    assert f"{bell}2" in browser.get("/").text
    assert f"{bell}1" in browser.get(f"/t/{made}").text, "already on the page that shows it"
    assert browser.get("/notifications").text.count('class="row fresh"') == 1
    read = {item["post"]["topic_id"]: item["read"] for item in client.get("/notifications").json()["items"]}
    assert (read[made], read[other]) == (True, False)
