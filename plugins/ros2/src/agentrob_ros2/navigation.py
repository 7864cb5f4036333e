"""Nav2's action `NavigateToPose` over DDS: send a goal to a named place, follow it, cancel it.

A ROS 2 action is three services and two topics. Over Fast DDS a request is a plain message, and its answer is matched
by a header that Cyclone DDS for Python does not show; so a goal is followed by the action's status topic, which names
each goal: one that does not appear there was not accepted. rmw_cyclonedds puts that header into the message instead, so
a Nav2 that runs on it understands no request, and no goal is accepted.
"""

from __future__ import annotations

import math
import uuid
from typing import Any

from agentrob.model import ActionClass, Pose
from agentrob.model.operations.declaration import Choice, Operation, Option, Quantity, Unit
from agentrob_ros2 import messages
from agentrob_ros2.network import Node, Subscription, qos_of
from agentrob_ros2.options import CommandOptions, NavigationOptions, PlaceOptions, Ros2Options, TopicOptions

#: The operation, and its argument.
GO, PLACE = "go_to_place", "place"
#: Of action_msgs/msg/GoalStatus.
ACCEPTED, EXECUTING, CANCELING, SUCCEEDED, CANCELED, ABORTED = range(1, 7)
OPEN = (ACCEPTED, EXECUTING, CANCELING)
_REQUESTS = CommandOptions(reliability="reliable")
_STATUS = TopicOptions(reliability="reliable", durability="transient_local")
_WORDS = {
    "en": "go to the {place}|go to {place}|drive to the {place}|drive to {place}|navigate to the {place}",
    "zh": "去{place}|到{place}去|开到{place}|前往{place}",
}


def operation_of(options: Ros2Options) -> Operation:
    """The declaration of "go to PLACE"."""
    places = tuple(Option(name, _words(name, place)) for name, place in options.places.items())
    navigation = options.navigation
    return Operation(
        GO,
        ActionClass.MOVE,
        words=_WORDS,
        arguments=(Choice(PLACE, places),),
        done={"en": "went to the {place}", "zh": "到了{place}"},
        travel_m=navigation.travel_m,
        takes_s=min(30.0, navigation.seconds),
        time_limit_s=navigation.seconds,
        measured=(Quantity("missed_m", Unit.METRES), Quantity("driven_m", Unit.METRES)),
    )


def _words(name: str, place: PlaceOptions) -> dict[str, str]:
    return {"en": name.replace("_", " "), **place.words}


class Navigation:
    """The client of the action. `kind` is the type of the request that sends a goal."""

    kind: Any = messages.NavigateToPoseRequest

    def __init__(self, node: Node, options: Ros2Options) -> None:
        self.action = options.absolute(options.navigation.action)
        self._options: NavigationOptions = options.navigation
        requests = qos_of(_REQUESTS, depth=10)
        self._goals = node.writer(f"{self.action}/_action/send_goalRequest", self.kind, requests, prefix="rq")
        self._cancels = node.writer(
            f"{self.action}/_action/cancel_goalRequest", messages.CancelGoalRequest, requests, prefix="rq"
        )
        status = f"{self.action}/_action/status"
        self._status: Subscription[Any] = Subscription(node, status, messages.GoalStatusArray, _STATUS)

    def absence(self) -> str:
        """Why no goal can be sent; empty if one can."""
        if self._goals.get_matched_subscriptions() and self._cancels.get_matched_subscriptions():
            return ""
        return f"No action server {self.action} (nav2_msgs/action/NavigateToPose) is there: is Nav2 running?"

    def send(self, place: PlaceOptions, here: Pose, now_s: float) -> bytes:
        """Send a goal; returns its id. Where the place has no direction, the base faces away from where it is now."""
        goal = uuid.uuid4().bytes
        away = math.degrees(math.atan2(place.y_m - here.y_m, place.x_m - here.x_m))
        facing_deg = away if place.facing_deg is None else place.facing_deg
        self._goals.write(self.request(messages.Uuid(list(goal)), place, facing_deg, now_s))
        return goal

    def request(self, goal: messages.Uuid, place: PlaceOptions, facing_deg: float, now_s: float) -> Any:
        half = math.radians(facing_deg) / 2
        turned = messages.Quaternion(0.0, 0.0, math.sin(half), math.cos(half))
        pose = messages.PoseMessage(messages.Point(place.x_m, place.y_m, 0.0), turned)
        header = messages.Header(messages.Time.of(now_s), self._options.frame)
        return self.kind(goal, messages.NavigateToPoseGoal(messages.PoseStamped(header, pose)))

    def cancel_all(self) -> None:
        """Ask for the end of every goal, whoever sent it: a request without id and time means all."""
        self._cancels.write(messages.CancelGoalRequest())

    def status(self, goal: bytes) -> int | None:
        """The status of a goal; None if it does not appear."""
        return next((int(one.status) for one in self._list() if bytes(one.goal_info.goal_id.uuid) == goal), None)

    @property
    def busy(self) -> bool:
        """Whether any goal is under way."""
        return any(int(one.status) in OPEN for one in self._list())

    def _list(self) -> list[messages.GoalStatus]:
        newest = self._status.newest
        return list(newest[1].status_list) if newest is not None else []
