"""The forms of pages: their fields as models, checks of what was typed, and the pages of administration around them.

Every field of a form is optional text, so that a mistake never reaches FastAPI's own errors: it is reported on the
page of the form, which keeps what was typed.
"""

from __future__ import annotations

import hashlib
import re
import secrets
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, TypeVar

from fastapi import UploadFile
from pydantic import AfterValidator, BaseModel, BeforeValidator
from starlette.requests import Request
from starlette.responses import Response

from agentrob.board import access
from agentrob.board.access import Viewer
from agentrob.board.api.models import POST_BYTES
from agentrob.board.auth import rights
from agentrob.board.content import tags, uploads
from agentrob.board.content.images import MAX_BYTES
from agentrob.board.db.records import Image
from agentrob.board.services import Services, get_services
from agentrob.board.web.templating import error_text, render_page
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, ActionClass, Role

TITLE_LENGTH = 200
#: Characters of a title that is made from a command.
MADE_TITLE = 80
#: Characters of a field of tags.
TAGS_LENGTH = 500
#: The largest number of pictures in one form.
MAX_FILES = 8

E = TypeVar("E", bound=StrEnum)
#: Several lines; browsers send `\r\n` at their ends.
Text = Annotated[str, AfterValidator(lambda text: text.replace("\r\n", "\n"))]
#: Without white space around it.
Line = Annotated[str, AfterValidator(str.strip)]
#: Browsers do not send a box that is not checked, and any value for one that is.
Checkbox = Annotated[bool, BeforeValidator(lambda sent: sent is not False)]

#: The names at the beginning of a command.
_CALLING = re.compile(r"\A(?:[@＠][A-Za-z][A-Za-z0-9_-]*[\s,;:，：、]*(?:(?:and\b|&|和|与)\s*)?)+")
_CLASSES = {"photo": "Photos", "gesture": "Gestures", "move": "Walking and turning", "risky": "Flips"}
_CHOICES: dict[str, Any] = {
    "all_roles": tuple(Role),
    "all_kinds": tuple(AccountKind),
    "who": rights.WHO,
    "classes": tuple((str(c), _CLASSES[c]) for c in ActionClass),
}


# -------------------------------------------------------------------- fields
class PageForm(BaseModel):
    """The field that every form has. An endpoint declares its form as `Annotated[PageForm, Form()]`."""

    csrf: str = ""

    def sender(self, viewer: Viewer, role: Role = Role.GUEST) -> Account:
        """The account that sent the form. 401 or 403 unless its CSRF token is right and the account has the role."""
        access.check_form(viewer, self.csrf)
        account = access.account_of(viewer)
        return account if role is Role.GUEST else access.has_role(account, role)


class ButtonForm(PageForm):
    """A button that leads back to the page it was on."""

    back: str = ""


class KeyedForm(PageForm):
    """A form that writes a post. `key` is new each time the form is shown."""

    key: Line = ""

    def idempotency_key(self, *content: str) -> str:
        """The same form sent twice with the same content is one post; changed content (after going back) is another."""
        digest = hashlib.sha256("\0".join(content).encode("utf-8", "replace")).hexdigest()[:24]
        return f"form:{re.sub(r'[^A-Za-z0-9_-]', '', self.key)[:32]}:{digest}"


class PostForm(KeyedForm):
    """A text with pictures: `images` are ids of those uploaded before, `pictures` come with the form."""

    title: Text = ""
    body: Text = ""
    tags: Text = ""
    reply_to: Line = ""
    do: Line = ""
    images: list[str] = []
    pictures: list[UploadFile] = []

    @property
    def composed(self) -> Composed:
        return Composed(self.body, self.title, self.tags, self.reply_to)

    async def all_pictures(self, services: Services, by: Account) -> tuple[Image, ...]:
        """The pictures that the form names and those that it brings, which are stored. 403, 404, 413, 415, 422, 429."""
        if len(self.pictures) > MAX_FILES:
            raise BoardError(422, "too_many_files", "too many pictures at once", f"at most {MAX_FILES}")
        named = [image_id for image_id in self.images if image_id.isascii() and image_id.isdigit()]
        found = [services.store.image(image_id) for image_id in dict.fromkeys(named[:MAX_FILES])]
        for file in self.pictures:
            image, _ = await uploads.take(services.store, by, await file.read(MAX_BYTES + 1))
            found.append(image)
        return tuple(found)


