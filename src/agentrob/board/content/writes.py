"""Write jobs: create, edit and remove posts, record robot events, register pictures.

Each job repeats the checks that need the database, updates the topic's counters, and inserts its event in the same
transaction.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from sqlalchemy import Connection, bindparam, insert, select, update

from agentrob.board.auth import limits
from agentrob.board.content import notifications
from agentrob.board.content.rendered import Rendered
from agentrob.board.db import audit, fulltext
from agentrob.board.db import schema as db
from agentrob.board.db.reader import Reader, not_found, row_id
from agentrob.board.db.records import Board, Image, StoredEvent, StoredPost, Topic, Written, from_us, now_us
from agentrob.board.db.rows import event_id
from agentrob.board.db.writer import Transaction
from agentrob.board.settings import NO_LIMITS
from agentrob.config.board import BoardLimitsConfig
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, CommandState, EventKind, Role
from agentrob.model.lifecycle import ACTIVE_STATES

MAX_IMAGES = 32
#: The title of a topic whose author may not start one: it exists only for the stop in it.
STOP_TITLE = "Stop"
Card = Mapping[str, Any]
#: States of a status post that only report progress: an edit does not keep their text as a version. The text that asks
#: for an approval and the final one are kept, as every text of a person is.
PROGRESS = ACTIVE_STATES - {CommandState.WAITING}
#: Buttons of robots' owners; the audit log records who pressed one.
_AUDITED = frozenset({EventKind.ROBOT_RELEASE, EventKind.ROBOT_HOME})
_t = db.topics.c
_ONE_POST_MORE = (
    update(db.topics)
    .where(_t.id == bindparam("topic"))
    .values(last_post_id=bindparam("post"), last_post_us=bindparam("at"), posts=_t.posts + 1)
)


@dataclass(frozen=True, slots=True)
class Draft:
    """A post to be written; `images` are ids, `reply_to` is a post of the same topic."""

    author: Account
    text: Rendered
    key: str | None = None
    images: Sequence[str] = ()
    reply_to: str | None = None
    card: Card | None = None
    limits: BoardLimitsConfig = NO_LIMITS


def create_topic(t: Transaction, board_id: str, title: str, draft: Draft, tags: Sequence[str] = ()) -> Written:
    """Create a topic and its first post; `tags` are checked. A topic accepted only because it is a stop gets a fixed
    title and no tags, so that it says nothing else."""
    if old := _written_before(t, draft):
        return old
    board = Reader(t.connection).board(board_id)
    if not taken_as_any_other(t, draft, board):
        title, tags = STOP_TITLE, ()
    at = now_us()
    row = {"board_id": board.id, "title": title, "author_id": int(draft.author.id)}
    topic_id = _insert(t, db.topics, **row, created_us=at, last_post_us=at)
    if tags:
        t.connection.execute(insert(db.topic_tags), [{"topic_id": topic_id, "tag": tag} for tag in tags])
    return _add_post(t, topic_id, draft, at, title)


def reply(t: Transaction, topic_id: str, draft: Draft) -> Written:
    """Create a post in a topic."""
    if old := _written_before(t, draft):
        return old
    reader = Reader(t.connection)
    topic = reader.topic(topic_id)
    taken_as_any_other(t, draft, reader.board(topic.board_id), topic)
    return _add_post(t, int(topic.id), draft, now_us())


def taken_as_any_other(t: Transaction, draft: Draft, board: Board, topic: Topic | None = None) -> bool:
    """Whether the author may write this post; False if it is accepted only because it says stop and nothing else
    (law 15). Else 403 or 429; 404 if the author may not read the board."""
    taken = False
    with _a_stop_is_taken(draft.text):
        may_post(draft.author, board, topic)
        check_limits(t, draft)
        taken = True
    return taken


@contextmanager
def _a_stop_is_taken(text: Rendered) -> Iterator[None]:
    """Ignore errors of the checks inside, except 404, for a text that says stop and nothing else."""
    try:
        yield
    except BoardError as e:
        if e.status == 404 or not text.only_stop:
            raise


def may_post(author: Account, board: Board, topic: Topic | None = None) -> None:
    """403 if the author may not write here, 404 if it may not read here. Robots may reply everywhere."""
    if author.role.rank < board.read_role.rank:
        raise not_found("topic", topic.id) if topic else not_found("board", board.id)
    if author.kind is AccountKind.ROBOT_AGENT:
        return
    if author.role.rank < max(board.post_role.rank, Role.MEMBER.rank):
        what = f"writing on the board {board.id} needs the role {board.post_role}"
        raise BoardError(403, "board_role", what, "ask an admin; a post that only says stop is taken all the same")
    if topic is not None and topic.locked and author.role.rank < Role.MODERATOR.rank:
        hint = "begin a new one; a post that only says stop is taken all the same"
        raise BoardError(403, "locked", "this topic is locked", hint)


def check_limits(t: Transaction, draft: Draft) -> None:
    """429 if the author posted or commanded too often in the last hour. Robots are exempt."""
    if draft.author.kind is AccountKind.ROBOT_AGENT:
        return
    limits.check_posts(t.connection, draft.author, draft.limits.posts)
    if draft.limits.commands:
        robots = frozenset(r.name for r in Reader(t.connection).robots())
        if robots.intersection(draft.text.mentions):
            limits.check_commands(t.connection, draft.author, draft.limits.commands, robots)


def edit(
    t: Transaction,
    editor: Account,
    post_id: str,
    text: Rendered,
    key: str | None,
    images: Sequence[str],
    card: Card | Literal["keep"] | None,
    per_hour: int = 0,
) -> StoredPost:
    """Replace the text of the editor's own post. The old one is kept as a version, unless it was a robot's `PROGRESS`.
    429
    after `per_hour` changes."""
    reader = Reader(t.connection)
    post = reader.post(post_id)
    if post.author.id != editor.id:
        raise BoardError(403, "not_yours", "only its author may edit a post", "write a reply")
    if not _use_key(t, editor, f"edit:{post.id}", key, int(post.id)):
        return post
    if post.removed:
        raise BoardError(409, "removed", "the post was removed", "write a new one")
    board, topic = reader.board(post.board_id), reader.topic(post.topic_id)
    with _a_stop_is_taken(text):
        may_post(editor, board, topic)
        limits.record_change(t.connection, editor, per_hour)
    at = now_us()
    if not _only_progress(post):
        version = {"post_id": int(post.id), "version": post.version, "raw": post.raw}
        t.connection.execute(insert(db.post_versions).values(**version, until_us=at))
    values = _columns(text) | {"version": post.version + 1, "edited_us": at}
    if card != "keep":
        values["card"] = card
    t.connection.execute(update(db.posts).where(db.posts.c.id == int(post.id)).values(**values))
    _attach(t.connection, int(post.id), editor, images)
    fulltext.change(t.connection, int(post.id), text.words, text.chars, reader.title_begun_by(post))
    if card != "keep" and _waits(card) != _waits(post.card):
        notifications.notify_approvers(t, int(post.id), editor, _number(post.reply_to), _waits(card))
    add_event(t, EventKind.POST_EDITED, at, topic_id=int(post.topic_id), post_id=int(post.id))
    return reader.post(post.id)


def remove(t: Transaction, by: Account, post_id: str, reason: str = "") -> StoredPost:
    """Hide a post, as its author or a moderator. Repeating it does nothing."""
    reader = Reader(t.connection)
    post = reader.post(post_id)
    if post.author.id != by.id:
        if by.role.rank < reader.board(post.board_id).read_role.rank:
            raise not_found("post", post_id)
        if by.role.rank < Role.MODERATOR.rank or by.kind in (AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT):
            raise BoardError(403, "not_yours", "only its author or a moderator may remove a post")
    if post.removed:
        return post
    values = {"removed": True, "removed_by": int(by.id) or None, "version": post.version + 1}
    t.connection.execute(update(db.posts).where(db.posts.c.id == int(post.id)).values(**values))
    topics = db.topics.c
    counted = update(db.topics).where(topics.id == int(post.topic_id)).values(posts=topics.posts - 1)
    t.connection.execute(counted)
    add_event(t, EventKind.POST_REMOVED, now_us(), topic_id=int(post.topic_id), post_id=int(post.id))
    if post.author.id != by.id:
        audit.note(t.connection, by.name, "post.hide", f"post:{post.id}", author=post.author.name, reason=reason)
    return reader.post(post.id)


def record(t: Transaction, kind: EventKind, robot: str, by: Account | None, key: str | None, at_us: int) -> StoredEvent:
    """Record an event of a robot; with a key that was used before, return the earlier event."""
    values = {"robot": robot, "account_id": int(by.id) if by else None}
    if by and key and (old := _used(t.connection, by, f"{kind}:{robot}"[:40], key)):
        at_us = t.connection.execute(select(db.events.c.at_us).where(db.events.c.id == old)).scalar_one()
        return StoredEvent(event_id(old, at_us), kind, from_us(at_us), robot=robot, account=by)
    number = add_event(t, kind, at_us, **values)
    if by and kind in _AUDITED:
        audit.note(t.connection, by.name, str(kind), f"robot:{robot}")
    if by:
        _use_key(t, by, f"{kind}:{robot}"[:40], key, number)
    return StoredEvent(event_id(number, at_us), kind, from_us(at_us), robot=robot, account=by)


def add_image(
    t: Transaction, by: Account, file: Path, image: Image, key: str | None, per_hour: int = 0
) -> tuple[Image, bool] | None:
    """Register an uploaded picture; return it and whether it is new. 429 after `per_hour` uploads in the last hour.

    None if its file was deleted after it was written. No process deletes it during this transaction, nor after its
    commit.
    """
    if key and (old := _used(t.connection, by, "image", key)):
        return Reader(t.connection).image(str(old))[0], False
    if by.kind is not AccountKind.ROBOT_AGENT:
        limits.check_uploads(t.connection, by, per_hour)
    if not file.exists():
        return None
    values = {"media_type": image.media_type, "width": image.width, "height": image.height}
    image_id = _insert(t, db.images, account_id=int(by.id), sha256=file.name, created_us=now_us(), **values)
    _use_key(t, by, "image", key, image_id)
    return Image(str(image_id), image.width, image.height, image.media_type), True


# -------------------------------------------------------------------- parts
def _written_before(t: Transaction, draft: Draft) -> Written | None:
    reader = Reader(t.connection)
    if draft.key is None or (old := reader.find(draft.author, draft.key)) is None:
        return None
    return Written(reader.topic(old.topic_id), old, created=False)


def _add_post(t: Transaction, topic_id: int, draft: Draft, at: int, title: str = "") -> Written:
    reader = Reader(t.connection)
    reply_to = _same_topic(reader, draft.reply_to, topic_id) if draft.reply_to is not None else None
    values = {"author_id": int(draft.author.id), "reply_to": reply_to, "key": draft.key, "card": draft.card}
    post_id = _insert(t, db.posts, topic_id=topic_id, created_us=at, **values, **_columns(draft.text))
    t.connection.execute(_ONE_POST_MORE, {"topic": topic_id, "post": post_id, "at": at})
    _attach(t.connection, post_id, draft.author, draft.images)
    fulltext.add(t.connection, post_id, draft.text.words, draft.text.chars, title)
    notifications.notify(t, post_id, topic_id, draft.author, draft.text.mentions, reply_to)
    if _waits(draft.card):
        notifications.notify_approvers(t, post_id, draft.author, reply_to, True)
    add_event(t, EventKind.POST_CREATED, at, topic_id=topic_id, post_id=post_id)
    return Written(reader.topic(str(topic_id)), reader.post(str(post_id)))


def _only_progress(post: StoredPost) -> bool:
    """Whether this is a robot's status post of a command that is still in progress."""
    state = (post.card or {}).get("state")
    return post.author.kind is AccountKind.ROBOT_AGENT and state in PROGRESS


