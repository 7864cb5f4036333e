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

A reader hears as soon as the C library has made it. Python notes it a moment later (on a busy machine: many messages
later), and cyclonedds calls back with `None` until then: the SDK printed an error, and a request to a simulated world
lay unread until the next one came. So the first callback of a reader waits until the reader is made.
"""

from __future__ import annotations

import atexit
import threading
import time
from collections.abc import Callable
from functools import wraps
from typing import Any

from cyclonedds.core import Entity, Listener, _data_available_fn
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import _xt_builder
from cyclonedds.sub import DataReader
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
#: Callbacks that have begun get so long before everything is deleted; on a busy machine one may take part of a second.
_LAST_CALLS_S = 2.0
#: So long a callback waits for its reader to be made.
_MADE_S = 2.0


def patch() -> None:
    """Apply the patches; calling again does nothing."""
    if isinstance(_xt_builder.xt, _ByteForUint8):
        return
    _xt_builder.xt = _ByteForUint8(_xt_builder.xt)
    create, listen, read, announce = (
        Topic.__init__,
        Listener.__init__,
        DataReader.__init__,
        Listener.set_on_data_available,
    )

    @wraps(create)
    def one_at_a_time(*args: Any, **kwargs: Any) -> None:
        with _one_topic:
            create(*args, **kwargs)

    @wraps(listen)
    def for_good(self: Listener, *args: Any, **kwargs: Any) -> None:
        listen(self, *args, **{event: _until_the_end(callback) for event, callback in kwargs.items()})
        _listeners.append(self)

    @wraps(read)
    def made(self: DataReader, *args: Any, **kwargs: Any) -> None:
        read(self, *args, **kwargs)
        self.agentrob_made = True

    @wraps(announce)
    def when_made(self: Listener, callback: Callable[[DataReader], None] | None) -> None:
        announce(self, callback)
        if callback is not None:
            self._on_data_available = _data_available_fn(lambda ref, _: _call_with(ref, callback))
            self._set_data_available(self._ref, self._on_data_available)

    Topic.__init__ = one_at_a_time
    Listener.__init__ = for_good
    DataReader.__init__ = made
    Listener.set_on_data_available = when_made
    atexit.register(_end)


def _call_with(ref: int, callback: Callable[[DataReader], None]) -> None:
    """Call back with the reader of this number, unless it is dropped, or its making does not come to an end."""
    limit_s = time.monotonic() + _MADE_S
    while not hasattr(reader := Entity.get_entity(ref), "agentrob_made"):
        if _ended.is_set() or time.monotonic() > limit_s:
            return
        time.sleep(0.001)
    callback(reader)


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
