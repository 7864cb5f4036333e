"""Load plugins (`forums`, `robots`, `minds`) by entry point, both built-in and third-party ones."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from agentrob.errors import ConfigError

#: Packages of this repository, by the names of the robots that they bring.
PACKAGES = {
    "ros2": "agentrob-ros2", "ros2-sim": "agentrob-ros2",
    "reachy-mini": "agentrob-reachy-mini", "reachy-mini-sim": "agentrob-reachy-mini",
    "so101": "agentrob-so101",
}  # fmt: skip


def installed(family: str) -> Mapping[str, EntryPoint]:
    """The installed plugins of a family by name. All packages are searched once, and again when `sys.path` changes: a
    worker asks several times for each robot that it takes over."""
    return _on_path(family, tuple(sys.path))


@cache
def _on_path(family: str, _path: tuple[str, ...]) -> Mapping[str, EntryPoint]:
    return {e.name: e for e in entry_points(group=f"agentrob.{family}")}


def names(family: str) -> list[str]:
    """The names of the installed plugins of a family."""
    return sorted(installed(family))


def find(family: str, name: str) -> Any:
    """Load the object that an entry point names. Raises `ConfigError` if it is not installed or cannot be loaded."""
    plugins, kind = installed(family), family.removesuffix("s")
    if name not in plugins:
        package = f": pip install {PACKAGES[name]}" if family == "robots" and name in PACKAGES else ""
        raise ConfigError(
            f"{kind} {name!r} is not installed{package}; installed {family}: {', '.join(sorted(plugins))}"
        )
    plugin = plugins[name]
    try:
        return plugin.load()
    except Exception as e:  # third-party code runs here
        package = f" of the package {plugin.dist.name}" if plugin.dist else ""
        error = f"{type(e).__name__}: {e}"
        raise ConfigError(f"the {kind} {name!r}{package} cannot be loaded from {plugin.value}: {error}") from e
