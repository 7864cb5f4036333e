"""A forum with markup attacks in every place where a person, a robot or an admin can put words, many a page.

A page that shows one post shows many rows in it; lists are followed to their end by who looks.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from typing import Any
from urllib.parse import quote

import pytest

from agentrob.board.admin import local_admin as shell
from agentrob.board.admin import management
from agentrob.board.auth.accounts import NAME
from agentrob.board.content import tags, writes
from agentrob.board.content.rendered import Rendered, Text
from agentrob.board.content.writes import Draft
from agentrob.board.db import audit
from agentrob.board.db.writer import Transaction
from agentrob.board.robots import commands
from agentrob.board.web.forms import TITLE_LENGTH
from agentrob.board.web.posts import POSTS
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role
from tests.board.web.page_world import World

#: Lines that a quotation has; rows that a robot's card and a record can hold.
QUOTED, ON_CARD, IN_RECORD = 40, 60, 25
#: In every post that begins a topic, so that a search finds them all.
WORD = "wordofall"
LISTS = ("/", "/b/talk", "/latest", "/notifications", f"/search?q={WORD}", "/admin/audit", "/admin/accounts")
OTHERS = (
    *("/u/boss", "/b/talk/new", "/search?q=<script>alert(1)</script>", "/b/robots/new?to=<script>alert(1)</script>"),
    "/search?q=x&tag=<script>alert(1)</script>&board=<img src=x onerror=alert(1)>",
    *("/tags", "/tags/<svg onload=alert(1)>", "/unread"),
    *("/admin/boards", "/admin/invites", "/admin/robots", "/admin/robots/quadruped"),
)
#: One of so many tags is looked at on a page of its own; all are on `/tags`.
TAGS_LOOKED_AT = 20


def fill(world: World, rows: Sequence[str]) -> list[str]:
    """Put each row everywhere; the pages that show them, those of robots first, since cards are soon old."""
    boss = world.board.add("boss", role=Role.ADMIN)
    with shell.writing(world.settings) as connection:
        t, root = Transaction(connection), management.account_named(connection, "root")
        pages = [*named(t, rows), *posts(t, root, rows), *records(t, boss, rows)]
        pages += [path for some in parts(rows, POSTS) for path in thread(t, boss, some)]
        audited(t, rows)
        tagged = tags_on(t, boss, rows)
        titled(t, boss, rows)  # last, so that the lists begin with them
    return [*robots(world, rows), *LISTS, *OTHERS, *tagged, *pages, f"{pages[-1]}/moderate", f"{pages[-1]}/tags"]


def parts(rows: Sequence[str], most: int) -> Iterator[Sequence[str]]:
    return (rows[start : start + most] for start in range(0, len(rows), most))


def titles(rows: Sequence[str]) -> list[str]:
    """Rows as titles: as many in one as there is room for."""
    made = [""]
    for row in rows:
        line = re.sub(r"[\x00-\x1f\x7f-\x9f]", " ", row).strip()[:TITLE_LENGTH] or "x"
        if made[-1] and len(made[-1]) + 1 + len(line) > TITLE_LENGTH:
            made.append("")
        made[-1] = f"{made[-1]} {line}".strip()
    return made


# -------------------------------------------------------------------- people's words
def typed(raw: str) -> Rendered:
    """A text as the forum makes it of what somebody typed."""
    return Text(raw).rendered(("root", "quadruped"))


def titled(t: Transaction, boss: Account, rows: Sequence[str]) -> None:
    """As titles and first words of posts: in every list of topics and posts, and in the notifications of `root`."""
    for title in titles(rows):
        writes.create_topic(t, "talk", title, Draft(boss, typed(f"@root {WORD}\n\n{title}")))


def thread(t: Transaction, boss: Account, rows: Sequence[str]) -> list[str]:
    """Each as a post of its own, and as the words beside a picture."""
    topic = writes.create_topic(t, "robots", titles(rows)[0], Draft(boss, typed(rows[0]))).topic.id
    for row in rows[1:]:
        alt = row.replace("]", "\\]").replace("\n", " ")
        writes.reply(t, topic, Draft(boss, typed(f"{row}\n\n![{alt}](/images/1) @quadruped")))
    return [f"/t/{topic}"]


def tags_on(t: Transaction, boss: Account, rows: Sequence[str]) -> list[str]:
    """As tags, which are made plain: of those that are a word then. The pages of some of them."""
    found = list(dict.fromkeys(tag for row in rows if (tag := tags.plain(row.strip()[: tags.LENGTH]))))
    for some in parts(found, tags.MOST):
        writes.create_topic(t, "talk", "Tagged", Draft(boss, typed("x")), tags.checked(some))
    return [f"/tags/{quote(tag, safe='')}" for tag in found[::TAGS_LOOKED_AT]]


def posts(t: Transaction, root: Account, rows: Sequence[str]) -> list[str]:
    """Many in one post, on each page that shows one: as it is, as text, and as the text that it had before."""
    # A line of several rows, since a quotation ends after so many lines.
    lines = [" ".join(some).replace("\n", " ") for some in parts(rows, 4)]
    pages = []
    for some in parts(lines, QUOTED):
        made = writes.create_topic(t, "talk", "All in one", Draft(root, typed("\n".join(some))))
        topic, post = made.topic.id, made.post.id
        writes.edit(t, root, post, typed("\n".join([*some, "edited"])), None, (), "keep")
        pages.append(f"/t/{topic}?quote={post}")
        pages += [f"/p/{post}/{kind}" for kind in ("edit", "history", "moderate", "remove", "raw")]
    return pages


# -------------------------------------------------------------------- robots' words
def robots(world: World, rows: Sequence[str]) -> list[str]:
    """On robots' cards: what they can do, their limits, and fields that nobody knows."""
    pages = []
    for n, some in enumerate(parts(rows, ON_CARD)):
        name = "rover-" + "abcdefghjkmnpqrstuvxyz"[n]  # no two of them look alike
        world.board.add(name, kind=AccountKind.ROBOT_AGENT)
        card: dict[str, Any] = {"model": some[0], "state": some[-1], "ops": some[:40], "board": some[0]}
        card |= {"limits": {row: row for row in some[40:50]}} | {row: row for row in some[50:]}
        world.api(name).put(f"/robots/{name}", json={"card": card}).raise_for_status()
        pages.append(f"/robots/{name}")
    return [*pages, "/robots"]


