"""Refuse names that a reader could take for a robot's, so that only a robot's agent looks like one.

Two strings look alike when their skeletons are the same (as in Unicode TS 39): each character becomes the plain letter
that it is confused with, by the Unicode consortium's own table, and what hardly shows is left out.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from functools import cache

from agentrob.errors import BoardError

#: Digits and pairs of letters that look like other letters; the Unicode table does not cover ASCII.
_ASCII = (("rn", "m"), ("vv", "w"), ("cl", "d"), ("0", "o"), ("1", "l"), ("i", "l"), ("3", "e"), ("5", "s"), ("8", "b"))
_HARDLY_SHOWN = re.compile(r"[\W_]+")
#: Words that claim the role of a robot or of staff, after folding.
_CLAIMS = ("robot", "admin", "moderator", "operator", "agentrob", "official")


@cache
def _table() -> dict[str, str]:
    """Map each character that looks like an ASCII letter to that letter."""
    from confusable_homoglyphs.confusables import confusables_data

    found: dict[str, str] = {}
    for letter in "abcdefghijklmnopqrstuvwxyz0123456789":
        for shape in (letter, letter.upper()):
            for other in confusables_data.get(shape, ()):
                if len(other["c"]) == 1 and not other["c"].isascii():
                    found.setdefault(other["c"], letter)
    return found


def skeleton(text: str) -> str:
    """The text with lookalike characters replaced by one form."""
    table = _table()
    shown = "".join(table.get(c, c) for c in unicodedata.normalize("NFD", text))
    plain = "".join(c for c in unicodedata.normalize("NFKD", shown) if not unicodedata.combining(c)).casefold()
    folded = "".join(table.get(c, c) for c in plain)
    for looks, like in _ASCII:
        folded = folded.replace(looks, like)
    return _HARDLY_SHOWN.sub("", folded)


def check_name(name: str, robots: Iterable[str]) -> None:
    """422 for a handle that looks like that of another robot."""
    mine = skeleton(name)
    for robot in robots:
        if name != robot and mine == skeleton(robot):
            raise BoardError(422, "looks_like_a_robot", f"{name!r} looks like the robot @{robot}", "another name")


def check_display_name(display_name: str, name: str, robots: Iterable[str]) -> None:
    """422 for a display name that contains the name of a robot, or the word of a badge, unless it is the robot's
    own."""
    mine = skeleton(display_name)
    for robot in robots:
        looks = skeleton(robot)
        if name != robot and (mine == looks or (len(looks) >= 4 and looks in mine)):
            what = f"that display name looks like the robot @{robot}"
            raise BoardError(422, "looks_like_a_robot", what, "one without a robot's name in it")
    if name not in robots and mine in {skeleton(word) for word in _CLAIMS}:
        raise BoardError(422, "claims_a_role", "that display name claims to be more than its account", "another one")
