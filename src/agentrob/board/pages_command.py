"""The page of a command: what was asked, what was judged, what was measured, and who decided, under one trace id."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access, commands, robot_view
from agentrob.board.access import Viewer
from agentrob.board.command_view import command_view
from agentrob.board.services import services
from agentrob.board.templating import show

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Reading = Annotated[Viewer, Depends(access.reader)]


@router.get("/c/{post_id}")
async def command(request: Request, viewer: Reading, post_id: str, part: str = "") -> Response:
    """`post_id` is the post that asked. JSON of the same: `/api/v1/commands/{post_id}`."""
    known = services(request)
    post, told = commands.of(known.store.reader, post_id)
    views = [command_view(post, one) for one in told]
    hidden = robot_view.hidden_cameras(known, viewer.account, [one.reply for one in told if one.reply])
    data = {"post": post, "views": views, "topic": known.store.topic(post.topic_id), "hidden": hidden}
    data["board"] = known.store.board(post.board_id)
    template = "command_views.html" if part == "views" else "command.html"
    return show(request, viewer, template, data, here="home")
