"""The one door to DDS: cyclonedds with the patch that lets it talk to what robots run.

cyclonedds 11 describes `uint8` as XTypes `TK_UINT8`, 0.10 (on the robots) as `TK_BYTE`; unpatched, the two do not
understand each other. The patch must run before any IDL type is built, so everything that needs DDS types imports this
module first.

Topics are created one at a time: cyclonedds 11 deletes a topic that exists already while it holds Python's global lock,
and another thread that creates one then holds what the deletion waits for (seen: four SDK clients at once, on a busy
machine, and the process hung for good).

A callback given to DDS lives as long as the process: an entity that Python's cyclic collector takes (whoever drops a
client of the SDK without closing it) stays in the C library, which goes on calling what was freed (seen: segmentation
fault in the receiving thread, seconds later). So too everything is deleted before the interpreter takes itself apart,
and no callback begins from then on: the SDK prints on standard output what comes of taking from what is deleted.
"""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Callable
from functools import wraps
from typing import Any

from cyclonedds.core import Entity, Listener
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import _xt_builder
from cyclonedds.topic import Topic

#: cyclonedds configuration; `{interface}` is `name="lo"` or `autodetermine="true"`. No log file (the SDK's shared one
#: fails for a second user of the host).
CONFIG = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface {interface} priority="default" '
    'multicast="default"/></Interfaces></General></Domain></CycloneDDS>'
)


class _ByteForUint8:
    """Stands for the `xt` module inside `_xt_builder` only."""

    def __init__(self, xt: Any) -> None:
        self._xt = xt

    def __getattr__(self, name: str) -> Any:
        return self._xt.TK_BYTE if name == "TK_UINT8" else getattr(self._xt, name)


_one_topic = threading.Lock()
_listeners: list[Listener] = []  # a few for each client
_ended = threading.Event()
_calling: set[int] = set()  # threads of the C library that are in a callback
#: Callbacks that have begun get so long before everything is deleted.
_LAST_CALLS_S = 0.2


def patch() -> None:
    """Apply the patches; calling again does nothing."""
    if isinstance(_xt_builder.xt, _ByteForUint8):
        return
    _xt_builder.xt = _ByteForUint8(_xt_builder.xt)
    create, listen = Topic.__init__, Listener.__init__

    @wraps(create)
    def one_at_a_time(*args: Any, **kwargs: Any) -> None:
        with _one_topic:
            create(*args, **kwargs)

    @wraps(listen)
    def for_good(self: Listener, *args: Any, **kwargs: Any) -> None:
        listen(self, *args, **{event: _until_the_end(callback) for event, callback in kwargs.items()})
        _listeners.append(self)

    Topic.__init__ = one_at_a_time
    Listener.__init__ = for_good
    atexit.register(_end)


def _until_the_end(callback: Callable[..., None]) -> Callable[..., None]:
    def call(*args: Any) -> None:
        me = threading.get_ident()
        _calling.add(me)
        try:
            if not _ended.is_set():
                callback(*args)
        finally:
            _calling.discard(me)

    return call


def _end() -> None:
    """Delete the participants with all that they hold: no thread of the C library calls Python after this."""
    _ended.set()
    limit_s = time.monotonic() + _LAST_CALLS_S
    while _calling and time.monotonic() < limit_s:
        time.sleep(0.001)
    for entity in list(Entity._entities.values()):
        if isinstance(entity, DomainParticipant):
            entity._delete(entity._ref)


def config(interface: str | None) -> str:
    """The configuration for a network interface, or for the one cyclonedds picks."""
    return CONFIG.format(interface=f'name="{interface}"' if interface else 'autodetermine="true"')


patch()
