"""Receive the events of a forum once for all agents of a worker, instead of once for each.

The accounts of the agents differ, so each stream is shared only by accounts that may read the same: on the board, those
of the same role. On a forum with other permissions each agent has a stream of its own.

An agent that takes over a robot gets the events that it missed from the stream, too, if the stream still has them all;
otherwise it reads them with its own account.

Most posts of a fleet are reports of its robots, which no agent obeys (law 1). Agents are not woken for each of them,
but handle those of up to `LAZY_S` together; that a robot was stopped, which stops the other parts of a joint command,
is handled at once.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
import traceback
from collections import deque
from collections.abc import AsyncIterator
from datetime import datetime

import structlog

from agentrob.agent.intake.triage import NOT_OBEYED
from agentrob.errors import ForumDenied, ForumError, ForumNotFound, ForumUnreachable
from agentrob.forums.protocol import Event, Forum, ReadableByRole
from agentrob.model import CommandState, EventKind, Role

#: For how long, and how many, events are kept for agents that take over a robot.
KEPT_S, MOST_KEPT = 60.0, 2_000
#: Events of this long are given again to a listener that read what it missed with its own account: that reading may be
#: older.
OVERLAP_S = 5.0
#: A stream that delivered nothing for this long, no heartbeat either, may lack the newest events.
ALIVE_S = 1.0
#: For how long an account's role is taken to be the same, and how often the roles of all that listen are checked.
ROLE_S, CHECK_ROLES_S = 10.0, 60.0
#: An agent that does not handle this many events is cut off from the stream and reads them from the forum later.
MOST_WAITING = 10_000
#: How long a post of a robot may wait until it is handled: less than between two heartbeats, which it may replace.
LAZY_S = 0.4
#: The first and the longest wait before a stream that was cut is opened again.
BACKOFF_S = 0.2, 5.0
_log = structlog.get_logger()
_EventKey = tuple[str, EventKind, datetime]


class SharedEvents:
    """The event streams of one forum, one for each role of the accounts that listen."""

    def __init__(self) -> None:
        self._streams: dict[Role, _Stream] = {}

    def of(self, forum: Forum) -> AccountEvents | Forum:
        """The events of a forum as one account reads them."""
        shared = isinstance(forum, ReadableByRole) and forum.readable_by_role
        return AccountEvents(forum, self._streams) if shared else forum


class AccountEvents:
    """Fulfils `forums.protocol.Events` for one account. `stream` and, where possible, `changes` are shared."""

    def __init__(self, forum: Forum, streams: dict[Role, _Stream]) -> None:
        self._forum = forum
        self._streams = streams
        self._role, self._role_s = Role.GUEST, -math.inf
        #: The newest event when `now` was asked, which the stream must have reached; empty once it has.
        self._newest: str | None = None

    @property
    def live(self) -> bool:
        return self._forum.live

    @property
    def fastest_poll_s(self) -> float:
        return self._forum.fastest_poll_s

    async def now(self) -> tuple[str, datetime]:
        self._newest, at = await self._forum.now()
        return self._newest, at

    async def changes(self, after: str, limit: int = 100) -> tuple[Event, ...]:
        stream = self._streams.get(await self._current_role()) if self._streams else None
        if stream is not None and (events := self._missed(stream, after)) is not None:
            return tuple(events[:limit])
        return await self._forum.changes(after, limit)

    async def stream(self, after: str, heartbeat_s: float = 0.5) -> AsyncIterator[Event]:
        role = await self._current_role()
        stream = self._streams.setdefault(role, _Stream(role))
        missed = stream.events_after(after)
        listener = stream.join(self._forum, heartbeat_s, missed)
        try:
            await listener.opened()
            read: set[_EventKey] = set()
            if missed is None:
                while events := await self._forum.changes(after):
                    for event in events:
                        read.add(_key(event))
                        after = event.id
                        yield event
            caught_up_s = time.monotonic()
            async for event in listener.events():
                if event.kind is EventKind.HEARTBEAT:
                    if time.monotonic() - caught_up_s > OVERLAP_S:
                        read.clear()
                elif _key(event) in read:
                    continue
                yield event
        finally:
            self._role_s = -math.inf
            stream.leave(listener)

    def _missed(self, stream: _Stream, after: str) -> list[Event] | None:
        """The events that the stream has after one; None if it may lack one that `now` had reported, such as a stop."""
        events = stream.events_after(after) if stream.alive else None
        if events is None or self._newest is None:
            return None
        if self._newest and self._newest not in (after, *(event.id for event in events)):
            return None
        self._newest = ""
        return events

    async def _current_role(self) -> Role:
        if time.monotonic() - self._role_s > ROLE_S:
            self._role, self._role_s = (await self._forum.me()).role, time.monotonic()
        return self._role


class _Listener:
    """The events that one agent has yet to handle."""

    def __init__(self, forum: Forum, heartbeat_s: float, events: list[Event]) -> None:
        self.forum = forum
        self.heartbeat_s = heartbeat_s
        self._queue: deque[Event] = deque(events)
        self._error: ForumError | None = None
        self._open = False
        self._changed = asyncio.Event()

    def open(self) -> None:
        self._open = True
        self._changed.set()

    def put(self, event: Event, *, wake: bool) -> None:
        """Queue an event. It is handled at once if it is to `wake` the agent, else with the next one that does."""
        if len(self._queue) >= MOST_WAITING:
            return self.cut(ForumUnreachable(f"more than {MOST_WAITING} events wait to be handled"))
        self._queue.append(event)
        if wake:
            self._changed.set()

    def cut(self, error: ForumError) -> None:
        """End the listener's stream after the events that it has."""
        self._error = self._error or error
        self._changed.set()

    async def opened(self) -> None:
        """Wait until the stream is open. Raises the `ForumError` that prevents it."""
        while not self._open and self._error is None:
            self._changed.clear()
            await self._changed.wait()
        if not self._open and self._error is not None:
            raise self._error

    async def events(self) -> AsyncIterator[Event]:
        while True:
            while self._queue:
                yield self._queue.popleft()
            if self._error is not None:
                raise self._error
            self._changed.clear()
            await self._changed.wait()


