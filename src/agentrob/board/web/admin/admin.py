"""Pages for admins and robots' owners: forms that work without scripts and do what the API does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from starlette.datastructures import FormData
from starlette.responses import HTMLResponse, Response

from agentrob.board.admin import audit, management
from agentrob.board.admin.moderation import erase_content
from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.db.records import Board
from agentrob.board.robots import rights
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import Services, get_services
from agentrob.board.web.admin import forms
from agentrob.board.web.templating import go
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]

_PAGE = 50
_EMPTY = {"name": "", "display_name": "", "role": "member", "kind": "human"}


# -------------------------------------------------------------------- accounts
@router.get("/admin")
async def start(viewer: Reading) -> Response:
    forms.admin_of(viewer)
    return go("/admin/accounts")


@router.get("/admin/accounts")
async def accounts(request: Request, viewer: Reading, after: str = "") -> Response:
    forms.admin_of(viewer)
    return _accounts(request, viewer, after)


@router.post("/admin/accounts")
async def add_account(request: Request, viewer: Anybody) -> Response:
    form, by = await forms.sent(request, viewer, Role.ADMIN)
    name, kind = forms.field(form, "name").lower(), forms.one_of(AccountKind, forms.field(form, "kind"))
    role, shown = forms.one_of(Role, forms.field(form, "role")), forms.field(form, "display_name")

    def add(t: Any) -> tuple[str, str]:
        made = management.add_account(t.connection, by.name, name, kind=kind, role=role, display_name=shown)
        if kind is AccountKind.HUMAN:
            return made.name, management.link(t.connection, by.name, made.name, "password")
        return made.name, management.add_token(t.connection, by.name, made.name, "", ("read", "write"))

    try:
        made, secret = await forms.do(request, add)
    except BoardError as e:
        return _accounts(request, viewer, "", e, dict(form))
    what = "A link that sets the password" if kind is AccountKind.HUMAN else "The token"
    return forms.told(request, viewer, f"/admin/accounts/{made}", f"{what} of @{made}", secret)


@router.get("/admin/accounts/{name}")
async def account(request: Request, viewer: Reading, name: str) -> Response:
    forms.admin_of(viewer)
    return _account(request, viewer, name)


@router.post("/admin/accounts/{name}/{deed}")
async def change_account(request: Request, viewer: Anybody, name: str, deed: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.ADMIN)
    try:
        return await _change_account(request, viewer, by, name, deed, form)
    except BoardError as e:
        if e.code in ("no_such_account", "no_such_page"):
            raise
        return _account(request, viewer, name, e)


async def _change_account(
    request: Request, viewer: Viewer, by: Account, name: str, deed: str, form: FormData
) -> Response:
    page = f"/admin/accounts/{name}"
    match deed:
        case "change":
            role, shown = forms.one_of(Role, forms.field(form, "role")), forms.field(form, "display_name")
            changes: dict[str, Any] = {"role": role, "display_name": shown, "suspended": "suspended" in form}
            await forms.do(request, lambda t: management.change_account(t.connection, by.name, name, **changes))
        case "enter" | "password":
            path = await forms.do(request, lambda t: management.link(t.connection, by.name, name, deed))
            what = "that signs in" if deed == "enter" else "that sets a new password"
            return forms.told(request, viewer, page, f"A link {what}, once, for @{name}", path)
        case "sign-out":
            await forms.do(request, lambda t: management.sign_out_everywhere(t.connection, by.name, name))
        case "token":
            scopes = tuple(s for s in ("read", "write", "admin") if s == "read" or s in form)
            label = forms.field(form, "label")
            token = await forms.do(request, lambda t: management.add_token(t.connection, by.name, name, label, scopes))
            return forms.told(request, viewer, page, f"A token of @{name}", token)
        case "revoke":
            token_id = forms.field(form, "token")
            await forms.do(request, lambda t: management.revoke_token(t.connection, by.name, token_id))
        case "erase":
            if forms.field(form, "sure") != name:
                raise BoardError(422, "not_sure", "nothing was deleted", f"type {name} to delete all it wrote")
            await erase_content(get_services(request), by.name, name)
        case _:
            raise BoardError(404, "no_such_page", "there is nothing at this address")
    return go(page)


def _accounts(
    request: Request,
    viewer: Viewer,
    after: str,
    error: BoardError | None = None,
    draft: Mapping[str, Any] | None = None,
) -> Response:
    found = management.all_accounts(get_services(request).store.reader, after, _PAGE + 1)
    more = found[_PAGE - 1].name if len(found) > _PAGE else ""
    data = {"accounts": found[:_PAGE], "more": more, "draft": _EMPTY | dict(draft or {})}
    return forms.page(request, viewer, "admin_accounts.html", "accounts", data, error)


def _account(request: Request, viewer: Viewer, name: str, error: BoardError | None = None) -> Response:
    reader = get_services(request).store.reader
    found = management.account_named(reader.connection, name)
    data = {"account": found, "tokens": management.tokens(reader, found.name)}
    return forms.page(request, viewer, "admin_account.html", "accounts", data, error)


# -------------------------------------------------------------------- boards
@router.get("/admin/boards")
async def boards(request: Request, viewer: Reading) -> Response:
    forms.admin_of(viewer)
    return _boards(request, viewer)


@router.post("/admin/boards")
async def add_board(request: Request, viewer: Anybody) -> Response:
    form, by = await forms.sent(request, viewer, Role.ADMIN)
    try:
        board = Board(forms.field(form, "id"), **_board_fields(form))
        await forms.do(request, lambda t: management.add_board(t.connection, by.name, board))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


@router.post("/admin/boards/{board_id}")
async def change_board(request: Request, viewer: Anybody, board_id: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.ADMIN)
    try:
        fields = _board_fields(form)
        await forms.do(request, lambda t: management.change_board(t.connection, by.name, board_id, **fields))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


def _board_fields(form: FormData) -> dict[str, Any]:
    roles = {name: forms.one_of(Role, forms.field(form, name)) for name in ("read_role", "post_role", "command_role")}
    return {"name": forms.field(form, "name"), "description": forms.field(form, "description")} | roles


def _boards(request: Request, viewer: Viewer, error: BoardError | None = None) -> Response:
    data = {"boards": get_services(request).store.everything.all_boards(), "fresh": Board("", "")}
    return forms.page(request, viewer, "admin_boards.html", "boards", data, error)


# -------------------------------------------------------------------- robots
@router.get("/admin/robots")
async def robots(request: Request, viewer: Reading) -> Response:
    forms.admin_of(viewer)
    reader = get_services(request).store.reader
    found = [(a, rights.settings_of(reader, a.name)) for a in reader.robots()]
    return forms.page(request, viewer, "admin_robots.html", "robots", {"robots": found})


@router.get("/admin/robots/{name}")
async def robot(request: Request, viewer: Reading, name: str) -> Response:
    _robot_of(get_services(request), access.account_of(viewer), name)
    return _robot(request, viewer, name)


@router.post("/admin/robots/{name}")
async def change_robot(request: Request, viewer: Anybody, name: str) -> Response:
    form, by = await forms.sent(request, viewer, Role.GUEST)
    parts = get_services(request)
    _robot_of(parts, by, name)
    try:
        changes = _robot_fields(form)
        if by.role is Role.ADMIN:
            changes["owner"] = forms.field(form, "owner").removeprefix("@").lower()
        await forms.do(request, lambda t: management.change_robot(t.connection, by.name, name, **changes))
    except BoardError as e:
        return _robot(request, viewer, name, e, forms.field(form, "closed"))
    return go(f"/admin/robots/{name}")


def _robot_fields(form: FormData) -> dict[str, Any]:
    return {
        "command": {str(c): forms.field(form, f"command_{c}") for c in ActionClass},
        "approval": tuple(str(c) for c in ActionClass if f"approval_{c}" in form),
        "approve_own": "approve_own" in form,
        "approve": forms.field(form, "approve"),
        "release": forms.field(form, "release"),
        "camera_role": forms.one_of(Role, forms.field(form, "camera_role")),
        "camera_days": forms.number(form, "camera_days"),
        "closed": rights.hours_from_words(forms.field(form, "closed")),
    }


def _robot_of(parts: Services, by: Account, name: str) -> None:
    access.check_robot_owner(by, rights.settings_of(parts.store.reader, known_robot(parts, name).name).owner)


def _robot(
    request: Request, viewer: Viewer, name: str, error: BoardError | None = None, typed: str | None = None
) -> Response:
    kept = rights.settings_of(get_services(request).store.reader, name)
    data = {"robot": name, "kept": kept, "hours": rights.hours_in_words(kept.closed) if typed is None else typed}
    return forms.page(request, viewer, "admin_robot.html", "robots", data, error)


# -------------------------------------------------------------------- invites and the log
@router.get("/admin/invites")
async def invites(request: Request, viewer: Reading) -> Response:
    forms.admin_of(viewer)
    return _invites(request, viewer)


@router.post("/admin/invites")
async def invite(request: Request, viewer: Anybody) -> Response:
    form, by = await forms.sent(request, viewer, Role.ADMIN)
    try:
        if revoked := forms.field(form, "revoke"):
            await forms.do(request, lambda t: management.revoke_invite(t.connection, by.name, revoked))
            return go("/admin/invites")
        uses, days = forms.number(form, "uses"), forms.number(form, "days")
        role = forms.one_of(Role, forms.field(form, "role"))
        path = await forms.do(request, lambda t: management.invite(t.connection, by.name, role, uses, days, by))
    except BoardError as e:
        return _invites(request, viewer, e)
    return forms.told(request, viewer, "/admin/invites", f"An invite for {uses}, as {role}", path)


def _invites(request: Request, viewer: Viewer, error: BoardError | None = None) -> Response:
    found = management.invites(get_services(request).store.reader)
    return forms.page(request, viewer, "admin_invites.html", "invites", {"invites": found}, error)


@router.get("/admin/audit")
async def audit_log(request: Request, viewer: Reading, after: str | None = None, target: str = "") -> Response:
    forms.admin_of(viewer)
    found, more = audit.page(get_services(request).store.reader, after, _PAGE, target[:80])
    data = {"entries": found, "more": more, "target": target[:80]}
    return forms.page(request, viewer, "admin_audit.html", "audit", data)
