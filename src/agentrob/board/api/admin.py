"""The JSON API for administration: accounts, tokens, invites, boards, robots, the audit log. Every change is logged."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from starlette.responses import Response

from agentrob.board.access import Administrator, Member, administrator, check_robot_owner
from agentrob.board.admin import management, moderation
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
from agentrob.board.api.dependencies import Cursor, Limit, documented, json_response
from agentrob.board.api.models import AccountOut, Items, Paged, account_out
from agentrob.board.auth import rights
from agentrob.board.auth.rights import RobotSettings
from agentrob.board.db import audit
from agentrob.board.robots.actions import known_robot
from agentrob.board.services import AppServices, Services
from agentrob.errors import BoardError
from agentrob.model import Account, Role

router = APIRouter(prefix="/api/v1/admin", responses=documented(404, 409), tags=["administration"])
NameCursor = Annotated[str | None, Query(max_length=64, description="`next` of the previous page")]


# -------------------------------------------------------------------- accounts
@router.get("/accounts", response_model=Paged[AccountOut])
async def list_accounts(
    services: AppServices, by: Administrator, cursor: NameCursor = None, limit: Limit = 50
) -> Response:
    """All accounts, by name."""
    found = management.all_accounts(services.store.reader, cursor or "", limit + 1)
    more = found[limit - 1].name if len(found) > limit else None
    return json_response(Paged(items=tuple(map(account_out, found[:limit])), next=more))


@router.post("/accounts", response_model=AccountOut, status_code=201)
async def create_account(services: AppServices, new: AccountIn, by: Administrator) -> Response:
    """Create an account without a password; then create a link (for a person) or a token (for a program)."""
    made = await services.store.do(
        lambda t: management.add_account(
            t.connection, by.name, new.name, kind=new.kind, role=new.role, display_name=new.display_name
        ),
    )
    return json_response(account_out(made), 201)


@router.patch("/accounts/{name}", response_model=AccountOut)
async def update_account(services: AppServices, name: str, new: AccountChange, by: Administrator) -> Response:
    """Change role, right to command simulated robots or display name, suspend, or end a suspension."""
    changes: dict[str, Any] = new.given()
    changed = await services.store.do(lambda t: management.change_account(t.connection, by.name, name, **changes))
    return json_response(account_out(changed))


@router.post("/accounts/{name}/link", response_model=LinkOut, status_code=201)
async def create_account_link(services: AppServices, name: str, new: LinkIn, by: Administrator) -> Response:
    """Create a one-time link that signs in, or that sets a new password."""
    path = await services.store.do(lambda t: management.link(t.connection, by.name, name, new.purpose))
    return json_response(LinkOut(url=services.settings.base_url + path), 201)


@router.post("/accounts/{name}/sign-out", response_model=AccountOut)
async def sign_out_account(services: AppServices, name: str, by: Administrator) -> Response:
    """End all sessions of an account; its tokens stay."""
    await services.store.do(lambda t: management.sign_out_everywhere(t.connection, by.name, name))
    return json_response(account_out(management.account_named(services.store.reader.connection, name)))


@router.delete("/accounts/{name}/content", response_model=Erased)
async def erase_account_content(services: AppServices, name: str, by: Administrator) -> Response:
    """Delete all posts and pictures of an account for good. The account itself stays."""
    posts, pictures = await moderation.erase_content(services, by.name, name)
    return json_response(Erased(posts=posts, pictures=pictures))


# -------------------------------------------------------------------- tokens and invites
@router.get("/accounts/{name}/tokens", response_model=Items[TokenOut])
async def list_account_tokens(services: AppServices, name: str, by: Administrator) -> Response:
    """An account's tokens, without their secrets."""
    reader = services.store.reader
    account = management.account_named(reader.connection, name)
    return json_response(Items(items=tuple(map(token_out, management.tokens(reader, account.name)))))


@router.post("/accounts/{name}/tokens", response_model=TokenWritten, status_code=201)
async def create_account_token(services: AppServices, name: str, new: TokenIn, by: Administrator) -> Response:
    """Create a token; only this response shows it."""
    scopes = tuple(new.scopes)
    secret = await services.store.do(lambda t: management.add_token(t.connection, by.name, name, new.label, scopes))
    return json_response(TokenWritten(token=secret), 201)


