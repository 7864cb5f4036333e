"""One robot of a fleet, read from the card that its agent published.

Cards are untrusted, and agents of other versions leave out fields: a field that is missing or malformed is unknown.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from agentrob.model.robots import Pose

#: An agent publishes its card at least every 5 s; after this long nobody serves the robot.
SERVED_S = 15.0
_LONGEST, _LARGEST, _KINDS = 64, 1_000_000_000.0, 10
_FARTHEST_M = 10_000.0


@dataclass(frozen=True, slots=True)
class FleetRobot:
    """`age_s` is the age of the card, None if there was none. Unknown texts are empty, unknown numbers None.

    `pose` is where it last stood in its `room`."""

    name: str
    age_s: float | None
    worker: str = ""
    version: str = ""
    state: str = ""
    lag_ms: float | None = None
    queue: int | None = None
    battery_percent: float | None = None
    stop_ms: float | None = None
    stop_at: datetime | None = None
    failures: tuple[tuple[str, int], ...] = ()
    model: str = ""
    room: str = ""
    pose: Pose | None = None

    @property
    def served(self) -> bool:
        """Whether an agent serves the robot now."""
        return self.age_s is not None and self.age_s < SERVED_S

    @property
    def state_label(self) -> str:
        """The robot's state for people."""
        return (self.state or "unknown") if self.served else "not served"

    def as_data(self) -> dict[str, Any]:
        """The robot as JSON."""
        return {
            "name": self.name, "served": self.served, "age_s": self.age_s, "worker": self.worker,
            "version": self.version, "state": self.state, "lag_ms": self.lag_ms, "queue": self.queue,
            "battery_percent": self.battery_percent, "stop_ms": self.stop_ms,
            "stop_at": self.stop_at.isoformat() if self.stop_at else None, "failures": dict(self.failures),
        }  # fmt: skip


def fleet_robot(name: str, card: Mapping[str, Any], seen_at: datetime | None, now: datetime) -> FleetRobot:
    """Read a card that was published at `seen_at`."""
    age_s = None if seen_at is None else max(0.0, (now - seen_at).total_seconds())
    queue = _number(card.get("queue"))
    return FleetRobot(
        name,
        age_s,
        worker=_text(card.get("worker")),
        version=_text(card.get("version")),
        state=_text(card.get("state")),
        lag_ms=_number(card.get("lag_ms")),
        queue=None if queue is None else int(queue),
        battery_percent=_number(card.get("battery_percent")),
        stop_ms=_number(card.get("stop_ms")),
        stop_at=_time(card.get("stop_at")),
        failures=_failures(card.get("failures")),
        model=_text(card.get("model")),
        **_place(card.get("map")),
    )


def _place(place: object) -> dict[str, Any]:
    """The room of a robot and where it stands there, from the map of its card."""
    if not isinstance(place, Mapping) or not (room := _text(place.get("room"))):
        return {}
    pose = place.get("pose")
    numbers = pose if isinstance(pose, list | tuple) and len(pose) == 3 else ()
    known = [v for v in numbers if isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= _FARTHEST_M]
    return {"room": room, "pose": Pose(*map(float, known)) if len(known) == 3 else None}


def _text(value: object) -> str:
    return value[:_LONGEST] if isinstance(value, str) and value.isprintable() else ""


def _number(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value <= _LARGEST:
        return None  # also NaN
    return value


def _time(value: object) -> datetime | None:
    try:
        at = datetime.fromisoformat(value) if isinstance(value, str) else None
    except ValueError:
        return None
    return at.astimezone(UTC) if at is not None and at.tzinfo is not None else None


def _failures(value: object) -> tuple[tuple[str, int], ...]:
    if not isinstance(value, Mapping):
        return ()
    counted = [(_text(kind), _number(count)) for kind, count in list(value.items())[:_KINDS]]
    return tuple((kind, int(count)) for kind, count in counted if kind and count)