class _Stream:
    """One open stream while anybody listens, read with the account of one of the listeners, which have this role."""

    def __init__(self, role: Role) -> None:
        self._role = role
        self._listeners: dict[_Listener, None] = {}  # in the order in which they joined
        #: The newest events and when each was delivered: all that came after the event `_kept_after`.
        self._recent: deque[tuple[float, Event]] = deque()
        self._kept_after = ""
        self._delivered_s = -math.inf
        self._open = False
        self._reading: asyncio.Task[None] | None = None
        self._checking: asyncio.Task[None] | None = None
        self._reader: _Listener | None = None  # the listener with whose account it is read
        self._after = ""
        self._woken_s = -math.inf

    @property
    def alive(self) -> bool:
        """Whether something was delivered just now."""
        return self._open and time.monotonic() - self._delivered_s <= ALIVE_S

    def events_after(self, after: str) -> list[Event] | None:
        """The events that were delivered after one; None if the stream does not have all of them."""
        recent = [event for _, event in self._recent]
        if after == self._kept_after:
            return recent
        # After the first of this id: an event that the forum could not write has the id of the one before.
        return next((recent[number + 1 :] for number, event in enumerate(recent) if event.id == after), None)

    def join(self, forum: Forum, heartbeat_s: float, missed: list[Event] | None) -> _Listener:
        """Listen from now on, to what was `missed` first; if that is not known, to the events of `OVERLAP_S`."""
        if missed is None:
            since_s = time.monotonic() - OVERLAP_S
            missed = [event for delivered_s, event in self._recent if delivered_s >= since_s]
        listener = _Listener(forum, heartbeat_s, missed)
        self._listeners[listener] = None
        if self._open:
            listener.open()
        if self._reading is None:
            self._reading = asyncio.create_task(self._read())
            self._checking = asyncio.create_task(self._check_roles())
        return listener

    def leave(self, listener: _Listener) -> None:
        self._listeners.pop(listener, None)
        if not self._listeners and self._reading is not None:
            self._reading.cancel()
            self._close()
        elif listener is self._reader and self._reading is not None:  # its agent closes its forum: another one reads on
            self._reading.cancel()
            self._reading = asyncio.create_task(self._read())

    async def _read(self) -> None:
        """Read as long as anybody listens. When the stream is cut, read on after the last event: for the listeners it
        is a silence, and the forum does not receive the requests of all of them at once."""
        wait_s, longest_s = BACKOFF_S
        while self._listeners:
            reader = self._reader = next(iter(self._listeners))
            begun_s = time.monotonic()
            try:
                if not await self._has_role(reader):
                    continue
                if not self._after:
                    self._after = self._kept_after = (await reader.forum.now())[0]
                async for event in reader.forum.stream(self._after, reader.heartbeat_s):
                    self._after = event.id or self._after
                    self._deliver(event)
                error = "it ended"
            except ForumDenied as e:  # for this account alone
                self._listeners.pop(reader, None)
                reader.cut(e)
                continue
            except ForumNotFound as e:  # the forum was replaced, or its events are gone: each listener finds out
                for listener in self._listeners:
                    listener.cut(ForumUnreachable(f"the shared event stream was cut: {e}"))
                self._listeners.clear()
                break
            except ForumError as e:
                error = str(e)
            except Exception:  # a fault of the adapter: without events no stop would be received
                error = traceback.format_exc()
            if reader in self._listeners:  # the next attempt is another account's
                self._listeners[reader] = self._listeners.pop(reader)
            wait_s = BACKOFF_S[0] if time.monotonic() - begun_s > longest_s else wait_s
            _log.warning("shared event stream cut, trying again", after_s=round(wait_s, 1), error=error)
            await asyncio.sleep(wait_s)
            wait_s = min(longest_s, 2 * wait_s)
        self._close()

    async def _check_roles(self) -> None:
        while True:
            await asyncio.sleep(CHECK_ROLES_S)
            for listener in tuple(self._listeners):
                with contextlib.suppress(Exception):  # the forum did not answer: again in a minute
                    await self._has_role(listener)

    async def _has_role(self, listener: _Listener) -> bool:
        """Whether an account still has the role of this stream. Otherwise it is cut off, and joins another stream."""
        if (await listener.forum.me()).role is self._role:
            return True
        self._listeners.pop(listener, None)
        listener.cut(ForumUnreachable("the role of this account has changed"))
        return False

    def _deliver(self, event: Event) -> None:
        now_s = self._delivered_s = time.monotonic()
        while self._recent and (self._recent[0][0] < now_s - KEPT_S or len(self._recent) >= MOST_KEPT):
            self._kept_after = self._recent.popleft()[1].id
        if event.kind is not EventKind.HEARTBEAT:
            self._recent.append((now_s, event))
        if not self._open:
            self._open = True
            for listener in self._listeners:
                listener.open()
        wake = not _can_wait(event) or now_s - self._woken_s >= LAZY_S
        self._woken_s = now_s if wake else self._woken_s
        for listener in tuple(self._listeners):
            listener.put(event, wake=wake)

    def _close(self) -> None:
        self._listeners.clear()
        self._recent.clear()
        self._open = False
        if self._checking is not None:
            self._checking.cancel()
        self._reading = self._checking = self._reader = None
        self._after = self._kept_after = ""


def _can_wait(event: Event) -> bool:
    """Whether an event is a robot's post, but not one that says that it was stopped: that stops others, too."""
    post = event.post
    if post is None or post.author.kind not in NOT_OBEYED:
        return False
    return post.card is None or post.card.state != CommandState.STOPPED


def _key(event: Event) -> _EventKey:
    return event.id, event.kind, event.at
