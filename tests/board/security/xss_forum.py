"""Fill a forum with XSS payloads: one in every field that a person, a robot or an admin can write.

Each page holds many payloads. Lists have several pages; the test that loads them follows the links to the last one.
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
from tests.board.web.forum_site import Site

#: The most lines of a quotation, and the most payloads in a robot's card and in a record.
QUOTED_LINES, PER_CARD, PER_RECORD = 40, 60, 25
#: A word in the first post of every topic, so that one search finds them all.
SEARCH_WORD = "wordofall"
LISTS = ("/", "/b/talk", "/latest", "/notifications", f"/search?q={SEARCH_WORD}", "/admin/audit", "/admin/accounts")
OTHERS = (
    *("/u/boss", "/b/talk/new", "/search?q=<script>alert(1)</script>", "/b/robots/new?to=<script>alert(1)</script>"),
    "/search?q=x&tag=<script>alert(1)</script>&board=<img src=x onerror=alert(1)>",
    *("/tags", "/tags/<svg onload=alert(1)>", "/unread"),
    *("/admin/boards", "/admin/invites", "/admin/robots", "/admin/robots/quadruped"),
)
#: Every twentieth tag is also loaded on its own page; `/tags` shows all of them.
TAG_STEP = 20


def fill(site: Site, payloads: Sequence[str]) -> list[str]:
    """Write each payload to every field; return the pages that show them.

    Robots' pages come first, because their cards expire soon.
    """
    boss = site.board.add("boss", role=Role.ADMIN)
    with shell.writing(site.settings) as connection:
        t, root = Transaction(connection), management.account_named(connection, "root")
        pages = [*write_names(t, payloads), *write_posts(t, root, payloads), *write_records(t, boss, payloads)]
        pages += [path for batch in batches(payloads, POSTS) for path in write_thread(t, boss, batch)]
        write_reasons(t, payloads)
        tag_pages = write_tags(t, boss, payloads)
        write_titles(t, boss, payloads)  # last, so that these topics are at the top of all lists
    return [
        *write_cards(site, payloads),
        *LISTS,
        *OTHERS,
        *tag_pages,
        *pages,
        f"{pages[-1]}/moderate",
        f"{pages[-1]}/tags",
    ]


def batches(payloads: Sequence[str], most: int) -> Iterator[Sequence[str]]:
    return (payloads[start : start + most] for start in range(0, len(payloads), most))


def titles(payloads: Sequence[str]) -> list[str]:
    """Return titles that contain the payloads, each with as many as fit."""
    made = [""]
    for payload in payloads:
        line = re.sub(r"[\x00-\x1f\x7f-\x9f]", " ", payload).strip()[:TITLE_LENGTH] or "x"
        if made[-1] and len(made[-1]) + 1 + len(line) > TITLE_LENGTH:
            made.append("")
        made[-1] = f"{made[-1]} {line}".strip()
    return made


# -------------------------------------------------------------------- text by people
def render_text(raw: str) -> Rendered:
    """Render a text as the forum does."""
    return Text(raw).rendered(("root", "quadruped"))


def write_titles(t: Transaction, boss: Account, payloads: Sequence[str]) -> None:
    """Write payloads as titles and first words of posts, which appear in all lists and in `root`'s notifications."""
    for title in titles(payloads):
        writes.create_topic(t, "talk", title, Draft(boss, render_text(f"@root {SEARCH_WORD}\n\n{title}")))


def write_thread(t: Transaction, boss: Account, payloads: Sequence[str]) -> list[str]:
    """Write each payload as a post of its own, and as the alt text of a picture in it."""
    topic = writes.create_topic(t, "robots", titles(payloads)[0], Draft(boss, render_text(payloads[0]))).topic.id
    for payload in payloads[1:]:
        alt = payload.replace("]", "\\]").replace("\n", " ")
        writes.reply(t, topic, Draft(boss, render_text(f"{payload}\n\n![{alt}](/images/1) @quadruped")))
    return [f"/t/{topic}"]


def write_tags(t: Transaction, boss: Account, payloads: Sequence[str]) -> list[str]:
    """Write the payloads that are still valid tags once normalised; return the pages of some of these tags."""
    found = list(dict.fromkeys(tag for payload in payloads if (tag := tags.plain(payload.strip()[: tags.LENGTH]))))
    for batch in batches(found, tags.MOST):
        writes.create_topic(t, "talk", "Tagged", Draft(boss, render_text("x")), tags.checked(batch))
    return [f"/tags/{quote(tag, safe='')}" for tag in found[::TAG_STEP]]


