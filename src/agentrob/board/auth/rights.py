"""The rights of a robot that the forum stores: owner, command rights, camera, maintenance hours.

These settings can only narrow what the laws allow. Agents enforce them (`agentrob.screening.rights`); the forum
itself checks them only for its own buttons and pictures.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime, time, timedelta
from typing import Any
from zoneinfo import ZoneInfo

from sqlalchemy import bindparam, select

from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

#: Who a right can be given to, widest first.
WHO = ("operator", "moderator", "admin", "owner", "nobody")
DAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
#: A robot that is closed for longer should have `nobody` as its rights.
LOOK_AHEAD = timedelta(days=400)
_CLOCK = re.compile(r"([01]\d|2[0-3]):[0-5]\d")
_OWNER = db.accounts.alias("owner")
_ROBOT = (
    select(db.robots, _OWNER.c.name.label("owner"))
    .join(db.accounts, db.accounts.c.id == db.robots.c.account_id)
    .outerjoin(_OWNER, _OWNER.c.id == db.robots.c.owner_id)
    .where(db.accounts.c.name == bindparam("name"))
)


@dataclass(frozen=True, slots=True)
class MaintenanceWindow:
    """When a robot is in maintenance: on `days` (every day if empty) from `start` to `end` in `zone`, which is on the
    next day if it is earlier; or, with `until`, from now to then. `note` is shown."""

    days: tuple[str, ...] = ()
    start: str = "00:00"
    end: str = "00:00"
    zone: str = "UTC"
    until: datetime | None = None
    note: str = ""

    def end_at(self, now: datetime) -> datetime | None:
        """When it ends, if it is on now."""
        if self.until is not None:
            return self.until if now < self.until else None
        zone = ZoneInfo(self.zone)
        today = now.astimezone(zone).date()
        start, end = time.fromisoformat(self.start), time.fromisoformat(self.end)
        for day in (today, today - timedelta(days=1)):
            if self.days and DAYS[day.weekday()] not in self.days:
                continue
            first = datetime.combine(day, start, zone)
            last = datetime.combine(day if end > start else day + timedelta(days=1), end, zone)
            if first <= now < last:
                return last.astimezone(UTC)
        return None


@dataclass(frozen=True, slots=True)
class RobotSettings:
    """The settings of one robot. `camera_days` 0 keeps pictures forever."""

    owner: str = ""
    command: Mapping[str, str] = field(default_factory=lambda: dict.fromkeys(map(str, ActionClass), "operator"))
    approve: str = "moderator"
    release: str = "owner"
    approval: tuple[str, ...] = ()
    approve_own: bool = False
    camera_role: Role = Role.GUEST
    camera_days: int = 0
    closed: tuple[MaintenanceWindow, ...] = ()

    def closed_until(self, now: datetime) -> datetime | None:
        """The end of its maintenance if it is closed now, across consecutive windows."""
        until = None
        while (ends := [e for c in self.closed if (e := c.end_at(until or now)) is not None]) and (
            until is None or max(ends) > until
        ):
            until = max(ends)
            if until - now > LOOK_AHEAD:
                break
        return until

    def stored(self) -> dict[str, Any]:
        """The columns of its row, except the accounts."""
        rights = {"command": dict(self.command), "approve": self.approve, "release": self.release}
        return {
            "rights": rights | {"approval": list(self.approval), "approve_own": self.approve_own},
            "camera_role": str(self.camera_role),
            "camera_days": self.camera_days,
            "closed": [closed_out(c) for c in self.closed],
        }


def settings_of(reader: Reader, robot: str) -> RobotSettings:
    """The settings of a robot; safe defaults if none are stored."""
    return reader.kept(("robot", robot), lambda: _read(reader, robot), access=True)


def _read(reader: Reader, robot: str) -> RobotSettings:
    row = reader.first(_ROBOT, name=robot)
    if row is None:
        return RobotSettings()
    rights = row.rights
    # A missing class, for example a new one, is allowed to nobody.
    return RobotSettings(
        owner=row.owner or "",
        command={str(c): str(rights["command"].get(c, "nobody")) for c in ActionClass},
        approve=rights["approve"],
        release=rights["release"],
        approval=tuple(rights["approval"]),
        approve_own=rights.get("approve_own") is True,
        camera_role=Role(row.camera_role),
        camera_days=row.camera_days,
        closed=tuple(map(closed_in, row.closed)),
    )


def reaches(account: Account, who: str, owner: str) -> bool:
    """Whether an account has what `who` names: a role or a higher one, or is the owner or an admin."""
    if who == "owner":
        return (bool(owner) and account.name == owner) or account.role is Role.ADMIN
    return who in frozenset(Role) and account.role.rank >= Role(who).rank


def approves(settings: RobotSettings, account: Account, author: Account) -> bool:
    """Whether an account may approve or deny a command by `author`. The robot's agent checks the same."""
    if account.kind is not AccountKind.HUMAN or account.suspended or account.role.rank < Role.OPERATOR.rank:
        return False
    return reaches(account, settings.approve, settings.owner) and (settings.approve_own or account.id != author.id)


