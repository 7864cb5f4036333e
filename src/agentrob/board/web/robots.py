"""The pages of robots and people, and the buttons of robots."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.auth import rights
from agentrob.board.command_reading import READ_CHARS
from agentrob.board.content.store import Store
from agentrob.board.db.records import StoredPost, Topic
from agentrob.board.robots import actions, approvals, front, schedules
from agentrob.board.robots import view as robot_view
from agentrob.board.robots.abilities import ABOUT, abilities_of, example_commands
from agentrob.board.robots.view import RobotView
from agentrob.board.services import AppServices, Services, get_services
from agentrob.board.web import forms
from agentrob.board.web.forms import ButtonForm, Composed, KeyedForm, Line, PageForm
from agentrob.board.web.templating import own_path, redirect, render_page, with_receipt
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role, fleet_robot

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

_LATEST = 10
#: How often, and how many seconds each time, an owner's button waits for the agent to publish the result.
HEARD_TRIES, HEARD_S = 15, 0.1
SentForm = Annotated[PageForm, Form()]
Press = Callable[[Services, str, Account], Awaitable[object]]


@router.get("/robots")
async def robots(request: Request, services: AppServices, viewer: ReadingViewer, part: str = "") -> Response:
    """`part` is `cards`, or `aside` for those without pictures beside a topic."""
    data = {"cards": front.now(services, viewer.account, pictures=part != "aside")}
    template = "robot_cards.html" if part in ("cards", "aside") else "robots.html"
    return render_page(request, viewer, template, data, here="robots")


@router.get("/fleet")
async def fleet(request: Request, services: AppServices, viewer: ReadingViewer, part: str = "") -> Response:
    """All robots for operators and admins: who serves each one, and what goes wrong. Those not served come first."""
    account = access.has_role(access.account_of(viewer), Role.OPERATOR)
    now = datetime.now(UTC)
    found = [services.presence.robot(a.name) for a in services.store.reader.robots() if not a.suspended]
    robots = [fleet_robot(robot.name, robot.card, robot.seen_at, now) for robot in found]
    data = {"robots": sorted(robots, key=lambda robot: (robot.served, robot.name)), "tab": "fleet"}
    here = "admin" if account.role is Role.ADMIN else "fleet"
    return render_page(request, viewer, "fleet_table.html" if part == "table" else "fleet.html", data, here=here)


@router.get("/robots/{name}")
async def robot(request: Request, services: AppServices, viewer: ReadingViewer, name: str, say: str = "") -> Response:
    """`say` is a command for the box, as in the links of its abilities."""
    account, view = robot_view.robot(services, name)
    latest = _latest(services.store, account, once=True)
    kept = rights.settings_of(services.store.reader, account.name)
    hidden = robot_view.hidden_cameras(services, viewer.account, [post for _, post in latest])
    data = {"robot": view, "account": account, "latest": latest, "hidden": hidden} | _about(services, view, viewer)
    data |= {"about": ABOUT.get(view.model, ""), "examples": example_commands([(view.name, view.can)])}
    data |= {"typed": Composed(draft=say[:READ_CHARS] or f"@{view.name} "), "box_path": f"/robots/{view.name}"}
    data["neighbours"] = robot_view.robots(services)
    data["releases"] = actions.may_release(services, account.name, viewer.account)
    data["administers"] = viewer.account is not None and rights.reaches(viewer.account, "owner", kept.owner)
    return render_page(
        request, viewer, "robot.html", data | {"feed": f"/robots/{account.name}/feed.atom"}, here="robots"
    )


@router.get("/robots/{name}/fragment")
async def robot_fragment(
    request: Request, services: AppServices, viewer: ReadingViewer, name: str, part: str = ""
) -> Response:
    view = robot_view.robot(services, name)[1]
    data = {"robot": view, "releases": actions.may_release(services, view.name, viewer.account)}
    template = {"lock": "robot_lock.html", "actions": "robot_actions.html"}.get(part, "robot_facts.html")
    return render_page(request, viewer, template, data | _about(services, view, viewer))


@router.post("/robots/{name}/stop")
async def stop(
    request: Request, services: AppServices, viewer: AnyViewer, name: str, form: Annotated[ButtonForm, Form()]
) -> Response:
    """Every signed-in account may, without any limit, whatever the robot's agent last published."""
    await actions.stop(services, name, form.sender(viewer))
    return _stop_sent(request, viewer, name, "stop", form)


@router.post("/robots/{name}/estop")
async def emergency_stop(
    request: Request, services: AppServices, viewer: AnyViewer, name: str, form: Annotated[ButtonForm, Form()]
) -> Response:
    """As `stop`; also locks the robot."""
    await actions.emergency_stop(services, name, form.sender(viewer))
    return _stop_sent(request, viewer, name, "estop", form)


def _stop_sent(request: Request, viewer: Viewer, name: str, action: str, form: ButtonForm) -> Response:
    if request.headers.get("x-live"):
        return Response(status_code=204)
    return redirect(with_receipt(own_path(form.back, f"/robots/{name}"), viewer, action, name))


@router.get("/robots/{name}/release")
async def release_form(request: Request, viewer: ReadingViewer, name: str) -> Response:
    return _confirm(request, viewer, name, "release")


@router.post("/robots/{name}/release")
async def release(services: AppServices, viewer: AnyViewer, name: str, form: SentForm) -> Response:
    return await _press(services, viewer, name, form, "release", actions.release)


@router.get("/robots/{name}/home")
async def home_form(request: Request, viewer: ReadingViewer, name: str) -> Response:
    return _confirm(request, viewer, name, "home")


@router.post("/robots/{name}/home")
async def home(services: AppServices, viewer: AnyViewer, name: str, form: SentForm) -> Response:
    return await _press(services, viewer, name, form, "home", actions.home)


