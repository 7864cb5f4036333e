"""Build the view of a robot's page from the card that its agent sent, tolerating malformed cards."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime, timedelta
from typing import Any

from agentrob.board.auth import rights, visibility
from agentrob.board.db.records import StoredPost, from_text
from agentrob.board.events.presence import LIVE_FOR
from agentrob.board.robots import live
from agentrob.board.robots.abilities import capabilities_of, op_in_words
from agentrob.board.robots.actions import known_robot
from agentrob.board.robots.live import MapView
from agentrob.board.services import Services
from agentrob.model import BUILT_IN, Account, AccountKind, ActionClass, BaseMotion, Capabilities

_KNOWN = {
    "model",
    "ops",
    "operations",
    "limits",
    "directions",
    "state",
    "battery_percent",
    "board",
    "boards",
    "simulated",
    "can_reset",
    "camera",
    "sees",
    "queue",
    "line",
    "schedules",
    "schedules_more",
    "owner",
    "consents",
    "approval",
    "homed",
    "lock",
    "last_action",
    "map",
    "worker",
    "version",
    "since",
    "failures",
    "lag_ms",
    "stop_ms",
    "stop_at",
}
#: The modes of a robot in which its body moves.
_MOVING = frozenset({"walking", "gesture"})
#: How long the result of an owner's button is shown.
SHOWN_FOR = timedelta(minutes=5)
#: The maximum length of a scene.
SCENE_CHARS = 2000
_LIMITS = {
    "speed_mps": ("Speed", "m/s"),
    "turn_dps": ("Turning", "°/s"),
    "step_m": ("One move", "m"),
    "step_deg": ("One turn", "°"),
    "command_m": ("One command", "m"),
    "command_s": ("One command", "s"),
    "command_steps": ("One command", "steps"),
}
#: The limits that only concern one way of moving.
_LIMITED = {
    "speed_mps": BaseMotion.TRANSLATION,
    "step_m": BaseMotion.TRANSLATION,
    "command_m": BaseMotion.TRANSLATION,
    "turn_dps": BaseMotion.ROTATION,
    "step_deg": BaseMotion.ROTATION,
}


@dataclass(frozen=True, slots=True)
class LockView:
    """Who locked the robot, why and when; unknown fields are empty."""

    by: str = ""
    why: str = ""
    at: datetime | None = None


@dataclass(frozen=True, slots=True)
class OwnerActionView:
    """The result of the last release or home: who asked, whether it was done, and the agent's message."""

    action: str
    by: str
    at: datetime
    done: bool
    message: str

    @property
    def recent(self) -> bool:
        return datetime.now(UTC) - self.at < SHOWN_FOR


@dataclass(frozen=True, slots=True)
class RobotView:
    """`state` is a word such as idle; `battery` whole percent, None when unknown. `live`: its agent is here now.
    `camera`: there may be live pictures, unless its card says that there are none.

    `consents` are the risky operations that its owner consents to, None while that is not known; `approval` are the
    classes of action that need an approval by its owner's configuration; `scene` describes its surroundings, where its
    owner shows them.

    `line` are the posts of commands that are not done, the next one first. `limits` and `facts` are (name, value) in
    words for people; `facts` are what else the card says. `lock` is None while it is not locked, `homed` while that is
    not known; `last_action` is the result of the last release or home. `can` is what it can do, None while that is not
    known; `sees`: it finds things in its camera's pictures.
    """

    name: str
    live: bool = False
    seen_at: datetime | None = None
    state: str = ""
    model: str = ""
    simulated: bool = False
    battery: int | None = None
    board: str = ""
    boards: tuple[str, ...] = ()
    can_reset: bool = False
    camera: bool = True
    line: tuple[str, ...] = ()
    ops: tuple[str, ...] = ()
    limits: tuple[tuple[str, str], ...] = ()
    facts: tuple[tuple[str, str], ...] = ()
    lock: LockView | None = None
    homed: bool | None = None
    last_action: OwnerActionView | None = None
    can: Capabilities | None = None
    sees: tuple[str, ...] = ()
    map: MapView | None = None
    consents: frozenset[str] | None = None
    approval: tuple[str, ...] = ()
    scene: str = ""

    @property
    def moves(self) -> bool:
        """Whether its body moves now, as far as its agent says."""
        return self.live and self.state in _MOVING


def robot_view(name: str, card: Mapping[str, Any], seen_at: datetime | None) -> RobotView:
    """The view of one robot; fields of the wrong type are left out."""
    limits = card.get("limits")
    ops = card.get("ops")
    can = capabilities_of(card)
    facts = [("Model", _words(card.get("model"))), ("Simulated", "yes" if card.get("simulated") is True else "")]
    facts += [(str(k)[:40].replace("_", " ").capitalize(), _words(v)) for k, v in card.items() if k not in _KNOWN]
    return RobotView(
        name=name,
        live=seen_at is not None and datetime.now(UTC) - seen_at < LIVE_FOR,
        seen_at=seen_at,
        state="locked" if _lock(card.get("lock")) else _words(card.get("state")),
        model=_words(card.get("model")),
        simulated=card.get("simulated") is True,
        battery=_percent(card.get("battery_percent")),
        board=_words(card.get("board")),
        boards=_boards(card),
        can_reset=card.get("can_reset") is True,
        camera=card.get("camera") is not False,
        line=tuple(p for p in line[:20] if _is_id(p)) if isinstance(line := card.get("line"), (list, tuple)) else (),
        ops=tuple(op_in_words(op, can) for op in _strings(ops)[:40]),
        limits=_limits(_applying(limits, card.get("ops"))) if isinstance(limits, Mapping) else (),
        facts=tuple((name, value) for name, value in facts[:20] if value),
        lock=_lock(card.get("lock")),
        homed=homed if isinstance(homed := card.get("homed"), bool) else None,
        last_action=_owner_action(card.get("last_action")),
        can=can,
        sees=_sees(card.get("sees")),
        map=live.map_view(card.get("map")),
        consents=_consents(card.get("consents")),
        approval=_classes(card.get("approval")),
        scene=_scene(card.get("map")),
    )


