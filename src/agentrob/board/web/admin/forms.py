"""What the forms of administration, moderation and entry share: who sent it, what its fields say, what is shown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fastapi import Request
from starlette.datastructures import FormData
from starlette.responses import Response

from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.db.writer import Job, T
from agentrob.board.robots import rights
from agentrob.board.services import get_services
from agentrob.board.web.templating import hint_of, sentence, show
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

_CLASSES = {"photo": "Photos", "gesture": "Gestures", "move": "Walking and turning", "risky": "Flips"}
_CHOICES: dict[str, Any] = {
    "all_roles": tuple(Role),
    "all_kinds": tuple(AccountKind),
    "who": rights.WHO,
    "classes": tuple((str(c), _CLASSES[c]) for c in ActionClass),
}


def admin_of(viewer: Viewer) -> Account:
    """The viewer, when that is an admin. Else 401, 403."""
    return access.has_role(access.account_of(viewer), Role.ADMIN)


async def read(request: Request) -> FormData:
    """The form that was sent; how large it may be is for `SecurityMiddleware` to say."""
    return await request.form(max_files=0)


async def sent(request: Request, viewer: Viewer, role: Role) -> tuple[FormData, Account]:
    """The form, once its token is right, and who sent it when that has the role. Else 401, 403."""
    form = await read(request)
    access.check_form(viewer, form.get("csrf"))
    account = access.account_of(viewer)
    return form, account if role is Role.GUEST else access.has_role(account, role)


async def do(request: Request, job: Job[T]) -> T:
    """Run a job of the writer."""
    return await get_services(request).store.do(job)


def page(
    request: Request,
    viewer: Viewer,
    template: str,
    tab: str,
    data: Mapping[str, Any],
    error: BoardError | None = None,
) -> Response:
    """A page of administration, with what went wrong when something did. `tab` marks its part."""
    frame = {"tab": tab, "problem": problem(error), **_CHOICES, **data}
    return show(request, viewer, template, frame, status=error.status if error else 200, here="admin")


def told(request: Request, viewer: Viewer, back: str, what: str, secret: str) -> Response:
    """A secret, shown this once. A path is shown as an address."""
    shown = get_services(request).settings.base_url + secret if secret.startswith("/") else secret
    data = {"tab": "", "what": what, "secret": shown, "back": back}
    response = show(request, viewer, "admin_told.html", data, here="admin")
    response.headers["Cache-Control"] = "no-store"
    return response


def problem(error: BoardError | None) -> str:
    """What went wrong and what would be right, in a line."""
    return f"{sentence(str(error))} {sentence(hint_of(error))}".strip() if error else ""


def field(form: FormData, name: str) -> str:
    """A field as text without white space around it."""
    value = form.get(name)
    return value.replace("\r\n", "\n").strip() if isinstance(value, str) else ""


def number(form: FormData, name: str) -> int:
    """A field as a number that is not negative; 422 for what is none."""
    text = field(form, name)
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise BoardError(422, "bad_number", f"{text[:20]!r} is no number", "digits only")
    return int(text)


def password(form: FormData, name: str) -> str:
    """A field exactly as it was typed."""
    value = form.get(name)
    return value if isinstance(value, str) else ""


def address(request: Request) -> str:
    """Whose request it is, as far as the network tells."""
    return request.client.host if request.client else ""


def one_of(kind: type[T], word: str) -> T:
    """A word of an enumeration; 422 for any other."""
    known = [str(k) for k in kind]  # type: ignore[attr-defined]
    if word not in known:
        raise BoardError(422, "bad_choice", f"{word[:40]!r} is no choice", ", ".join(known))
    return kind(word)  # type: ignore[call-arg]
