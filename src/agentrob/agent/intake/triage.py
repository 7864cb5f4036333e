"""Decide what a post is for one robot: a stop, an approval, a text to read, too old, or nothing (laws 1, 3, 5, 13)."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from agentrob.language import registry
from agentrob.language.approval import ApprovalIntent, approval_in
from agentrob.language.parser.grammar import asks_for_picture_at_rest
from agentrob.language.rendered_text import text_in
from agentrob.language.schedule.reading import cancels_named_schedule, cancels_schedule, renews_schedule
from agentrob.language.stop.at_rest import stop_intent
from agentrob.language.stop.while_moving import stop_while_moving
from agentrob.language.visible_text import mentions, without_mentions
from agentrob.model import Account, AccountKind, Intent, Language, Post

#: Never obeyed, whatever they write.
NOT_OBEYED = frozenset({AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT})


class Route(StrEnum):
    """How one robot handles a post."""

    NOTHING = "nothing"
    STOP = "stop"
    HALT = "halt"
    STALE = "stale"
    READ = "read"
    APPROVE = "approve"
    DENY = "deny"
    CANCEL = "cancel"  # the schedules of its thread
    RENEW = "renew"  # the schedules of its thread that had their last run


@dataclass(frozen=True, slots=True)
class Addressing:
    """Who is addressed, and the state of things when a post arrives.

    `names` are the mentions it answers to, without @. `boards` are where it may be commanded (a stop counts anywhere).
    `running_topics` are threads in which a command of this robot runs or waits, `schedule_topics` those in which it has
    a schedule, `renewable_topics` those in which one may be renewed, `commands` the posts of the commands that run or
    wait, `robots` the accounts that are known to be robots, and `partners` those that carry out parts of the same post,
    whose stop is a stop of all. `watermark_at` is when its agent first started,
    `now_at` the forum's clock.
    """

    me: Account
    names: Collection[str]
    boards: Collection[str]
    watermark_at: datetime
    now_at: datetime
    max_age_s: float
    running_topics: Collection[str] = ()
    schedule_topics: Collection[str] = ()
    renewable_topics: Collection[str] = ()
    commands: Collection[str] = ()
    robots: Collection[str] = ()
    partners: Collection[str] = ()


@dataclass(frozen=True, slots=True)
class TriagedPost:
    """A post with its route. `text` is its visible text, `others` are the other accounts that it mentions. An approval
    or a renewal that is not `fresh` is too old to count. `taken_as_stop`: it is a stop only because something moves or
    waits."""

    route: Route
    text: str = ""
    others: tuple[str, ...] = ()
    fresh: bool = True
    taken_as_stop: bool = False

    @property
    def language(self) -> Language:
        return language_of(self.text)


def triage(post: Post, addressing: Addressing, edited: bool = False) -> TriagedPost:
    """Return the route of a post. `edited`: it was seen before and has changed, so only a stop counts (law 4)."""
    if post.removed or not obeyed(post.author, addressing.me):
        return TriagedPost(Route.NOTHING)
    text = text_in(post)
    named = mentions(text)
    # In doubt it stops: by a name that another forum does not link, links where it is not read, or that ends in a slip.
    mine = addressing.me.name in post.mentions or any(
        {name, name.rstrip("-_")} & set(addressing.names) for name in named
    )
    # Only a name that is read and that the page links commands; further names of `mentions` need be no accounts.
    called = any(name in addressing.names and (name in post.mentions or name != addressing.me.name) for name in named)
    others = tuple(name for name in named if name not in addressing.names)
    # In the thread of a command that runs a stop needs no mention; "@another-robot stop" is for that robot, but only
    # where it is known to be one: "@alice stop it!" may be a warning to a person who never wrote here.
    partner = any(name in addressing.partners for name in others)
    robots = () if partner else tuple(name for name in others if name in addressing.robots)
    scheduled = post.topic_id in addressing.schedule_topics
    here = mine or partner or (not robots and (scheduled or post.topic_id in addressing.running_topics))
    # Where nothing moves or waits, "cancel" in the thread of a schedule ends that schedule; elsewhere it is a stop.
    if here and scheduled and not edited and _only_cancels(text, post.topic_id, addressing.running_topics):
        return TriagedPost(Route.CANCEL, text, others)
    at_rest = called and not addressing.running_topics  # then "don't move, just take a photo" takes the photo
    if here and (stop := stop_intent(text)) and not (at_rest and asks_for_picture_at_rest(without_mentions(text))):
        return TriagedPost(Route.HALT if stop is Intent.HALT else Route.STOP, text, others)
    # While anything moves or waits, in doubt it stops; a command under way does not stop itself.
    doubted = (
        here
        and addressing.running_topics
        and (edited or post.id not in addressing.commands)
        and approval_in(text) is None
    )
    if doubted and (stop := stop_while_moving(text, (*addressing.names, *addressing.partners), robots)):
        return TriagedPost(Route.HALT if stop is Intent.HALT else Route.STOP, text, others, taken_as_stop=True)
    renewable = (mine or not robots) and post.topic_id in addressing.renewable_topics
    if renewable and not edited and renews_schedule(text):
        return TriagedPost(Route.RENEW, text, others, _fresh(post, addressing))
    if edited or not called or post.board_id not in addressing.boards:
        return TriagedPost(Route.NOTHING, text, others)
    fresh = _fresh(post, addressing)
    if (approval := approval_in(text)) is not None:
        return TriagedPost(Route.APPROVE if approval is ApprovalIntent.APPROVE else Route.DENY, text, others, fresh)
    return TriagedPost(Route.READ if fresh else Route.STALE, text, others)


def _only_cancels(text: str, topic_id: str, running_topics: Collection[str]) -> bool:
    """Whether a text ends a schedule of its thread instead of stopping the robot.

    While the robot moves or has a command waiting, it does so only in other threads, and only if it names a schedule
    (law 13).
    """
    if not running_topics:
        return cancels_schedule(text)
    return topic_id not in running_topics and cancels_named_schedule(text)


def obeyed(author: Account, me: Account) -> bool:
    """Whether what this account writes or presses can count at all; what it may do is asked elsewhere."""
    return author.name != me.name and author.kind not in NOT_OBEYED and not author.suspended


def language_of(text: str) -> Language:
    """The language of a text; mentions do not count."""
    for name in mentions(text):
        text = text.replace("@" + name, " ")
    return registry.language_of(text)


def _fresh(post: Post, addressing: Addressing) -> bool:
    age_s = (addressing.now_at - post.created_at).total_seconds()
    return post.created_at > addressing.watermark_at and age_s <= addressing.max_age_s