def _confirm(request: Request, viewer: Viewer, name: str, action: str) -> Response:
    """Ask for confirmation, so that a slip of the finger cannot let a robot move."""
    services = get_services(request)
    actions.check_owner(services, name, access.account_of(viewer))
    robot = robot_view.robot(services, name)[1]
    heading = f"Set the home of @{robot.name} where it stands?"
    if action == "release":
        heading = f"Release @{robot.name}?" if robot.lock else f"@{robot.name} is not locked"
    data = {"robot": robot, "action": action, "heading": heading}
    return render_page(request, viewer, "robot_owner.html", data, here="robots")


async def _press(services: Services, viewer: Viewer, name: str, form: PageForm, action: str, press: Press) -> Response:
    """Press an owner's button and wait a moment for the result, so that the following page shows it."""
    presence, before = services.presence, services.presence.robot(name).card.get("last_action")
    await press(services, name, form.sender(viewer))
    for _ in range(HEARD_TRIES):
        if presence.robot(name).card.get("last_action") != before:
            return redirect(f"/robots/{name}")
        await asyncio.sleep(HEARD_S)
    return redirect(with_receipt(f"/robots/{name}", viewer, action, name))


@router.get("/robots/{name}/reset")
async def reset_form(request: Request, services: AppServices, viewer: ReadingViewer, name: str) -> Response:
    actions.check_resets(services, name, access.account_of(viewer))
    robot = robot_view.robot(services, name)[1]
    data = {"robot": robot, "action": "reset", "heading": f"Reset the room of @{robot.name}?"}
    return render_page(request, viewer, "robot_owner.html", data, here="robots")


@router.post("/robots/{name}/reset")
async def reset(services: AppServices, viewer: AnyViewer, name: str, form: SentForm) -> Response:
    await actions.reset(services, name, form.sender(viewer))
    return redirect(with_receipt(f"/robots/{name}", viewer, "reset", name))


@router.get("/schedules")
async def all_schedules(request: Request, services: AppServices, viewer: ReadingViewer, part: str = "") -> Response:
    """The schedules of all robots. `part` is `list` for the list alone."""
    data = {"robot": None, "schedules": schedules.of_all(services, viewer.account), "key": forms.nonce()}
    template = "schedules_list.html" if part == "list" else "schedules.html"
    return render_page(request, viewer, template, data, here="robots")


@router.get("/robots/{name}/schedules")
async def robot_schedules(
    request: Request, services: AppServices, viewer: ReadingViewer, name: str, part: str = ""
) -> Response:
    """As `/schedules`, for one robot."""
    view = robot_view.robot(services, name)[1]
    data = {"robot": view, "schedules": schedules.of_robot(services, name, viewer.account), "key": forms.nonce()}
    template = "schedules_list.html" if part == "list" else "schedules.html"
    return render_page(request, viewer, template, data, here="robots")


class CancelForm(KeyedForm):
    """Cancels the schedule of a robot."""

    robot: Line = ""
    back: str = ""


@router.post("/schedules/{post_id}/cancel")
async def cancel_schedule(
    services: AppServices, viewer: AnyViewer, post_id: str, form: Annotated[CancelForm, Form()]
) -> Response:
    """Cancel a schedule, by a reply to its post."""
    by = form.sender(viewer)
    await schedules.cancel(services, by, post_id, form.robot, form.idempotency_key(post_id, form.robot))
    return redirect(with_receipt(own_path(form.back, "/schedules"), viewer, "cancel", form.robot))


@router.get("/u/{name}")
async def person(request: Request, services: AppServices, viewer: ReadingViewer, name: str) -> Response:
    store = services.store
    found = store.reader.account(name)
    if found is None:
        raise BoardError(404, "no_such_account", f"there is no account {name[:64]!r}")
    if found.kind is AccountKind.ROBOT_AGENT:
        return redirect(f"/robots/{found.name}")
    mine = viewer.account is not None and viewer.account.id == found.id
    latest = _latest(store, found)
    data = {"account": found, "mine": mine, "latest": latest, "has_password": access.has_password(services, found)}
    return render_page(request, viewer, "account.html", data, here="me" if mine else "")


# ------------------------------------------------------------------ pieces
def _latest(store: Store, author: Account, *, once: bool = False) -> list[tuple[Topic, StoredPost]]:
    """An account's latest posts, each with its topic; with `once` only the latest one of each topic."""
    posts = store.reader.posts_by(author, 5 * _LATEST if once else _LATEST)
    newest: dict[str, StoredPost] = {}
    for post in posts:
        newest.setdefault(post.topic_id if once else post.id, post)
    return [(store.reader.topic(post.topic_id), post) for post in list(newest.values())[:_LATEST]]


def _about(services: Services, view: RobotView, viewer: Viewer) -> dict[str, Any]:
    """The forum's facts about a robot: its owner, its queue and the commands that wait for approval, as far as the
    viewer may see them."""
    posts = {post.id: post for post in services.store.reader.posts_by_id([int(i) for i in view.line])}
    line = [posts[i] for i in view.line if i in posts and not posts[i].removed]
    robots = [actions.known_robot(services, view.name)]
    asking = [one for post in line for one in approvals.waiting(services, post, robots, viewer.account)]
    about: dict[str, Any] = {
        "owner": actions.owner_of(services, view.name),
        "line": line,
        "schedules": schedules.of_robot(services, view.name, viewer.account),
        "abilities": abilities_of(view.name, view.can, sees=bool(view.sees)),
    }
    about["moves"] = front.robot_now(services, view, viewer.account, pictures=False).moves
    return about | {"waiting": asking, "key": forms.nonce()}
