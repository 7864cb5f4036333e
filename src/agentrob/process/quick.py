"""Makes the first import of large libraries quicker: a program that is started by another is waited for.

Nothing becomes garbage while modules are imported: looking for some costs a third of the time. What a library's own
`__init__` imports beyond what is asked for need not be run: `import mcp.server.lowlevel` first runs `mcp/__init__` and
`mcp/server/__init__`, which import the SDK's client, its other server framework and more. And pydantic builds the
validator of a model when it is defined, though of the five hundred models of the SDK, for two eras of the protocol, a
client ever meets a few dozen.
"""

from __future__ import annotations

import gc
import importlib
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from importlib.machinery import PathFinder
from types import ModuleType
from typing import Any


@contextmanager
def quick_imports(
    folders: Sequence[str] = (), without: Sequence[str] = (), later: Sequence[str] = (), models_later: bool = False
) -> Iterator[None]:
    """Import within this. `folders` are packages whose `__init__` is left out, each after the one it is in; `without`
    are libraries that are not found meanwhile, for others that go without. What is imported from the modules `later` is
    only a name until it is used, as with the lazy imports of Python 3.15. Afterwards all is there for who asks.
    With `models_later` pydantic's models that are defined meanwhile are built when they are first used."""
    left_out = [name for name in (*without, *later) if name not in sys.modules]
    made = [] if folders and folders[0] in sys.modules else _bare(folders)
    stands: dict[str, Any] = {name: _Names(name) if name in later else None for name in left_out}
    sys.modules.update(stands)  # None: it cannot be imported
    collecting = gc.isenabled()
    gc.disable()
    try:
        with _models_later() if models_later else nullcontext():
            yield
    finally:
        if collecting:
            gc.freeze()
            gc.enable()
        for name in left_out:
            sys.modules.pop(name, None)
        for package in made:
            _complete_when_asked(package)


@contextmanager
def _models_later() -> Iterator[None]:
    from pydantic import BaseModel, TypeAdapter

    # An adapter of a union of models has no configuration of its own that could say so.
    asked: Any = TypeAdapter.__dict__.get("_defer_build")
    setattr(TypeAdapter, "_defer_build", True)  # noqa: B010
    BaseModel.model_config["defer_build"] = True
    try:
        yield
    finally:
        del BaseModel.model_config["defer_build"]
        delattr(TypeAdapter, "_defer_build")
        if asked is not None:
            setattr(TypeAdapter, "_defer_build", asked)  # noqa: B010


class _Names(ModuleType):
    """Stands for a module that is not imported yet."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Name(self.__name__, name)


class _Name:
    """Something of such a module: imported when it is called or asked for something, or as a type of pydantic's."""

    def __init__(self, module: str, name: str) -> None:
        self._module, self._name = module, name

    def _meant(self) -> Any:
        return getattr(importlib.import_module(self._module), self._name)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        return self._meant()(*args, **kwargs)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._meant(), name)

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        return handler.generate_schema(self._meant())


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
