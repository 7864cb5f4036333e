"""Who is asking, and may they: sessions, bearer tokens, CSRF and rights, as dependencies of endpoints.

What pages use: `viewer` for every page; `reader` where reading is required; after reading a form
`check_form(viewer, form.get("csrf"))`; `keep(response, viewer)` on each page that shows a form to somebody who is not
signed in (it keeps the cookie that the token belongs to); `sign_in`, `sign_up`, `enter`, which give a session to
`set_session(response, services, session)`, and `sign_out`.
"""

from __future__ import annotations

from dataclasses import dataclass

from fastapi import Request
from starlette.responses import Response

from agentrob.board.services import Services
from agentrob.model import Account


@dataclass(frozen=True, slots=True)
class Viewer:
    """Who asks: `account` is None when nobody is signed in. `csrf` goes into forms as the field `csrf` (a meta tag
    `csrf` for scripts, which send it as `X-CSRF-Token`). `secret` is the cookie's value, never shown."""

    account: Account | None
    csrf: str
    secret: str
    by_token: bool = False


async def viewer(request: Request) -> Viewer:
    """Whoever asks, signed in or not. 401 for a bearer token that is not valid."""
    raise NotImplementedError


async def reader(request: Request) -> Viewer:
    """Who may read: anybody signed in and not suspended, or everybody when `public_read` is set. Else 401, 403."""
    raise NotImplementedError


async def member(request: Request) -> Account:
    """Who may write by API: signed in, not suspended, with the CSRF header when signed in by cookie. Else 401, 403."""
    raise NotImplementedError


def check_form(viewer: Viewer, token: object) -> None:
    """403 unless the form's token is the viewer's. Call it before anything else is done with a form."""
    raise NotImplementedError


def account_of(viewer: Viewer) -> Account:
    """The viewer's account when it may write: 401 when nobody is signed in, 403 when suspended."""
    raise NotImplementedError


async def sign_in(services: Services, name: str, password: str, address: str) -> str:
    """A new session. 401 for a wrong name or password (the same words for both), 429 after too many attempts."""
    raise NotImplementedError


async def sign_up(services: Services, name: str, password: str, address: str) -> str:
    """A new member account and its session. 403 when sign-up is off, 409 when the name is taken, 422."""
    raise NotImplementedError


async def enter(services: Services, secret: str) -> str:
    """Spend a one-time link: a new session. 404 when it is unknown, used or expired."""
    raise NotImplementedError


async def sign_out(services: Services, viewer: Viewer, response: Response) -> None:
    """End the session and drop its cookie."""
    raise NotImplementedError


def set_session(response: Response, services: Services, session: str) -> None:
    """Put the session's cookie on the response."""
    raise NotImplementedError


def keep(response: Response, services: Services, viewer: Viewer) -> None:
    """Keep the cookie that an anonymous viewer's form token belongs to."""
    raise NotImplementedError
