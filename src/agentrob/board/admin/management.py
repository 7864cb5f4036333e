"""Manage accounts, tokens, links, invites, boards and robots, for pages, API and command line.

Each change takes a connection within a transaction and the handle of its actor (`audit.SHELL` for the command line).
It adds a row to the audit log. Raises `BoardError` 404 for what does not exist, 409 for conflicts, 422 for invalid
values.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, and_, func, insert, select, update

from agentrob.board.auth import accounts, rights
from agentrob.board.auth.lookalike import check_display_name, check_name
from agentrob.board.auth.rights import RobotSettings
from agentrob.board.db import audit
from agentrob.board.db import schema as db
from agentrob.board.db.reader import ACCOUNT, Reader, not_found
from agentrob.board.db.records import Board, from_us, now_us
from agentrob.board.db.rows import account_from
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

BOARD_ID = re.compile(r"[a-z0-9][a-z0-9-]{0,31}")
_DAY_US = 86_400_000_000
MAX_INVITE_DAYS, MAX_INVITE_USES = 90, 1000


class Token(NamedTuple):
    """A bearer token without its secret; `id` are the first digits of its hash."""

    id: str
    account: str
    label: str
    scopes: tuple[str, ...]
    created_at: datetime
    revoked_at: datetime | None


class Invite(NamedTuple):
    """An invite without its secret."""

    id: str
    role: Role
    commands_simulated: bool
    left: int
    expires_at: datetime

    @property
    def label(self) -> str:
        """The role that the invite gives, in words."""
        return f"{self.role}, operator of simulated robots" if self.commands_simulated else str(self.role)


# -------------------------------------------------------------------- accounts
def account_named(connection: Connection, name: str) -> Account:
    found = Reader(connection).account(name)
    if found is None:
        raise not_found("account", name)
    return found


def all_accounts(reader: Reader, after: str, limit: int) -> Sequence[Account]:
    """Accounts by name, after a name."""
    a = db.accounts.c
    return tuple(map(account_from, reader.rows(ACCOUNT.where(a.name > after).order_by(a.name).limit(limit))))


def add_account(
    connection: Connection,
    actor: str,
    name: str,
    *,
    kind: AccountKind = AccountKind.HUMAN,
    role: Role = Role.MEMBER,
    display_name: str = "",
    password_hash: str | None = None,
    commands_simulated: bool = False,
) -> Account:
    """Create an account. Names that look like a robot's are refused."""
    name = accounts.checked_name(name)
    robots = [r.name for r in Reader(connection).robots()]
    check_name(name, robots)
    check_display_name(accounts.checked_display_name(display_name), name, robots)
    made = accounts.create(
        connection, name, kind=kind, role=role, password_hash=password_hash, display_name=display_name,
        commands_simulated=commands_simulated,
    )  # fmt: skip
    more = {"commands_simulated": True} if commands_simulated else {}
    audit.note(connection, actor, "account.add", f"account:{name}", kind=str(kind), role=str(role), **more)
    return made


def change_account(
    connection: Connection,
    actor: str,
    name: str,
    *,
    role: Role | None = None,
    suspended: bool | None = None,
    display_name: str | None = None,
    commands_simulated: bool | None = None,
) -> Account:
    """Change the given fields. The last admin keeps the role, since only the command line could restore it."""
    account = account_named(connection, name)
    values: dict[str, Any] = {}
    if role is not None and role is not account.role:
        values["role"] = str(role)
    if suspended is not None and suspended != account.suspended:
        values["suspended"] = suspended
    if commands_simulated is not None and commands_simulated != account.commands_simulated:
        values["commands_simulated"] = commands_simulated
    if display_name is not None and display_name != account.display_name:
        robots = [r.name for r in Reader(connection).robots()]
        values["display_name"] = accounts.checked_display_name(display_name)
        check_display_name(values["display_name"], account.name, robots)
    if not values:
        return account
    if ("role" in values or values.get("suspended")) and actor != audit.SHELL and _is_last_admin(connection, account):
        raise BoardError(409, "last_admin", "this is the last admin", "make somebody else an admin first")
    accounts.change(connection, account, **values)
    audit.note(
        connection, actor, "account.change", f"account:{account.name}", before=_before(account, values), **values
    )
    return account_named(connection, account.name)


def _before(account: Account, values: dict[str, Any]) -> dict[str, Any]:
    return {k: getattr(account, k) if k != "role" else str(account.role) for k in values}


def _is_last_admin(connection: Connection, account: Account) -> bool:
    a = db.accounts.c
    others = and_(a.role == "admin", a.kind == "human", a.suspended.is_(False), a.id != int(account.id))
    return (
        account.role is Role.ADMIN
        and connection.execute(select(func.count()).select_from(db.accounts).where(others)).scalar_one() == 0
    )


