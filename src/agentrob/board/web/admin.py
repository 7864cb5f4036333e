"""The pages of administrators and of robots' owners."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Form, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board import access
from agentrob.board.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.admin import management
from agentrob.board.admin.moderation import erase_content
from agentrob.board.auth import rights
from agentrob.board.db import audit
from agentrob.board.db.records import Board
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import AppServices, Services, get_services
from agentrob.board.web import forms
from agentrob.board.web.forms import Checkbox, Line, PageForm, Text
from agentrob.board.web.templating import redirect
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

_PAGE = 50


class NewAccountForm(PageForm):
    name: Line = ""
    kind: Line = "human"
    role: Line = "member"
    display_name: Line = ""


class AccountForm(PageForm):
    """The forms of an account's page; each sends some of these fields."""

    role: Line = ""
    display_name: Line = ""
    suspended: Checkbox = False
    commands_simulated: Checkbox = False
    label: Line = ""
    write: Checkbox = False
    admin: Checkbox = False
    token: Line = ""
    sure: Line = ""


class BoardForm(PageForm):
    id: Line = ""
    name: Line = ""
    description: Line = ""
    read_role: Line = ""
    post_role: Line = ""
    command_role: Line = ""

    @property
    def fields(self) -> dict[str, Any]:
        """The columns of the board. 422 for a role that does not exist."""
        roles = {name: forms.one_of(Role, getattr(self, name)) for name in ("read_role", "post_role", "command_role")}
        return {"name": self.name, "description": self.description} | roles


class RobotForm(PageForm):
    owner: Line = ""
    command_photo: Line = ""
    command_gesture: Line = ""
    command_move: Line = ""
    command_risky: Line = ""
    approval_photo: Checkbox = False
    approval_gesture: Checkbox = False
    approval_move: Checkbox = False
    approval_risky: Checkbox = False
    approve: Line = ""
    approve_own: Checkbox = False
    release: Line = ""
    camera_role: Line = ""
    camera_days: Line = ""
    closed: Text = ""

    @property
    def fields(self) -> dict[str, Any]:
        """Fields of `RobotSettings` except the owner. 422 for a wrong value."""
        return {
            "command": {str(c): getattr(self, f"command_{c}") for c in ActionClass},
            "approval": tuple(str(c) for c in ActionClass if getattr(self, f"approval_{c}")),
            "approve_own": self.approve_own,
            "approve": self.approve,
            "release": self.release,
            "camera_role": forms.one_of(Role, self.camera_role),
            "camera_days": forms.number(self.camera_days),
            "closed": rights.hours_from_words(self.closed),
        }


class InviteForm(PageForm):
    """`revoke` is the id of an invite to revoke; the others are those of a new one."""

    revoke: Line = ""
    role: Line = ""
    commands_simulated: Checkbox = False
    uses: Line = ""
    days: Line = ""


# -------------------------------------------------------------------- accounts
@router.get("/admin")
async def start(viewer: ReadingViewer) -> Response:
    forms.admin_of(viewer)
    return redirect("/admin/accounts")


@router.get("/admin/accounts")
async def accounts(request: Request, viewer: ReadingViewer, after: str = "") -> Response:
    forms.admin_of(viewer)
    return _accounts(request, viewer, after)


@router.post("/admin/accounts")
async def add_account(
    request: Request, services: AppServices, viewer: AnyViewer, form: Annotated[NewAccountForm, Form()]
) -> Response:
    by = form.sender(viewer, Role.ADMIN)

    def add(t: Any) -> tuple[Account, str]:
        kind, role = forms.one_of(AccountKind, form.kind), forms.one_of(Role, form.role)
        made = management.add_account(
            t.connection, by.name, form.name.lower(), kind=kind, role=role, display_name=form.display_name
        )
        if kind is AccountKind.HUMAN:
            return made, management.link(t.connection, by.name, made.name, "password")
        return made, management.add_token(t.connection, by.name, made.name, "", ("read", "write"))

    try:
        made, secret = await services.store.do(add)
    except BoardError as e:
        return _accounts(request, viewer, "", e, form)
    what = "A link that sets the password" if made.kind is AccountKind.HUMAN else "The token"
    return forms.secret_page(request, viewer, f"/admin/accounts/{made.name}", f"{what} of @{made.name}", secret)


