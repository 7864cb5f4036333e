"""Limit attempts to sign in, so that nobody can guess passwords or exhaust the machine with argon2.

Also counts other uses that have a limit per hour and leave no row with a time: new accounts, and changes. The counts
are in the database, so that all processes share them and they survive a restart. Names and addresses are stored as
hashes, for one hour, and are left out of backups.
"""

from __future__ import annotations

import hashlib
import ipaddress
import math

from sqlalchemy import Connection, delete, insert, select

from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import now_us
from agentrob.errors import BoardError

WINDOW_S = 300.0
HOUR_S = 3600.0
#: Attempts within `WINDOW_S`: for one name from one address, and for all names from one address.
PER_NAME = 10
PER_ADDRESS = 30
#: After this many attempts for a name, from any address, each further one takes a second longer, up to `SLOWEST_S`.
SLOWER_EVERY = 30
SLOWEST_S = 5.0


def check(reader: Reader, name: str, address: str) -> None:
    """429 when there were `PER_NAME` attempts for the name from the address, or `PER_ADDRESS` for any, in `WINDOW_S`.

    A name is never blocked for all addresses, since anybody could then lock its owner out. Without a name (sign-up)
    only the address counts, since a few newcomers would otherwise block all others.
    """
    for key, limit in _limits(name, address):
        if (wait_s := _wait_s(reader, key, limit, WINDOW_S)) is not None:
            raise BoardError(429, "too_many_attempts", "too many attempts to sign in", "wait", wait_s)


def record(connection: Connection, name: str, address: str) -> None:
    """Record one attempt. 429 when there were too many; that attempt is not recorded."""
    check(Reader(connection), name, address)
    _add(connection, *(key for key, _ in _limits(name, address)), *([_name(name)] if name else []))


def delay_s(reader: Reader, name: str) -> float:
    """Seconds to delay an attempt for this name, by the number of recent attempts from all addresses."""
    a, most = db.attempts.c, math.ceil(SLOWEST_S) * SLOWER_EVERY
    since = now_us() - int(WINDOW_S * 1_000_000)
    recent = select(a.at_us).where(a.key == _name(name), a.at_us > since).limit(most)
    return min(SLOWEST_S, float(len(reader.rows(recent)) // SLOWER_EVERY))


def record_sign_up(connection: Connection, address: str, most: int) -> None:
    """Record one account made from an address. 429 after `most` within an hour; 0 means no limit."""
    if (wait_s := record_use(connection, "sign-up", _network(address), most)) is not None:
        said = f"{most} accounts were made from your address within the last hour, which is the limit"
        minutes = math.ceil(wait_s / 60)
        raise BoardError(429, "too_many_sign_ups", said, f"come again in {minutes} minutes", wait_s)


def record_use(connection: Connection, kind: str, value: str, most: int) -> float | None:
    """Record one use; return the seconds to wait if over the limit of `most` per hour, else None. 0 means no limit."""
    if not most:
        return None
    key = _key(kind, value)
    wait_s = _wait_s(Reader(connection), key, most, HOUR_S)
    if wait_s is None:
        _add(connection, key)
    return wait_s


def clear(connection: Connection, name: str, address: str) -> None:
    """Clear the attempts for a name from an address, after a right password."""
    connection.execute(delete(db.attempts).where(db.attempts.c.key == _name_at(name, address)))


def _limits(name: str, address: str) -> list[tuple[str, int]]:
    limits = [(_key("address", _network(address)), PER_ADDRESS)]
    return [(_name_at(name, address), PER_NAME), *limits] if name else limits


def _wait_s(reader: Reader, key: str, limit: int, window_s: float) -> float | None:
    """Seconds until the next attempt is allowed; None when it is allowed now."""
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
    """The part of an address that a client cannot choose: the whole IPv4 address, the first 64 bits of IPv6."""
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
