"""Reads and checks the forms of pages, and shows the pages of administration again with what went wrong."""

from __future__ import annotations

import hashlib
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeVar

from starlette.datastructures import FormData, UploadFile
from starlette.requests import Request
from starlette.responses import Response

from agentrob.board.api.models import POST_BYTES
from agentrob.board.auth import access
from agentrob.board.auth.access import Viewer
from agentrob.board.content import tags, uploads
from agentrob.board.content.images import MAX_BYTES
from agentrob.board.db.records import Image
from agentrob.board.robots import rights
from agentrob.board.services import Services, get_services
from agentrob.board.web.templating import hint_of, sentence, show
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

TITLE_LENGTH = 200
#: Characters of a field of tags.
TAGS_LENGTH = 500
#: Pictures that one form may bring.
MAX_FILES = 8

E = TypeVar("E", bound=StrEnum)
_CLASSES = {"photo": "Photos", "gesture": "Gestures", "move": "Walking and turning", "risky": "Flips"}
_CHOICES: dict[str, Any] = {
    "all_roles": tuple(Role),
    "all_kinds": tuple(AccountKind),
    "who": rights.WHO,
    "classes": tuple((str(c), _CLASSES[c]) for c in ActionClass),
}


@dataclass(frozen=True, slots=True)
class Composed:
    """What is in a form for writing, as it is shown again: the text, what it answers, its pictures.

    `preview` is safe HTML, None when nobody asked for it, and `hint` says why no robot would answer.
    `problem` says what is wrong.
    """

    draft: str = ""
    title: str = ""
    tags: str = ""
    reply_to: str = ""
    pictures: tuple[Image, ...] = ()
    preview: str | None = None
    hint: str = ""
    problem: str = ""


async def read(request: Request) -> FormData:
    """The form of a request. `SecurityMiddleware` limits its size."""
    return await request.form(max_files=MAX_FILES)


async def read_checked(request: Request, viewer: Viewer) -> FormData:
    """The form of a request. 403 unless its CSRF token is the viewer's."""
    form = await read(request)
    access.check_form(viewer, form.get("csrf"))
    return form


async def sent_by(request: Request, viewer: Viewer, role: Role) -> tuple[FormData, Account]:
    """The form and the account that sent it. 401 or 403 unless the token is right and the account has the role."""
    form = await read_checked(request, viewer)
    account = access.account_of(viewer)
    return form, account if role is Role.GUEST else access.has_role(account, role)


# -------------------------------------------------------------------- fields
def field(form: FormData, name: str) -> str:
    """A field as text, with `\\n` at the ends of lines (browsers send `\\r\\n`)."""
    return password(form, name).replace("\r\n", "\n")


def stripped(form: FormData, name: str) -> str:
    """A field as text without white space around it."""
    return field(form, name).strip()


def password(form: FormData, name: str) -> str:
    """A field exactly as it was typed; empty when it is missing or a file."""
    value = form.get(name)
    return value if isinstance(value, str) else ""


def number(form: FormData, name: str) -> int:
    """A field as a number that is not negative. 422 for anything else."""
    text = stripped(form, name)
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise BoardError(422, "bad_number", f"{text[:20]!r} is not a number", "digits only")
    return int(text)


def one_of(kind: type[E], text: str) -> E:
    """A member of an enumeration by its value. 422 for anything else."""
    valid = [str(k) for k in kind]
    if text not in valid:
        raise BoardError(422, "bad_choice", f"{text[:40]!r} is not a choice", ", ".join(valid))
    return kind(text)


async def pictures(services: Services, form: FormData, by: Account) -> tuple[Image, ...]:
    """The pictures that a form names, and those that it brings, which are kept. 403, 404, 413, 415, 429."""
    named = [v for v in form.getlist("images") if isinstance(v, str) and v.isascii() and v.isdigit()]
    found = [services.store.image(image_id) for image_id in dict.fromkeys(named[:MAX_FILES])]
    for value in form.getlist("pictures"):
        if isinstance(value, UploadFile) and value.filename:
            image, _ = await uploads.take(services, by, await value.read(MAX_BYTES + 1))
            found.append(image)
    return tuple(found)


def title(text: str) -> str:
    """A title on one line. 422 when there is none."""
    line = " ".join("".join(c for c in text if c.isprintable() or c.isspace()).split())
    if not line or len(line) > TITLE_LENGTH:
        raise BoardError(422, "bad_title", "a topic needs a title", f"at most {TITLE_LENGTH} characters")
    return line


def tags_of(form: FormData) -> tuple[str, ...]:
    """The tags that a form gives, between commas. 422 for too many or too long ones."""
    return tags.checked(re.split(r"[,，、\n]", field(form, "tags")[:TAGS_LENGTH]))


def body(text: str) -> str:
    """The text of a post. 422 when there is none, 413 when it is too long."""
    text = text.replace("\0", "")
    if not text.strip():
        raise BoardError(422, "empty", "a post needs a text")
    if len(text.encode()) > POST_BYTES:
        raise BoardError(413, "post_too_large", "the post is too long", f"at most {POST_BYTES // 1024} KiB")
    return text


# -------------------------------------------------------------------- answers
def problem(error: BoardError | None) -> str:
    """What went wrong and what would be right, in a line."""
    return f"{sentence(str(error))} {sentence(hint_of(error))}".strip() if error else ""


def nonce() -> str:
    return secrets.token_urlsafe(9)


def key(form: FormData, *content: str) -> str:
    """The same form sent twice with the same content is one post; changed content (after going back) is another."""
    digest = hashlib.sha256("\0".join(content).encode("utf-8", "replace")).hexdigest()[:24]
    sent = re.sub(r"[^A-Za-z0-9_-]", "", field(form, "key"))[:32]
    return f"form:{sent}:{digest}"


def quoted(raw: str) -> str:
    """A post as a quotation to write below; what is quoted is said by nobody (law 3)."""
    lines = raw.strip().splitlines()[:40]
    return "".join(f"> {line}".rstrip() + "\n" for line in lines) + "\n" if lines else ""


# -------------------------------------------------------------------- pages of administration
def admin_of(viewer: Viewer) -> Account:
    """The viewer's account when it is an admin. Else 401, 403."""
    return access.has_role(access.account_of(viewer), Role.ADMIN)


def admin_page(
    request: Request,
    viewer: Viewer,
    template: str,
    tab: str,
    data: Mapping[str, Any],
    error: BoardError | None = None,
) -> Response:
    """A page of administration, with what went wrong if something did. `tab` marks its part."""
    frame = {"tab": tab, "problem": problem(error), **_CHOICES, **data}
    return show(request, viewer, template, frame, status=error.status if error else 200, here="admin")


def secret_page(request: Request, viewer: Viewer, back: str, what: str, secret: str) -> Response:
    """Show a secret, once. A path is shown as an address."""
    shown = get_services(request).settings.base_url + secret if secret.startswith("/") else secret
    data = {"tab": "", "what": what, "secret": shown, "back": back}
    response = show(request, viewer, "admin_told.html", data, here="admin")
    response.headers["Cache-Control"] = "no-store"
    return response


def address(request: Request) -> str:
    """The address that the request came from; empty when the server does not know it."""
    return request.client.host if request.client else ""
