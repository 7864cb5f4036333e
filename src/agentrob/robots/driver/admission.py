"""Which connections the driver's network listener accepts: limits before the costly part (TLS), so that a flood of
strangers delays neither a stop on a connection that is open nor one on the Unix socket."""

from __future__ import annotations

import ipaddress
from collections import Counter
from dataclasses import dataclass

from limits import RateLimitItemPerMinute, RateLimitItemPerSecond
from limits.storage import MemoryStorage
from limits.strategies import MovingWindowRateLimiter

#: Open connections, in total and of one address. A client keeps about eight.
TOTAL, PER_ADDRESS = 128, 48
#: Connections that have not yet shown a valid certificate or token, in total and of one address, …
STRANGERS, STRANGERS_PER_ADDRESS = 48, 24
#: … are closed after this time.
STRANGER_S = 5.0
#: New connections in ten seconds, of all addresses and of one.
NEW, NEW_PER_ADDRESS = RateLimitItemPerSecond(200, 10), RateLimitItemPerSecond(100, 10)
#: Wrong tokens of one address, before its new connections are closed for the rest of the minute.
WRONG = RateLimitItemPerMinute(10)

#: An address and port: one connection.
Peer = tuple[str, int]


@dataclass
class _Connection:
    group: str
    trusted: bool = False


class Admission:
    """Counts connections, strangers and wrong tokens. Connections that are trusted are never closed by it."""

    def __init__(self) -> None:
        self._open: dict[Peer, _Connection] = {}
        self._limiter = MovingWindowRateLimiter(MemoryStorage())

    def admit(self, peer: Peer) -> bool:
        """Whether to accept a connection; it then counts until `closed`."""
        group = _group(peer[0])
        strangers = Counter(c.group for c in self._open.values() if not c.trusted)
        if (
            len(self._open) >= TOTAL
            or sum(c.group == group for c in self._open.values()) >= PER_ADDRESS
            or strangers.total() >= STRANGERS
            or strangers[group] >= STRANGERS_PER_ADDRESS
            or not self._limiter.test(WRONG, "wrong", group)
            or not self._limiter.hit(NEW_PER_ADDRESS, "new", group)
            or not self._limiter.hit(NEW, "new")
        ):
            return False
        self._open[peer] = _Connection(group)
        return True

    def trust(self, peer: Peer) -> None:
        """The connection has shown what it must."""
        if peer in self._open:
            self._open[peer].trusted = True

    def trusted(self, peer: Peer) -> bool:
        return peer in self._open and self._open[peer].trusted

    def wrong(self, peer: Peer) -> bool:
        """Count a wrong token; return whether that is to be logged, which is once a minute for each address."""
        group = _group(peer[0])
        first = self._limiter.get_window_stats(WRONG, "wrong", group).remaining == WRONG.amount
        self._limiter.hit(WRONG, "wrong", group)
        return first

    def closed(self, peer: Peer) -> None:
        self._open.pop(peer, None)


def _group(host: str) -> str:
    """The address, or the network of an IPv6 address: one machine has all addresses of such a network."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host
    if address.version == 4:
        return str(address)
    return str(ipaddress.ip_network((int(address), 64), strict=False))
