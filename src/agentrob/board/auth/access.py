"""Who is asking, and may they: sessions, bearer tokens, CSRF and rights, as dependencies of endpoints.

What pages use: `viewer` for every page; `reader` where reading is required; after reading a form
`check_form(viewer, form.get("csrf"))`; `keep(response, services, viewer)` on each page that shows a form to somebody
who is not signed in (it keeps the cookie that the token belongs to); `sign_in`, `sign_up`, `enter`, which give a
session to `set_session(response, services, session)`, and `sign_out`.
"""

from __future__ import annotations

import asyncio
import hashlib
import hmac
import re
from dataclasses import dataclass
from typing import Annotated

from fastapi import Depends, Request
from starlette.responses import Response

from agentrob.board.admin import management
from agentrob.board.auth import accounts, attempts, visibility
from agentrob.board.db.writer import Transaction
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role

_SECRET = re.compile(r"[A-Za-z0-9_-]{43}")


@dataclass(frozen=True, slots=True)
class Viewer:
    """Who asks: `account` is None when nobody is signed in. `csrf` goes into forms as the field `csrf` (a meta tag
    `csrf` for scripts, which send it as `X-CSRF-Token`). `secret` is the cookie's value or the token, never shown."""

    account: Account | None
    csrf: str
    secret: str
    by_token: bool = False
    scopes: frozenset[str] = frozenset(accounts.SCOPES)


async def viewer(request: Request) -> Viewer:
    """Whoever asks, signed in or not; from here on the store shows what they may see. 401 for a bad bearer token."""
    who = _viewer(request)
    parts = get_services(request)
    boards = parts.store.everything.all_boards()
    visibility.set_readable_boards(visibility.boards_readable_by(boards, who.account, parts.settings.public_read))
    return who


def _viewer(request: Request) -> Viewer:
    parts = get_services(request)
    if (header := request.headers.get("authorization")) is not None:
        scheme, _, token = header.partition(" ")
        found = accounts.token_of(parts.store.reader, token) if scheme.lower() == "bearer" else None
        if found is None:
            raise BoardError(401, "bad_token", "that token is not valid", "agentrob board account token NAME makes one")
        return Viewer(found[0], "", token, by_token=True, scopes=found[1])
    secret = request.cookies.get(parts.settings.cookie, "")
    if not _SECRET.fullmatch(secret):
        secret = accounts.new_secret()
        return Viewer(None, csrf_token(secret), secret)
    return Viewer(accounts.by_session(parts.store.reader, secret), csrf_token(secret), secret)


async def reader(request: Request) -> Viewer:
    """Who may read: anybody signed in and not suspended, or everybody when `public_read` is set. Else 401, 403."""
    who = await viewer(request)
    if who.account is None and get_services(request).settings.public_read:
        return who
    account_of(who)
    return who


async def stopper(request: Request) -> Account:
    """Who may stop by API: whoever is signed in and not suspended, whatever the role and the token. Else 401, 403."""
    who = await viewer(request)
    account = account_of(who)
    if not who.by_token:
        check_form(who, request.headers.get("x-csrf-token"))
    return account


async def member(request: Request) -> Account:
    """Who may write by API: as `stopper`, with a token for writing when it is one. Roles are asked by what is done."""
    return await _scoped(request, "write")


async def moderator(request: Request) -> Account:
    """Who may moderate: moderators and admins, with a token for it when it is one."""
    account = await _scoped(request, "admin")
    return has_role(account, Role.MODERATOR)


async def administrator(request: Request) -> Account:
    """Who may administer: admins who are people, with a token for it when it is one."""
    return has_role(await _scoped(request, "admin"), Role.ADMIN)


def has_role(account: Account, role: Role) -> Account:
    """The account when it has this role or one above it and is nobody's robot; admins besides are people. Else 403."""
    if account.role.rank < role.rank or account.kind in (AccountKind.ROBOT_AGENT, AccountKind.MONITORING_AGENT):
        raise BoardError(403, f"not_{role}", f"this needs the role {role}", "ask an admin")
    if role is Role.ADMIN and account.kind is not AccountKind.HUMAN:
        raise BoardError(403, "not_admin", "only people administer", "sign in as a person")
    return account


def check_robot_owner(account: Account, owner: str) -> None:
    """403 unless the account is a person who owns the robot or is an admin."""
    owns = account.role is Role.ADMIN or (bool(owner) and account.name == owner)
    if not owns or account.kind is not AccountKind.HUMAN:
        raise BoardError(403, "not_owner", "this is for the robot's owner and for admins", "ask an admin")


async def _scoped(request: Request, scope: str) -> Account:
    who = await viewer(request)
    account = account_of(who)
    if scope not in who.scopes:
        raise BoardError(403, "token_scope", f"this token is not good for {scope}", f"one with the scope {scope}")
    if not who.by_token:
        check_form(who, request.headers.get("x-csrf-token"))
    return account


def check_form(viewer: Viewer, token: object) -> None:
    """403 unless the form's token is the viewer's. Call it before anything else is done with a form.

    Bearer tokens send no forms: what each is good for is asked by the API only.
    """
    if viewer.by_token:
        raise BoardError(403, "no_forms", "forms are for browsers", "use the API")
    if not isinstance(token, str) or not hmac.compare_digest(token.encode("utf-8", "replace"), viewer.csrf.encode()):
        raise BoardError(403, "bad_csrf", "the form is too old or not from this forum", "load the page again")


