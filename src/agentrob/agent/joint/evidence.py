"""Read from the cards of other robots how far the parts of a post are, and decide about one's own part (pure).

A robot's card is a fact, never an order (law 1): it releases a wait that a person's post declared, or ends it. It
counts only from the robot's own account, for the same post and the same text.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from agentrob.language.joint.parts import Choice, JointCommand, JointPart
from agentrob.model import AccountKind, Command, CommandState, Post, StatusCard
from agentrob.model.lifecycle import is_final_word

#: No part waits longer than this after its post, whatever the others show.
MOST_WAIT_S = 3600.0
#: How long bids are collected, how long the robot whose turn it is may take to begin, and which battery counts as low.
BID_S, BEGIN_S, LOW_PERCENT = 2.0, 10.0, 15


@dataclass(frozen=True, slots=True)
class PartStatus:
    """How far a part is, as the forum shows it. `state` is empty while nothing is shown; `robot` does it, empty while
    none of several is chosen. `at` is when this was written, `until` until when the part itself still waits."""

    state: str = ""
    robot: str = ""
    at: datetime | None = None
    until: datetime | None = None

    @property
    def has_ended(self) -> bool:
        return is_final_word(self.state)


@dataclass(frozen=True, slots=True)
class Waiting:
    """The part waits for these parts, until then at the latest."""

    parts: tuple[int, ...]
    until: datetime


@dataclass(frozen=True, slots=True)
class Released:
    """All parts before it are done, the last one since `at`; None if the forum does not say when."""

    at: datetime | None


@dataclass(frozen=True, slots=True)
class Ended:
    """The part may not begin: the part `part` ended in `state`; empty if nothing was heard of it in time."""

    part: int
    state: str = ""


@dataclass(frozen=True, slots=True)
class Turn:
    """It is this robot's turn to take the part."""


@dataclass(frozen=True, slots=True)
class LeftTo:
    """Another robot took the part."""

    robot: str


@dataclass(frozen=True, slots=True)
class Bidding:
    """Nobody took the part yet; look again at `until`."""

    until: datetime


def part_posts(posts: Iterable[Post], command: Command) -> list[Post]:
    """The posts by which robots show parts of this command's post, in the order of the thread."""
    return [
        post
        for post in posts
        if post.card is not None
        and post.card.part
        and (post.card.post, post.card.content_hash) == (command.post_id, command.content_hash)
        and post.author.kind is AccountKind.ROBOT_AGENT
        and post.card.robot == post.author.name
        and not post.removed
    ]


def status_of(part: JointPart, posts: Sequence[Post]) -> PartStatus:
    """How far a part is. `posts` as `part_posts` returns them."""
    if part.choice is Choice.NAMED:
        return _status(part, part.robots[0], posts)
    if robot := taker_of(part, posts):
        return _status(part, robot, posts)
    each = [_status(part, robot, posts) for robot in part.robots]
    if did := next((status for status in each if status.state == CommandState.DONE), None):
        return did  # the post by which it took the part was removed
    if all(status.has_ended for status in each):
        return PartStatus(CommandState.CANCELLED, at=max((s.at for s in each if s.at), default=None))
    shown = next((status for status in each if status.state and not status.has_ended), PartStatus())
    return PartStatus(shown.state, until=shown.until)


def taker_of(part: JointPart, posts: Sequence[Post]) -> str:
    """The robot that took a part first, by the order of the thread; empty if none did."""
    takers = (p.author.name for p in posts if p.card and p.card.part == part.number and p.card.takes)
    return next((name for name in takers if name in part.robots), "")


def _status(part: JointPart, robot: str, posts: Sequence[Post]) -> PartStatus:
    own = [
        post
        for post in posts
        if post.card and post.author.name == robot and post.card.part == part.number and not post.card.takes
    ]
    if not own:
        return PartStatus(robot=robot)
    post = next((post for post in reversed(own) if post.card and post.card.is_final), own[-1])
    assert post.card is not None
    return PartStatus(post.card.state, robot, post.edited_at or post.created_at, _time(post.card.until))


def _time(text: str) -> datetime | None:
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return found if found.tzinfo is not None else None