@router.delete("/tokens/{token_id}", status_code=204)
async def revoke_token(services: AppServices, token_id: str, by: Administrator) -> Response:
    """Revoke a token."""
    await services.store.do(lambda t: management.revoke_token(t.connection, by.name, token_id))
    return Response(status_code=204)


@router.get("/invites", response_model=Items[InviteOut])
async def list_invites(services: AppServices, by: Administrator) -> Response:
    """Invites that can still be used, without their secrets."""
    found = management.invites(services.store.reader)
    return json_response(Items(items=tuple(map(invite_out, found))))


@router.post("/invites", response_model=LinkOut, status_code=201)
async def create_invite(services: AppServices, new: InviteIn, by: Administrator) -> Response:
    """Create a link with which people create their own accounts."""
    path = await services.store.do(
        lambda t: management.invite(
            t.connection, by.name, Role(new.role), new.uses, new.days, by, commands_simulated=new.commands_simulated
        )
    )
    return json_response(LinkOut(url=services.settings.base_url + path), 201)


@router.delete("/invites/{invite_id}", status_code=204)
async def revoke_invite(services: AppServices, invite_id: str, by: Administrator) -> Response:
    """Revoke an invite."""
    await services.store.do(lambda t: management.revoke_invite(t.connection, by.name, invite_id))
    return Response(status_code=204)


# -------------------------------------------------------------------- boards
@router.get("/boards", response_model=Items[BoardRights])
async def list_board_rights(services: AppServices, by: Administrator) -> Response:
    """All boards with the roles that may read, post and command."""
    return json_response(Items(items=tuple(map(board_rights, services.store.everything.all_boards()))))


@router.post("/boards", response_model=BoardRights, status_code=201)
async def create_board(services: AppServices, new: BoardIn, by: Administrator) -> Response:
    """Create a board."""
    made = await services.store.do(lambda t: management.add_board(t.connection, by.name, new.record()))
    return json_response(board_rights(made), 201)


@router.patch("/boards/{board_id}", response_model=BoardRights)
async def update_board(services: AppServices, board_id: str, new: BoardChange, by: Administrator) -> Response:
    """Change name, description, or the roles that may read, post and command."""
    changes = new.given()
    changed = await services.store.do(lambda t: management.change_board(t.connection, by.name, board_id, **changes))
    return json_response(board_rights(changed))


# -------------------------------------------------------------------- robots
@router.get("/robots/{name}", response_model=RobotSettingsOut)
async def get_robot_settings(request: Request, services: AppServices, name: str, by: Member) -> Response:
    """The settings of a robot, for its owner and for admins."""
    return json_response(robot_settings_out(name, await _settings_for(request, services, name, by)))


@router.patch("/robots/{name}", response_model=RobotSettingsOut)
async def update_robot_settings(
    request: Request, services: AppServices, name: str, new: RobotChange, by: Member
) -> Response:
    """Change rights, camera and maintenance hours of a robot, as its owner or an admin; only admins change the
    owner."""
    changes = new.changes(await _settings_for(request, services, name, by))
    if "owner" in changes and by.role is not Role.ADMIN:
        raise BoardError(403, "not_admin", "only an admin can change the owner of a robot", "ask an admin")
    changed = await services.store.do(lambda t: management.change_robot(t.connection, by.name, name, **changes))
    return json_response(robot_settings_out(name, changed))


async def _settings_for(request: Request, services: Services, name: str, by: Account) -> RobotSettings:
    """A robot's settings. 403 unless the caller owns it, or is an admin whose token has the scope for that."""
    kept = rights.settings_of(services.store.reader, known_robot(services, name).name)
    check_robot_owner(by, kept.owner)
    if by.name != kept.owner:
        await administrator(request)
    return kept


# -------------------------------------------------------------------- the audit log
@router.get("/audit", response_model=Paged[AuditOut])
async def list_audit_entries(
    services: AppServices,
    by: Administrator,
    cursor: Cursor = None,
    limit: Limit = 50,
    target: Annotated[str | None, Query(max_length=80)] = None,
) -> Response:
    """Who changed what, newest first; of one target such as `account:ann` or of all."""
    found, more = audit.page(services.store.reader, cursor, limit, target)
    return json_response(Paged(items=tuple(map(audit_out, found)), next=more))