def account_of(viewer: Viewer) -> Account:
    """The viewer's account when it may write: 401 when nobody is signed in, 403 when suspended."""
    if viewer.account is None:
        raise BoardError(401, "not_signed_in", "sign in first", "a session cookie or Authorization: Bearer <token>")
    if viewer.account.suspended:
        raise BoardError(403, "suspended", "this account is suspended", "ask an admin")
    return viewer.account


# -------------------------------------------------------------------- parameters of endpoints
#: Any viewer, signed in or not.
AnyViewer = Annotated[Viewer, Depends(viewer)]
#: A viewer who may read.
ReadingViewer = Annotated[Viewer, Depends(reader)]
#: Accounts that may stop robots, write, moderate, administer.
Stopper = Annotated[Account, Depends(stopper)]
Member = Annotated[Account, Depends(member)]
Moderator = Annotated[Account, Depends(moderator)]
Administrator = Annotated[Account, Depends(administrator)]


# -------------------------------------------------------------------- sessions
async def sign_in(services: Services, name: str, password: str, address: str) -> str:
    """A new session. 401 for a wrong name or password (the same words for both), 429 after too many attempts."""
    await _check_password(services, name, password, address)
    account = services.store.account(name.strip())
    if account is None or account.suspended:
        raise BoardError(403, "suspended", "this account is suspended", "ask an admin")
    return await services.store.do(lambda t: accounts.new_session(t.connection, int(account.id)))


async def _check_password(services: Services, name: str, password: str, address: str) -> None:
    await _count(services, name, address)
    await asyncio.sleep(attempts.delay_s(services.store.reader, name))
    row = services.store.reader.first(accounts.password_of(name))
    async with services.hashing:
        right = await asyncio.to_thread(accounts.verify_password, row.password_hash if row else None, password)
    if row is None or not right:
        raise BoardError(401, "wrong_password", "that name or password is wrong", "try again, or ask an admin")
    await services.store.do(lambda t: attempts.forget(t.connection, name, address))


async def _count(services: Services, name: str, address: str) -> None:
    attempts.refuse(services.store.reader, name, address)  # a flood is refused without a write
    await services.store.do(lambda t: attempts.count(t.connection, name, address))


async def sign_up(services: Services, name: str, password: str, address: str, invite: str = "") -> str:
    """A new account and its session: a member, or what the invite gives. 403 when sign-up is off and there is no
    invite, 404 when the invite is void, 409 when the name is taken, 422, 429."""
    if not services.settings.sign_up and not invite:
        raise BoardError(403, "sign_up_off", "this forum does not take new accounts by itself", "ask an admin")
    await _count(services, "", address)
    name = accounts.checked_name(name)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, password)

    def make(t: Transaction) -> str:
        if not invite:  # one that fails is undone with the rest
            attempts.count_sign_up(t.connection, address, services.settings.limits.sign_ups)
        role = management.spend_invite(t.connection, invite) if invite else Role.MEMBER
        made = management.add_account(t.connection, name, name, role=role, password_hash=password_hash)
        return accounts.new_session(t.connection, int(made.id))

    return await services.store.do(make)


async def new_password(services: Services, secret: str, password: str, address: str) -> str:
    """Spend a one-time link for a new password: a session; all others end. 404 for a void link, 422, 429."""
    await _count(services, "", address)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, password)
    return await services.store.do(lambda t: accounts.spend_password_link(t.connection, secret, password_hash))


async def change_password(services: Services, account: Account, old: str, new: str, address: str) -> str:
    """Another password for who knows the old one: a session; all others end. 401, 422, 429."""
    await _check_password(services, account.name, old, address)
    async with services.hashing:
        password_hash = await asyncio.to_thread(accounts.hash_password, new)
    return await services.store.do(lambda t: accounts.set_password(t.connection, int(account.id), password_hash))


async def enter(services: Services, secret: str) -> str:
    """Spend a one-time link: a new session. 404 when it is unknown, used or expired."""
    return await services.store.do(lambda t: accounts.spend_link(t.connection, secret))


async def sign_out(services: Services, viewer: Viewer, response: Response) -> None:
    """End the session and drop its cookie."""
    await services.store.do(lambda t: accounts.end_session(t.connection, viewer.secret))
    response.delete_cookie(services.settings.cookie, path="/", secure=services.settings.secure, httponly=True)


def set_session(response: Response, services: Services, session: str) -> None:
    """Put the session's cookie on the response."""
    response.set_cookie(
        services.settings.cookie,
        session,
        max_age=accounts.SESSION_DAYS * 24 * 3600,
        path="/",
        secure=services.settings.secure,
        httponly=True,
        samesite="lax",
    )


def keep(response: Response, services: Services, viewer: Viewer) -> None:
    """Keep the cookie that an anonymous viewer's form token belongs to.

    A viewer without a secret is one of whom nothing could be found out (the database cannot be read), perhaps signed
    in: the cookie stays what it is.
    """
    if viewer.account is None and not viewer.by_token and viewer.secret:
        set_session(response, services, viewer.secret)


def csrf_token(secret: str) -> str:
    """Follows from the cookie's secret and does not reveal it."""
    return hmac.new(secret.encode(), b"csrf", hashlib.sha256).hexdigest()
