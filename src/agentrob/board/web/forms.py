"""What forms of pages send: read, checked and made into what is written; pictures among it."""

from __future__ import annotations

import hashlib
import re
import secrets
from dataclasses import dataclass

from starlette.datastructures import FormData, UploadFile
from starlette.requests import Request

from agentrob.board.api.models import POST_BYTES
from agentrob.board.content import tags, uploads
from agentrob.board.content.images import MAX_BYTES
from agentrob.board.db.records import Image
from agentrob.board.services import Services
from agentrob.board.web.templating import hint_of, sentence
from agentrob.errors import BoardError
from agentrob.model import Account

TITLE_LENGTH = 200
#: Characters of a field of tags.
TAGS_LENGTH = 500
#: Pictures that one form may bring.
MAX_FILES = 8


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
    """The form that was sent; how large it may be is for `SecurityMiddleware` to say."""
    return await request.form(max_files=MAX_FILES)


def field(form: FormData, name: str) -> str:
    """A field as text, with the line ends that people use (browsers send others)."""
    value = form.get(name)
    return value.replace("\r\n", "\n") if isinstance(value, str) else ""


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