def sign_out_everywhere(connection: Connection, actor: str, name: str) -> int:
    """End the account's sessions and return how many there were. Its tokens stay valid."""
    account = account_named(connection, name)
    ended = accounts.end_sessions(connection, account)
    audit.note(connection, actor, "account.sign_out", f"account:{account.name}", sessions=ended)
    return ended


def link(connection: Connection, actor: str, name: str, purpose: str) -> str:
    """Create a one-time link that signs in (`enter`) or sets a new password (`password`); return its path."""
    account = account_named(connection, name)
    if purpose == "password" and account.kind is not AccountKind.HUMAN:
        raise BoardError(409, "no_password", "programs have tokens, not passwords", "create a token")
    secret = accounts.new_link(connection, account, purpose)
    audit.note(connection, actor, f"link.{purpose}", f"account:{account.name}")
    return f"/{purpose}/{secret}"


# -------------------------------------------------------------------- tokens
def tokens(reader: Reader, name: str) -> Sequence[Token]:
    """All tokens of an account, including revoked ones, newest first."""
    t, a = db.tokens.c, db.accounts.c
    statement = select(db.tokens, a.name).join(db.accounts, a.id == t.account_id).where(a.name == name)
    rows = reader.rows(statement.order_by(t.created_us.desc()))
    return [
        Token(
            r.hash[:16], r.name, r.label, tuple(r.scopes.split()), from_us(r.created_us),
            from_us(r.revoked_us) if r.revoked_us is not None else None,
        )
        for r in rows
    ]  # fmt: skip


def add_token(connection: Connection, actor: str, name: str, label: str, scopes: Collection[str]) -> str:
    """Create a token and return its secret, which is not stored."""
    account = account_named(connection, name)
    secret = accounts.new_token(connection, account, label, scopes)
    named = " ".join(sorted(scopes))
    audit.note(connection, actor, "token.add", f"account:{account.name}", label=label[:64], scopes=named)
    return secret


def revoke_token(connection: Connection, actor: str, token_id: str) -> None:
    """End one token at once, by its id."""
    t = db.tokens.c
    found = select(t.hash, db.accounts.c.name).join(db.accounts, db.accounts.c.id == t.account_id)
    rows = connection.execute(found.where(t.hash.startswith(token_id, autoescape=True), t.revoked_us.is_(None))).all()
    if len(token_id) != 16 or len(rows) != 1:
        raise not_found("token", token_id)
    connection.execute(update(db.tokens).where(t.hash == rows[0].hash).values(revoked_us=now_us()))
    audit.note(connection, actor, "token.revoke", f"account:{rows[0].name}", token=token_id)


# -------------------------------------------------------------------- invites
def invite(
    connection: Connection,
    actor: str,
    role: Role,
    uses: int,
    days: int,
    by: Account | None = None,
    *,
    commands_simulated: bool = False,
) -> str:
    """Create an invite, a link with which people create their own accounts; return its path. Never for admins."""
    if role is Role.ADMIN or not 1 <= uses <= MAX_INVITE_USES or not 1 <= days <= MAX_INVITE_DAYS:
        hint = f"any role but admin, 1 to {MAX_INVITE_USES} uses, 1 to {MAX_INVITE_DAYS} days"
        raise BoardError(422, "bad_invite", "the invite is not valid", hint)
    secret, now = accounts.new_secret(), now_us()
    digest = accounts.hash_of(secret)
    row = {"hash": digest, "by_id": int(by.id) if by else None, "role": str(role), "left": uses}
    row["commands_simulated"] = commands_simulated
    connection.execute(insert(db.invites).values(**row, created_us=now, expires_us=now + days * _DAY_US))
    noted = {"role": str(role), "uses": uses, "days": days} | (
        {"commands_simulated": True} if commands_simulated else {}
    )
    audit.note(connection, actor, "invite.add", f"invite:{digest[:16]}", **noted)
    return f"/invite/{secret}"


def invites(reader: Reader) -> Sequence[Invite]:
    """Invites that can still be used."""
    i = db.invites.c
    rows = reader.rows(select(db.invites).where(i.left > 0, i.expires_us > now_us()).order_by(i.expires_us))
    return [_invite(r) for r in rows]


def _invite(r: Row[Any]) -> Invite:
    return Invite(r.hash[:16], Role(r.role), r.commands_simulated, r.left, from_us(r.expires_us))


def revoke_invite(connection: Connection, actor: str, invite_id: str) -> None:
    i = db.invites.c
    mine = and_(i.hash.startswith(invite_id, autoescape=True), i.left > 0)
    if len(invite_id) != 16 or connection.execute(update(db.invites).where(mine).values(left=0)).rowcount != 1:
        raise not_found("invite", invite_id)
    audit.note(connection, actor, "invite.revoke", f"invite:{invite_id}")


