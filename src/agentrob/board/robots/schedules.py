"""Schedules of robots as their agents publish them, and the button that cancels one.

The agents keep the schedules; the board shows those whose posts the viewer may read. The button posts the same reply
that a person would write.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any
from urllib.parse import urlsplit

from agentrob.board.auth import rights
from agentrob.board.db.records import StoredPost, Written, from_text
from agentrob.board.robots.actions import known_robot, owner_of
from agentrob.board.robots.view import robot
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.language.messages.durations import duration
from agentrob.language.messages.moments import local
from agentrob.language.registry import language_of
from agentrob.language.visible_text import visible_text
from agentrob.model import Account
from agentrob.model.schedules import zone_of

#: How many of the next runs are shown, and the most schedules and runs that are read from a card.
SHOWN, MOST, MOST_RUNS = 3, 60, 60
#: Runs further ahead are ignored: a schedule ends after two months.
FARTHEST = timedelta(days=400)
#: How long an event of the calendar lasts, since no command takes longer, and how often a program reads it again.
LASTS, REFRESH = timedelta(minutes=1), timedelta(hours=1)
_WORDS = {"en": "cancel the schedule", "zh": "取消日程"}


@dataclass(frozen=True, slots=True)
class ScheduleView:
    """A schedule of a robot. `text` is the command in the robot's words, `runs` are its further runs, `until` is when
    it ends at the latest. `renewable`: its author may renew it then. `may_cancel`: the viewer has the button. `live`:
    the robot's agent is here now."""

    robot: str
    live: bool
    post: StoredPost
    text: str
    zone: str
    runs: tuple[datetime, ...]
    until: datetime | None
    renewable: bool
    may_cancel: bool

    @property
    def next_runs(self) -> tuple[tuple[str, str], ...]:
        """The next runs: how long until then, and as local time of the schedule's zone."""
        return tuple((self._wait(at), local(at, self.zone)) for at in self.runs[:SHOWN])

    @property
    def last(self) -> str:
        """The day of its last run, in its zone."""
        return local(self.runs[-1], self.zone).rpartition(" ")[0] if self.runs else ""

    def _wait(self, at: datetime) -> str:
        left_s = (at - datetime.now(UTC)).total_seconds()
        if left_s > 60:
            left_s = 60 * round(left_s / 60)
        return f"in {duration(left_s)}" if left_s > 0 else "now"


def of_robot(services: Services, name: str, viewer: Account | None) -> tuple[ScheduleView, ...]:
    """The schedules of a robot whose posts the viewer may read, the next one first. 404 for an unknown robot."""
    account, view = robot(services, name)
    owner = owner_of(services, account.name)
    data = services.presence.robot(account.name).card.get("schedules")
    entries = [e for e in data[:MOST] if isinstance(e, Mapping)] if isinstance(data, (list, tuple)) else []
    ids = [int(e["post"]) for e in entries if _is_id(e.get("post"))]
    posts = {post.id: post for post in services.store.reader.posts_by_id(ids) if not post.removed}
    found = [
        schedule_view(entry, post, account.name, view.live, _may_cancel(viewer, post, owner))
        for entry in entries
        if (post := posts.get(str(entry.get("post")))) is not None
    ]
    return tuple(sorted((one for one in found if one.runs), key=lambda one: (one.runs[0], one.post.id)))


def of_all(services: Services, viewer: Account | None) -> tuple[ScheduleView, ...]:
    """The schedules of all robots whose posts the viewer may read, the next one first."""
    robots = [account for account in services.store.reader.robots() if not account.suspended]
    found = [one for account in robots for one in of_robot(services, account.name, viewer)]
    return tuple(sorted(found, key=lambda one: (one.runs[0], one.robot)))