def records(t: Transaction, boss: Account, rows: Sequence[str]) -> list[str]:
    """In what a robot's agent tells of a command, wherever there are words."""
    quadruped, pages = management.account_named(t.connection, "quadruped"), []
    for some in parts(rows, IN_RECORD):
        post = writes.create_topic(t, "robots", "A command", Draft(boss, typed(some[0]))).post.id
        told = record([row[:120] for row in some])
        commands.check(told, "record", commands.RECORD_BYTES, commands.RECORD_DEPTH)
        commands.save_record(t, quadruped, post, None, told)
        pages.append(f"/c/{post}")
    return pages


def record(some: Sequence[str]) -> dict[str, Any]:
    steps = [{"op": row, "asked": {row: row}, "measured": {}, "outcome": row, "message": row} for row in some]
    turns = [{"tool": row, "arguments": {row: row}, "words": row, "problem": row} for row in some]
    usage = [{"mind": row, "model": row, "failed": row} for row in some]
    links = [{"kind": row, "url": row, "until": row} for row in some]
    links += [{"kind": row, "url": f"https://example.org/{row}", "until": ""} for row in some]
    verdict = {"decision": some[0], "rule": some[-1], "reason": " ".join(some)[:600]}
    looked = {"goal": some[0], "turns": turns, "end": {"did": " ".join(some)[:300], "saw": some[:8]}}
    told = {"steps": steps, "models": usage, "looked": looked, "links": links, "verdict": verdict}
    return told | {"status": some[0], "message": some[-1], "trace_id": some[0], "mind": some[-1], "notes": some[:8]}


# -------------------------------------------------------------------- names, and what admins do
def named(t: Transaction, rows: Sequence[str]) -> list[str]:
    """As names: no handle is taken, what can be a display name is shown; some of the pages of who has one."""
    shown = []
    for n, row in enumerate(rows):
        if not NAME.fullmatch(row.strip().lower()):
            with pytest.raises(BoardError):
                management.add_account(t.connection, "root", row)
        with contextlib.suppress(BoardError):
            management.add_account(t.connection, "root", f"attacker-{n:04}", display_name=row[:64])
            shown.append(f"attacker-{n:04}")
    assert len(shown) > len(rows) // 2
    some = shown[:: max(1, len(shown) // 8)]
    return [f"/u/{name}" for name in some] + [f"/admin/accounts/{name}" for name in some]


def audited(t: Transaction, rows: Sequence[str]) -> None:
    """As the reasons that moderators give."""
    for row in rows:
        audit.note(t.connection, "root", "post.hide", row, reason=row[:200])
