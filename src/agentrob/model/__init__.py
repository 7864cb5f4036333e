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
from agentrob.model.plans import Direction, Op, Plan, Primitive
from agentrob.model.posts import Page, Post, StatusCard
from agentrob.model.results import ActionResult, Outcome, Report, StopResult
from agentrob.model.robots import EMERGENCY_STOP, Capabilities, Limits, Lock, Pose, Posture, RobotState
from agentrob.model.schedules import Schedule, ScheduledRun, ScheduleEnd

__all__ = [
    "EMERGENCY_STOP",
    "Account",
    "AccountKind",
    "ActionClass",
    "ActionResult",
    "Capabilities",
    "Command",
    "CommandState",
    "Decision",
    "Direction",
    "EndReason",
    "EventKind",
    "FencingToken",
    "FleetRobot",
    "Intent",
    "Language",
    "Limits",
    "Lock",
    "Mandate",
    "Op",
    "Outcome",
    "Page",
    "Plan",
    "Pose",
    "Post",
    "Posture",
    "Primitive",
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
    "Verdict",
    "fleet_robot",
]
