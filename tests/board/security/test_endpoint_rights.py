"""Every endpoint of the OpenAPI document, called by everybody: the table says who may, and all others are refused."""

from __future__ import annotations

import gzip
from collections.abc import Iterator
from typing import Any

import httpx2
import pytest

from agentrob.board.admin import local_admin
from agentrob.model import AccountKind, Role
from tests.board.auth.test_rights import jpeg, topic_on
from tests.board.running_board import RunningBoard

#: Roles in rising order: whatever a role may do, those after it may do too. `account` is any signed-in account, even a
#: suspended one.
RISING = ("account", "guest", "member", "operator", "moderator", "admin")
#: The lowest role that may call an endpoint, a member of `RISING`. With `+robot`, agents of robots may too; `robot` is
#: the agent of that robot only, `author` the author of the post only, `owner` the robot's owner and admins.
LEAST = {
    "GET /me": "account",
    "GET /notifications": "guest",  # returns the caller's own; an account without any gets an empty list
    "GET /unread": "guest",
    "PUT /unread": "guest",
    "PUT /topics/{topic_id}/read": "guest",
    "GET /accounts/{name}": "guest",
    "GET /boards": "guest",
    "GET /boards/{board_id}/topics": "guest",
    "GET /topics/{topic_id}": "guest",
    "POST /topics": "member+robot",
    "GET /topics/{topic_id}/posts": "guest",
    "POST /topics/{topic_id}/posts": "member+robot",
    "GET /posts": "guest",
    "GET /posts/{post_id}": "guest",
    "PATCH /posts/{post_id}": "author",
    "DELETE /posts/{post_id}": "moderator",
    "GET /posts/{post_id}/hidden": "moderator",
    "POST /posts/{post_id}/hide": "moderator",
    "POST /posts/{post_id}/show": "moderator",
    "POST /topics/{topic_id}/lock": "moderator",
    "POST /topics/{topic_id}/move": "moderator",
    "GET /search": "guest",
    "GET /search/modes": "guest",
    "GET /tags": "guest",
    "PUT /topics/{topic_id}/tags": "moderator",  # the topic was started by another account
    "GET /commands/{post_id}": "guest",
    "POST /commands/read": "guest",
    "POST /commands/{post_id}/approve": "approver",
    "POST /commands/{post_id}/deny": "approver",
    "PUT /commands/{post_id}": "robot+robot",  # for any post, under the robot's own name
    "PUT /commands/{post_id}/replay": "robot+robot",
    "GET /commands/{post_id}/replay": "guest",
    "GET /changes": "guest",
    "GET /events": "guest",
    "GET /robots": "guest",
    "GET /robots/{name}": "guest",
    "GET /robots/{name}/schedules": "guest",
    "PUT /robots/{name}": "robot",
    "PUT /robots/{name}/frame": "robot",
    "GET /robots/{name}/frame.jpg": "guest",
    "GET /robots/{name}/camera.mjpg": "guest",
    "PUT /robots/{name}/pose": "robot",
    "GET /poses": "guest",
    "GET /robots/{name}/map": "guest",
    "PUT /robots/{name}/geometry": "robot",
    "GET /geometry/{name}": "guest",
    "GET /robots/{name}/rights": "guest",
    "POST /robots/{name}/stop": "guest",
    "POST /robots/{name}/estop": "guest",
    "POST /robots/{name}/release": "releaser",
    "POST /robots/{name}/home": "releaser",
    "POST /robots/{name}/reset": "operator",
    "POST /images": "operator+robot",
    "GET /admin/robots/{name}": "owner",
    "PATCH /admin/robots/{name}": "owner",
}
#: The request bodies, where one is needed.
BODIES: dict[str, Any] = {
    "POST /topics": {"board_id": "talk", "title": "t", "body": "b"},
    "POST /topics/{topic_id}/posts": {"body": "b"},
    "PATCH /posts/{post_id}": {"body": "mine now"},
    "POST /topics/{topic_id}/lock": {"locked": False},
    "POST /topics/{topic_id}/move": {"board_id": "talk"},
    "PUT /topics/{topic_id}/tags": {"tags": ["mine"]},
    "PUT /unread": {"up_to": "0"},
    "PUT /robots/{name}": {"card": {}},
    "PUT /robots/{name}/pose": {"pose": [0, 0, 0]},
    "PUT /commands/{post_id}": {"record": {}},
    "POST /commands/read": {"text": "@quadruped wave"},
    "POST /commands/{post_id}/approve": {"robot": "quadruped"},
    "POST /commands/{post_id}/deny": {"robot": "quadruped"},
    "POST /admin/accounts": {"name": "op"},
    "POST /admin/boards": {"id": "talk", "name": "Talk"},
}
#: The account that the requests may change; no test signs in with it.
NAMES = {"name": "victim", "board_id": "talk", "token_id": "0" * 16, "invite_id": "0" * 16}
WITH_SCOPE = ("member", "operator", "moderator", "admin", "robot", "owner")