def _columns(text: Rendered) -> dict[str, Any]:
    """The columns that follow from a text."""
    return {"raw": text.raw, "html": text.html, "mentions": list(text.mentions)}


def _same_topic(reader: Reader, post_id: str, topic_id: int) -> int:
    post = reader.post(post_id)
    if int(post.topic_id) != topic_id:
        hint = "the id of a post of this topic"
        raise BoardError(404, "no_such_post", f"post {post_id} is in another topic", hint)
    return int(post.id)


def _waits(card: Card | None) -> bool:
    """Whether a status says that its robot waits for an approval."""
    return (card or {}).get("state") == CommandState.WAITING


def _number(post_id: str | None) -> int | None:
    return None if post_id is None else int(post_id)


def _attach(connection: Connection, post_id: int, by: Account, images: Sequence[str]) -> None:
    """Append pictures to a post. Expired ones do not count, but keep their positions."""
    if not images:
        return
    columns, at = db.images.c, db.post_images.c
    there = select(at.position, columns.gone_us).join(db.images, columns.id == at.image_id).where(at.post_id == post_id)
    before = connection.execute(there).all()
    if sum(row.gone_us is None for row in before) + len(images) > MAX_IMAGES:
        raise BoardError(422, "too_many_images", f"a post shows at most {MAX_IMAGES} images", "fewer images")
    wanted = [row_id(image, "image") for image in images]
    mine = columns.id.in_(wanted), columns.account_id == int(by.id), columns.gone_us.is_(None)
    missing = set(wanted) - set(connection.execute(select(columns.id).where(*mine)).scalars())
    if missing:
        which = ", ".join(map(str, sorted(missing)))
        raise BoardError(404, "no_such_image", f"you uploaded no image {which}", "ids from your own POST /images")
    first = max((row.position for row in before), default=-1) + 1
    rows = [{"post_id": post_id, "position": first + n, "image_id": i} for n, i in enumerate(wanted)]
    connection.execute(insert(db.post_images), rows)


def add_event(t: Transaction, kind: EventKind, at_us: int, **values: Any) -> int:
    event_id = _insert(t, db.events, kind=str(kind), at_us=at_us, **values)
    t.event_ids.append(event_id)
    return event_id


def _used(connection: Connection, by: Account, scope: str, key: str) -> int | None:
    u = db.used_keys.c
    found = select(u.ref).where(u.account_id == int(by.id), u.scope == scope, u.key == key)
    return connection.execute(found).scalar_one_or_none()


def _use_key(t: Transaction, by: Account, scope: str, key: str | None, ref: int) -> bool:
    """Whether this is the first use of the key; always true without one."""
    if key is None:
        return True
    if _used(t.connection, by, scope, key) is not None:
        return False
    t.connection.execute(insert(db.used_keys).values(account_id=int(by.id), scope=scope, key=key, ref=ref))
    return True


def _insert(t: Transaction, table: Any, **values: Any) -> int:
    key = t.connection.execute(insert(table), values).inserted_primary_key
    return int(key[0]) if key else 0
