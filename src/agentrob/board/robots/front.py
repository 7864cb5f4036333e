"""The robots and threads of the home page: current activities, last pictures, and how commands ended."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy import func, select

from agentrob.board.auth import rights
from agentrob.board.db import schema as db
from agentrob.board.db.records import Image, StoredPost, Topic
from agentrob.board.robots.view import RobotView, robots
from agentrob.board.services import Services
from agentrob.model import Account, AccountKind, CommandState

#: The number of replies in which the last picture is searched.
_LOOK_BACK = 10
#: On a forum with more robots, their pictures are only on their own pages.
MOST_PICTURES = 12


@dataclass(frozen=True, slots=True)
class RobotNow:
    """A robot with what it does now (`doing`, in words; empty if nothing), the post of that command, and its last
    picture that the viewer may see."""

    robot: RobotView
    doing: str = ""
    command: str = ""
    picture: Image | None = None

    @property
    def moves(self) -> bool:
        """Whether it moves, or carries out a command and may move at any moment."""
        return self.robot.live and (self.robot.moves or bool(self.command))


def now(services: Services, viewer: Account | None, *, pictures: bool = True) -> tuple[RobotNow, ...]:
    """All robots, connected ones first; with their pictures, unless there are too many robots."""
    found = robots(services)
    pictures = pictures and len(found) <= MOST_PICTURES
    return tuple(robot_now(services, robot, viewer, pictures=pictures) for robot in found)


def robot_now(services: Services, robot: RobotView, viewer: Account | None, *, pictures: bool = True) -> RobotNow:
    post, doing = running(services, robot)
    picture = last_picture(services, robot.name, viewer) if pictures else None
    return RobotNow(robot, doing, post.reply_to or "" if post else "", picture)


def running(services: Services, robot: RobotView) -> tuple[StoredPost | None, str]:
    """The robot's status post of the command that it carries out now, and what it does in words."""
    account = services.store.reader.account(robot.name)
    if account is None or not robot.live:
        return None, ""
    reader = services.store.reader
    for command in reader.posts_by_id([int(post_id) for post_id in robot.line[:3]]):
        status = reader.status_post(account, command)
        card = (status.card if status else None) or {}
        if status and card.get("state") == CommandState.RUNNING:
            return status, str(card.get("doing") or "")[:200]
    return None, ""


def last_picture(services: Services, robot: str, viewer: Account | None) -> Image | None:
    """The latest photo in a robot's replies, else another picture, if the viewer may see its camera."""
    reader = services.store.reader
    account = reader.account(robot)
    if account is None or not rights.sees_camera(rights.settings_of(reader, robot), viewer, robot):
        return None

    def read() -> Image | None:
        return best_picture([image for post in reader.posts_by(account, _LOOK_BACK) for image in post.images])

    return reader.kept(("last picture", account.id, reader.seen()), read)


def best_picture(images: Sequence[Image]) -> Image | None:
    """The picture to show for a reply: the first photo, else recording, else plot; None without any."""
    return min(
        images, key=lambda image: 0 if image.media_type == "image/jpeg" else 1 if image.moving else 2, default=None
    )


def outcomes(services: Services, topics: Collection[Topic]) -> Mapping[str, StoredPost]:
    """The newest answer of a robot in each of these topics, by topic."""
    p, a = db.posts.c, db.accounts.c
    ids = [int(topic.id) for topic in topics]
    newest = select(func.max(p.id).label("id")).join(db.accounts, a.id == p.author_id).group_by(p.topic_id)
    newest = newest.where(p.topic_id.in_(ids), p.removed.is_(False), p.card.is_not(None))
    rows = services.store.reader.rows(newest.where(a.kind == AccountKind.ROBOT_AGENT)) if ids else ()
    return {post.topic_id: post for post in services.store.reader.posts_by_id([row.id for row in rows])}
