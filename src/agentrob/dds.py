"""The one door to DDS: cyclonedds with the patch that lets it talk to what robots run.

cyclonedds 11 describes `uint8` as XTypes `TK_UINT8`, 0.10 (on the robots) as `TK_BYTE`; unpatched, the two do not
understand each other. The patch must run before any IDL type is built, so everything that needs DDS types imports this
module first.

Topics are created one at a time: cyclonedds 11 deletes a topic that exists already while it holds Python's global lock,
and another thread that creates one then holds what the deletion waits for (seen: four SDK clients at once, on a busy
machine, and the process hung for good).
"""

from __future__ import annotations

import threading
from functools import wraps
from typing import Any

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


def patch() -> None:
    """Apply the patches; calling again does nothing."""
    if isinstance(_xt_builder.xt, _ByteForUint8):
        return
    _xt_builder.xt = _ByteForUint8(_xt_builder.xt)
    create = Topic.__init__

    @wraps(create)
    def one_at_a_time(*args: Any, **kwargs: Any) -> None:
        with _one_topic:
            create(*args, **kwargs)

    Topic.__init__ = one_at_a_time


def config(interface: str | None) -> str:
    """The configuration for a network interface, or for the one cyclonedds picks."""
    return CONFIG.format(interface=f'name="{interface}"' if interface else 'autodetermine="true"')


patch()
