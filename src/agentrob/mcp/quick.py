"""Makes the first import of the MCP SDK quicker: a server needs few of its thousand models, and nothing of its client.

`import mcp.server.lowlevel` first runs the SDK's own `mcp/__init__` and `mcp/server/__init__`, which import its client,
its other server framework and more: half of the time that a stdio server takes to its first answer. Within
`quick_imports` the two packages are only their folders, so that just the modules that are asked for are run; afterwards
they are themselves again for whoever imports them. Looking for garbage meanwhile, where there is none, is left out too.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.machinery import PathFinder
from types import ModuleType

_PACKAGES = ("mcp", "mcp.server")


@contextmanager
def quick_imports() -> Iterator[None]:
    """Import the SDK's modules for a server within this; nothing happens when the SDK is there already."""
    made = [] if "mcp" in sys.modules else _folders()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
        for package in made:
            if sys.modules.get(package.__name__) is package:
                del sys.modules[package.__name__]


def _folders() -> list[ModuleType]:
    """The packages as bare folders of modules."""
    made: list[ModuleType] = []
    path = sys.path
    for name in _PACKAGES:
        spec = PathFinder.find_spec(name, path)
        if spec is None or spec.submodule_search_locations is None:
            break
        package = ModuleType(name)
        package.__path__ = path = list(spec.submodule_search_locations)
        package.__spec__ = spec
        sys.modules[name] = package
        made.append(package)
    return made
