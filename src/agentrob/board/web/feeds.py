"""Atom feeds of the site, a board, a topic, a tag and a robot: the latest posts that the viewer may read; and the
calendar of a robot's schedules.

A feed reader signs in with `Authorization: Bearer <token>`, except where the forum is public.
"""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from datetime import UTC, datetime

from fastapi import APIRouter, Request
from starlette.responses import Response

from agentrob.board.access import ReadingViewer
from agentrob.board.content import tags
from agentrob.board.db.records import StoredPost
from agentrob.board.robots import actions, schedules
from agentrob.board.robots.schedules import schedule_calendar
from agentrob.board.services import AppServices, get_services
from agentrob.board.web.templating import render_feed

router = APIRouter(include_in_schema=False)

#: Posts in a feed.
ENTRIES = 30


@router.get("/feed.atom")
async def site(request: Request, services: AppServices, viewer: ReadingViewer) -> Response:
    return _feed(request, services.settings.title, "/", services.store.reader.latest_posts(None, ENTRIES).items)


@router.get("/b/{board_id}/feed.atom")
async def board(request: Request, services: AppServices, viewer: ReadingViewer, board_id: str) -> Response:
    store = services.store
    found = store.reader.board(board_id)
    posts = store.reader.latest_posts(None, ENTRIES, found.id).items
    return _feed(request, found.name, f"/b/{found.id}", posts)


@router.get("/t/{topic_id}/feed.atom")
async def topic(request: Request, services: AppServices, viewer: ReadingViewer, topic_id: str) -> Response:
    store = services.store
    found = store.reader.topic(topic_id)
    return _feed(request, found.title, found.path, store.reader.latest_posts(None, ENTRIES, topic_id=found.id).items)


@router.get("/tags/{tag}/feed.atom")
async def tag(request: Request, services: AppServices, viewer: ReadingViewer, tag: str) -> Response:
    named = tags.plain(tag)
    posts = await services.store.beside(tags.posts, named, ENTRIES)
    return _feed(request, f"#{named}", f"/tags/{named}", posts)


@router.get("/robots/{name}/feed.atom")
async def robot(request: Request, services: AppServices, viewer: ReadingViewer, name: str) -> Response:
    account = actions.known_robot(services, name)
    posts = services.store.reader.posts_by(account, ENTRIES)
    return _feed(request, f"@{account.name}", f"/robots/{account.name}", posts)


@router.get("/robots/{name}/schedules.ics")
async def calendar(services: AppServices, viewer: ReadingViewer, name: str) -> Response:
    """The further runs of a robot's schedules as a calendar (RFC 5545), one event for each run."""
    account = actions.known_robot(services, name)
    found = schedules.of_robot(services, account.name, viewer.account)
    text = await asyncio.to_thread(schedule_calendar, found, account.name, services.settings.base_url)
    return Response(text, media_type="text/calendar; charset=utf-8", headers={"Cache-Control": "private, no-cache"})


def _feed(request: Request, title: str, path: str, posts: Sequence[StoredPost]) -> Response:
    services = get_services(request)
    topics = {topic_id: services.store.reader.topic(topic_id) for topic_id in {post.topic_id for post in posts}}
    updated = max((post.edited_at or post.created_at for post in posts), default=datetime.fromtimestamp(0, UTC))
    data = {"title": title, "path": path, "posts": posts, "topics": topics, "updated": updated}
    xml = render_feed(
        data | {"base": services.settings.base_url, "here": request.url.path, "site": services.settings.title}
    )
    headers = {"Cache-Control": "private, no-cache"}
    return Response(xml, media_type="application/atom+xml", headers=headers)
