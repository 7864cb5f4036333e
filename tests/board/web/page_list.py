"""The list of all pages, and a forum with sample content for them; used by the axe tests and for pictures in docs."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from zoneinfo import ZoneInfo

from sqlalchemy import update

from agentrob.board.admin import local_admin
from agentrob.board.db import schema as db
from agentrob.model import ScheduledRun
from tests.board.web import sample_reports
from tests.board.web.forum_site import CARD, Site
from tests.board.web.sample_reports import IMAGES, ROBOT, send_report

CARD_SHOWN = CARD | {
    "ops": ["move", "turn", "hello", "heart", "get_front_image"],
    "limits": {"speed_mps": 0.5, "turn_dps": 45, "step_m": 5, "command_m": 10, "command_s": 60, "command_steps": 10},
    "state": "walking",
    "queue": 1,
    "worker": "lab-1-4711",
    "version": "0.1.0",
    "lag_ms": 34,
    "stop_ms": 41.5,
    "stop_at": "2026-11-20T09:30:00+00:00",
    "failures": {"failed": 2, "interrupted": 1},
    "boards": ["robots"],
    "map": {
        "room": "lab",
        "size_m": [8, 6],
        "fence": [[-2, -2], [3, -2], [3, 2], [-2, 2]],
        "things": [
            {"name": "table", "at_m": [1, -2], "size_m": [1.2, 0.7], "colour": "#996940"},
            {"name": "red ball", "at_m": [2.7, 0.75], "radius_m": 0.15, "colour": "#db241c"},
        ],
        "pose": [0.5, 0.4, 0.6],
        "geometry": "",
    },
}


@dataclass(frozen=True, slots=True)
class PageEntry:
    """One page: its name, its path with placeholders that `fill` returns, and the account that opens it, if any."""

    name: str
    path: str
    who: str | None = "alice"
    quick: bool = True  # also loaded by the quick tests, which load one page of each kind


PAGES = (
    PageEntry("home", "/"),
    PageEntry("board", "/b/robots"),
    PageEntry("topic", "/t/{topic}"),
    PageEntry("command", "/c/{walk}"),
    PageEntry("command-looked", "/c/{look}"),
    PageEntry("command-none", "/c/{waiting}", quick=False),
    PageEntry("approval", "/c/{asks}", "root"),
    PageEntry("approval-of-others", "/c/{asks}", quick=False),
    PageEntry("approval-given", "/c/{approved}", "root", quick=False),
    PageEntry("approval-refused", "/c/{denied}", "root"),
    PageEntry("approval-late", "/c/{expired}", quick=False),
    PageEntry("command-stopped", "/c/{stopped}", quick=False),
    PageEntry("command-removed", "/c/{removed}", quick=False),
    PageEntry("robot-approves", f"/robots/{ROBOT}", "root", quick=False),
    PageEntry("robot", f"/robots/{ROBOT}"),
    PageEntry("release", f"/robots/{ROBOT}/release", "root"),
    PageEntry("set-home", f"/robots/{ROBOT}/home", "root", quick=False),
    PageEntry("reset-room", f"/robots/{ROBOT}/reset", "root", quick=False),
    PageEntry("robots", "/robots"),
    PageEntry("schedules", "/schedules"),
    PageEntry("robot-schedules", f"/robots/{ROBOT}/schedules"),
    PageEntry("command-run", "/c/{run}"),
    PageEntry("search", "/search?q=walk"),
    PageEntry("search-meaning", "/search?q=stroll to the glass&by=meaning", quick=False),
    PageEntry("search-empty", "/search"),
    PageEntry("search-chinese", "/search?q=机器人 前进", quick=False),
    PageEntry("latest", "/latest"),
    PageEntry("unread", "/unread", "bob", quick=False),
    PageEntry("tags", "/tags", quick=False),
    PageEntry("tag", "/tags/window"),
    PageEntry("topic-tags", "/t/{topic}/tags"),
    PageEntry("notifications", "/notifications"),
    PageEntry("approvals", "/approvals", "root"),
    PageEntry("approvals-none", "/approvals", quick=False),
    PageEntry("new-topic", "/b/robots/new?to=quadruped"),
    PageEntry("quote", "/t/{topic}?quote={said}#reply", quick=False),
    PageEntry("edit", "/p/{walk}/edit"),
    PageEntry("history", "/p/{said}/history"),
    PageEntry("remove", "/p/{walk}/remove", quick=False),
    PageEntry("me", "/u/alice"),
    PageEntry("person", "/u/bob", quick=False),
    PageEntry("password", "/password", quick=False),
    PageEntry("not-found", "/t/999999"),
    PageEntry("api", "/docs", None),
    PageEntry("sign-in", "/sign-in", None),
    PageEntry("sign-up", "/sign-up", None, quick=False),
    PageEntry("enter", "{enter}", None),
    PageEntry("invite", "{invite}", None, quick=False),
    PageEntry("set-password", "{password}", None),
    PageEntry("admin-accounts", "/admin/accounts", "root"),
    PageEntry("admin-account", "/admin/accounts/bob", "root", quick=False),
    PageEntry("admin-boards", "/admin/boards", "root"),
    PageEntry("admin-robots", "/admin/robots", "root", quick=False),
    PageEntry("admin-robot", f"/admin/robots/{ROBOT}", "root"),
    PageEntry("admin-invites", "/admin/invites", "root"),
    PageEntry("admin-audit", "/admin/audit", "root"),
    PageEntry("fleet", "/fleet", "root"),
    PageEntry("moderate-topic", "/t/{topic}/moderate", "root"),
    PageEntry("moderate-post", "/p/{said}/moderate", "root", quick=False),
)


def fill(site: Site) -> dict[str, str]:
    """Write sample content as people and as the robot; return values for the placeholders in `PAGES`."""
    alice, bob, robot = (site.api(name) for name in ("alice", "bob", ROBOT))
    robot.put(f"/robots/{ROBOT}", json={"card": CARD_SHOWN}).raise_for_status()
    begin = alice.post(
        "/topics", json={"board_id": "talk", "title": "机器人记录", "body": "机器人前进了两米。", "tags": ["记录"]}
    )
    begin.raise_for_status()
    text = f"@{ROBOT} walk forward 2 metres, turn left and take a photo"
    topic = {"board_id": "robots", "title": "A walk to the window", "body": text, "tags": ["window", "photo", "窗户"]}
    made = alice.post("/topics", json=topic).json()
    topic, walk = made["topic"]["id"], made["post"]["id"]
    backdate(site, walk, 8.0)
    send_report(site, topic, walk, sample_reports.walk(walk, topic))
    said = _reply(
        site, "bob", topic, f"> walk forward 2 metres\n\n@alice that was **quick**. Next: `@{ROBOT} wave`?", walk
    )
    bob.patch(
        f"/posts/{said}", json={"body": f"> walk forward 2 metres\n\n@alice that was quick. Next: `@{ROBOT} wave`?"}
    )
    look = _reply(site, "alice", topic, f"@{ROBOT} go and look for the red ball")
    backdate(site, look, 5.0)
    send_report(site, topic, look, sample_reports.look(look, topic), sample_reports.loop_record())
    waiting = _reply(
        site, "alice", topic, f"@{ROBOT} turn right by 90 degrees\n\n| lap | time |\n|---|--:|\n| 1 | 12 s |"
    )
    ahead = _reply(site, "alice", topic, f"@{ROBOT} wave")
    card = {"robot": ROBOT, "state": "running", "step": 1, "steps": 2, "doing": "turn right 90°", "trace_id": "5e01aa"}
    robot.post(f"/topics/{topic}/posts", json={"body": "Step 1 of 2.", "reply_to": waiting, "card": card})
    names = {"topic": topic, "walk": walk, "said": said, "look": look, "waiting": waiting, "next": ahead}
    names |= approval_commands(site)
    names |= scheduled_commands(site)
    send_presence(site, names)
    return names | one_time_links(site)


def approval_commands(site: Site) -> dict[str, str]:
    """Post commands that need an approval: one still waits, and one for each way to end; return their post ids."""
    text = f"@{ROBOT} do a backflip"
    made = site.api("alice").post("/topics", json={"board_id": "robots", "title": "A flip?", "body": text}).json()
    topic, asks = made["topic"]["id"], made["post"]["id"]
    sample_reports.ask_for_approval(site, topic, asks)
    names = {"asks": asks}
    for name, report in {
        "approved": sample_reports.approved,
        "denied": sample_reports.denied,
        "expired": sample_reports.expired,
        "stopped": sample_reports.stopped,
        "removed": sample_reports.denied,
    }.items():
        names[name] = post = _reply(site, "alice", topic, f"@{ROBOT} walk 3 m" if name == "stopped" else text)
        backdate(site, post, 45.0)
        said = (
            sample_reports.approval_record(name == "approved", post)
            if name in ("approved", "denied", "removed")
            else {}
        )
        said |= {"stopped_by": "bob"} if name == "stopped" else {}
        send_report(site, topic, post, report(post, topic), **said)
    site.api("alice").delete(f"/posts/{names['removed']}").raise_for_status()
    return names


def scheduled_commands(site: Site) -> dict[str, str]:
    """Post schedules, of which one has run once; return the ids of their posts and of the run's report."""
    posts = {}
    for key, who, text in (
        ("daily", "alice", f"@{ROBOT} every weekday at 9:00 take a photo"),
        ("later", "bob", f"@{ROBOT} tomorrow at 15:30 walk forward 2 metres, then turn left"),
        ("hourly", "alice", f"@{ROBOT} 每隔一小时三次挥手"),
    ):
        topic = {"board_id": "robots", "title": text.removeprefix(f"@{ROBOT} ").capitalize(), "body": text}
        made = site.api(who).post("/topics", json=topic).json()
        posts[key], thread = made["post"]["id"], made["topic"]["id"]
    report, now = sample_reports.walk(posts["hourly"], thread), datetime.now(UTC)
    due = ScheduledRun(now, now, "Europe/Berlin", number=1, of=3, url=f"{site.base}/p/{posts['hourly']}")
    report = replace(report, command=replace(report.command, run=due))
    return posts | {"run": send_report(site, thread, posts["hourly"], report)}


