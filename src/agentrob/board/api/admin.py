"""The JSON API's administration: accounts, tokens, invites, boards, robots, the audit log; all of it is logged."""

from __future__ import annotations

import asyncio
from collections.abc import Collection, Sequence
from typing import Annotated, Any

import structlog
from fastapi import APIRouter, Depends, Query, Request
from starlette.responses import Response

from agentrob.board.admin import audit, management, moderation
from agentrob.board.api.admin_models import (
    AccountChange,
    AccountIn,
    AuditOut,
    BoardChange,
    BoardIn,
    BoardRights,
    Erased,
    InviteIn,
    InviteOut,
    LinkIn,
    LinkOut,
    RobotChange,
    RobotSettingsOut,
    TokenIn,
    TokenOut,
    TokenWritten,
    audit_out,
    board_rights,
    invite_out,
    robot_settings_out,
    token_out,
)
from agentrob.board.api.forum import Cursor, Limit, out
from agentrob.board.api.models import AccountOut, Items, Paged, account_out
from agentrob.board.api.problem import documented
from agentrob.board.auth.access import administrator, member
from agentrob.board.db.cursors import from_cursor, to_cursor
from agentrob.board.db.writer import Job, T
from agentrob.board.robots import rights
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

log = structlog.get_logger(__name__)
router = APIRouter(prefix="/api/v1/admin", responses=documented(404, 409))
Admin = Annotated[Account, Depends(administrator)]
Writer = Annotated[Account, Depends(member)]


async def _do(request: Request, job: Job[T]) -> T:
    return await get_services(request).store.do(job)


# -------------------------------------------------------------------- accounts
@router.get("/accounts", response_model=Paged[AccountOut])
async def accounts(request: Request, by: Admin, after: str = "", limit: Limit = 50) -> Response:
    """All accounts by name; `next` is the `after` of the next page."""
    found = management.all_accounts(get_services(request).store.reader, after, limit + 1)
    more = found[limit - 1].name if len(found) > limit else None
    return out(Paged(items=tuple(map(account_out, found[:limit])), next=more))


@router.post("/accounts", response_model=AccountOut, status_code=201)
async def add_account(request: Request, new: AccountIn, by: Admin) -> Response:
    """A new account, without a password: give a link (people) or a token (programs)."""
    made = await _do(
        request,
        lambda t: management.add_account(
            t.connection, by.name, new.name, kind=new.kind, role=new.role, display_name=new.display_name
        ),
    )
    return out(account_out(made), 201)


@router.patch("/accounts/{name}", response_model=AccountOut)
async def change_account(request: Request, name: str, new: AccountChange, by: Admin) -> Response:
    """Another role or display name, suspended or let in again."""
    changes: dict[str, Any] = new.given()
    changed = await _do(request, lambda t: management.change_account(t.connection, by.name, name, **changes))
    return out(account_out(changed))


@router.post("/accounts/{name}/link", response_model=LinkOut, status_code=201)
async def link(request: Request, name: str, new: LinkIn, by: Admin) -> Response:
    """A one-time link that signs in, or that sets a new password when it was forgotten."""
    path = await _do(request, lambda t: management.link(t.connection, by.name, name, new.purpose))
    return out(LinkOut(url=get_services(request).settings.base_url + path), 201)


@router.post("/accounts/{name}/sign-out", response_model=AccountOut)
async def sign_out(request: Request, name: str, by: Admin) -> Response:
    """End all sessions of an account; its tokens stay."""
    await _do(request, lambda t: management.sign_out_everywhere(t.connection, by.name, name))
    return out(account_out(management.account_named(get_services(request).store.reader.connection, name)))


@router.delete("/accounts/{name}/content", response_model=Erased)
async def erase(request: Request, name: str, by: Admin) -> Response:
    """Delete for good all that an account wrote and uploaded. The account itself stays."""
    posts, pictures = await erase_content(get_services(request), by.name, name)
    return out(Erased(posts=posts, pictures=pictures))


async def erase_content(parts: Services, actor: str, name: str) -> tuple[int, int]:
    """Posts and pictures, and the files of these after the commit."""
    posts, pictures, digests = await parts.store.do(lambda t: moderation.erase(t, actor, name))
    await drop_files(parts, digests)
    return posts, pictures


# -------------------------------------------------------------------- tokens and invites
@router.get("/accounts/{name}/tokens", response_model=Items[TokenOut])
async def tokens(request: Request, name: str, by: Admin) -> Response:
    """An account's tokens, without their secrets."""
    reader = get_services(request).store.reader
    account = management.account_named(reader.connection, name)
    return out(Items(items=tuple(map(token_out, management.tokens(reader, account.name)))))


@router.post("/accounts/{name}/tokens", response_model=TokenWritten, status_code=201)
async def add_token(request: Request, name: str, new: TokenIn, by: Admin) -> Response:
    """A new token; this answer is the only place where it is ever shown."""
    scopes = tuple(new.scopes)
    secret = await _do(request, lambda t: management.add_token(t.connection, by.name, name, new.label, scopes))
    return out(TokenWritten(token=secret), 201)


@router.delete("/tokens/{token_id}", status_code=204)
async def revoke_token(request: Request, token_id: str, by: Admin) -> Response:
    """End a token at once."""
    await _do(request, lambda t: management.revoke_token(t.connection, by.name, token_id))
    return Response(status_code=204)