def _consents(data: object) -> frozenset[str] | None:
    """The consents in a list of a card."""
    return frozenset(_strings(data)[:20]) if isinstance(data, (list, tuple)) else None


def _strings(data: object) -> list[str]:
    return [one for one in data if isinstance(one, str)] if isinstance(data, (list, tuple)) else []


def _classes(classes: object) -> tuple[str, ...]:
    """The classes of action in a list of a card."""
    data = classes[:20] if isinstance(classes, (list, tuple)) else ()
    return tuple(kind for kind in ActionClass if kind in data)


def _scene(room: object) -> str:
    scene = room.get("scene") if isinstance(room, Mapping) else ""
    return scene[:SCENE_CHARS] if isinstance(scene, str) else ""


def _lock(lock: object) -> LockView | None:
    """The lock in a card; cards of older agents have only the state."""
    if not isinstance(lock, Mapping):
        return None
    return LockView(_words(lock.get("by")), _words(lock.get("why")).rstrip("."), from_text(lock.get("at")))


def _owner_action(entry: object) -> OwnerActionView | None:
    if not isinstance(entry, Mapping) or (at := from_text(entry.get("at"))) is None:
        return None
    texts = {key: _words(entry.get(key)) for key in ("action", "by", "message")}
    return OwnerActionView(at=at, done=entry.get("done") is True, **texts)


def robots(services: Services) -> tuple[RobotView, ...]:
    """All robots that have an account, connected ones first."""
    found = [_look(services, account) for account in services.store.reader.robots() if not account.suspended]
    return tuple(sorted(found, key=lambda robot: (not robot.live, robot.name)))


def robot(services: Services, name: str) -> tuple[Account, RobotView]:
    """One robot. Raises `BoardError` 404."""
    account = known_robot(services, name)
    return account, _look(services, account)


def hidden_cameras(services: Services, viewer: Account | None, posts: Iterable[StoredPost]) -> frozenset[str]:
    """Robots with pictures in these posts that the viewer may not see."""
    reader = services.store.reader
    shown = {p.author.name for p in posts if p.images and p.author.kind is AccountKind.ROBOT_AGENT}
    return frozenset(n for n in shown if not rights.sees_camera(rights.settings_of(reader, n), viewer, n))


def owners(services: Services, posts: Iterable[StoredPost]) -> dict[str, str]:
    """The owners of the robots that wrote these posts, by robot; without robots that have none."""
    reader = services.store.reader
    robots = {p.author.name for p in posts if p.author.kind is AccountKind.ROBOT_AGENT}
    return {name: owner for name in robots if (owner := rights.settings_of(reader, name).owner)}


def _look(services: Services, account: Account) -> RobotView:
    now = services.presence.robot(account.name)
    view = robot_view(account.name, now.card, now.seen_at)
    return view if live.shows(now.card, visibility.readable_boards()) else replace(view, map=None, scene="")


def _boards(card: Mapping[str, Any]) -> tuple[str, ...]:
    """The boards on which the robot acts; agents before 0.2 publish only the first one."""
    data = card.get("boards")
    boards = data if isinstance(data, (list, tuple)) else (card.get("board"),)
    return tuple(board for board in boards[:20] if isinstance(board, str) and board)


def _sees(data: object) -> tuple[str, ...]:
    things = data[:40] if isinstance(data, (list, tuple)) else ()
    return tuple(thing[:40] for thing in things if isinstance(thing, str) and thing)


def _is_id(value: object) -> bool:
    return isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 19


def _applying(limits: Mapping[str, object], ops: object) -> Mapping[str, object]:
    """The limits without those of walks and turns that the robot cannot do."""
    if not isinstance(ops, (list, tuple)):
        return limits
    motions = {BUILT_IN[op].base_motion for op in ops if isinstance(op, str) and op in BUILT_IN}
    return {name: value for name, value in limits.items() if name not in _LIMITED or _LIMITED[name] in motions}


def _limits(limits: Mapping[str, object]) -> tuple[tuple[str, str], ...]:
    """The limits in words; those with the same label are joined."""
    lines: dict[str, list[str]] = {}
    for name, value in list(limits.items())[:20]:
        label, shown = _limit(name, value)
        lines.setdefault(label, []).append(shown)
    return tuple((label, ", ".join(shown)) for label, shown in lines.items())


def _limit(name: str, value: object) -> tuple[str, str]:
    label, unit = _LIMITS.get(name, (str(name)[:40].replace("_", " ").capitalize(), ""))
    try:
        shown = f"{value:g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else _words(value)
    except OverflowError:
        shown = "?"
    return label, f"{shown}{'' if unit in ('°', '°/s', '') else ' '}{unit}"


def _percent(value: object) -> int | None:
    try:
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            return None
    except OverflowError:
        return None
    return round(min(max(value, 0), 100))


def _words(value: object) -> str:
    """A value of a card as a short line; empty for None."""
    if value is None or value == "":
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, (list, tuple)):
        return ", ".join(filter(None, map(_words, value[:20])))[:200] or "empty"
    if isinstance(value, Mapping):
        return ", ".join(f"{k}: {_words(v)}" for k, v in list(value.items())[:20])[:200]
    return f"{value:g}" if isinstance(value, float) else str(value)[:200]
