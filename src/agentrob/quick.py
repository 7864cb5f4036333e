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
from typing import Any


@contextmanager
def quick_imports(folders: Sequence[str] = (), without: Sequence[str] = ()) -> Iterator[None]:
    """Import within this. `folders` are packages whose `__init__` is left out, each after the one it is in; `without`
    are libraries that are not found meanwhile, for others that go without. Afterwards all is there for who asks."""
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
            _complete_when_asked(package)


def _complete_when_asked(package: ModuleType) -> None:
    """Let a bare package run its own `__init__` when something is asked of it that is not there."""

    def ask(name: str) -> Any:
        spec = package.__spec__
        if name.startswith("__") or spec is None or spec.loader is None:
            raise AttributeError(f"module {package.__name__!r} has no attribute {name!r}")
        del package.__dict__["__getattr__"]
        spec.loader.exec_module(package)
        return getattr(package, name)

    package.__dict__["__getattr__"] = ask


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
        if made:
            setattr(made[-1], name.rpartition(".")[2], package)
        made.append(package)
    return made
