"""Pages for admins and robots' owners: forms that work without scripts and do what the API does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fastapi import APIRouter, Request
from starlette.datastructures import FormData
from starlette.responses import HTMLResponse, Response

from agentrob.board.admin import audit, management
from agentrob.board.admin.moderation import erase_content
from agentrob.board.auth import access
from agentrob.board.auth.access import AnyViewer, ReadingViewer, Viewer
from agentrob.board.db.records import Board
from agentrob.board.robots import rights
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import AppServices, Services, get_services
from agentrob.board.web import forms
from agentrob.board.web.templating import go
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

_PAGE = 50
_BOARD_ROLES = ("read_role", "post_role", "command_role")
_EMPTY = {"name": "", "display_name": "", "role": "member", "kind": "human"}


# -------------------------------------------------------------------- accounts
@router.get("/admin")
async def start(viewer: ReadingViewer) -> Response:
    forms.admin_of(viewer)
    return go("/admin/accounts")


@router.get("/admin/accounts")
async def accounts(request: Request, viewer: ReadingViewer, after: str = "") -> Response:
    forms.admin_of(viewer)
    return _accounts(request, viewer, after)


@router.post("/admin/accounts")
async def add_account(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.ADMIN)
    name, kind = forms.stripped(form, "name").lower(), forms.one_of(AccountKind, forms.stripped(form, "kind"))
    role, shown = forms.one_of(Role, forms.stripped(form, "role")), forms.stripped(form, "display_name")

    def add(t: Any) -> tuple[str, str]:
        made = management.add_account(t.connection, by.name, name, kind=kind, role=role, display_name=shown)
        if kind is AccountKind.HUMAN:
            return made.name, management.link(t.connection, by.name, made.name, "password")
        return made.name, management.add_token(t.connection, by.name, made.name, "", ("read", "write"))

    try:
        made, secret = await services.store.do(add)
    except BoardError as e:
        return _accounts(request, viewer, "", e, dict(form))
    what = "A link that sets the password" if kind is AccountKind.HUMAN else "The token"
    return forms.secret_page(request, viewer, f"/admin/accounts/{made}", f"{what} of @{made}", secret)


@router.get("/admin/accounts/{name}")
async def account(request: Request, viewer: ReadingViewer, name: str) -> Response:
    forms.admin_of(viewer)
    return _account(request, viewer, name)


@router.post("/admin/accounts/{name}/{deed}")
async def change_account(request: Request, services: AppServices, viewer: AnyViewer, name: str, deed: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.ADMIN)
    try:
        return await _change_account(request, services, viewer, by, name, deed, form)
    except BoardError as e:
        if e.code in ("no_such_account", "no_such_page"):
            raise
        return _account(request, viewer, name, e)


async def _change_account(
    request: Request, services: Services, viewer: Viewer, by: Account, name: str, deed: str, form: FormData
) -> Response:
    page = f"/admin/accounts/{name}"
    match deed:
        case "change":
            role, shown = forms.one_of(Role, forms.stripped(form, "role")), forms.stripped(form, "display_name")
            changes: dict[str, Any] = {"role": role, "display_name": shown, "suspended": "suspended" in form}
            await services.store.do(lambda t: management.change_account(t.connection, by.name, name, **changes))
        case "enter" | "password":
            path = await services.store.do(lambda t: management.link(t.connection, by.name, name, deed))
            what = "that signs in" if deed == "enter" else "that sets a new password"
            return forms.secret_page(request, viewer, page, f"A link {what}, once, for @{name}", path)
        case "sign-out":
            await services.store.do(lambda t: management.sign_out_everywhere(t.connection, by.name, name))
        case "token":
            scopes = tuple(s for s in ("read", "write", "admin") if s == "read" or s in form)
            label = forms.stripped(form, "label")
            token = await services.store.do(lambda t: management.add_token(t.connection, by.name, name, label, scopes))
            return forms.secret_page(request, viewer, page, f"A token of @{name}", token)
        case "revoke":
            token_id = forms.stripped(form, "token")
            await services.store.do(lambda t: management.revoke_token(t.connection, by.name, token_id))
        case "erase":
            if forms.stripped(form, "sure") != name:
                raise BoardError(422, "not_sure", "nothing was deleted", f"type {name} to delete all it wrote")
            await erase_content(services, by.name, name)
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
async def add_board(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.ADMIN)
    try:
        board = Board(forms.stripped(form, "id"), **_board_fields(form))
        await services.store.do(lambda t: management.add_board(t.connection, by.name, board))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


@router.post("/admin/boards/{board_id}")
async def change_board(request: Request, services: AppServices, viewer: AnyViewer, board_id: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.ADMIN)
    try:
        fields = _board_fields(form)
        await services.store.do(lambda t: management.change_board(t.connection, by.name, board_id, **fields))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


def _board_fields(form: FormData) -> dict[str, Any]:
    roles = {
        name: forms.one_of(Role, forms.stripped(form, name)) for name in ("read_role", "post_role", "command_role")
    }
    return {"name": forms.stripped(form, "name"), "description": forms.stripped(form, "description")} | roles


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
    _robot_of(services, access.account_of(viewer), name)
    return _robot(request, viewer, name)


@router.post("/admin/robots/{name}")
async def change_robot(request: Request, services: AppServices, viewer: AnyViewer, name: str) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.GUEST)
    _robot_of(services, by, name)
    try:
        changes = _robot_fields(form)
        if by.role is Role.ADMIN:
            changes["owner"] = forms.stripped(form, "owner").removeprefix("@").lower()
        await services.store.do(lambda t: management.change_robot(t.connection, by.name, name, **changes))
    except BoardError as e:
        return _robot(request, viewer, name, e, forms.stripped(form, "closed"))
    return go(f"/admin/robots/{name}")


def _robot_fields(form: FormData) -> dict[str, Any]:
    return {
        "command": {str(c): forms.stripped(form, f"command_{c}") for c in ActionClass},
        "approval": tuple(str(c) for c in ActionClass if f"approval_{c}" in form),
        "approve_own": "approve_own" in form,
        "approve": forms.stripped(form, "approve"),
        "release": forms.stripped(form, "release"),
        "camera_role": forms.one_of(Role, forms.stripped(form, "camera_role")),
        "camera_days": forms.number(form, "camera_days"),
        "closed": rights.hours_from_words(forms.stripped(form, "closed")),
    }


def _robot_of(services: Services, by: Account, name: str) -> None:
    access.check_robot_owner(by, rights.settings_of(services.store.reader, known_robot(services, name).name).owner)


def _robot(
    request: Request, viewer: Viewer, name: str, error: BoardError | None = None, typed: str | None = None
) -> Response:
    kept = rights.settings_of(get_services(request).store.reader, name)
    data = {"robot": name, "kept": kept, "hours": rights.hours_in_words(kept.closed) if typed is None else typed}
    return forms.admin_page(request, viewer, "admin_robot.html", "robots", data, error)


# -------------------------------------------------------------------- invites and the log
@router.get("/admin/invites")
async def invites(request: Request, viewer: ReadingViewer) -> Response:
    forms.admin_of(viewer)
    return _invites(request, viewer)


@router.post("/admin/invites")
async def invite(request: Request, services: AppServices, viewer: AnyViewer) -> Response:
    form, by = await forms.sent_by(request, viewer, Role.ADMIN)
    try:
        if revoked := forms.stripped(form, "revoke"):
            await services.store.do(lambda t: management.revoke_invite(t.connection, by.name, revoked))
            return go("/admin/invites")
        uses, days = forms.number(form, "uses"), forms.number(form, "days")
        role = forms.one_of(Role, forms.stripped(form, "role"))
        path = await services.store.do(lambda t: management.invite(t.connection, by.name, role, uses, days, by))
    except BoardError as e:
        return _invites(request, viewer, e)
    return forms.secret_page(request, viewer, "/admin/invites", f"An invite for {uses}, as {role}", path)


def _invites(request: Request, viewer: Viewer, error: BoardError | None = None) -> Response:
    found = management.invites(get_services(request).store.reader)
    return forms.admin_page(request, viewer, "admin_invites.html", "invites", {"invites": found}, error)


@router.get("/admin/audit")
async def audit_log(
    request: Request, services: AppServices, viewer: ReadingViewer, after: str | None = None, target: str = ""
) -> Response:
    forms.admin_of(viewer)
    found, more = audit.page(services.store.reader, after, _PAGE, target[:80])
    data = {"entries": found, "more": more, "target": target[:80]}
    return forms.admin_page(request, viewer, "admin_audit.html", "audit", data)
