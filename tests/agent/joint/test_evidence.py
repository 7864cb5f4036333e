"""Decisions by the cards of other robots (pure)."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from agentrob.agent.joint import evidence
from agentrob.agent.joint.evidence import Bidding, Ended, LeftTo, PartStatus, Released, Turn, Waiting
from agentrob.language.joint.parts import JointCommand
from agentrob.language.joint.reading import joint_command
from agentrob.model import Account, AccountKind, Post, StatusCard

AT = datetime(2030, 1, 1, tzinfo=UTC)


def joint(text: str) -> JointCommand:
    found = joint_command(text)
    assert isinstance(found, JointCommand)
    return found


def post(robot: str, state: str, number: int = 1, **more: Any) -> Post:
    card = StatusCard(robot, state, part=number, post="1", content_hash="h", **more)
    account = Account(robot, robot, AccountKind.ROBOT_AGENT)
    return Post(f"{robot}{number}{state}", "1", "robots", account, "", AT, card=card)


CHAIN = joint("@rex wave, then @bot wave, then @cat wave")
ONE = joint("@rex @bot @cat one of you wave").parts[0]


def after(seconds: float) -> datetime:
    return AT + timedelta(seconds=seconds)


def test_a_part_is_released_by_done_alone() -> None:
    for state in ("failed", "refused", "asks_back", "stopped", "interrupted", "cancelled", "expired", "answered"):
        found = evidence.look_at(CHAIN, 2, {1: PartStatus(state, "rex", AT)}, AT, AT)
        assert found == Ended(1, state)
    assert evidence.look_at(CHAIN, 2, {1: PartStatus("done", "rex", after(3))}, AT, AT) == Released(after(3))
    for state in ("", "seen", "queued", "waiting", "running"):
        assert isinstance(evidence.look_at(CHAIN, 2, {1: PartStatus(state, "rex", AT)}, AT, AT), Waiting)


def test_a_wait_ends_in_silence_at_the_time_that_the_part_before_it_has() -> None:
    limit_s = CHAIN.seconds_until(1)
    assert evidence.look_at(CHAIN, 2, {1: PartStatus()}, AT, after(limit_s)) == Waiting((1,), after(limit_s))
    assert evidence.look_at(CHAIN, 2, {1: PartStatus()}, AT, after(limit_s + 1)) == Ended(1)
    assert evidence.look_at(CHAIN, 2, {1: PartStatus("running")}, AT, after(limit_s + 1)) == Ended(1, "running")


def test_a_part_that_itself_waits_for_an_approval_is_waited_for_longer() -> None:
    status = PartStatus("waiting", "rex", AT, until=after(600))
    found = evidence.look_at(CHAIN, 2, {1: status}, AT, after(500))
    assert found == Waiting((1,), after(600 + CHAIN.part(1).seconds))
    long = PartStatus("waiting", "rex", AT, until=after(1e6))
    assert evidence.look_at(CHAIN, 2, {1: long}, AT, AT) == Waiting((1,), after(evidence.MOST_WAIT_S))


def test_a_card_that_waits_for_ever_is_waited_for_an_hour() -> None:
    last = datetime.max.replace(tzinfo=UTC)  # beyond it there is no time to add to
    found = evidence.look_at(CHAIN, 2, {1: PartStatus("waiting", "rex", AT, until=last)}, AT, AT)
    assert found == Waiting((1,), after(evidence.MOST_WAIT_S))


def test_the_last_of_several_ends_counts_and_an_end_stays() -> None:
    posts = [post("rex", "done"), post("rex", "running")]  # a late event of before
    assert evidence.status_of(CHAIN.part(1), posts).state == "done"


def test_the_first_in_the_thread_takes_a_part() -> None:
    posts = [post("bot", "answered", takes=1), post("rex", "answered", takes=1)]
    assert evidence.taker_of(ONE, posts) == "bot"
    assert evidence.taker_of(ONE, [post("imp", "answered", takes=1), *posts]) == "bot"
    own = StatusCard("rex", "queued", bid_s=1)
    assert evidence.look_at_bids(ONE, own, posts, AT, AT) == LeftTo("bot")
    assert evidence.look_at_bids(ONE, StatusCard("bot", "queued", bid_s=1), posts, AT, AT) == Turn()


def test_the_best_bid_begins_then_the_next_one_once() -> None:
    bids = [post("rex", "queued", bid_s=9, battery=80), post("bot", "queued", bid_s=5, battery=80)]
    bids += [post("cat", "queued", bid_s=1, battery=5)]  # its battery is low
    cards = {p.author.name: p.card for p in bids}

    def look(robot: str, seconds: float) -> object:
        card = cards[robot]
        assert card is not None
        return evidence.look_at_bids(ONE, card, bids, AT, after(seconds))

    begins_s = evidence.BID_S + evidence.BEGIN_S
    assert look("bot", 0) == Turn()  # all have bid
    assert look("rex", 0) == Bidding(after(begins_s))
    assert look("rex", begins_s) == Turn()
    assert look("cat", begins_s + evidence.BEGIN_S) == Bidding(after(begins_s + 2 * evidence.BEGIN_S))
    assert look("cat", begins_s + 2 * evidence.BEGIN_S) == Ended(1)


NEAR = joint("@rex @bot @cat whoever is nearer to the door, wave").parts[0]


def ranked(**bids: dict[str, Any]) -> str:
    """The robot whose turn it is, once all have bid."""
    posts = [post(robot, "queued", **{"bid_s": 5, "battery": 80, **bid}) for robot, bid in bids.items()]
    cards = [p.card for p in posts if p.card]
    return next(c.robot for c in cards if evidence.look_at_bids(NEAR, c, posts, AT, AT) == Turn())


def test_the_nearest_does_it_where_all_know_how_far_it_is() -> None:
    lab = {"room": "lab"}
    assert (
        ranked(rex={"near_cm": 300, **lab}, bot={"near_cm": 100, "bid_s": 9, **lab}, cat={"near_cm": 200, **lab})
        == "bot"
    )
    assert (
        ranked(rex={"near_cm": 300, **lab}, bot={"near_cm": 100, "battery": 5, **lab}, cat={"near_cm": 200, **lab})
        == "cat"
    )


def test_whoever_is_done_first_does_it_where_one_does_not_know_how_far_it_is_or_is_in_another_room() -> None:
    lab = {"room": "lab"}
    far = {"rex": {"near_cm": 300, "bid_s": 1, **lab}, "bot": {"near_cm": 100, **lab}}
    assert ranked(**far, cat={}) == "rex"
    assert ranked(**far, cat={"near_cm": 10, "room": "hall"}) == "rex"


def test_a_battery_that_is_not_known_is_not_low() -> None:
    assert ranked(rex={"bid_s": 1, "battery": 0}, bot={}, cat={}) == "rex"


def test_a_part_is_done_although_the_post_by_which_a_robot_took_it_was_removed() -> None:
    posts = [post("rex", "cancelled", left_to="bot"), post("bot", "done"), post("cat", "refused")]
    assert evidence.status_of(ONE, posts).state == "done"
    assert evidence.status_of(ONE, posts).robot == "bot"


def test_bids_are_waited_for_and_who_has_ended_is_not() -> None:
    own = StatusCard("rex", "queued", bid_s=9)
    assert evidence.look_at_bids(ONE, own, [], AT, after(1)) == Bidding(after(evidence.BID_S))
    assert evidence.look_at_bids(ONE, own, [], AT, after(evidence.BID_S)) == Turn()
    ended = [post("bot", "refused", bid_s=1), post("cat", "failed")]
    assert evidence.look_at_bids(ONE, own, ended, AT, AT) == Turn()


@pytest.mark.parametrize("until", ["", "yesterday", "2030-01-01T00:00:00"])
def test_an_end_of_a_wait_that_is_not_readable_counts_for_nothing(until: str) -> None:
    assert evidence.status_of(CHAIN.part(1), [post("rex", "queued", until=until)]).until is None


def test_a_part_of_several_has_ended_when_it_was_done_or_nobody_does_it() -> None:
    assert not evidence.status_of(ONE, [post("rex", "refused"), post("bot", "queued")]).has_ended
    each = [post(robot, "refused") for robot in ("rex", "bot", "cat")]
    assert evidence.status_of(ONE, each).state == "cancelled"
    taken = [post("bot", "answered", takes=1), post("rex", "cancelled", left_to="bot"), post("bot", "done")]
    assert evidence.status_of(ONE, taken).state == "done"
    assert evidence.status_of(ONE, taken).robot == "bot"
