"""The kinds of events that forums report."""

from __future__ import annotations

from enum import StrEnum


class EventKind(StrEnum):
    """The kind of change that an event reports. `heartbeat` is never stored: it only proves that the event stream is
    alive."""

    POST_CREATED = "post.created"
    POST_EDITED = "post.edited"
    POST_REMOVED = "post.removed"
    ROBOT_STOP = "robot.stop"
    ROBOT_ESTOP = "robot.estop"
    ROBOT_RELEASE = "robot.release"
    ROBOT_HOME = "robot.home"
    ROBOT_RESET = "robot.reset"
    ROBOT_WATCH = "robot.watch"
    ROBOT_POSES = "robot.poses"
    HEARTBEAT = "heartbeat"
