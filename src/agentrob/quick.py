"""Makes the first import of large libraries quicker: a program that is started by another is waited for.

Nothing becomes garbage while modules are imported: looking for some costs a third of the time. And what a library's own
`__init__` imports beyond what is asked for need not be run: `import mcp.server.lowlevel` first runs `mcp/__init__` and
`mcp/server/__init__`, which import the SDK's client, its other server framework and more.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.machinery import PathFinder
from types import ModuleType


@contextmanager
def quick_imports(folders: Sequence[str] = (), without: Sequence[str] = ()) -> Iterator[None]:
    """Import within this. `folders` are packages whose `__init__` is left out, each after the one it is in; `without`
    are libraries that are not found meanwhile, for others that go without. Afterwards all are themselves again."""
    left_out = [name for name in without if name not in sys.modules]
    made = [] if folders and folders[0] in sys.modules else _bare(folders)
    sys.modules.update(dict.fromkeys(left_out))  # type: ignore[arg-type]  # None: it cannot be imported
    collecting = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collecting:
            gc.freeze()
            gc.enable()
        for name in left_out:
            sys.modules.pop(name, None)
        for package in made:
            if sys.modules.get(package.__name__) is package:
                del sys.modules[package.__name__]


def _bare(names: Sequence[str]) -> list[ModuleType]:
    """Packages as nothing but folders of modules."""
    made: list[ModuleType] = []
    path = sys.path
    for name in names:
        spec = PathFinder.find_spec(name, path)
        if spec is None or spec.submodule_search_locations is None:
            break
        package = ModuleType(name)
        package.__path__ = path = list(spec.submodule_search_locations)
        package.__spec__ = spec
        sys.modules[name] = package
        made.append(package)
    return made