def releases(settings: RobotSettings, account: Account | None, configured_owner: str = "") -> bool:
    """Whether an account may press Release and Set home. The robot's agent checks the same, and decides.

    `configured_owner` is the owner that the agent's own configuration names, from the robot's card.
    """
    if account is None or account.kind is not AccountKind.HUMAN or account.suspended or settings.release == "nobody":
        return False
    if account.role is Role.ADMIN:
        return True
    return settings.release == "owner" and account.name in {settings.owner, configured_owner} - {""}


def sees_camera(settings: RobotSettings, account: Account | None, robot: str) -> bool:
    """Whether an account that may read here may see pictures of this robot's camera. Its own agent always may."""
    if account is not None and account.name in (robot, settings.owner):
        return True
    return (account.role if account else Role.GUEST).rank >= settings.camera_role.rank


# -------------------------------------------------------------------- checking what was sent
def checked(settings: RobotSettings) -> RobotSettings:
    """422 for unknown words in rights, and for maintenance hours that are not valid."""
    wrong = {w for w in (*settings.command.values(), settings.approve) if w not in WHO}
    if settings.release not in ("owner", "admin", "nobody"):
        wrong.add(settings.release)
    if wrong or set(settings.command) != set(ActionClass) or not set(settings.approval) <= set(ActionClass):
        hint = f"for each of {', '.join(ActionClass)}: one of {', '.join(WHO)}; release: owner, admin, nobody"
        raise BoardError(422, "bad_rights", f"{', '.join(sorted(wrong))[:80] or 'that'} is not a right", hint)
    for closed in settings.closed:
        _check_closed(closed)
    return settings


def _check_closed(closed: MaintenanceWindow) -> None:
    try:
        ZoneInfo(closed.zone)
    except (ValueError, OSError, KeyError):
        raise BoardError(
            404, "no_such_zone", f"there is no time zone {closed.zone[:40]!r}", "a name such as Europe/Berlin"
        ) from None
    if not set(closed.days) <= set(DAYS) or not _CLOCK.fullmatch(closed.start) or not _CLOCK.fullmatch(closed.end):
        hint = f"days of {', '.join(DAYS)}, from and to as 09:00; or until, a time"
        raise BoardError(422, "bad_hours", "invalid maintenance hours", hint)


def closed_in(data: Mapping[str, Any]) -> MaintenanceWindow:
    """From JSON, of the database or the API."""
    until = data.get("until")
    return MaintenanceWindow(
        days=tuple(data.get("days") or ()),
        start=data.get("from") or "00:00",
        end=data.get("to") or "00:00",
        zone=data.get("zone") or "UTC",
        until=datetime.fromisoformat(until).astimezone(UTC) if until else None,
        note=data.get("note") or "",
    )


def closed_out(closed: MaintenanceWindow) -> dict[str, Any]:
    if closed.until is not None:
        return {"until": closed.until.astimezone(UTC).isoformat(), "note": closed.note}
    hours = {"days": list(closed.days), "from": closed.start, "to": closed.end}
    return hours | {"zone": closed.zone, "note": closed.note}


def hours_from_words(text: str) -> tuple[MaintenanceWindow, ...]:
    """Maintenance hours as people write them, one a line or separated by `;`: `mon,fri 09:00-12:00 Europe/Berlin`, or
    `until 2026-12-24T08:00Z`. 422 says what would be valid."""
    return tuple(_hours(line) for line in re.split(r"[;\n]", text) if line.strip())


def _hours(line: str) -> MaintenanceWindow:
    words = line.split()
    try:
        if words[0] == "until":
            return MaintenanceWindow(
                until=datetime.fromisoformat(words[1]).astimezone(UTC), note=" ".join(words[2:])[:200]
            )
        start, end = words[1].split("-")
        made = MaintenanceWindow(tuple(_days(words[0])), start, end, words[2] if len(words) > 2 else "UTC")
        _check_closed(made)
        return made
    except (IndexError, ValueError):
        hint = "mon,fri 09:00-12:00 Europe/Berlin, or mon-sun 22:00-06:00, or until 2026-12-24T08:00Z"
        raise BoardError(422, "bad_hours", f"{line.strip()[:80]!r} is not a valid maintenance window", hint) from None


def _days(text: str) -> Sequence[str]:
    if "-" in text:
        first, last = (DAYS.index(day) for day in text.split("-"))
        return [DAYS[(first + n) % 7] for n in range((last - first) % 7 + 1)]
    return [DAYS[DAYS.index(day)] for day in text.split(",")]


def hours_in_words(closed: Sequence[MaintenanceWindow]) -> str:
    """As `hours_from_words` reads them."""
    return "\n".join(
        f"until {c.until:%Y-%m-%dT%H:%MZ} {c.note}".strip()
        if c.until is not None
        else f"{','.join(c.days) or 'mon-sun'} {c.start}-{c.end} {c.zone}"
        for c in closed
    )
