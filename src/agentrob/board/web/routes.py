"""The router of all pages. They work without scripts."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.web import (
    admin,
    api_docs,
    commands,
    feeds,
    find,
    moderation,
    posts,
    robots,
    sign_in,
    topics,
)
from agentrob.board.web.templating import static_file

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

# In this order: a request tries one path after the other, and most requests ask for topics.
for module in (topics, posts, robots, commands, find, sign_in, feeds, api_docs, admin, moderation):
    router.include_router(module.router)


@router.get("/static/{version}/{name}")
async def static(request: Request, version: str, name: str) -> Response:
    accepted = {word.partition(";")[0].strip() for word in request.headers.get("accept-encoding", "").split(",")}
    return static_file(version, name, compressed="gzip" in accepted)


@router.get("/favicon.ico")
async def favicon() -> Response:
    return static_file("", "logo.svg")
