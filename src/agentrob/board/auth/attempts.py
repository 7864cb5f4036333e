"""Counts attempts to sign in, so that passwords cannot be guessed and argon2 cannot be used to exhaust the machine.

Also counts what else has a limit in an hour and leaves no row with its time: accounts made, and changes. The count is
in the database: one for all processes that serve it, and the same after a restart. Names and addresses are kept as
hashes, for an hour, and in no backup.
"""

from __future__ import annotations

import hashlib
import ipaddress
import math

from sqlalchemy import Connection, delete, insert, select

from agentrob.board.admin.audit import now_us
from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.errors import BoardError

WINDOW_S = 300.0
HOUR_S = 3600.0
#: Of one name from one address, and of all names from one address.
PER_NAME = 10
PER_ADDRESS = 30
#: So many attempts for a name from anywhere make each further one a second slower, up to `SLOWEST_S`.
SLOWER_EVERY = 30
SLOWEST_S = 5.0


def refuse(reader: Reader, name: str, address: str) -> None:
    """429 when there were `PER_NAME` attempts for the name from the address, or `PER_ADDRESS` for any, in `WINDOW_S`.

    A name is never refused to all addresses: else anybody could lock its owner out. Without a name (signing up) only
    the address counts: else a few newcomers would shut out all others.
    """
    for key, limit in _limits(name, address):
        if (wait_s := _wait_s(reader, key, limit, WINDOW_S)) is not None:
            raise BoardError(429, "too_many_attempts", "too many attempts to sign in", "wait", wait_s)


def count(connection: Connection, name: str, address: str) -> None:
    """Count one attempt. 429 when there were too many; that one then does not count."""
    refuse(Reader(connection), name, address)
    _add(connection, *(key for key, _ in _limits(name, address)), *([_name(name)] if name else []))


def delay_s(reader: Reader, name: str) -> float:
    """How long an attempt for this name has to wait, since there were many, from however many addresses."""
    a, most = db.attempts.c, math.ceil(SLOWEST_S) * SLOWER_EVERY
    since = now_us() - int(WINDOW_S * 1_000_000)
    recent = select(a.at_us).where(a.key == _name(name), a.at_us > since).limit(most)
    return min(SLOWEST_S, float(len(reader.rows(recent)) // SLOWER_EVERY))


def count_sign_up(connection: Connection, address: str, most: int) -> None:
    """Count one account made from an address. 429 beyond `most` in an hour; 0 is no such limit."""
    if (wait_s := count_in_hour(connection, "sign-up", _network(address), most)) is not None:
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


def forget(connection: Connection, name: str, address: str) -> None:
    """A right password: the name starts anew from this address."""
    connection.execute(delete(db.attempts).where(db.attempts.c.key == _name_at(name, address)))


def _limits(name: str, address: str) -> list[tuple[str, int]]:
    limits = [(_key("address", _network(address)), PER_ADDRESS)]
    return [(_name_at(name, address), PER_NAME), *limits] if name else limits


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


def _name_at(name: str, address: str) -> str:
    return _key("name at", f"{name.strip().lower()[:64]} {_network(address)}")


def _network(address: str) -> str:
    """The part of an address that its owner cannot choose: all of IPv4, the first 64 bits of IPv6."""
    try:
        ip = ipaddress.ip_address(address)
    except ValueError:
        return address
    if isinstance(ip, ipaddress.IPv4Address):
        return address
    if ip.ipv4_mapped is not None:
        return str(ip.ipv4_mapped)
    return str(ipaddress.ip_network((int(ip), 64), strict=False))


def _key(kind: str, value: str) -> str:
    return hashlib.sha256(f"{kind}:{value}".encode("utf-8", "surrogatepass")).hexdigest()
