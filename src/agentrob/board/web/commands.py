"""The page of a command: what was asked, what was judged, what was measured, and who decided, under one trace id."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer
from agentrob.board.robots import approvals, commands
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.command_view import command_view
from agentrob.board.services import AppServices
from agentrob.board.web import forms
from agentrob.board.web.templating import go, own_path, show, with_receipt

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


@router.get("/c/{post_id}")
async def command(
    request: Request, services: AppServices, viewer: ReadingViewer, post_id: str, part: str = ""
) -> Response:
    """`post_id` is the post that asked. JSON of the same: `/api/v1/commands/{post_id}`."""
    if (asked := commands.answered(services.store.reader, post_id)) is not None:
        return go(f"/c/{asked}")
    post, told = commands.records_of(services.store.reader, post_id)
    views = [command_view(post, one) for one in told]
    hidden = robot_view.hidden_cameras(services, viewer.account, [one.reply for one in told if one.reply])
    data = {"post": post, "views": views, "topic": services.store.topic(post.topic_id), "hidden": hidden}
    data["board"] = services.store.board(post.board_id)
    data |= {"waiting": approvals.of_post(services, post, viewer.account), "key": forms.nonce()}
    ended = {view.robot for view in views}
    data["awaited"] = [r.name for r in services.store.robots() if r.name in post.mentions and r.name not in ended]
    template = "command_views.html" if part == "views" else "command.html"
    return show(request, viewer, template, data, here="home")


@router.post("/c/{post_id}/approve")
async def approve(request: Request, services: AppServices, viewer: AnyViewer, post_id: str) -> Response:
    """Approve or deny a command that waits."""
    form = await forms.read_checked(request, viewer)
    robot, yes = forms.field(form, "robot"), forms.field(form, "do") == "approve"
    key = forms.key(form, post_id, robot, str(yes))
    await approvals.say(services, access.account_of(viewer), post_id, robot, yes, key)
    back = own_path(form.get("back"), f"/c/{post_id}")
    return go(with_receipt(back, viewer, "approve" if yes else "deny", robot))
