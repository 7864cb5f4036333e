"""Find the address of a command's page on the forum and publish the command's record there, if the forum has pages."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import structlog

from agentrob.agent.media.pictures import Picture
from agentrob.agent.reporting.status_post import retry_until_answered
from agentrob.errors import ForumError
from agentrob.forums.protocol import CommandPages

#: How often to try; if all fail, the record is only on the robot's machine.
TRIES = 4
#: The maximum size of a record as JSON; a longer one is published without the conversation with the model.
MOST_BYTES = 60 * 1024
#: Not published: people's words, which the forum has and may have to delete, and paths of this machine.
_NOT_SENT = frozenset({"author", "text", "content_hash", "recording"})
#: The timeout for the address of a page, because a report must not wait for its link.
PAGE_S = 2.0
#: An address that needs no escaping in a Markdown link.
_ADDRESS = re.compile(r"https?://[^\s<>()\[\]\\`*]{1,500}")
_log = structlog.get_logger()


def public(facts: Mapping[str, Any], pictures: Sequence[Picture]) -> dict[str, Any]:
    """Return the record for publication: without people's words and local paths, with the kinds of its pictures."""
    record = {k: v for k, v in facts.items() if k not in _NOT_SENT}
    record["pictures"] = [{"kind": p.kind, "step": p.step} for p in pictures if p.attached]
    links = [(p, p.link) for p in pictures if p.link]
    if links:
        record["links"] = [
            {"kind": p.kind, "step": p.step, "url": link.url, "until": link.until.isoformat()} for p, link in links
        ]
    if len(json.dumps(record, ensure_ascii=False, default=str).encode()) > MOST_BYTES:
        record["looked"] = None
        record["shortened"] = True
    plain: dict[str, Any] = json.loads(json.dumps(record, ensure_ascii=False, default=str))
    return plain


async def page_of(forum: object, post_id: str, *, hurry: bool = False) -> str:
    """Return the address of a command's page, or an empty string if the forum has none or does not answer in time.

    Never raises a `ForumError`. With `hurry` (the agent is shutting down) the forum is not asked.
    """
    if hurry or not post_id or not isinstance(forum, CommandPages):
        return ""
    try:
        async with asyncio.timeout(PAGE_S):
            address = await forum.command_page(post_id)
    except (ForumError, TimeoutError) as e:
        _log.info("page of the command not known", post=post_id, error=str(e))
        return ""
    return address if _ADDRESS.fullmatch(address) else ""


async def publish(
    forum: object, post_id: str, reply_id: str | None, facts: Mapping[str, Any] | None, pictures: Sequence[Picture]
) -> bool:
    """Publish the record if the forum keeps records; return whether it is there. Never raises a `ForumError`."""
    if facts is None or not post_id or not isinstance(forum, CommandPages):
        return False
    try:
        await retry_until_answered(partial(forum.publish_record, post_id, reply_id, public(facts, pictures)), TRIES)
    except ForumError as e:
        _log.info("record not published", post=post_id, error=str(e))
        return False
    return True
