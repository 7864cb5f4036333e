"""Counts attempts to sign in, so that passwords cannot be guessed and argon2 cannot be used to exhaust the machine.

Also counts what else has a limit in an hour and leaves no row with its time: accounts made, and changes. The count is
in the database: one for all processes that serve it, and the same after a restart. Names and addresses are kept as
hashes, for an hour, and in no backup.
"""

from __future__ import annotations

import hashlib
import math

from sqlalchemy import Connection, delete, insert, select

from agentrob.board import schema as db
from agentrob.board.audit import now_us
from agentrob.board.reader import Reader
from agentrob.errors import BoardError

WINDOW_S = 300.0
HOUR_S = 3600.0
PER_NAME = 10
PER_ADDRESS = 30


def refuse(reader: Reader, name: str, address: str) -> None:
    """429 when there were `PER_NAME` attempts for the name or `PER_ADDRESS` from the address in `WINDOW_S`.

    Without a name (signing up) only the address counts: else a few newcomers would shut out all others.
    """
    for key, limit in _limits(name, address):
        if (wait_s := _wait_s(reader, key, limit, WINDOW_S)) is not None:
            raise BoardError(429, "too_many_attempts", "too many attempts to sign in", "wait", wait_s)


def count(connection: Connection, name: str, address: str) -> None:
    """Count one attempt. 429 when there were too many; that one then does not count."""
    refuse(Reader(connection), name, address)
    _add(connection, *(key for key, _ in _limits(name, address)))


def count_sign_up(connection: Connection, address: str, most: int) -> None:
    """Count one account made from an address. 429 beyond `most` in an hour; 0 is no such limit."""
    if (wait_s := count_in_hour(connection, "sign-up", address, most)) is not None:
        said = f"{most} accounts were made from your address within the last hour, which is the limit"
        minutes = math.ceil(wait_s / 60)
        raise BoardError(429, "too_many_sign_ups", said, f"come again in {minutes} minutes", wait_s)


def count_in_hour(connection: Connection, kind: str, value: str, most: int) -> float | None:
    """Count one. Beyond `most` in an hour it does not count: in how many seconds there is room. 0 is no such limit."""
    if not most:
        return None
    key = _key(kind, value)
    wait_s = _wait_s(Reader(connection), key, most, HOUR_S)
    if wait_s is None:
        _add(connection, key)
    return wait_s


def forget(connection: Connection, name: str) -> None:
    """A right password: the name starts anew."""
    connection.execute(delete(db.attempts).where(db.attempts.c.key == _name(name)))


def _limits(name: str, address: str) -> list[tuple[str, int]]:
    limits = [(_key("address", address), PER_ADDRESS)]
    return [(_name(name), PER_NAME), *limits] if name else limits


def _wait_s(reader: Reader, key: str, limit: int, window_s: float) -> float | None:
    """How long until there is room again; None when there is."""
    a, now, window_us = db.attempts.c, now_us(), int(window_s * 1_000_000)
    recent = select(a.at_us).where(a.key == key, a.at_us > now - window_us).order_by(a.at_us.desc()).limit(limit)
    times = reader.rows(recent)
    return (times[-1].at_us + window_us - now) / 1_000_000 if len(times) >= limit else None


def _add(connection: Connection, *keys: str) -> None:
    now = now_us()
    connection.execute(delete(db.attempts).where(db.attempts.c.at_us <= now - int(HOUR_S * 1_000_000)))
    connection.execute(insert(db.attempts), [{"key": key, "at_us": now} for key in keys])


def _name(name: str) -> str:
    return _key("name", name.strip().lower()[:64])


def _key(kind: str, value: str) -> str:
    return hashlib.sha256(f"{kind}:{value}".encode("utf-8", "surrogatepass")).hexdigest()
