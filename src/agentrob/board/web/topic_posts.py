"""The posts of a topic's page as HTML: most of its time is spent on them, so they are made once until one changes."""

from __future__ import annotations

from dataclasses import dataclass

from agentrob.board.auth import visibility
from agentrob.board.auth.access import Viewer
from agentrob.board.db.records import StoredPost
from agentrob.board.robots import approvals
from agentrob.board.robots import view as robot_view
from agentrob.board.services import Services
from agentrob.board.web import forms
from agentrob.board.web.templating import piece
from agentrob.model import Page


@dataclass(frozen=True, slots=True)
class Shown:
    """The posts, safe to put into a page, the cursor of the next page, the ids of the first and the last of them."""

    html: str
    next: str | None
    first: str = ""
    last: str = ""


def posts_of_topic(services: Services, viewer: Viewer, topic_id: str, after: str | None, limit: int) -> Shown:
    """For a viewer who may read the topic. 404, and 422 for a bad cursor."""

    def make() -> tuple[Shown, int]:
        page: Page[StoredPost] = services.store.posts(topic_id, after, limit)
        hidden = robot_view.hidden_cameras(services, viewer.account, page.items)
        authors = {post.id: post.author.name for post in page.items}
        data: dict[str, object] = {"posts": page.items, "viewer": viewer, "authors": authors, "hidden": hidden}
        data["owners"] = robot_view.owners(services, page.items)
        data |= {"asking": approvals.in_thread(services, page.items, viewer.account), "key": forms.nonce()}
        html = piece("topic_posts.html", data)
        ids = [post.id for post in page.items]
        return Shown(html, page.next, *(ids[:1] + ids[-1:])), len(html)

    form = viewer.csrf if viewer.account else ""  # in the buttons
    return services.topic_cache.of(
        services.store.reader, topic_id, (after, viewer.account, form, visibility.readable_boards()), make
    )