@router.get("/invites", response_model=Items[InviteOut])
async def invites(request: Request, by: Admin) -> Response:
    """Invites that can still be used, without their secrets."""
    found = management.invites(get_services(request).store.reader)
    return out(Items(items=tuple(map(invite_out, found))))


@router.post("/invites", response_model=LinkOut, status_code=201)
async def invite(request: Request, new: InviteIn, by: Admin) -> Response:
    """A link by which people make their own accounts."""
    path = await _do(
        request, lambda t: management.invite(t.connection, by.name, Role(new.role), new.uses, new.days, by)
    )
    return out(LinkOut(url=get_services(request).settings.base_url + path), 201)


@router.delete("/invites/{invite_id}", status_code=204)
async def revoke_invite(request: Request, invite_id: str, by: Admin) -> Response:
    """Nobody uses it any more."""
    await _do(request, lambda t: management.revoke_invite(t.connection, by.name, invite_id))
    return Response(status_code=204)


# -------------------------------------------------------------------- boards
@router.get("/boards", response_model=Items[BoardRights])
async def boards(request: Request, by: Admin) -> Response:
    """All boards, also those that few may read, with who may read, post and command."""
    return out(Items(items=tuple(map(board_rights, get_services(request).store.everything.all_boards()))))


@router.post("/boards", response_model=BoardRights, status_code=201)
async def add_board(request: Request, new: BoardIn, by: Admin) -> Response:
    """A new board."""
    made = await _do(request, lambda t: management.add_board(t.connection, by.name, new.record()))
    return out(board_rights(made), 201)


@router.patch("/boards/{board_id}", response_model=BoardRights)
async def change_board(request: Request, board_id: str, new: BoardChange, by: Admin) -> Response:
    """Another name, description, or who may read, post and command."""
    changes = new.given()
    changed = await _do(request, lambda t: management.change_board(t.connection, by.name, board_id, **changes))
    return out(board_rights(changed))


# -------------------------------------------------------------------- robots
@router.get("/robots/{name}", response_model=RobotSettingsOut)
async def robot(request: Request, name: str, by: Writer) -> Response:
    """What is kept of a robot: for admins and its owner."""
    parts = get_services(request)
    kept = rights.settings_of(parts.store.reader, known_robot(parts, name).name)
    check_owner(by, kept.owner)
    if by.name != kept.owner:
        await administrator(request)  # whose token has to be one for it
    return out(robot_settings_out(name, kept))


@router.patch("/robots/{name}", response_model=RobotSettingsOut)
async def change_robot(request: Request, name: str, new: RobotChange, by: Writer) -> Response:
    """Rights, camera and maintenance hours of a robot, by admins and its owner; another owner by admins only."""
    parts = get_services(request)
    kept = rights.settings_of(parts.store.reader, known_robot(parts, name).name)
    check_owner(by, kept.owner)
    if by.name != kept.owner:
        await administrator(request)  # whose token has to be one for it
    changes = new.changes(kept)
    if "owner" in changes and by.role is not Role.ADMIN:
        raise BoardError(403, "not_admin", "only an admin gives a robot to somebody else", "ask an admin")
    changed = await _do(request, lambda t: management.change_robot(t.connection, by.name, name, **changes))
    return out(robot_settings_out(name, changed))


def check_owner(by: Account, owner: str) -> None:
    """403 unless this is the robot's owner or an admin, and a person."""
    owns = by.role is Role.ADMIN or (bool(owner) and by.name == owner)
    if not owns or by.kind is not AccountKind.HUMAN:
        raise BoardError(403, "not_owner", "this is for the robot's owner and for admins", "ask an admin")


# -------------------------------------------------------------------- the audit log
@router.get("/audit", response_model=Paged[AuditOut])
async def audit_log(
    request: Request,
    by: Admin,
    cursor: Cursor = None,
    limit: Limit = 50,
    target: Annotated[str | None, Query(max_length=80)] = None,
) -> Response:
    """Who changed what, newest first; of one target such as `account:ann` or of all."""
    found, more = audit_page(get_services(request), cursor, limit, target)
    return out(Paged(items=tuple(map(audit_out, found)), next=more))


def audit_page(
    parts: Services, cursor: str | None, limit: int, target: str | None = None
) -> tuple[Sequence[audit.Entry], str | None]:
    """A page of the audit log, and the cursor of the next one."""
    before = from_cursor(cursor) if cursor else None
    rows = parts.store.reader.rows(audit.statement(before, limit + 1, target or None))
    more = to_cursor(rows[limit - 1].id) if len(rows) > limit else None
    return [audit.entry(r) for r in rows[:limit]], more


async def expire_pictures(parts: Services, every_s: float) -> None:
    """Delete what cameras saw longer ago than it is kept, now and again; until cancelled."""
    while True:
        try:
            await drop_files(parts, await parts.store.do(moderation.expire_pictures))
        except (BoardError, OSError) as e:
            log.error("board.pictures_not_expired", error=str(e))
        await asyncio.sleep(every_s)


async def drop_files(parts: Services, digests: Collection[str]) -> None:
    """Delete the files of pictures that are gone, unless another picture has the same content."""
    if digests:
        await parts.store.do(lambda t: moderation.take_away(t, parts.settings.images_dir, digests))
