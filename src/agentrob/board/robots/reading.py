"""Say in one line for each robot of a board how it would carry out a text that is being written."""

from __future__ import annotations

from dataclasses import dataclass, replace
from datetime import UTC, datetime

from agentrob.board.auth import rights
from agentrob.board.command_reading import READ_CHARS, DraftCommand, ReadableRobot, RobotReading
from agentrob.board.db.reader import not_found
from agentrob.board.robots import commands, reach
from agentrob.board.robots.view import RobotView, robots
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.language.complexity import parsing_us
from agentrob.language.visible_text import mentions, visible_text, without_mentions
from agentrob.model import Account, RobotRights
from agentrob.process.answering.server import TooSlow

NOBODY = "Nobody is addressed."


@dataclass(frozen=True, slots=True)
class Reading:
    """`line` is what a page shows; empty if there is nothing to say. `robots` are those that the text addresses."""

    line: str = ""
    robots: tuple[RobotReading, ...] = ()


async def read(services: Services, by: Account, text: str, board_id: str = "", topic_id: str = "") -> Reading:
    """Read a text for the robots of the topic or board, else for all. 404 if the forum reads no commands, 413, 429."""
    if services.reading is None:
        raise not_found("reader", "commands", "this forum does not read commands while they are written")
    reader = services.store.reader
    if topic_id:
        board_id = reader.topic(topic_id).board_id
    elif board_id:
        reader.board(board_id)  # 404
    if not without_mentions(text[:READ_CHARS]).strip():
        return Reading()
    found = robots(services)
    here = [robot for robot in found if robot.live and robot.can and _acts(services, robot, board_id)]
    draft = DraftCommand(text, by, tuple(_readable(services, robot, board_id, topic_id) for robot in here))
    try:
        read = await services.reading.read(draft)
    except TooSlow:
        return Reading()
    if read.robots:
        alone = len(read.robots) == 1
        return Reading("\n".join(r.line if alone else f"@{r.robot}: {r.line}" for r in read.robots), read.robots)
    board_id = board_id or board_for(services, read.mentioned)
    return Reading(reach.hint(services, board_id, text) or ("" if read.mentioned else _nobody(services, board_id)))


def board_for(services: Services, names: tuple[str, ...]) -> str:
    """The board for a command to these names: the first one that the viewer sees on which the first robot among them
    acts, else any robot; else the first board. Empty if the viewer sees none."""
    seen = [board.id for board in services.store.reader.boards()]
    found = robots(services)
    called = [robot for name in names for robot in found if robot.name == name]
    acting = (board for robot in (*called, *found) for board in robot.boards if board in seen)
    return next(acting, seen[0] if seen else "")


def board_of(services: Services, text: str) -> str:
    """The board for a command, by the names in it. 422 if the viewer sees no board."""
    short = parsing_us(text, reach.READ_US) <= reach.READ_US
    board_id = board_for(services, tuple(mentions(visible_text(text))) if short else ())
    if not board_id:
        raise BoardError(422, "no_board", "there is no board for a command yet", "ask an admin to make one")
    return board_id


def _acts(services: Services, robot: RobotView, board_id: str) -> bool:
    seen = {board.id for board in services.store.reader.boards()}
    return board_id in robot.boards if board_id else any(board in seen for board in robot.boards)


def _readable(services: Services, robot: RobotView, board_id: str, topic_id: str) -> ReadableRobot:
    assert robot.can is not None
    reader = services.store.reader
    board = reader.board(board_id or next(b for b in robot.boards if b in reader.board_names()))
    kept, now = rights.settings_of(reader, robot.name), datetime.now(UTC)
    closed = kept.closed_until(now)
    allowed = RobotRights(
        owner=kept.owner,
        command=dict(kept.command),
        approve=kept.approve,
        release=kept.release,
        board=str(board.command_role),
        approval=tuple(dict.fromkeys((*map(str, kept.approval), *robot.approval))),
        approve_own=kept.approve_own,
        closed_s=(closed - now).total_seconds() if closed else None,
    )
    account = reader.account(robot.name)
    plans = commands.done_plans(reader, topic_id, account) if topic_id and account else ()
    known = [plan for plan in plans if all(step.op in robot.can.ops for step in plan.steps)]
    history = tuple(replace(plan, steps=tuple(map(robot.can.bound, plan.steps))) for plan in known)
    consents = robot.consents
    if consents is None:
        consents = frozenset(operation.needed_consent for operation in robot.can.operations)
    return ReadableRobot(robot.name, robot.can, allowed, history, robot.sees, consents, robot.scene)


def _nobody(services: Services, board_id: str) -> str:
    acting = reach.acting_on(board_id, services)
    if not acting:
        return "No robot acts on this board."
    return f"{NOBODY} Begin with the name of a robot: @{acting[0].name}"
