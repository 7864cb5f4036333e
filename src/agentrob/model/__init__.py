"""The frozen facts that travel between rooms: who wrote what, what is wanted, what is allowed, what was measured.

Frames follow REP-103: x forward, y left, yaw counter-clockwise. Units stand in the names. Times called `*_at` are
aware UTC datetimes by the forum's clock; times called `*_s` are seconds of the machine's monotonic clock.
"""

from agentrob.model.accounts import Account, AccountKind, ActionClass, RobotRights, Role
from agentrob.model.commands import Command, Intent, Language, Understanding
from agentrob.model.decisions import Decision, Mandate, Verdict
from agentrob.model.events import EventKind
from agentrob.model.fencing import FencingToken
from agentrob.model.fleet import FleetRobot, fleet_robot
from agentrob.model.lifecycle import CommandState, EndReason
from agentrob.model.operations.built_in import BUILT_IN, PHOTO, Direction, Op
from agentrob.model.operations.declaration import BaseMotion, Choice, Number, Operation, Option, Quantity, Unit
from agentrob.model.plans import Plan, Primitive, turn, walk
from agentrob.model.posts import Page, Post, StatusCard
from agentrob.model.results import ActionResult, Outcome, Report, StopResult
from agentrob.model.robots import (
    EMERGENCY_STOP,
    Capabilities,
    Hindrance,
    Limits,
    Lock,
    Pose,
    Posture,
    RobotState,
)
from agentrob.model.schedules import Schedule, ScheduledRun, ScheduleEnd

__all__ = [
    "BUILT_IN",
    "EMERGENCY_STOP",
    "PHOTO",
    "Account",
    "AccountKind",
    "ActionClass",
    "ActionResult",
    "BaseMotion",
    "Capabilities",
    "Choice",
    "Command",
    "CommandState",
    "Decision",
    "Direction",
    "EndReason",
    "EventKind",
    "FencingToken",
    "FleetRobot",
    "Hindrance",
    "Intent",
    "Language",
    "Limits",
    "Lock",
    "Mandate",
    "Number",
    "Op",
    "Operation",
    "Option",
    "Outcome",
    "Page",
    "Plan",
    "Pose",
    "Post",
    "Posture",
    "Primitive",
    "Quantity",
    "Report",
    "RobotRights",
    "RobotState",
    "Role",
    "Schedule",
    "ScheduleEnd",
    "ScheduledRun",
    "StatusCard",
    "StopResult",
    "Understanding",
    "Unit",
    "Verdict",
    "fleet_robot",
    "turn",
    "walk",
]
