"""Notifications of a NodeBB account that point to a post worth answering."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from agentrob.errors import ForumNotFound
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.protocol import Notification
from agentrob.model import Page, Post

#: By `type`; other notifications (votes, followers, chats) are not about a post to answer.
KINDS = {"mention": "mention", "new-reply": "reply"}
#: NodeBB's page size, and the most pages to read for one answer.
NOTES_A_PAGE, MOST_PAGES = 20, 5


async def notifications_of(
    client: NodeBBClient, read: Callable[[str], Awaitable[Post]], mine: str, cursor: str | None, limit: int
) -> Page[Notification]:
    """Return the notifications of the account `mine`, newest first.

    NodeBB creates them half a second after the post, and shows only the latest of several replies in a topic. A reply
    that mentions us appears once, as a mention. Deleted and unreadable posts are left out.
    """
    at = int(cursor) if cursor and cursor.isdigit() and len(cursor) < 10 else 0
    found: list[Notification] = []
    for _ in range(MOST_PAGES):
        page, skip = divmod(at, NOTES_A_PAGE)
        notes = (await client.get("/api/notifications", page=page + 1))["notifications"]
        for note in notes[skip:]:
            at += 1
            if (notification := await _notification(read, note, mine)) is not None:
                found.append(notification)
            if len(found) == limit:
                more = page * NOTES_A_PAGE + len(notes) > at or len(notes) == NOTES_A_PAGE
                return Page(tuple(found), str(at) if more else None)
        if len(notes) < NOTES_A_PAGE:
            return Page(tuple(found))
    return Page(tuple(found), str(at))


async def _notification(
    read: Callable[[str], Awaitable[Post]], note: Mapping[str, Any], mine: str
) -> Notification | None:
    kind, pid = KINDS.get(str(note.get("type"))), note.get("pid")
    if kind is None or not pid:
        return None
    try:
        post = await read(str(pid))
    except ForumNotFound:  # also NodeBB's answer for posts that may not be read
        return None
    if post.removed or (kind == "reply" and mine in post.mentions):
        return None
    return Notification(str(note["nid"]), kind, post, bool(note.get("read")))
