"""Members of a family (`forums`, `robots`, `minds`) by their entry points, built-in or a stranger's."""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any

from agentrob.errors import ConfigError


def find(family: str, name: str) -> Any:
    """What the member's entry point names. Raises `ConfigError` where there is none or it cannot be loaded."""
    members, kind = {e.name: e for e in entry_points(group=f"agentrob.{family}")}, family.removesuffix("s")
    if name not in members:
        raise ConfigError(f"no {kind} named {name!r} is installed; there are: {', '.join(sorted(members))}")
    member = members[name]
    try:
        return member.load()
    except Exception as e:  # it is a stranger's code that runs here
        whose = f" of the package {member.dist.name}" if member.dist else ""
        what = f"{type(e).__name__}: {e}"
        raise ConfigError(f"the {kind} {name!r}{whose} cannot be loaded from {member.value}: {what}") from e
