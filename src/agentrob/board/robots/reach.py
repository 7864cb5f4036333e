"""Find the robots that a post reaches, and tell its author what to change if it reaches none."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence

from agentrob.board.robots.view import RobotView, robots
from agentrob.board.services import Services
from agentrob.language.complexity import parsing_us
from agentrob.language.parser.grammar import parse
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.visible_text import mentions, visible_text
from agentrob.model import Intent, Op

#: The similarity by `difflib` from which a handle counts as a misspelling of a robot's.
ALIKE = 0.75
#: Longer texts without a mention are not parsed: a text this long is not a command.
COMMAND_CHARS = 500
#: Texts whose markup is estimated to take longer are not parsed either, because parsing blocks the event loop (law 15).
READ_US = 10_000


def acting_on(board_id: str, known: Services) -> tuple[RobotView, ...]:
    """The robots that act on a board, connected ones first. A robot whose agent never connected acts nowhere."""
    return tuple(robot for robot in robots(known) if board_id in robot.boards)


def hint(known: Services, board_id: str, raw: str) -> str:
    """Why no robot will answer this post on this board; empty if one will, or if none is addressed."""
    if parsing_us(raw, READ_US) > READ_US:
        return ""
    text, found = visible_text(raw), robots(known)
    names = mentions(text)
    called = [robot for robot in found if robot.name in names]
    if called:
        return "" if any(board_id in robot.boards and robot.live for robot in called) else _away(called[0], board_id)
    here = known.store.reader.names(names) if names else ()
    strangers = [name for name in names if name not in here]
    if strangers:
        return _stranger(strangers[0], found)
    return "" if names else _nobody(text, found, board_id)


def _away(robot: RobotView, board_id: str) -> str:
    if not robot.live:
        return f"@{robot.name} is not connected now, so it does not answer. It never carries out an old post."
    where = " and ".join(robot.boards) or "no board"
    return f"@{robot.name} does not act on this board ({board_id}): it acts on {where}."


def _stranger(name: str, found: Sequence[RobotView]) -> str:
    alike = difflib.get_close_matches(name, [robot.name for robot in found], 1, ALIKE)
    if alike:
        return f"There is no account @{name}. Did you mean @{alike[0]}?"
    known = ", ".join(f"@{robot.name}" for robot in found)
    return f"There is no account @{name}. {'Robots here: ' + known if known else 'No robot is on this forum yet'}."


def _nobody(text: str, found: Sequence[RobotView], board_id: str) -> str:
    """The hint for a post without a mention: only if it reads as a command or names a robot."""
    here = [robot for robot in found if board_id in robot.boards]
    named = next((r for r in found if re.search(rf"(?<![\w@-]){re.escape(r.name)}(?![\w-])", text, re.I)), None)
    if named is None and not _commands(text):
        return ""
    if not here:
        return "No robot acts on this board."
    name = (named or here[0]).name
    return f"No robot is mentioned, so none answers. Mention one, for example: @{name} {text.strip()[:60]}"


def _commands(text: str) -> bool:
    if not text or len(text) > COMMAND_CHARS or stop_intent(text):  # a bare stop counts in a running thread
        return False
    return parse(text, (), (), frozenset(Op)).intent is Intent.COMMAND
