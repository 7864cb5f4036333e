"""A forum with markup attacks in every place where a person, a robot or an admin can put words, many a page.

A page that shows one post shows many rows in it; lists are followed to their end by who looks.
"""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from pages_world import World

from agentrob.board import admin as shell
from agentrob.board import administration, audit
from agentrob.board.accounts import NAME
from agentrob.board.forms import TITLE_LENGTH
from agentrob.board.pages_posts import POSTS
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

#: Characters of a post that lists show; lines that a quotation has; rows that a robot's card and a record can hold.
EXCERPT, QUOTED, ON_CARD, IN_RECORD = 140, 40, 60, 30
#: In every post that begins a topic, so that a search finds them all.
WORD = "wordofall"
LISTS = ("/", "/b/talk", "/latest", "/notices", f"/search?q={WORD}", "/admin/audit", "/admin/accounts")
OTHERS = ("/u/boss", "/b/talk/new", "/search?q=<script>alert(1)</script>", "/b/robots/new?to=<script>alert(1)</script>")


def fill(world: World, rows: Sequence[str]) -> list[str]:
    """Put each row everywhere; the pages that show them, those of robots first, since cards are soon old."""
    world.board.add("boss", role=Role.ADMIN)
    boss = shell.find_account(world.settings, "boss")
    names = named(world, rows)
    audited(world, rows)
    threads = [thread(world, boss, some) for some in parts(rows, POSTS)]
    titled(world, boss, rows)
    pages = [path for thread in threads for path in thread] + posts(world, boss, rows) + records(world, boss, rows)
    return [*robots(world, rows), *LISTS, *OTHERS, *names, *pages]


def parts(rows: Sequence[str], most: int) -> Iterator[Sequence[str]]:
    return (rows[start : start + most] for start in range(0, len(rows), most))


def titles(rows: Sequence[str]) -> list[str]:
    """Rows as titles: as many in one as lists show of a post."""
    made = [""]
    for row in rows:
        line = re.sub(r"[\x00-\x1f\x7f-\x9f]", " ", row).strip()[:TITLE_LENGTH] or "x"
        if made[-1] and len(made[-1]) + 1 + len(line) > EXCERPT:
            made.append("")
        made[-1] = f"{made[-1]} {line}".strip()
    return made


# -------------------------------------------------------------------- people's words
def titled(world: World, boss: Account, rows: Sequence[str]) -> None:
    """As titles and as the beginnings of posts: in every list of topics and posts, and in the notices of `root`."""
    store = world.board.services.store

    async def begin(some: Sequence[str]) -> None:
        await asyncio.gather(*(store.create_topic(boss, "talk", title, f"{title}\n\n{WORD} @root") for title in some))

    for some in parts(titles(rows), 100):
        world.board.run(begin(some))


def thread(world: World, boss: Account, rows: Sequence[str]) -> list[str]:
    """Each as a post of its own, and as the words beside a picture."""
    store = world.board.services.store

    async def write() -> str:
        title = titles(rows)[0]
        topic = (await store.create_topic(boss, "robots", title, rows[0])).topic.id
        for row in rows[1:]:
            alt = row.replace("]", "\\]").replace("\n", " ")
            await store.reply(boss, topic, f"{row}\n\n![{alt}](/images/1) @quadruped")
        return topic

    topic = world.board.run(write())
    return [f"/t/{topic}", f"/t/{topic}/moderate"]


def posts(world: World, boss: Account, rows: Sequence[str]) -> list[str]:
    """Many in one post, on each page that shows one: as it is, as text, and as the text that it had before."""
    store = world.board.services.store
    lines = [" ".join(row.split("\n")) for row in rows]

    async def write(some: Sequence[str]) -> list[str]:
        made = await store.create_topic(boss, "talk", "All in one", "\n".join(some))
        topic, post = made.topic.id, made.post.id
        await store.edit(boss, post, "\n".join([*some, "edited"]))
        kinds = ("edit", "history", "moderate", "remove", "raw")
        return [f"/t/{topic}?quote={post}", f"/t/{topic}", *(f"/p/{post}/{kind}" for kind in kinds)]

    # A line of several rows, since a quotation ends after so many lines.
    several = [" ".join(some) for some in parts(lines, 4)]
    return [page for some in parts(several, QUOTED) for page in world.board.run(write(some))]


# -------------------------------------------------------------------- robots' words
def robots(world: World, rows: Sequence[str]) -> list[str]:
    """On robots' cards: what they can do, their limits, and fields that nobody knows."""
    pages = []
    for n, some in enumerate(parts(rows, ON_CARD)):
        name = "rover-" + chr(ord("a") + n)
        world.board.add(name, kind=AccountKind.ROBOT_AGENT)
        card: dict[str, Any] = {"model": some[0], "state": some[-1], "ops": some[:40], "board": some[0]}
        card |= {"limits": {row: row for row in some[40:50]}} | {row: row for row in some[50:]}
        world.api(name).put(f"/robots/{name}", json={"card": card}).raise_for_status()
        pages.append(f"/robots/{name}")
    return [*pages, "/robots"]


def records(world: World, boss: Account, rows: Sequence[str]) -> list[str]:
    """In what a robot's agent tells of a command, wherever there are words."""
    store, pages = world.board.services.store, []
    for some in parts(rows, IN_RECORD):
        post = world.board.run(store.create_topic(boss, "robots", "A command", some[0])).post.id
        told = {"record": record([row[:200] for row in some])}
        world.api("quadruped").put(f"/commands/{post}", json=told).raise_for_status()
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
def named(world: World, rows: Sequence[str]) -> list[str]:
    """As names: no handle is taken, what can be a display name is shown; some of the pages of who has one."""
    shown = []
    with shell.writing(world.settings) as connection:
        for n, row in enumerate(rows):
            if not NAME.fullmatch(row.strip().lower()):
                with pytest.raises(BoardError):
                    administration.add_account(connection, "root", row)
            with contextlib.suppress(BoardError):
                administration.add_account(connection, "root", f"attacker-{n:04}", display_name=row[:64])
                shown.append(f"attacker-{n:04}")
    assert len(shown) > len(rows) // 2
    some = shown[:: max(1, len(shown) // 8)]
    return [f"/u/{name}" for name in some] + [f"/admin/accounts/{name}" for name in some]


def audited(world: World, rows: Sequence[str]) -> None:
    """As the reasons that moderators give."""
    with shell.writing(world.settings) as connection:
        for row in rows:
            audit.note(connection, "root", "post.hide", row, reason=row[:200])
