"""Pages for admins, moderators and robots' owners: forms that work without scripts and do what the API does."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from starlette.datastructures import FormData
from starlette.responses import HTMLResponse, Response

from agentrob.board import access, administration, moderation, rights
from agentrob.board.access import Viewer
from agentrob.board.api_admin import audit_page, check_owner, erase_content
from agentrob.board.buttons import known_robot
from agentrob.board.records import Board
from agentrob.board.services import Services, services
from agentrob.board.templating import go, hint_of, sentence, show
from agentrob.board.writer import Job, T
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)
Reading = Annotated[Viewer, Depends(access.reader)]
Anybody = Annotated[Viewer, Depends(access.viewer)]

_PAGE = 50
_EMPTY = {"name": "", "display_name": "", "role": "member", "kind": "human"}
_CLASSES = {"photo": "Photos", "gesture": "Gestures", "move": "Walking and turning", "risky": "Flips"}
_CHOICES: dict[str, Any] = {
    "all_roles": tuple(Role),
    "all_kinds": tuple(AccountKind),
    "who": rights.WHO,
    "classes": tuple((str(c), _CLASSES[c]) for c in ActionClass),
}


# -------------------------------------------------------------------- accounts
@router.get("/admin")
async def start(viewer: Reading) -> Response:
    _admin(viewer)
    return go("/admin/accounts")


@router.get("/admin/accounts")
async def accounts(request: Request, viewer: Reading, after: str = "") -> Response:
    _admin(viewer)
    return _accounts(request, viewer, after)


@router.post("/admin/accounts")
async def add_account(request: Request, viewer: Anybody) -> Response:
    form, by = await _sent(request, viewer, Role.ADMIN)
    name, kind = _field(form, "name").lower(), _one_of(AccountKind, _field(form, "kind"))
    role, shown = _one_of(Role, _field(form, "role")), _field(form, "display_name")

    def add(t: Any) -> tuple[str, str]:
        made = administration.add_account(t.connection, by.name, name, kind=kind, role=role, display_name=shown)
        if kind is AccountKind.HUMAN:
            return made.name, administration.link(t.connection, by.name, made.name, "password")
        return made.name, administration.add_token(t.connection, by.name, made.name, "", ("read", "write"))

    try:
        made, secret = await _do(request, add)
    except BoardError as e:
        return _accounts(request, viewer, "", e, dict(form))
    what = "A link that sets the password" if kind is AccountKind.HUMAN else "The token"
    return _told(request, viewer, f"/admin/accounts/{made}", f"{what} of @{made}", secret)


@router.get("/admin/accounts/{name}")
async def account(request: Request, viewer: Reading, name: str) -> Response:
    _admin(viewer)
    return _account(request, viewer, name)


@router.post("/admin/accounts/{name}/{deed}")
async def change_account(request: Request, viewer: Anybody, name: str, deed: str) -> Response:
    form, by = await _sent(request, viewer, Role.ADMIN)
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
            role, shown = _one_of(Role, _field(form, "role")), _field(form, "display_name")
            changes: dict[str, Any] = {"role": role, "display_name": shown, "suspended": "suspended" in form}
            await _do(request, lambda t: administration.change_account(t.connection, by.name, name, **changes))
        case "enter" | "password":
            path = await _do(request, lambda t: administration.link(t.connection, by.name, name, deed))
            what = "that signs in" if deed == "enter" else "that sets a new password"
            return _told(request, viewer, page, f"A link {what}, once, for @{name}", path)
        case "sign-out":
            await _do(request, lambda t: administration.sign_out_everywhere(t.connection, by.name, name))
        case "token":
            scopes = tuple(s for s in ("read", "write", "admin") if s == "read" or s in form)
            label = _field(form, "label")
            token = await _do(request, lambda t: administration.add_token(t.connection, by.name, name, label, scopes))
            return _told(request, viewer, page, f"A token of @{name}", token)
        case "revoke":
            token_id = _field(form, "token")
            await _do(request, lambda t: administration.revoke_token(t.connection, by.name, token_id))
        case "erase":
            if _field(form, "sure") != name:
                raise BoardError(422, "not_sure", "nothing was deleted", f"type {name} to delete all it wrote")
            await erase_content(services(request), by.name, name)
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
    found = administration.all_accounts(services(request).store.reader, after, _PAGE + 1)
    more = found[_PAGE - 1].name if len(found) > _PAGE else ""
    data = {"accounts": found[:_PAGE], "more": more, "draft": _EMPTY | dict(draft or {})}
    return _page(request, viewer, "admin_accounts.html", "accounts", data, error)


def _account(request: Request, viewer: Viewer, name: str, error: BoardError | None = None) -> Response:
    reader = services(request).store.reader
    found = administration.account_named(reader.connection, name)
    data = {"account": found, "tokens": administration.tokens(reader, found.name)}
    return _page(request, viewer, "admin_account.html", "accounts", data, error)


# -------------------------------------------------------------------- boards
@router.get("/admin/boards")
async def boards(request: Request, viewer: Reading) -> Response:
    _admin(viewer)
    return _boards(request, viewer)


@router.post("/admin/boards")
async def add_board(request: Request, viewer: Anybody) -> Response:
    form, by = await _sent(request, viewer, Role.ADMIN)
    try:
        board = Board(_field(form, "id"), **_board_fields(form))
        await _do(request, lambda t: administration.add_board(t.connection, by.name, board))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


@router.post("/admin/boards/{board_id}")
async def change_board(request: Request, viewer: Anybody, board_id: str) -> Response:
    form, by = await _sent(request, viewer, Role.ADMIN)
    try:
        fields = _board_fields(form)
        await _do(request, lambda t: administration.change_board(t.connection, by.name, board_id, **fields))
    except BoardError as e:
        return _boards(request, viewer, e)
    return go("/admin/boards")


def _board_fields(form: FormData) -> dict[str, Any]:
    roles = {name: _one_of(Role, _field(form, name)) for name in ("read_role", "post_role", "command_role")}
    return {"name": _field(form, "name"), "description": _field(form, "description")} | roles


def _boards(request: Request, viewer: Viewer, error: BoardError | None = None) -> Response:
    data = {"boards": services(request).store.everything.all_boards(), "fresh": Board("", "")}
    return _page(request, viewer, "admin_boards.html", "boards", data, error)


# -------------------------------------------------------------------- robots
@router.get("/admin/robots")
async def robots(request: Request, viewer: Reading) -> Response:
    _admin(viewer)
    reader = services(request).store.reader
    found = [(a, rights.settings_of(reader, a.name)) for a in reader.robots()]
    return _page(request, viewer, "admin_robots.html", "robots", {"robots": found})


@router.get("/admin/robots/{name}")
async def robot(request: Request, viewer: Reading, name: str) -> Response:
    _robot_of(services(request), access.account_of(viewer), name)
    return _robot(request, viewer, name)


@router.post("/admin/robots/{name}")
async def change_robot(request: Request, viewer: Anybody, name: str) -> Response:
    form, by = await _sent(request, viewer, Role.GUEST)
    parts = services(request)
    _robot_of(parts, by, name)
    try:
        changes = _robot_fields(form)
        if by.role is Role.ADMIN:
            changes["owner"] = _field(form, "owner").removeprefix("@").lower()
        await _do(request, lambda t: administration.change_robot(t.connection, by.name, name, **changes))
    except BoardError as e:
        return _robot(request, viewer, name, e)
    return go(f"/admin/robots/{name}")


def _robot_fields(form: FormData) -> dict[str, Any]:
    return {
        "command": {str(c): _field(form, f"command_{c}") for c in ActionClass},
        "approval": tuple(str(c) for c in ActionClass if f"approval_{c}" in form),
        "approve": _field(form, "approve"),
        "release": _field(form, "release"),
        "camera_role": _one_of(Role, _field(form, "camera_role")),
        "camera_days": _number(form, "camera_days"),
        "closed": rights.hours_from_words(_field(form, "closed")),
    }


def _robot_of(parts: Services, by: Account, name: str) -> None:
    check_owner(by, rights.settings_of(parts.store.reader, known_robot(parts, name).name).owner)


def _robot(request: Request, viewer: Viewer, name: str, error: BoardError | None = None) -> Response:
    kept = rights.settings_of(services(request).store.reader, name)
    data = {"robot": name, "kept": kept, "hours": rights.hours_in_words(kept.closed)}
    return _page(request, viewer, "admin_robot.html", "robots", data, error)


# -------------------------------------------------------------------- invites and the log
@router.get("/admin/invites")
async def invites(request: Request, viewer: Reading) -> Response:
    _admin(viewer)
    found = administration.invites(services(request).store.reader)
    return _page(request, viewer, "admin_invites.html", "invites", {"invites": found})


@router.post("/admin/invites")
async def invite(request: Request, viewer: Anybody) -> Response:
    form, by = await _sent(request, viewer, Role.ADMIN)
    if revoked := _field(form, "revoke"):
        await _do(request, lambda t: administration.revoke_invite(t.connection, by.name, revoked))
        return go("/admin/invites")
    uses, days = _number(form, "uses"), _number(form, "days")
    role = _one_of(Role, _field(form, "role"))
    path = await _do(request, lambda t: administration.invite(t.connection, by.name, role, uses, days, by))
    return _told(request, viewer, "/admin/invites", f"An invite for {uses}, as {role}", path)


@router.get("/admin/audit")
async def audit_log(request: Request, viewer: Reading, after: str | None = None, target: str = "") -> Response:
    _admin(viewer)
    found, more = audit_page(services(request), after, _PAGE, target[:80])
    data = {"entries": found, "more": more, "target": target[:80]}
    return _page(request, viewer, "admin_audit.html", "audit", data)


# -------------------------------------------------------------------- moderation
@router.get("/t/{topic_id}/moderate")
async def moderate_topic(request: Request, viewer: Reading, topic_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    store = services(request).store
    return show(request, viewer, "moderate.html", {"topic": store.topic(topic_id), "boards": store.boards()})


@router.post("/t/{topic_id}/{deed}")
async def change_topic(request: Request, viewer: Anybody, topic_id: str, deed: str) -> Response:
    form, by = await _sent(request, viewer, Role.MODERATOR)
    store = services(request).store
    store.topic(topic_id)
    reason = _field(form, "reason")[:200]
    if deed == "lock":
        locked = "locked" in form
        await store.do(lambda t: moderation.lock(t, by, topic_id, locked, reason))
    elif deed == "move":
        board_id = store.board(_field(form, "board")).id
        await store.do(lambda t: moderation.move(t, by, topic_id, board_id, reason))
    else:
        raise BoardError(404, "no_such_page", "there is nothing at this address")
    return go(f"/t/{topic_id}")


@router.get("/p/{post_id}/moderate")
async def moderate_post(request: Request, viewer: Reading, post_id: str) -> Response:
    access.has_role(access.account_of(viewer), Role.MODERATOR)
    post, versions, hidden_by = moderation.hidden(services(request).store.reader, post_id)
    return show(request, viewer, "moderate_post.html", {"post": post, "versions": versions, "hidden_by": hidden_by})


@router.post("/p/{post_id}/moderate")
async def change_post(request: Request, viewer: Anybody, post_id: str) -> Response:
    form, by = await _sent(request, viewer, Role.MODERATOR)
    store = services(request).store
    store.post(post_id)
    reason = _field(form, "reason")[:200]
    if "show" in form:
        await store.do(lambda t: moderation.show(t, by, post_id, reason))
    else:
        await store.remove(by, post_id, reason)
    return go(f"/p/{post_id}")


# -------------------------------------------------------------------- passwords and invites
@router.get("/invite/{secret}")
async def invited(request: Request, viewer: Anybody, secret: str) -> Response:
    """Shows a form only: a prefetch of the link uses nothing up."""
    return show(request, viewer, "invited.html", {"secret": secret, "draft": ""}, here="sign-in")


@router.post("/invite/{secret}")
async def accept_invite(request: Request, viewer: Anybody, secret: str) -> Response:
    form = await request.form(max_files=0)
    name, known = _field(form, "name"), services(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.sign_up(known, name, _password(form, "password"), _address(request), secret)
    except BoardError as e:
        data = {"secret": secret, "draft": name, "problem": _problem(e)}
        return show(request, viewer, "invited.html", data, status=e.status, here="sign-in")
    return _signed_in(known, session)


@router.get("/password/{secret}")
async def forgotten(request: Request, viewer: Anybody, secret: str) -> Response:
    return show(request, viewer, "password.html", {"action": f"/password/{secret}", "old": False}, here="sign-in")


@router.post("/password/{secret}")
async def reset_password(request: Request, viewer: Anybody, secret: str) -> Response:
    form, known = await request.form(max_files=0), services(request)
    try:
        access.check_form(viewer, form.get("csrf"))
        session = await access.new_password(known, secret, _password(form, "password"))
    except BoardError as e:
        data = {"action": f"/password/{secret}", "old": False, "problem": _problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="sign-in")
    return _signed_in(known, session)


@router.get("/password")
async def own_password(request: Request, viewer: Reading) -> Response:
    access.account_of(viewer)
    return show(request, viewer, "password.html", {"action": "/password", "old": True}, here="me")


@router.post("/password")
async def change_password(request: Request, viewer: Anybody) -> Response:
    form, by = await _sent(request, viewer, Role.GUEST)
    known, old, new = services(request), _password(form, "old"), _password(form, "password")
    try:
        session = await access.change_password(known, by, old, new, _address(request))
    except BoardError as e:
        data = {"action": "/password", "old": True, "problem": _problem(e)}
        return show(request, viewer, "password.html", data, status=e.status, here="me")
    return _signed_in(known, session)


def _signed_in(known: Services, session: str) -> Response:
    response = go("/")
    access.set_session(response, known, session)
    return response


# -------------------------------------------------------------------- pieces
def _admin(viewer: Viewer) -> Account:
    return access.has_role(access.account_of(viewer), Role.ADMIN)


async def _sent(request: Request, viewer: Viewer, role: Role) -> tuple[FormData, Account]:
    """The form, once its token is right, and who sent it when that has the role."""
    form = await request.form(max_files=0)
    access.check_form(viewer, form.get("csrf"))
    account = access.account_of(viewer)
    return form, account if role is Role.GUEST else access.has_role(account, role)


async def _do(request: Request, job: Job[T]) -> T:
    return await services(request).store.do(job)


def _page(
    request: Request,
    viewer: Viewer,
    template: str,
    tab: str,
    data: Mapping[str, Any],
    error: BoardError | None = None,
) -> Response:
    frame = {"tab": tab, "problem": _problem(error), **_CHOICES, **data}
    return show(request, viewer, template, frame, status=error.status if error else 200, here="admin")


def _told(request: Request, viewer: Viewer, back: str, what: str, secret: str) -> Response:
    """A secret, shown this once. A path is shown as an address."""
    shown = services(request).settings.base_url + secret if secret.startswith("/") else secret
    data = {"tab": "", "what": what, "secret": shown, "back": back}
    response = show(request, viewer, "admin_told.html", data, here="admin")
    response.headers["Cache-Control"] = "no-store"
    return response


def _problem(error: BoardError | None) -> str:
    return f"{sentence(str(error))} {sentence(hint_of(error))}".strip() if error else ""


def _field(form: FormData, name: str) -> str:
    value = form.get(name)
    return value.replace("\r\n", "\n").strip() if isinstance(value, str) else ""


def _number(form: FormData, name: str) -> int:
    text = _field(form, name)
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise BoardError(422, "bad_number", f"{text[:20]!r} is no number", "digits only")
    return int(text)


def _password(form: FormData, name: str) -> str:
    value = form.get(name)
    return value if isinstance(value, str) else ""


def _address(request: Request) -> str:
    return request.client.host if request.client else ""


def _one_of(kind: type[T], word: str) -> T:
    """A word of an enumeration; 422 for any other."""
    known = [str(k) for k in kind]  # type: ignore[attr-defined]
    if word not in known:
        raise BoardError(422, "bad_choice", f"{word[:40]!r} is no choice", ", ".join(known))
    return kind(word)  # type: ignore[call-arg]
