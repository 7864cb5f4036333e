"""The page of a command: the request, the verdict, the measurements and the approval, under one trace id."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer
from agentrob.board.robots import approvals, commands, live, replays
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.command_view import command_view
from agentrob.board.robots.live import RoomView
from agentrob.board.services import AppServices, Services
from agentrob.board.web import forms
from agentrob.board.web.forms import KeyedForm, Line
from agentrob.board.web.templating import own_path, redirect, render_page, with_receipt

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


@router.get("/c/{post_id}")
async def command(
    request: Request, services: AppServices, viewer: ReadingViewer, post_id: str, part: str = ""
) -> Response:
    """`post_id` is the post with the command. The same as JSON: `/api/v1/commands/{post_id}`."""
    if (asked := commands.answered(services.store.reader, post_id)) is not None:
        return redirect(f"/c/{asked}")
    post, records = commands.records_of(services.store.reader, post_id)
    can = {robot.name: robot.can for robot in robot_view.robots(services)}
    views = [command_view(post, one, can.get(one.robot)) for one in records]
    hidden = robot_view.hidden_cameras(services, viewer.account, [one.reply for one in records if one.reply])
    data = {"post": post, "views": views, "topic": services.store.reader.topic(post.topic_id), "hidden": hidden}
    data["schedule"] = commands.schedule_of(services.store.reader, post)
    data["board"] = services.store.reader.board(post.board_id)
    waiting = approvals.of_post(services, post, viewer.account)
    data |= {"waiting": waiting, "key": forms.nonce()}
    robots = {*(view.robot for view in views), *(one.robot for one in waiting)}
    data["replays"] = _replays(services, post_id, sorted(robots))
    ended = {view.robot for view in views}
    data["awaited"] = [
        r.name for r in services.store.reader.robots() if r.name in post.mentions and r.name not in ended
    ]
    template = "command_views.html" if part == "views" else "command.html"
    return render_page(request, viewer, template, data, here="home")


def _replays(services: Services, post_id: str, robots: Sequence[str]) -> dict[str, RoomView]:
    """The last picture of each robot's replay, by robot."""
    found = {robot: replays.replay_of(services.store.reader, post_id, robot) for robot in robots}
    maps = [(robot, replays.final_map(replay)) for robot, replay in found.items() if replay is not None]
    return {robot: live.rooms([(robot, one)])[0] for robot, one in maps if one is not None}


@router.get("/approvals")
async def asked(request: Request, services: AppServices, viewer: ReadingViewer, part: str = "") -> Response:
    """The commands that wait for the viewer's approval. `part` is `list`, or `count` for the menu."""
    account = access.account_of(viewer)
    template = {"list": "approvals_list.html", "count": "approvals_count.html"}.get(part, "approvals.html")
    data: dict[str, Any] = {"waiting": approvals.asked_of(services, account), "key": forms.nonce()}
    data["approver"] = approvals.may_any(services, account)
    return render_page(request, viewer, template, data, here="approvals")


class DecisionForm(KeyedForm):
    """Approves the command of a robot if `do` is `approve`, else denies it."""

    robot: Line = ""
    do: Line = ""
    back: str = ""


@router.post("/c/{post_id}/approve")
async def approve(
    services: AppServices, viewer: AnyViewer, post_id: str, form: Annotated[DecisionForm, Form()]
) -> Response:
    """Approve or deny a waiting command."""
    by, yes = form.sender(viewer), form.do == "approve"
    key = form.idempotency_key(post_id, form.robot, str(yes))
    await approvals.say(services, by, post_id, form.robot, yes, key)
    return redirect(
        with_receipt(own_path(form.back, f"/c/{post_id}"), viewer, "approve" if yes else "deny", form.robot)
    )