async def cancel(services: Services, by: Account, post_id: str, name: str, key: str | None) -> Written:
    """Cancel a schedule by a reply of the account. 403 if it may not, 404 for an unknown post or robot, 409 for a post
    without a schedule of this robot."""
    post, account = services.store.reader.post(post_id), known_robot(services, name)
    if not _may_cancel(by, post, owner_of(services, account.name)):
        hint = "everybody may stop the robot, which ends its schedules"
        raise BoardError(
            403, "not_your_schedule", "only its author, the robot's owner and moderators may cancel it", hint
        )
    if all(one.post.id != post.id for one in of_robot(services, account.name, by)):
        raise BoardError(409, "no_schedule", f"{account.name} has no schedule of this post", "see its schedules")
    words = _WORDS.get(language_of(visible_text(post.raw)), _WORDS["en"])
    return await services.store.reply(by, post.topic_id, f"@{account.name} {words}", key=key, reply_to=post.id)


def schedule_calendar(schedules: Sequence[ScheduleView], name: str, base_url: str) -> bytes:
    """The further runs of schedules as an iCalendar file.

    Each run is an event of its own, in UTC: a recurrence rule would move runs where clocks change, which a robot's
    schedule treats in its own way.
    """
    from icalendar import Calendar, Event

    made = Calendar()
    made.add("prodid", "-//AgentRob//schedules//EN")
    made.add("version", "2.0")
    made.add("name", f"Schedules of @{name}")
    made.add("x-wr-calname", f"Schedules of @{name}")
    made.add("refresh-interval", REFRESH, parameters={"value": "DURATION"})
    host = urlsplit(base_url).hostname or "localhost"
    for one in schedules:
        for at in one.runs:
            event = Event()
            event.add("uid", f"{one.post.id}-{int(at.timestamp())}-{name}@{host}")
            event.add("dtstamp", one.post.edited_at or one.post.created_at)
            event.add("dtstart", at)
            event.add("duration", LASTS)
            event.add("summary", f"@{name}: {one.text}")
            event.add("description", f"{local(at, one.zone)} ({one.zone}). Asked by {one.post.author.name}.")
            event.add("url", f"{base_url}/p/{one.post.id}")
            event.add("transp", "TRANSPARENT")
            made.add_component(event)
    return bytes(made.to_ical())


def _may_cancel(viewer: Account | None, post: StoredPost, owner: str) -> bool:
    """Whether the viewer wrote the post, owns the robot, or moderates. All of them may stop the robot, too."""
    if viewer is None or viewer.suspended:
        return False
    return viewer.id == post.author.id or viewer.name == owner or rights.reaches(viewer, "moderator", owner)


def schedule_view(entry: Mapping[str, Any], post: StoredPost, name: str, live: bool, may_cancel: bool) -> ScheduleView:
    """The view of one entry of a card; fields of the wrong type are left out."""
    text, data = entry.get("text"), entry.get("runs")
    runs = [_moment(value) for value in data[:MOST_RUNS]] if isinstance(data, (list, tuple)) else []
    return ScheduleView(
        robot=name,
        live=live,
        post=post,
        text=text[:200] if isinstance(text, str) else "",
        zone=_zone(entry.get("zone")),
        runs=tuple(sorted(at for at in runs if at is not None)),
        until=from_text(entry.get("until")),
        renewable=entry.get("renewable") is True,
        may_cancel=may_cancel,
    )


def _moment(value: object) -> datetime | None:
    """A moment from Unix seconds, if a schedule can have it."""
    if isinstance(value, bool) or not isinstance(value, int):
        return None
    near = abs(value - time.time()) < FARTHEST.total_seconds()
    return datetime.fromtimestamp(value, UTC) if near else None


def _zone(name: object) -> str:
    """The name of a time zone, UTC if this machine does not know it."""
    try:
        zone_of(name if isinstance(name, str) else "UTC")
    except ValueError:
        return "UTC"
    return name if isinstance(name, str) else "UTC"


def _is_id(value: object) -> bool:
    return isinstance(value, str) and value.isascii() and value.isdigit() and len(value) < 19
