"""A gesture of several calls: what happens to the remaining calls when a reason to stop occurs."""

from __future__ import annotations

import threading

import pytest

from agentrob.robots.control.gesture import Gesture


def test_its_calls_follow_each_other() -> None:
    called = list[str]()

    def call(name: str) -> int:
        called.append(name)
        return 0

    gesture = Gesture((lambda: call("rise"), lambda: call("balance")), lambda: None)
    gesture.follow()
    assert (called, gesture.code, gesture.reason) == (["rise", "balance"], 0, "")
    assert not gesture.running


def test_after_a_call_that_failed_no_other_follows() -> None:
    called = list[bool]()
    gesture = Gesture((lambda: 4205, lambda: called.append(True) or 0), lambda: None)
    gesture.follow()
    assert (called, gesture.code) == ([], 4205)


@pytest.mark.parametrize("reason", ["stop", "lease_lapsed", "halted"])
@pytest.mark.parametrize("passes", [True, False])
def test_law_14_after_a_reason_to_stop_no_call_follows_also_when_it_has_passed(reason: str, passes: bool) -> None:
    rising, risen, called = threading.Event(), threading.Event(), list[bool]()
    asked = list[str]()

    def rise() -> int:
        rising.set()
        assert risen.wait(60)
        return 0

    def objection() -> str | None:
        if not rising.is_set() or (passes and asked):
            return None
        asked.append(reason)
        return reason

    gesture = Gesture((rise, lambda: called.append(True) or 0), objection)
    gesture.follow()  # ends during the first call
    assert (gesture.running, gesture.reason) == (True, reason)
    risen.set()
    gesture._thread.join(60)
    assert not gesture.running
    assert called == []


def test_law_14_a_stop_just_before_the_next_call_prevents_it() -> None:
    stopped, called = threading.Event(), list[bool]()

    def rise() -> int:
        stopped.set()  # and is noticed only when the call has returned
        return 0

    gesture = Gesture((rise, lambda: called.append(True) or 0), lambda: "stop" if stopped.is_set() else None)
    gesture.follow()
    gesture._thread.join(60)
    assert (called, gesture.reason) == ([], "stop")


@pytest.mark.parametrize("reason", ["stop", "lease_lapsed", "halted"])
def test_law_18_a_gesture_that_a_stop_broke_off_at_once_is_reported_as_stopped_and_not_as_failed(reason: str) -> None:
    """The robot's error may come before the next check whether to continue."""
    stopped = threading.Event()

    def broken_off() -> int:
        stopped.set()
        return 4201

    gesture = Gesture((broken_off,), lambda: reason if stopped.is_set() else None)
    gesture.follow()
    assert (gesture.running, gesture.reason) == (False, reason)


def test_a_gesture_that_was_done_when_the_stop_came_was_done() -> None:
    stopped = threading.Event()

    def done() -> int:
        stopped.set()
        return 0

    gesture = Gesture((done,), lambda: "stop" if stopped.is_set() else None)
    gesture.follow()
    assert (gesture.code, gesture.reason) == (0, "")


def test_a_call_is_late_by_the_robots_clock_and_not_by_the_hosts() -> None:
    """On a busy machine a simulated robot needs 30 s for a gesture of 8 s, which must not count as no answer."""
    robot_s, answered, called = [0.0], threading.Event(), list[bool]()

    def rise() -> int:
        assert answered.wait(60)
        return 0

    def objection() -> None:
        robot_s[0] += 1.0
        if robot_s[0] == 9.0:
            answered.set()

    gesture = Gesture((rise, lambda: called.append(True) or 0), objection, limit_s=15.0, now_s=lambda: robot_s[0])
    gesture.follow()
    assert (gesture.unanswered, gesture.code, called) == (False, 0, [True])


def test_after_a_call_that_is_late_no_other_follows() -> None:
    robot_s, answered, called = [0.0], threading.Event(), list[bool]()

    def rise() -> int:
        robot_s[0] = 15.1
        assert answered.wait(60)
        return 0

    gesture = Gesture((rise, lambda: called.append(True) or 0), lambda: None, limit_s=15.0, now_s=lambda: robot_s[0])
    gesture.follow()
    assert (gesture.unanswered, gesture.running) == (True, False)
    answered.set()
    gesture._thread.join(60)
    assert called == []