@pytest.fixture(scope="module")
def everybody(board: RunningBoard) -> dict[str, httpx2.Client]:
    """Return a client of each role and kind, and admins' tokens with narrower scopes."""
    found = {"nobody": board.client()}
    for role in Role:
        account = board.add(f"a-{role}", role=role)
        token = local_admin.issue_token(board.settings, account, "all", ("read", "write", "admin"))
        found[str(role)] = bearer(board, token)
    for name, options in {
        "suspended": {"role": Role.ADMIN},
        "monitor": {"kind": AccountKind.MONITORING_AGENT, "role": Role.ADMIN},
        "other-robot": {"kind": AccountKind.ROBOT_AGENT, "role": Role.MEMBER},
        "victim": {},
        "owner": {"role": Role.MEMBER},
    }.items():
        board.add(name, **options)  # type: ignore[arg-type]
        found[name] = board.client(name)
    local_admin.change_account(board.settings, local_admin.find_account(board.settings, "suspended"), suspended=True)
    found["robot"] = board.client("quadruped")
    agent = board.add("agent", kind=AccountKind.COMMANDING_AGENT, role=Role.ADMIN)
    found["agent"] = bearer(board, local_admin.issue_token(board.settings, agent, "all", ("read", "write", "admin")))
    admin = local_admin.find_account(board.settings, "a-admin")
    found["admin, read only"] = bearer(board, local_admin.issue_token(board.settings, admin, "r", ("read",)))
    found["admin, no admin"] = bearer(board, local_admin.issue_token(board.settings, admin, "w", ("read", "write")))
    found["admin"].patch("/admin/robots/quadruped", json={"owner": "owner"}).raise_for_status()
    found["robot"].put(
        "/robots/quadruped/frame", content=jpeg(), headers={"Content-Type": "image/jpeg"}
    ).raise_for_status()
    return found


def bearer(board: RunningBoard, token: str) -> httpx2.Client:
    client = board.client()
    client.headers["Authorization"] = f"Bearer {token}"
    return client


def operations(board: RunningBoard) -> Iterator[tuple[str, dict[str, Any]]]:
    for path, methods in board.client("op").get("/openapi.json").json()["paths"].items():
        for method, operation in methods.items():
            yield f"{method.upper()} {path.removeprefix('/api/v1')}", operation


def least(name: str) -> str:
    return LEAST.get(name) or ("admin" if " /admin/" in name else "not written down")


def may(who: str, name: str) -> bool:
    """Return the table's answer for an account that did not write the post in question."""
    wanted, _, also = least(name).partition("+")
    reading = name.startswith("GET") and wanted in ("account", "guest", "member")
    looks = wanted in ("account", "guest")
    match who:
        case "nobody":
            return False
        case "suspended":
            return wanted == "account"
        case "robot":
            return looks or also == "robot" or wanted == "robot"
        case "other-robot":
            return looks or also == "robot"
        case "monitor":  # an admin by role, but of a kind that may only read
            return reading or looks or wanted in ("member", "operator")
        case "agent":  # an admin by role, but only people may administer or own robots
            return looks or wanted in ("member", "operator", "moderator")
        case "owner":
            return looks or wanted in ("member", "owner", "releaser")
        case "admin, read only":
            return looks
        case "admin, no admin":
            return looks or wanted in ("member", "operator", "approver", "releaser")
    if wanted in ("owner", "releaser"):  # to release, a token of scope `write` is enough
        return who == "admin"
    if wanted == "approver":  # by default only people may approve
        return who in ("moderator", "admin")
    return wanted in RISING and RISING.index(who if who != "victim" else "member") >= RISING.index(wanted)