@dataclass(frozen=True, slots=True)
class Composed:
    """The content of a form that is shown again: the text, the post it replies to, its pictures.

    `preview` is safe HTML, None unless a preview was asked for; `hint` says why no robot would answer, `reading`
    what the robots would do; `problem` says what is wrong.
    """

    draft: str = ""
    title: str = ""
    tags: str = ""
    reply_to: str = ""
    pictures: tuple[Image, ...] = ()
    preview: str | None = None
    hint: str = ""
    reading: str = ""
    problem: str = ""


# -------------------------------------------------------------------- checks
def number(text: str) -> int:
    """A field as a number that is not negative. 422 for anything else."""
    text = text.strip()
    if not text.isascii() or not text.isdigit() or len(text) > 6:
        raise BoardError(422, "bad_number", f"{text[:20]!r} is not a number", "digits only")
    return int(text)


def one_of(kind: type[E], text: str) -> E:
    """A member of an enumeration by its value. 422 for anything else."""
    valid = [str(k) for k in kind]
    if text not in valid:
        raise BoardError(422, "bad_choice", f"{text[:40]!r} is not a choice", ", ".join(valid))
    return kind(text)


def title(text: str) -> str:
    """A title on one line. 422 if it is empty or too long."""
    line = " ".join("".join(c for c in text if c.isprintable() or c.isspace()).split())
    if not line or len(line) > TITLE_LENGTH:
        raise BoardError(422, "bad_title", "a topic needs a title", f"at most {TITLE_LENGTH} characters")
    return line


def title_of(command: str) -> str:
    """A title made from a command: its first line without the names at its beginning, shortened."""
    lines = (" ".join("".join(c for c in line if c.isprintable()).split()) for line in command.splitlines())
    first = next((line for line in lines if line), "")
    made = _CALLING.sub("", first) or first
    made = made[:1].upper() + made[1:]
    return made if len(made) <= MADE_TITLE else made[: MADE_TITLE - 1].rstrip() + "…"


def tags_of(text: str) -> tuple[str, ...]:
    """Tags separated by commas. 422 for too many or too long ones."""
    return tags.checked(re.split(r"[,，、\n]", text[:TAGS_LENGTH]))


def body(text: str) -> str:
    """The text of a post. 422 if it is empty, 413 if it is too long."""
    text = text.replace("\0", "")
    if not text.strip():
        raise BoardError(422, "empty", "a post needs a text")
    if len(text.encode()) > POST_BYTES:
        raise BoardError(413, "post_too_large", "the post is too long", f"at most {POST_BYTES // 1024} KiB")
    return text


def post_number(text: str) -> int | None:
    """The id of a post as a number; None for anything else."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 19 else None


def nonce() -> str:
    """A new value for the field `key`."""
    return secrets.token_urlsafe(9)


def quoted(raw: str) -> str:
    """Return a post as a quotation for a reply. Quoted text commands nobody (law 3)."""
    lines = raw.strip().splitlines()[:40]
    return "".join(f"> {line}".rstrip() + "\n" for line in lines) + "\n" if lines else ""


def address(request: Request) -> str:
    """The address that the request came from; empty if unknown."""
    return request.client.host if request.client else ""


# -------------------------------------------------------------------- pages of administration
def admin_of(viewer: Viewer) -> Account:
    """The viewer's account if it is an admin. Else 401, 403."""
    return access.has_role(access.account_of(viewer), Role.ADMIN)


def admin_page(
    request: Request,
    viewer: Viewer,
    template: str,
    tab: str,
    data: Mapping[str, Any],
    error: BoardError | None = None,
) -> Response:
    """A page of administration, with the error if there was one. `tab` marks its part."""
    frame = {"tab": tab, "problem": error_text(error), **_CHOICES, **data}
    return render_page(request, viewer, template, frame, status=error.status if error else 200, here="admin")


def secret_page(request: Request, viewer: Viewer, back: str, what: str, secret: str) -> Response:
    """Show a secret once. A path is shown as a URL."""
    shown = get_services(request).settings.base_url + secret if secret.startswith("/") else secret
    data = {"tab": "", "what": what, "secret": shown, "back": back}
    response = render_page(request, viewer, "admin_secret.html", data, here="admin")
    response.headers["Cache-Control"] = "no-store"
    return response