def spend_invite(connection: Connection, secret: str) -> Invite:
    """Use an invite once and return it. 404 when it is unknown, used up or expired."""
    i, digest = db.invites.c, accounts.hash_of(secret)
    mine = and_(i.hash == digest, i.left > 0, i.expires_us > now_us())
    if connection.execute(update(db.invites).where(mine).values(left=i.left - 1)).rowcount != 1:
        raise BoardError(404, "no_such_invite", "this invite was used up or has expired", "ask for a new one")
    return _invite(connection.execute(select(db.invites).where(i.hash == digest)).one())


# -------------------------------------------------------------------- boards
def add_board(connection: Connection, actor: str, board: Board) -> Board:
    """A new board, the last in the list."""
    _check_board(board)
    if not BOARD_ID.fullmatch(board.id):
        hint = "1 to 32 of a-z, 0-9 and -, not beginning with -"
        raise BoardError(422, "bad_board", f"{board.id[:40]!r} cannot be a board's id", hint)
    b = db.boards.c
    if connection.execute(select(b.id).where(b.id == board.id)).first():
        raise BoardError(409, "board_taken", f"there is a board {board.id!r} already", "another id")
    place = connection.execute(select(func.coalesce(func.max(b.position), -1) + 1)).scalar_one()
    connection.execute(insert(db.boards).values(id=board.id, position=place, **_board_row(board)))
    audit.note(connection, actor, "board.add", f"board:{board.id}", **_board_row(board))
    return board


def change_board(connection: Connection, actor: str, board_id: str, **changes: Any) -> Board:
    """Change name, description or the roles that read, post and command."""
    before = Reader(connection).board(board_id)
    after = replace(before, **changes)
    _check_board(after)
    if after != before:
        old, new = _board_row(before), _board_row(after)
        connection.execute(update(db.boards).where(db.boards.c.id == board_id).values(**new))
        changed = {k: v for k, v in new.items() if v != old[k]}
        audit.note(
            connection, actor, "board.change", f"board:{board_id}", before={k: old[k] for k in changed}, **changed
        )
    return after


def _check_board(board: Board) -> None:
    if not board.name.strip() or not board.name.isprintable() or len(board.name) > 64 or len(board.description) > 200:
        hint = "a name of at most 64 characters, a description of at most 200"
        raise BoardError(422, "bad_board", "that cannot be a board", hint)
    if board.command_role.rank < Role.OPERATOR.rank:
        raise BoardError(422, "bad_board", "commanding is for operators and those above", "operator, moderator, admin")
    if board.post_role is Role.GUEST or board.post_role.rank < board.read_role.rank:
        raise BoardError(409, "bad_board", "who posts must read too, and guests do not post", "another role")


def _board_row(board: Board) -> dict[str, str]:
    roles = {"read_role": board.read_role, "post_role": board.post_role, "command_role": board.command_role}
    return {"name": board.name, "description": board.description} | {k: str(v) for k, v in roles.items()}


# -------------------------------------------------------------------- robots
def robot_settings(reader: Reader, name: str) -> RobotSettings:
    """The settings of a robot. Raises `BoardError` 404."""
    robot = reader.account(name)
    if robot is None or robot.kind is not AccountKind.ROBOT_AGENT:
        raise not_found("robot", name)
    return rights.settings_of(reader, robot.name)


def change_robot(connection: Connection, actor: str, name: str, **changes: Any) -> RobotSettings:
    """Change fields of a robot's `RobotSettings`; the owner by handle, empty for none."""
    robot = account_named(connection, name)
    if robot.kind is not AccountKind.ROBOT_AGENT:
        raise not_found("robot", name)
    before = rights.settings_of(Reader(connection), robot.name)
    after = rights.checked(replace(before, **changes))
    owner_id = None
    if after.owner:
        owner = account_named(connection, after.owner)
        if owner.kind is not AccountKind.HUMAN:
            raise BoardError(409, "bad_owner", "a robot's owner is a person", "the handle of a person's account")
        owner_id, after = int(owner.id), replace(after, owner=owner.name)
    if not 0 <= after.camera_days <= 3650:
        raise BoardError(422, "bad_days", f"{after.camera_days} days cannot be kept", "0 (forever) to 3650")
    if after == before:
        return after
    row, r = after.stored() | {"owner_id": owner_id}, db.robots.c
    if connection.execute(update(db.robots).where(r.account_id == int(robot.id)).values(**row)).rowcount == 0:
        connection.execute(insert(db.robots).values(account_id=int(robot.id), **row))
    old, new = (s.stored() | {"owner": s.owner} for s in (before, after))
    changed = {k: v for k, v in new.items() if v != old[k]}
    audit.note(connection, actor, "robot.change", f"robot:{robot.name}", before={k: old[k] for k in changed}, **changed)
    return after