def scheduled_card(names: Mapping[str, str]) -> dict[str, object]:
    """Return what a robot's card says of these schedules."""
    morning = datetime.now(ZoneInfo("Europe/Berlin")).replace(hour=9, minute=0, second=0, microsecond=0)
    days = [morning + timedelta(days=n) for n in range(1, 43)]
    weekdays = [int(day.timestamp()) for day in days if day.weekday() < 5][:29]
    soon = int(morning.timestamp()) + 3600 * ((int(time.time()) - int(morning.timestamp())) // 3600 + 1)
    until = (morning + timedelta(days=60)).isoformat()
    entry = {"zone": "Europe/Berlin", "until": until, "renewable": False}
    hourly = {"post": names["hourly"], "text": "挥手", "runs": [soon, soon + 3600]}
    later = {"post": names["later"], "text": "walk forward 2 m, turn left 90°", "runs": [weekdays[0] + 23400]}
    daily = {"post": names["daily"], "text": "take a photo", "runs": weekdays, "renewable": True}
    return {"schedules": [entry | hourly, entry | later, entry | daily], "schedules_more": 0}


def send_presence(site: Site, names: Mapping[str, str]) -> None:
    """Send the robot's card and camera frame, as its agent does."""
    robot, jpeg = site.api(ROBOT), (IMAGES / "world-room.jpg").read_bytes()
    card = CARD_SHOWN | {"line": [names["waiting"], names["next"], names["asks"]]} | scheduled_card(names)
    robot.put(f"/robots/{ROBOT}", json={"card": card}).raise_for_status()
    robot.put(f"/robots/{ROBOT}/frame", content=jpeg, headers={"Content-Type": "image/jpeg"}).raise_for_status()


def backdate(site: Site, post: str, seconds: float) -> None:
    """Backdate a post."""
    with local_admin.writing(site.settings) as connection:
        mine, at = db.posts.c.id == int(post), db.posts.c.created_us
        connection.execute(update(db.posts).where(mine).values(created_us=at - int(seconds * 1e6)))


def one_time_links(site: Site) -> dict[str, str]:
    """Return one-time links that an admin creates: to sign in, for an invitation and for a new password."""
    admin_api = site.admin_api()
    admin_api.patch(f"/admin/robots/{ROBOT}", json={"owner": "alice"}).raise_for_status()
    invite = admin_api.post("/admin/invites", json={"role": "member", "uses": 3, "days": 7}).json()["url"]
    password = admin_api.post("/admin/accounts/bob/link", json={"purpose": "password"}).json()["url"]
    return {"enter": site.link("bob"), "invite": _path(site, invite), "password": _path(site, password)}


def _path(site: Site, url: str) -> str:
    return url.removeprefix(site.base)


def _reply(site: Site, who: str, topic: str, body: str, reply_to: str | None = None) -> str:
    answer = site.api(who).post(f"/topics/{topic}/posts", json={"body": body, "reply_to": reply_to})
    answer.raise_for_status()
    return str(answer.json()["post"]["id"])
