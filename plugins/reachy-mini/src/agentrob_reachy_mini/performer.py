"""Runs the frames of a motion as moves of the daemon, one after the other, and stops them."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

from agentrob.robots.protocol import Watch
from agentrob_reachy_mini.daemon import Daemon, DaemonLost, DaemonRefused
from agentrob_reachy_mini.motions import Frame
from agentrob_reachy_mini.pose import OutOfReach
from agentrob_reachy_mini.watcher import POLL_S, Seen, Watcher

log = logging.getLogger(__name__)

#: A move may end so much later than it should.
LATE_S = 1.0
#: How often the daemon is asked whether a move that should have ended has ended.
ENDING_S = 0.01
#: After the last frame it comes to rest within this time.
SETTLE_S = 1.0


class Run(NamedTuple):
    """The result of a run. `reason`: why it was ended, as a stable word, with a sentence; both empty where all was
    done. `seen`: the poses, in order."""

    reason: str
    message: str
    seen: list[Seen]


class Performer:
    """One motion at a time. `stop_all` may be called from another thread at any time."""

    def __init__(self, daemon: Daemon, watcher: Watcher) -> None:
        self._daemon, self._watcher = daemon, watcher
        self._stops = 0
        self._current = ""  # the id of our running move
        self._changing = threading.Lock()

    def attentive(self, watch: Watch) -> Watch:
        """The watch, which also ends what was begun before a stop."""
        stops = self._stops
        return lambda state: "stop" if self._stops != stops else watch(state)

    def perform(self, frames: Sequence[Frame], watch: Watch) -> Run:
        """Go through the frames until they are done or the watch gives a reason."""
        return self._run([_going(self._daemon, frame) for frame in frames], watch)

    def play(self, dataset: str, move: str, seconds: float, watch: Watch) -> Run:
        """Play a recorded move; it is ended after so many seconds."""
        return self._run([_Start(lambda: self._daemon.play(dataset, move), 0.0, seconds)], watch)

    def stop_all(self) -> bool:
        """End our running move first, then all others; return whether the daemon has none left."""
        self._stops += 1
        current = self._take()
        try:
            if current:
                self._daemon.stop(current)
            for move in self._daemon.running():
                self._daemon.stop(move)
            return not self._daemon.running()
        except (DaemonLost, DaemonRefused):  # the robot's state says why
            return False

    # ------------------------------------------------------------ one motion
    def _run(self, starts: Sequence[_Start], watch: Watch) -> Run:
        seen = list[Seen]()
        try:
            for start in starts:
                if reason := self._look(seen, watch) or self._follow(start, seen, watch):
                    return Run(reason, "", seen)
            return Run(self._settle(seen, watch), "", seen)
        except OutOfReach as e:
            return Run("invalid", str(e), seen)
        except DaemonRefused as e:
            return Run("rejected", str(e), seen)
        except DaemonLost as e:
            return Run("no_answer", str(e), seen)
        finally:
            self._end_current()

    def _follow(self, start: _Start, seen: list[Seen], watch: Watch) -> str:
        """Start a move and wait for its end; returns why it was ended before."""
        move = start.begin()
        self._watcher.own(move)
        with self._changing:
            self._current = move
        begun_s = time.monotonic()
        while True:
            if reason := self._look(seen, watch):
                return reason
            now_s = time.monotonic()
            if now_s >= begun_s + start.least_s:
                if move not in self._daemon.running():
                    self._forget(move)
                    return ""
                if now_s > begun_s + start.most_s:
                    return "timeout"
                time.sleep(ENDING_S)
            else:
                self._watcher.wait_newer(self._watcher.newest, min(POLL_S, begun_s + start.least_s - now_s))

    def _settle(self, seen: list[Seen], watch: Watch) -> str:
        end_s = time.monotonic() + SETTLE_S
        while time.monotonic() < end_s:
            self._watcher.wait_newer(self._watcher.newest, POLL_S)
            if reason := self._look(seen, watch):
                return reason
            if self._watcher.at_rest():
                break
        return ""

    def _look(self, seen: list[Seen], watch: Watch) -> str:
        """Take the newest pose in and ask the watch."""
        newest = self._watcher.newest
        if newest is not None and (not seen or newest is not seen[-1]):
            seen.append(newest)
        return watch(self._watcher.state()) or ""

    def _forget(self, move: str) -> None:
        """Record that a move has ended."""
        with self._changing:
            if self._current == move:
                self._current = ""

    def _take(self) -> str:
        """Return our running move to the one thread that ends it; empty if there is none, or another one ends it."""
        with self._changing:
            current, self._current = self._current, ""
        return current

    def _end_current(self) -> None:
        if current := self._take():
            try:
                self._daemon.stop(current)
            except (DaemonLost, DaemonRefused) as e:
                log.warning("the move %s could not be stopped: %s", current, e)


class _Start(NamedTuple):
    """How a move begins, and when it ends: not before `least_s`, and it is ended after `most_s`."""

    begin: Callable[[], str]
    least_s: float
    most_s: float


def _going(daemon: Daemon, frame: Frame) -> _Start:
    return _Start(lambda: daemon.goto(frame.pose, frame.seconds), frame.seconds, frame.seconds + LATE_S)
