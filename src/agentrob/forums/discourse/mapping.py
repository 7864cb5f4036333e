"""Convert Discourse's JSON to boards, times, post versions and path segments."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

from agentrob.errors import ForumNotFound
from agentrob.forums.bounded import BoundedDict
from agentrob.forums.protocol import Board
from agentrob.model import Account, AccountKind

_JSON = Mapping[str, Any]
_KEPT = 2_000


class VersionTracker:
    """Count the versions of each post. Discourse does not count edits within its grace period (five minutes), so a post
    that changed since it was seen, or was touched after it was written, is not at version 1 (law 4)."""

    def __init__(self) -> None:
        self._known = BoundedDict[int, tuple[str, int]](_KEPT)

    def of(self, raw: _JSON) -> int:
        post_id, text = int(raw["id"]), str(raw["raw"])
        touched = time_of(raw["updated_at"]) - time_of(raw["created_at"]) > timedelta(seconds=1)
        version = max(int(raw["version"]), 2 if touched else 1)
        if (known := self._known.get(post_id)) is not None:
            version = max(version, known[1] + (known[0] != text))
        self._known[post_id] = (text, version)
        return version


def boards_of(categories: Sequence[_JSON], above: str = "") -> list[tuple[int, Board]]:
    """Return all categories with their subcategories. Slugs are unique only below one parent, and may be missing."""
    found = []
    for c in categories:
        path = f"{above}{c['slug'] or str(c['id']) + '-category'}"
        found.append((int(c["id"]), Board(path, c["name"], c.get("description_text") or "")))
        found += boards_of([s for s in c.get("subcategory_list") or () if isinstance(s, Mapping)], f"{path}/")
    return found


def stranger_of(raw: _JSON) -> Account:
    """Return an account without rights for an author whose account was deleted; it is never obeyed."""
    return Account(str(raw.get("user_id") or 0), str(raw["username"]).lower(), AccountKind.MONITORING_AGENT)


def number_of(text: str, what: str) -> int:
    if not (text.isascii() and text.isdigit()) or len(text) > 18:
        raise ForumNotFound(f"there is no {what} {text!r}")
    return int(text)


def path_segment(name: str) -> str:
    """Return a name that is safe in an address."""
    if not name or any(c in name for c in "/?#%\\") or name.startswith("."):
        raise ForumNotFound(f"there is no account {name!r}")
    return name


def time_of(text: str) -> datetime:
    return datetime.fromisoformat(text).astimezone(UTC)