@router.get("/admin/accounts/{name}")
async def account(request: Request, viewer: ReadingViewer, name: str) -> Response:
    forms.admin_of(viewer)
    return _account(request, viewer, name)


@router.post("/admin/accounts/{name}/{action}")
async def change_account(
    request: Request,
    services: AppServices,
    viewer: AnyViewer,
    name: str,
    action: str,
    form: Annotated[AccountForm, Form()],
) -> Response:
    by = form.sender(viewer, Role.ADMIN)
    try:
        return await _change_account(request, services, viewer, by, name, action, form)
    except BoardError as e:
        if e.code in ("no_such_account", "no_such_page"):
            raise
        return _account(request, viewer, name, e)


async def _change_account(
    request: Request, services: Services, viewer: Viewer, by: Account, name: str, action: str, form: AccountForm
) -> Response:
    page, do = f"/admin/accounts/{name}", services.store.do
    match action:
        case "change":
            role = forms.one_of(Role, form.role)
            changes: dict[str, Any] = {"role": role, "display_name": form.display_name, "suspended": form.suspended}
            changes["commands_simulated"] = form.commands_simulated
            await do(lambda t: management.change_account(t.connection, by.name, name, **changes))
        case "enter" | "password":
            path = await do(lambda t: management.link(t.connection, by.name, name, action))
            what = "that signs in" if action == "enter" else "that sets a new password"
            return forms.secret_page(request, viewer, page, f"A link {what}, once, for @{name}", path)
        case "sign-out":
            await do(lambda t: management.sign_out_everywhere(t.connection, by.name, name))
        case "token":
            scopes = ("read", *(["write"] if form.write else []), *(["admin"] if form.admin else []))
            token = await do(lambda t: management.add_token(t.connection, by.name, name, form.label, scopes))
            return forms.secret_page(request, viewer, page, f"A token of @{name}", token)
        case "revoke":
            await do(lambda t: management.revoke_token(t.connection, by.name, form.token))
        case "erase":
            if form.sure != name:
                raise BoardError(422, "not_sure", "nothing was deleted", f"type {name} to delete all its posts")
            await erase_content(services, by.name, name)
        case _:
            raise BoardError(404, "no_such_page", "this address does not exist")
    return redirect(page)


def _accounts(
    request: Request,
    viewer: Viewer,
    after: str,
    error: BoardError | None = None,
    draft: NewAccountForm | None = None,
) -> Response:
    found = management.all_accounts(get_services(request).store.reader, after, _PAGE + 1)
    more = found[_PAGE - 1].name if len(found) > _PAGE else ""
    data = {"accounts": found[:_PAGE], "more": more, "draft": draft or NewAccountForm()}
    return forms.admin_page(request, viewer, "admin_accounts.html", "accounts", data, error)


def _account(request: Request, viewer: Viewer, name: str, error: BoardError | None = None) -> Response:
    reader = get_services(request).store.reader
    found = management.account_named(reader.connection, name)
    data = {"account": found, "tokens": management.tokens(reader, found.name)}
    return forms.admin_page(request, viewer, "admin_account.html", "accounts", data, error)


# -------------------------------------------------------------------- boards
@router.get("/admin/boards")
async def boards(request: Request, viewer: ReadingViewer) -> Response:
    forms.admin_of(viewer)
    return _boards(request, viewer)


@router.post("/admin/boards")
async def add_board(
    request: Request, services: AppServices, viewer: AnyViewer, form: Annotated[BoardForm, Form()]
) -> Response:
    by = form.sender(viewer, Role.ADMIN)
    try:
        board = Board(form.id, **form.fields)
        await services.store.do(lambda t: management.add_board(t.connection, by.name, board))
    except BoardError as e:
        return _boards(request, viewer, e)
    return redirect("/admin/boards")


@router.post("/admin/boards/{board_id}")
async def change_board(
    request: Request, services: AppServices, viewer: AnyViewer, board_id: str, form: Annotated[BoardForm, Form()]
) -> Response:
    by = form.sender(viewer, Role.ADMIN)
    try:
        fields = form.fields
        await services.store.do(lambda t: management.change_board(t.connection, by.name, board_id, **fields))
    except BoardError as e:
        return _boards(request, viewer, e)
    return redirect("/admin/boards")


