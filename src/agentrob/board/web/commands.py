"""The page of a command: what was asked, what was judged, what was measured, and who decided, under one trace id."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.robots import approvals, commands
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.command_view import command_view
from agentrob.board.services import get_services
from agentrob.board.web import forms
from agentrob.board.web.templating import go, own_path, show, with_receipt

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]


@router.get("/c/{post_id}")
async def command(request: Request, viewer: Reading, post_id: str, part: str = "") -> Response:
    """`post_id` is the post that asked. JSON of the same: `/api/v1/commands/{post_id}`."""
    known = get_services(request)
    if (asked := commands.answered(known.store.reader, post_id)) is not None:
        return go(f"/c/{asked}")
    post, told = commands.records_of(known.store.reader, post_id)
    views = [command_view(post, one) for one in told]
    hidden = robot_view.hidden_cameras(known, viewer.account, [one.reply for one in told if one.reply])
    data = {"post": post, "views": views, "topic": known.store.topic(post.topic_id), "hidden": hidden}
    data["board"] = known.store.board(post.board_id)
    data |= {"waiting": approvals.of_post(known, post, viewer.account), "key": forms.nonce()}
    ended = {view.robot for view in views}
    data["awaited"] = [r.name for r in known.store.robots() if r.name in post.mentions and r.name not in ended]
    template = "command_views.html" if part == "views" else "command.html"
    return show(request, viewer, template, data, here="home")


@router.post("/c/{post_id}/approve")
async def approve(request: Request, viewer: Anybody, post_id: str) -> Response:
    """Approve or deny a command that waits."""
    form = await forms.read(request)
    access.check_form(viewer, form.get("csrf"))
    robot, yes = forms.field(form, "robot"), forms.field(form, "do") == "approve"
    key = forms.key(form, post_id, robot, str(yes))
    await approvals.say(get_services(request), access.account_of(viewer), post_id, robot, yes, key)
    back = own_path(form.get("back"), f"/c/{post_id}")
    return go(with_receipt(back, viewer, "approve" if yes else "deny", robot))
