"""Replays of commands: one per post and robot, sent by the robot's agent, deleted after `retention.replay_days`."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import Any

from sqlalchemy import and_, insert, select, update

from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader, not_found
from agentrob.board.db.records import now_us
from agentrob.board.db.writer import Transaction
from agentrob.board.robots import live
from agentrob.board.robots.commands import removed
from agentrob.board.robots.live import MapView
from agentrob.errors import BoardError
from agentrob.model import Account

#: The largest replay, compressed and not; agents send at most 20 kB.
MOST_BYTES, MOST_TEXT = 64 * 1024, 2**20


def unpacked(replay: bytes) -> dict[str, Any]:
    """The JSON of a gzipped replay. 413 if it is too large, 422 if it is not a replay."""
    hint = f"a JSON object, gzipped to at most {MOST_BYTES} bytes, with at most {MOST_TEXT} characters"
    if len(replay) > MOST_BYTES:
        raise BoardError(413, "replay_too_large", f"the replay has {len(replay)} bytes", hint)
    try:
        reading = zlib.decompressobj(zlib.MAX_WBITS | 16)
        text = reading.decompress(replay, MOST_TEXT)
        if reading.unconsumed_tail or not reading.eof:
            raise ValueError("it is longer, or cut off")
        data = json.loads(text)
        if not isinstance(data, dict) or "t" not in data:
            raise ValueError("it is not a JSON object with times")
    except (ValueError, zlib.error, RecursionError) as e:
        raise BoardError(422, "bad_replay", f"that replay cannot be read: {e}"[:200], hint) from None
    return data


def save(t: Transaction, by: Account, post_id: str, replay: bytes) -> None:
    """Store or replace a robot's replay. 404 if the post does not exist or was removed."""
    post = Reader(t.connection).post(post_id)
    if post.removed:
        raise not_found("post", post_id)
    c = db.replays.c
    mine = and_(c.post_id == int(post.id), c.robot_id == int(by.id))
    values = {"at_us": now_us(), "replay": base64.b64encode(replay).decode()}
    if t.connection.execute(update(db.replays).where(mine).values(**values)).rowcount == 0:
        t.connection.execute(insert(db.replays).values(post_id=int(post.id), robot_id=int(by.id), **values))


def replay_of(reader: Reader, post_id: str, robot: str) -> bytes | None:
    """The gzipped replay of a robot, None if there is none. 404 if the post may not be seen."""
    post = reader.post(post_id)
    if removed(reader, post):
        return None
    r, a = db.replays.c, db.accounts.c
    wanted = select(r.replay).join(db.accounts, a.id == r.robot_id).where(r.post_id == int(post.id), a.name == robot)
    row = reader.first(wanted)
    return None if row is None else base64.b64decode(row.replay)


def final_map(replay: bytes) -> MapView | None:
    """The map of a replay with the whole path, for pages without scripts; None for a malformed one."""
    try:
        data = unpacked(replay)
        one = live.map_view(data.get("map"))
        channels = [list(accumulate(channel)) for channel in data["pose"]]
        poses = [(x / 1000, y / 1000, yaw / 1000) for x, y, yaw in zip(*channels, strict=True)]
        if one is None or not poses:
            return None
        return replace(live.with_paths(one, _planned(data), poses), simulated=data.get("simulated") is True)
    except (BoardError, KeyError, TypeError, ValueError, OverflowError):
        return None


def _planned(data: Mapping[str, Any]) -> Sequence[Sequence[float]]:
    plan = data.get("plan")
    return [(float(x), float(y)) for x, y in plan] if isinstance(plan, list) else []