def _boards(request: Request, viewer: Viewer, error: BoardError | None = None) -> Response:
    data = {"boards": get_services(request).store.everything.all_boards(), "fresh": Board("", "")}
    return forms.admin_page(request, viewer, "admin_boards.html", "boards", data, error)


# -------------------------------------------------------------------- robots
@router.get("/admin/robots")
async def robots(request: Request, services: AppServices, viewer: ReadingViewer) -> Response:
    forms.admin_of(viewer)
    reader = services.store.reader
    found = [(a, rights.settings_of(reader, a.name)) for a in reader.robots()]
    return forms.admin_page(request, viewer, "admin_robots.html", "robots", {"robots": found})


@router.get("/admin/robots/{name}")
async def robot(request: Request, services: AppServices, viewer: ReadingViewer, name: str) -> Response:
    _check_owner(services, access.account_of(viewer), name)
    return _robot(request, viewer, name)


@router.post("/admin/robots/{name}")
async def change_robot(
    request: Request, services: AppServices, viewer: AnyViewer, name: str, form: Annotated[RobotForm, Form()]
) -> Response:
    by = form.sender(viewer)
    _check_owner(services, by, name)
    try:
        changes = form.fields
        if by.role is Role.ADMIN:
            changes["owner"] = form.owner.removeprefix("@").lower()
        await services.store.do(lambda t: management.change_robot(t.connection, by.name, name, **changes))
    except BoardError as e:
        return _robot(request, viewer, name, e, form.closed)
    return redirect(f"/admin/robots/{name}")


def _check_owner(services: Services, by: Account, name: str) -> None:
    access.check_robot_owner(by, rights.settings_of(services.store.reader, known_robot(services, name).name).owner)


def _robot(
    request: Request, viewer: Viewer, name: str, error: BoardError | None = None, typed: str | None = None
) -> Response:
    kept = rights.settings_of(get_services(request).store.reader, name)
    data = {"robot": name, "kept": kept, "hours": rights.hours_in_words(kept.closed) if typed is None else typed}
    return forms.admin_page(request, viewer, "admin_robot.html", "robots", data, error)


# -------------------------------------------------------------------- invites and the log
@router.get("/admin/invites")
async def invites(request: Request, viewer: ReadingViewer, simulated: bool = False) -> Response:
    """`simulated`: the form begins with an invite to command simulated robots."""
    forms.admin_of(viewer)
    return _invites(request, viewer, InviteForm(commands_simulated=simulated))


@router.post("/admin/invites")
async def invite(
    request: Request, services: AppServices, viewer: AnyViewer, form: Annotated[InviteForm, Form()]
) -> Response:
    by, do = form.sender(viewer, Role.ADMIN), services.store.do
    try:
        if form.revoke:
            await do(lambda t: management.revoke_invite(t.connection, by.name, form.revoke))
            return redirect("/admin/invites")
        role, uses, days = forms.one_of(Role, form.role), forms.number(form.uses), forms.number(form.days)
        simulated = form.commands_simulated
        path = await do(
            lambda t: management.invite(t.connection, by.name, role, uses, days, by, commands_simulated=simulated)
        )
    except BoardError as e:
        return _invites(request, viewer, form, e)
    what = f"An invite for {uses}, as {role}{', who may command simulated robots' if simulated else ''}"
    return forms.secret_page(request, viewer, "/admin/invites", what, path)


def _invites(request: Request, viewer: Viewer, draft: InviteForm, error: BoardError | None = None) -> Response:
    data = {"invites": management.invites(get_services(request).store.reader), "draft": draft}
    return forms.admin_page(request, viewer, "admin_invites.html", "invites", data, error)


@router.get("/admin/audit")
async def audit_log(
    request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None, target: str = ""
) -> Response:
    forms.admin_of(viewer)
    found, more = audit.page(services.store.reader, after, _PAGE, target[:80])
    data = {"entries": found, "more": more, "target": target[:80]}
    return forms.admin_page(request, viewer, "admin_audit.html", "audit", data)
