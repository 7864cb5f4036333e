"""Sends the record of a finished command to a forum that has a page per command, as best it can."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import structlog

from agentrob.agent.pictures import Picture
from agentrob.agent.status import insist
from agentrob.errors import ForumError
from agentrob.forums.forum import Archive

#: A forum that fails so often is left without the record, which stays on the robot's machine.
TRIES = 4
#: Bytes of JSON; of a longer record what a model was told and answered is left out.
MOST_BYTES = 60 * 1024
#: What the forum has itself and may have to forget (people's words), and what is only of this machine.
_NOT_SENT = frozenset({"author", "text", "content_hash", "recording"})
_log = structlog.get_logger()


def public(facts: Mapping[str, Any], pictures: Sequence[Picture]) -> dict[str, Any]:
    """A record as it is sent: without people's words and paths of this machine, with what its pictures are."""
    record = {k: v for k, v in facts.items() if k not in _NOT_SENT}
    record["pictures"] = [{"kind": p.kind, "step": p.step} for p in pictures if p.attached]
    if len(json.dumps(record, ensure_ascii=False, default=str).encode()) > MOST_BYTES:
        record["looked"] = None
        record["shortened"] = True
    plain: dict[str, Any] = json.loads(json.dumps(record, ensure_ascii=False, default=str))
    return plain


async def publish(
    forum: object, post_id: str, reply_id: str | None, facts: Mapping[str, Any] | None, pictures: Sequence[Picture]
) -> None:
    """Send it where the forum keeps records. Never raises a `ForumError`."""
    if facts is None or not isinstance(forum, Archive):
        return
    try:
        await insist(partial(forum.publish_record, post_id, reply_id, public(facts, pictures)), TRIES)
    except ForumError as e:
        _log.info("record not published", post=post_id, error=str(e))