def look_at(
    joint: JointCommand, number: int, statuses: Mapping[int, PartStatus], posted_at: datetime, now_at: datetime
) -> Waiting | Released | Ended:
    """Decide about the part `number` by how far the parts before it are.

    A part gives up at the time by which the one before it should have ended, counted from the post; while that one
    itself waits for something and says until when, counted from then.
    """
    pending: dict[int, datetime] = {}
    for before in joint.part(number).after:
        status = statuses[before]
        if status.has_ended and status.state != CommandState.DONE:
            return Ended(before, status.state)
        if not status.has_ended:
            pending[before] = until_of(joint, before, status, posted_at)
    if not pending:
        times = [at for before in joint.part(number).after if (at := statuses[before].at) is not None]
        return Released(max(times, default=None))
    late = next((before for before, until in pending.items() if now_at > until), None)
    if late is not None:
        return Ended(late, statuses[late].state)
    return Waiting(tuple(pending), max(pending.values()))


def until_of(joint: JointCommand, number: int, status: PartStatus, posted_at: datetime) -> datetime:
    """Until when a part should have ended; whatever it says of its own wait, at most `MOST_WAIT_S` after its post."""
    latest = posted_at + timedelta(seconds=MOST_WAIT_S)
    until = posted_at + timedelta(seconds=joint.seconds_until(number))
    if status.until is not None:
        until = max(until, min(status.until, latest) + timedelta(seconds=joint.part(number).seconds))
    return min(until, latest)


def look_at_bids(
    part: JointPart, own: StatusCard, posts: Sequence[Post], since: datetime, now_at: datetime, window_s: float = BID_S
) -> Turn | LeftTo | Bidding | Ended:
    """Whether it is the turn of a robot to take a part of which it is one candidate. It has bid by the card `own`, at
    `since`.

    The best bid's robot takes the part; if it has not begun to in time, the next one does, once. All may see different
    bids: the first post that takes the part decides, and nobody moves before it is written and read.
    """
    robot = own.robot
    if taker := taker_of(part, posts):
        return Turn() if taker == robot else LeftTo(taker)
    bids, ended = _bids(part, posts)
    bids[robot] = own
    window, begins = timedelta(seconds=window_s), timedelta(seconds=BEGIN_S)
    if not bids.keys() | ended >= set(part.robots) and now_at < since + window:
        return Bidding(since + window)
    place = _ranked(part, bids).index(robot)
    if place == 0:
        return Turn()
    from_at = since + window + begins * place
    if place == 1:
        return Turn() if now_at >= from_at else Bidding(from_at)
    return Ended(part.number) if now_at >= from_at + begins else Bidding(from_at + begins)


def _ranked(part: JointPart, bids: Mapping[str, StatusCard]) -> list[str]:
    """The robots by their bids, the best first: one whose battery is not low, the nearest where that is wanted and all
    know how far it is, the one with the fewest commands before it where a free one is wanted, the one done first."""
    near = measurable(part, bids.values())

    def key(name: str) -> tuple[bool, int, int, int, str]:
        card = bids[name]
        low = 0 < card.battery < LOW_PERCENT
        ahead = card.ahead if part.choice is Choice.FREE else 0
        return low, card.near_cm if near else 0, ahead, card.bid_s, name

    return sorted(bids, key=key)


def measurable(part: JointPart, bids: Iterable[StatusCard]) -> bool:
    """Whether these bids say which robot is nearer to what the post names: all of one room, in one frame."""
    measured = [(card.near_cm, card.room) for card in bids]
    return bool(part.near and measured) and all(cm for cm, _ in measured) and len({room for _, room in measured}) == 1


def _bids(part: JointPart, posts: Sequence[Post]) -> tuple[dict[str, StatusCard], set[str]]:
    """The newest bid of each candidate that has not ended, and those that have ended."""
    bids: dict[str, StatusCard] = {}
    ended = set[str]()
    for post in posts:
        card, name = post.card, post.author.name
        if card is None or card.part != part.number or card.takes or name not in part.robots:
            continue
        if card.is_final:
            ended.add(name)
            bids.pop(name, None)
        elif card.bid_s and name not in ended:
            bids[name] = card
    return bids, ended


def bids_of(part: JointPart, posts: Sequence[Post]) -> dict[str, StatusCard]:
    """The newest card with a bid of each candidate, as far as it is shown."""
    found: dict[str, StatusCard] = {}
    for post in posts:
        if post.card is not None and post.card.part == part.number and post.card.bid_s:
            found[post.author.name] = post.card
    return found
