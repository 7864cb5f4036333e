"""A forum with everything on it that a page can show, and the list of all pages: for axe and for the docs' pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from sqlalchemy import update

from agentrob.board.admin import local_admin
from agentrob.board.db import schema as db
from tests.board.web import told_commands as robot_told
from tests.board.web.page_world import CARD, World
from tests.board.web.told_commands import IMAGES, ROBOT, tell

CARD_SHOWN = CARD | {
    "ops": ["move", "turn", "hello", "heart", "get_front_image"],
    "limits": {"speed_mps": 0.5, "turn_dps": 45, "step_m": 5, "command_m": 10, "command_s": 60, "command_steps": 10},
    "state": "walking",
    "queue": 1,
}


@dataclass(frozen=True, slots=True)
class Shown:
    """One page: what it is called, its address with the names of `fill`, and who looks (None: nobody signed in)."""

    name: str
    path: str
    who: str | None = "alice"
    quick: bool = True  # one of each kind, looked at where time is short


PAGES = (
    Shown("home", "/"),
    Shown("board", "/b/robots"),
    Shown("topic", "/t/{topic}"),
    Shown("command", "/c/{walk}"),
    Shown("command-looked", "/c/{look}"),
    Shown("command-none", "/c/{waiting}", quick=False),
    Shown("approval", "/c/{asks}", "root"),
    Shown("approval-of-others", "/c/{asks}", quick=False),
    Shown("approval-given", "/c/{approved}", "root", quick=False),
    Shown("approval-refused", "/c/{denied}", "root"),
    Shown("approval-late", "/c/{expired}", quick=False),
    Shown("command-stopped", "/c/{stopped}", quick=False),
    Shown("command-removed", "/c/{removed}", quick=False),
    Shown("robot-approves", f"/robots/{ROBOT}", "root", quick=False),
    Shown("robot", f"/robots/{ROBOT}"),
    Shown("release", f"/robots/{ROBOT}/release", "root"),
    Shown("set-home", f"/robots/{ROBOT}/home", "root", quick=False),
    Shown("robots", "/robots"),
    Shown("search", "/search?q=walk"),
    Shown("search-meaning", "/search?q=stroll to the glass&by=meaning", quick=False),
    Shown("search-empty", "/search"),
    Shown("search-chinese", "/search?q=机器人 前进", quick=False),
    Shown("latest", "/latest"),
    Shown("unread", "/unread", "bob", quick=False),
    Shown("tags", "/tags", quick=False),
    Shown("tag", "/tags/window"),
    Shown("topic-tags", "/t/{topic}/tags"),
    Shown("notifications", "/notifications"),
    Shown("new-topic", "/b/robots/new?to=quadruped"),
    Shown("quote", "/t/{topic}?quote={said}#reply", quick=False),
    Shown("edit", "/p/{walk}/edit"),
    Shown("history", "/p/{said}/history"),
    Shown("remove", "/p/{walk}/remove", quick=False),
    Shown("me", "/u/alice"),
    Shown("person", "/u/bob", quick=False),
    Shown("password", "/password", quick=False),
    Shown("not-found", "/t/999999"),
    Shown("api", "/docs", None),
    Shown("sign-in", "/sign-in", None),
    Shown("sign-up", "/sign-up", None, quick=False),
    Shown("enter", "{enter}", None),
    Shown("invite", "{invite}", None, quick=False),
    Shown("set-password", "{password}", None),
    Shown("admin-accounts", "/admin/accounts", "root"),
    Shown("admin-account", "/admin/accounts/bob", "root", quick=False),
    Shown("admin-boards", "/admin/boards", "root"),
    Shown("admin-robots", "/admin/robots", "root", quick=False),
    Shown("admin-robot", f"/admin/robots/{ROBOT}", "root"),
    Shown("admin-invites", "/admin/invites", "root"),
    Shown("admin-audit", "/admin/audit", "root"),
    Shown("moderate-topic", "/t/{topic}/moderate", "root"),
    Shown("moderate-post", "/p/{said}/moderate", "root", quick=False),
)


def fill(world: World) -> dict[str, str]:
    """Let people and the robot write; the names in the addresses of `PAGES`."""
    alice, bob, robot = (world.api(name) for name in ("alice", "bob", ROBOT))
    robot.put(f"/robots/{ROBOT}", json={"card": CARD_SHOWN}).raise_for_status()
    begin = alice.post(
        "/topics", json={"board_id": "talk", "title": "机器人记录", "body": "机器人前进了两米。", "tags": ["记录"]}
    )
    begin.raise_for_status()
    text = f"@{ROBOT} walk forward 2 metres, turn left and take a photo"
    topic = {"board_id": "robots", "title": "A walk to the window", "body": text, "tags": ["window", "photo", "窗户"]}
    made = alice.post("/topics", json=topic).json()
    topic, walk = made["topic"]["id"], made["post"]["id"]
    earlier(world, walk, 8.0)
    tell(world, topic, walk, robot_told.walk(walk, topic))
    said = _says(
        world, "bob", topic, f"> walk forward 2 metres\n\n@alice that was **quick**. Next: `@{ROBOT} wave`?", walk
    )
    bob.patch(
        f"/posts/{said}", json={"body": f"> walk forward 2 metres\n\n@alice that was quick. Next: `@{ROBOT} wave`?"}
    )
    look = _says(world, "alice", topic, f"@{ROBOT} go and look for the red ball")
    earlier(world, look, 5.0)
    tell(world, topic, look, robot_told.look(look, topic), robot_told.looked())
    waiting = _says(
        world, "alice", topic, f"@{ROBOT} turn right by 90 degrees\n\n| lap | time |\n|---|--:|\n| 1 | 12 s |"
    )
    ahead = _says(world, "alice", topic, f"@{ROBOT} wave")
    card = {"robot": ROBOT, "state": "running", "step": 1, "steps": 2, "doing": "turn right 90°", "trace_id": "5e01aa"}
    robot.post(f"/topics/{topic}/posts", json={"body": "Step 1 of 2.", "reply_to": waiting, "card": card})
    names = {"topic": topic, "walk": walk, "said": said, "look": look, "waiting": waiting, "next": ahead}
    names |= decisions(world)
    alive(world, names)
    return names | links(world)


def decisions(world: World) -> dict[str, str]:
    """Commands that need an approval, and how each of them ended, or not yet."""
    text = f"@{ROBOT} do a backflip"
    made = world.api("alice").post("/topics", json={"board_id": "robots", "title": "A flip?", "body": text}).json()
    topic, asks = made["topic"]["id"], made["post"]["id"]
    robot_told.waits(world, topic, asks)
    names = {"asks": asks}
    for name, report in {
        "approved": robot_told.approved,
        "denied": robot_told.denied,
        "expired": robot_told.expired,
        "stopped": robot_told.stopped,
        "removed": robot_told.denied,
    }.items():
        names[name] = post = _says(world, "alice", topic, f"@{ROBOT} walk 3 m" if name == "stopped" else text)
        earlier(world, post, 45.0)
        said = robot_told.decided(name == "approved", post) if name in ("approved", "denied", "removed") else {}
        said |= {"stopped_by": "bob"} if name == "stopped" else {}
        tell(world, topic, post, report(post, topic), **said)
    world.api("alice").delete(f"/posts/{names['removed']}").raise_for_status()
    return names


def alive(world: World, names: Mapping[str, str]) -> None:
    """The robot's agent tells what it does, and what its room's camera sees."""
    robot, jpeg = world.api(ROBOT), (IMAGES / "world-room.jpg").read_bytes()
    card = CARD_SHOWN | {"line": [names["waiting"], names["next"], names["asks"]]}
    robot.put(f"/robots/{ROBOT}", json={"card": card}).raise_for_status()
    robot.put(f"/robots/{ROBOT}/frame", content=jpeg, headers={"Content-Type": "image/jpeg"}).raise_for_status()


def earlier(world: World, post: str, seconds: float) -> None:
    """As if it had been written so long ago."""
    with local_admin.writing(world.settings) as connection:
        mine, at = db.posts.c.id == int(post), db.posts.c.created_us
        connection.execute(update(db.posts).where(mine).values(created_us=at - int(seconds * 1e6)))


def links(world: World) -> dict[str, str]:
    """Links of admins to people."""
    chief = world.chief()
    chief.patch(f"/admin/robots/{ROBOT}", json={"owner": "alice"}).raise_for_status()
    invite = chief.post("/admin/invites", json={"role": "member", "uses": 3, "days": 7}).json()["url"]
    password = chief.post("/admin/accounts/bob/link", json={"purpose": "password"}).json()["url"]
    return {"enter": world.link("bob"), "invite": _path(world, invite), "password": _path(world, password)}


def _path(world: World, url: str) -> str:
    return url.removeprefix(world.base)


def _says(world: World, who: str, topic: str, body: str, reply_to: str | None = None) -> str:
    answer = world.api(who).post(f"/topics/{topic}/posts", json={"body": body, "reply_to": reply_to})
    answer.raise_for_status()
    return str(answer.json()["post"]["id"])
