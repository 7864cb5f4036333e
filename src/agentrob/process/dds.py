"""DDS entities that robots understand and that cannot crash the interpreter; import this before any DDS type.

cyclonedds 11 describes `uint8` as XTypes `TK_UINT8`, version 0.10 (on the robots) as `TK_BYTE`, and the two do not
understand each other. Importing this module makes cyclonedds 11 say `TK_BYTE`. There is no public setting for it, so
this patches the one private module `cyclonedds.idl._xt_builder`, before any IDL type is built.

The classes below replace those of cyclonedds of the same name, also in Unitree's SDK (`use_in`). They differ so:

- `Topic` is created one at a time. cyclonedds 11 deletes a topic that already exists while it holds Python's global
  lock; another thread that creates a topic then holds the lock that the deletion needs (seen: four SDK clients created
  at once on a busy machine hung the process).
- `Listener` lives as long as the process. An SDK client that is dropped without being closed leaves its reader in the C
  library, which keeps calling the callback (seen: segmentation fault in the receiving thread, seconds later).
- A callback waits until its `DataReader` is complete. The C library calls back as soon as it has created the reader,
  and cyclonedds passes `None` until Python has registered it (seen: the SDK printed an error, and a request to a
  simulated world lay unread until the next one came).
- The participants are deleted, with all that they hold, before the interpreter shuts down, and no callback begins after
  that (seen: the SDK printed errors of readers that were gone).
"""

from __future__ import annotations

import atexit
import platform
import threading
import time
import weakref
from collections.abc import Callable
from typing import Any

from agentrob.errors import ConfigError

try:
    from cyclonedds import core, domain, sub, topic
    from cyclonedds.idl import _xt_builder
except ModuleNotFoundError as e:
    raise ConfigError(
        f"robots on DDS need the package cyclonedds, which has no wheel for {platform.machine()}; build it: see "
        '"On a Jetson or a Raspberry Pi" in docs/forum/deploy.md'
    ) from e

#: cyclonedds configuration; `{interface}` is `name="lo"` or `autodetermine="true"`. Without a log file: the one that
#: the SDK configures is shared by all users of the host and cannot be opened by a second one.
CONFIG = (
    '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface {interface} priority="default" '
    'multicast="default"/></Interfaces></General></Domain></CycloneDDS>'
)
#: At shutdown, callbacks that have begun get this long to end; on a busy machine one may take part of a second.
_LAST_CALLS_S = 2.0
#: A callback waits at most this long for its reader to be complete.
_COMPLETE_S = 2.0

# The type checker sees cyclonedds as untyped, hence the ignored subclassing.
_one_topic = threading.Lock()
_registry = threading.Lock()
_listeners: list[Listener] = []  # a few per client
_participants: weakref.WeakSet[DomainParticipant] = weakref.WeakSet()
_ended = threading.Event()
_calling: set[int] = set()  # threads of the C library that run a callback


class DomainParticipant(domain.DomainParticipant):  # type: ignore[misc]
    """A participant that `participants` lists."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with _registry:
            _participants.add(self)


class Topic(topic.Topic[Any]):  # type: ignore[misc]
    """A topic; two are never created at the same time."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        with _one_topic:
            super().__init__(*args, **kwargs)


class Listener(core.Listener):  # type: ignore[misc]
    """Callbacks that are kept for the life of the process and are not called after its end began."""

    def __init__(self, *, on_data_available: Callable[[Any], None] | None = None, **callbacks: Any) -> None:
        self.on_data: _OnData | None = None
        if on_data_available is not None:
            self.on_data = _OnData(on_data_available)
            callbacks["on_data_available"] = self.on_data
        super().__init__(**{event: _until_the_end(callback) for event, callback in callbacks.items()})
        with _registry:
            _listeners.append(self)


class DataReader(sub.DataReader[Any]):  # type: ignore[misc]
    """A reader whose listener is called only once the reader is complete."""

    def __init__(self, parent: Any, of: Any, qos: Any = None, listener: Any = None) -> None:
        on_data = listener.on_data if isinstance(listener, Listener) else None
        if on_data is not None:
            on_data.begin()
        super().__init__(parent, of, qos, listener)
        if on_data is not None:
            on_data.complete(self)


class _OnData:
    """Calls back with the reader of a listener, after that reader is complete."""

    def __init__(self, callback: Callable[[Any], None]) -> None:
        self._callback = callback
        self._complete = threading.Event()
        self._reader: Callable[[], Any] = lambda: None
        self._creator, self._missed = 0, False

    def begin(self) -> None:
        """The reader is being created in this thread."""
        self._creator = threading.get_ident()

    def complete(self, reader: DataReader) -> None:
        self._reader = weakref.ref(reader)  # a reader that the SDK closes must go
        self._complete.set()
        if self._missed:
            self._callback(reader)

    def __call__(self, _: Any) -> None:
        if not self._complete.is_set() and threading.get_ident() == self._creator:
            self._missed = True  # kept data of a writer in this process, which comes while the reader is created
            return
        limit_s = time.monotonic() + _COMPLETE_S
        while not self._complete.wait(0.02):
            if _ended.is_set() or time.monotonic() > limit_s:
                return
        if (reader := self._reader()) is not None:
            self._callback(reader)


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
    for participant in participants():
        delete(participant)


def delete(participant: DomainParticipant) -> None:
    """Delete a participant with all that it holds, also what somebody still refers to, such as a reader's listener."""
    participant.__del__()  # cyclonedds has no other way


def use_in(channel: Any) -> None:
    """Make the SDK's module `unitree_sdk2py.core.channel` create the classes of this module."""
    channel.DomainParticipant, channel.Topic = DomainParticipant, Topic
    channel.DataReader, channel.Listener = DataReader, Listener
    channel.ChannelConfigHasInterface = config("$__IF_NAME__$")


def participants() -> list[DomainParticipant]:
    """The participants of this process."""
    with _registry:
        return list(_participants)


def config(interface: str | None) -> str:
    """The cyclonedds configuration for a network interface, or for the one cyclonedds picks."""
    return CONFIG.format(interface=f'name="{interface}"' if interface else 'autodetermine="true"')


class _ByteForUint8:
    """Stands for the `xt` module inside `_xt_builder` only."""

    def __init__(self, xt: Any) -> None:
        self._xt = xt

    def __getattr__(self, name: str) -> Any:
        return self._xt.TK_BYTE if name == "TK_UINT8" else getattr(self._xt, name)


if not isinstance(_xt_builder.xt, _ByteForUint8):
    _xt_builder.xt = _ByteForUint8(_xt_builder.xt)
    atexit.register(_end)