def ask(client: httpx2.Client, name: str, ids: dict[str, str]) -> int:
    method, _, path = name.partition(" ")
    robots = "/robots/" in path
    path = path.format(**(NAMES | ids | ({"name": "quadruped"} if robots else {})))
    params = {"key": "x", "q": "x"} if name in ("GET /posts", "GET /search") else {}
    params |= {"board_id": "talk"} if path.endswith("/rights") else {}
    params |= {"robots": "quadruped"} if path == "/poses" else {}
    params |= {"robot": "quadruped"} if path.endswith("/replay") else {}
    options: dict[str, Any] = {"params": params}
    if name == "POST /images":
        options["files"] = {"file": ("x.jpg", jpeg(), "image/jpeg")}
    elif path.endswith("/frame"):
        options |= {"content": jpeg(), "headers": {"Content-Type": "image/jpeg"}}
    elif method == "PUT" and path.endswith(("/geometry", "/replay")):
        options["content"] = gzip.compress(b"{}")
    elif method in ("POST", "PATCH", "PUT"):
        options["json"] = BODIES.get(name, {})
    with client.stream(method, path, **options) as answer:
        return answer.status_code


def test_the_table_lists_every_endpoint(board: RunningBoard) -> None:
    names = [name for name, _ in operations(board)]
    assert [name for name in names if least(name) == "not written down"] == []
    assert [name for name in LEAST if name not in names] == []
    assert len(names) > 40


def test_nobody_may_call_an_endpoint_above_their_rights(
    board: RunningBoard, everybody: dict[str, httpx2.Client]
) -> None:
    wrong = []
    topic, post = topic_on(board, "talk")
    for name, _ in operations(board):
        for who, client in everybody.items():
            status = ask(client, name, {"topic_id": topic, "post_id": post})
            if name == "DELETE /posts/{post_id}" and status < 300:
                topic, post = topic_on(board, "talk")
            refused = status in (401, 403)
            if refused is may(who, name) or status >= 500 or (who == "nobody" and status != 401):
                wrong.append(f"{who}: {name}: {status}")
    assert wrong == []


def test_refused_requests_changed_nothing(board: RunningBoard, everybody: dict[str, httpx2.Client]) -> None:
    topic, post = topic_on(board, "talk", "as it was")
    picture = {"file": ("x.jpg", jpeg(), "image/jpeg")}
    theirs = board.client("author").post("/images", files=picture).json()["id"]
    for who, client in everybody.items():
        assert client.patch(f"/posts/{post}", json={"body": f"{who} was here"}).status_code in (401, 403)
        reply = {"body": "x", "images": [theirs]}
        if who not in ("nobody", "suspended", "guest", "admin, read only"):
            answer = client.post(f"/topics/{topic}/posts", json=reply)
            assert (answer.status_code, answer.json()["code"]) == (404, "no_such_image"), who
    assert board.client("op").get(f"/posts/{post}").json()["raw"] == "as it was"


#: Fields that no body may set, unless the endpoint declares them.
FOREIGN = {
    **{"author": "op", "author_id": "1", "removed": True, "created_at": "2020-01-01T00:00:00Z", "is_admin": 1},
    **{"account_id": "1", "key": "x", "html": "<b>", "mentions": ["op"], "password_hash": "x", "version": 9},
}


def test_law_1_undeclared_fields_of_a_body_change_nothing(
    board: RunningBoard, everybody: dict[str, httpx2.Client]
) -> None:
    """Mass assignment: send each JSON body of the document with one undeclared field added to the valid ones."""
    topic, post = topic_on(board, "talk")
    ids, tried = NAMES | {"topic_id": topic, "post_id": post}, 0
    for name, operation in operations(board):
        if "application/json" not in operation.get("requestBody", {}).get("content", {}):
            continue
        method, _, path = name.partition(" ")
        path = path.format(**(ids | ({"name": "quadruped"} if "/robots/" in path else {})))
        client = everybody["robot" if name == "PUT /robots/{name}" else "admin"]
        for field, value in (FOREIGN | {"role": "owner", "kind": "robot_agent", "suspended": "no"}).items():
            body = BODIES.get(name, {}) | {field: value}
            if name in ("POST /admin/accounts",) and field == "kind":
                continue
            answer = client.request(method, path, json=body)
            assert answer.status_code == 422, (name, field, answer.text)
            tried += 1
    assert tried > 150