def write_posts(t: Transaction, root: Account, payloads: Sequence[str]) -> list[str]:
    """Write many payloads into one post; return every page that shows that post, its source or its history."""
    # Several payloads a line, because a quotation is cut after `QUOTED_LINES` lines.
    lines = [" ".join(batch).replace("\n", " ") for batch in batches(payloads, 4)]
    pages = []
    for batch in batches(lines, QUOTED_LINES):
        made = writes.create_topic(t, "talk", "All in one", Draft(root, render_text("\n".join(batch))))
        topic, post = made.topic.id, made.post.id
        writes.edit(t, root, post, render_text("\n".join([*batch, "edited"])), None, (), "keep")
        pages.append(f"/t/{topic}?quote={post}")
        pages += [f"/p/{post}/{kind}" for kind in ("edit", "history", "moderate", "remove", "raw")]
    return pages


# -------------------------------------------------------------------- text by robots
def write_cards(site: Site, payloads: Sequence[str]) -> list[str]:
    """Write payloads to robots' cards: operations, limits and unknown fields."""
    pages = []
    for n, batch in enumerate(batches(payloads, PER_CARD)):
        name = "rover-" + "abcdefghjkmnpqrstuvxyz"[n]  # the board refuses names that look alike
        site.board.add(name, kind=AccountKind.ROBOT_AGENT)
        card: dict[str, Any] = {"model": batch[0], "state": batch[-1], "ops": batch[:40], "board": batch[0]}
        card |= {"limits": {payload: payload for payload in batch[40:50]}} | {
            payload: payload for payload in batch[50:]
        }
        site.api(name).put(f"/robots/{name}", json={"card": card}).raise_for_status()
        pages.append(f"/robots/{name}")
    return [*pages, "/robots"]


def write_records(t: Transaction, boss: Account, payloads: Sequence[str]) -> list[str]:
    """Write payloads to every text field of a command's record."""
    quadruped, pages = management.account_named(t.connection, "quadruped"), []
    for batch in batches(payloads, PER_RECORD):
        post = writes.create_topic(t, "robots", "A command", Draft(boss, render_text(batch[0]))).post.id
        told = record([payload[:120] for payload in batch])
        commands.check(told, "record", commands.RECORD_BYTES, commands.RECORD_DEPTH)
        commands.save_record(t, quadruped, post, None, told)
        pages.append(f"/c/{post}")
    return pages


def record(batch: Sequence[str]) -> dict[str, Any]:
    steps = [{"op": p, "asked": {p: p}, "measured": {}, "outcome": p, "message": p} for p in batch]
    turns = [{"tool": p, "arguments": {p: p}, "words": p, "problem": p} for p in batch]
    usage = [{"mind": p, "model": p, "failed": p} for p in batch]
    links = [{"kind": p, "url": p, "until": p} for p in batch]
    links += [{"kind": p, "url": f"https://example.org/{p}", "until": ""} for p in batch]
    verdict = {"decision": batch[0], "rule": batch[-1], "reason": " ".join(batch)[:600]}
    looked = {"goal": batch[0], "turns": turns, "end": {"did": " ".join(batch)[:300], "saw": batch[:8]}}
    told = {"steps": steps, "models": usage, "looked": looked, "links": links, "verdict": verdict}
    return told | {
        "status": batch[0],
        "message": batch[-1],
        "trace_id": batch[0],
        "mind": batch[-1],
        "notes": batch[:8],
    }


# -------------------------------------------------------------------- names and the audit log
def write_names(t: Transaction, payloads: Sequence[str]) -> list[str]:
    """Try each payload as a handle, which is refused, and as a display name; return pages of some of these accounts."""
    shown = []
    for n, payload in enumerate(payloads):
        if not NAME.fullmatch(payload.strip().lower()):
            with pytest.raises(BoardError):
                management.add_account(t.connection, "root", payload)
        with contextlib.suppress(BoardError):
            management.add_account(t.connection, "root", f"attacker-{n:04}", display_name=payload[:64])
            shown.append(f"attacker-{n:04}")
    assert len(shown) > len(payloads) // 2
    batch = shown[:: max(1, len(shown) // 8)]
    return [f"/u/{name}" for name in batch] + [f"/admin/accounts/{name}" for name in batch]


def write_reasons(t: Transaction, payloads: Sequence[str]) -> None:
    """Write payloads as moderators' reasons."""
    for payload in payloads:
        audit.note(t.connection, "root", "post.hide", payload, reason=payload[:200])
