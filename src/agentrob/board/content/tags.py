"""Tags of topics: normalized, so that variants of a word are one tag, and set by the topic's author or a moderator."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from sqlalchemy import delete, func, insert, select

from agentrob.board.auth import limits
from agentrob.board.content.writes import may_post
from agentrob.board.db import audit
from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.db.writer import Transaction
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

#: Tags of one topic, characters of one tag, tags in the list of all.
MOST, LENGTH, LISTED = 5, 24, 200
_KEPT = "LNM"  # letters, digits, and the marks that belong to letters


@dataclass(frozen=True, slots=True)
class Tag:
    """A tag and the number of visible topics that have it."""

    tag: str
    topics: int


def plain(word: str) -> str:
    """A word as a tag: `#Red Ball!` becomes `red-ball`; empty if no letter or digit is left."""
    folded = unicodedata.normalize("NFKC", unicodedata.normalize("NFKC", word[:200]).casefold())
    kept = "".join(c if unicodedata.category(c)[0] in _KEPT else " " for c in folded)
    return "-".join(kept.split())[:LENGTH].rstrip("-")


def checked(words: Iterable[str]) -> tuple[str, ...]:
    """The tags of words, in their order, each once. 422 for a word that is too long, and for too many."""
    given = list(words)
    if any(len(word.strip()) > LENGTH for word in given):
        raise BoardError(422, "bad_tag", "a tag is too long", f"at most {LENGTH} characters")
    found = tuple(dict.fromkeys(tag for tag in map(plain, given) if tag))
    if len(found) > MOST:
        raise BoardError(422, "too_many_tags", f"a topic has at most {MOST} tags", "use fewer tags")
    return found


# -------------------------------------------------------------------- writing
def change(t: Transaction, by: Account, topic_id: str, found: Sequence[str], per_hour: int = 0) -> Topic:
    """Set the tags of a topic, as its author, who must be allowed to post there, or a moderator, which is logged. 403,
    and
    429 after `per_hour` changes."""
    reader = Reader(t.connection)
    topic = reader.topic(topic_id)
    may_post(by, reader.board(topic.board_id), topic)
    if not may_change(by, topic):
        what = "only the author of a topic and moderators choose its tags"
        raise BoardError(403, "not_yours", what, "ask one of them")
    if set(found) != set(topic.tags):
        limits.record_change(t.connection, by, per_hour)
        t.connection.execute(delete(db.topic_tags).where(db.topic_tags.c.topic_id == int(topic.id)))
        if rows := [{"topic_id": int(topic.id), "tag": tag} for tag in found]:
            t.connection.execute(insert(db.topic_tags), rows)
        if by.id != topic.author.id:
            audit.note(t.connection, by.name, "topic.tags", f"topic:{topic.id}", tags=sorted(found))
    return reader.topic(topic_id)


def may_change(by: Account, topic: Topic) -> bool:
    """Whether an account may choose the tags of a topic, if it may post there."""
    watches = by.kind in (AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT)
    return by.id == topic.author.id or (by.role.rank >= Role.MODERATOR.rank and not watches)


# -------------------------------------------------------------------- reading, beside the event loop
def listed(reader: Reader) -> tuple[Tag, ...]:
    """All tags of visible topics, most used first."""
    t, tag, count = db.topics.c, db.topic_tags.c.tag, func.count()
    statement = select(tag, count.label("topics")).join(db.topics, t.id == db.topic_tags.c.topic_id).where(t.posts > 0)
    if (seen := reader.seen()) is not None:
        statement = statement.where(t.board_id.in_(seen))
    rows = reader.rows(statement.group_by(tag).order_by(count.desc(), tag).limit(LISTED))
    return tuple(Tag(r.tag, r.topics) for r in rows)


def posts(reader: Reader, tag: str, limit: int) -> tuple[StoredPost, ...]:
    """The latest posts of topics with a tag, newest first, without removed ones."""
    p = db.posts.c
    topics = [int(topic.id) for topic in reader.topics(None, None, limit, tag).items]  # no other topic has a later post
    newest = select(p.id).where(p.topic_id.in_(topics), p.removed.is_(False)).order_by(p.id.desc()).limit(limit)
    found = {post.id: post for post in reader.posts_by_id([row.id for row in reader.rows(newest)])}
    return tuple(found[i] for i in sorted(found, key=int, reverse=True))
