"""Render templates as pages, and serve the static files."""

from __future__ import annotations

import gzip
import hashlib
import hmac
import math
import re
import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape
from starlette.requests import Request
from starlette.responses import HTMLResponse, RedirectResponse, Response

from agentrob.board import access
from agentrob.board.access import Viewer
from agentrob.board.content import notifications
from agentrob.board.content.excerpts import excerpt, report_parts
from agentrob.board.db.records import from_text
from agentrob.board.robots import approvals, live
from agentrob.board.robots.abilities import example_commands
from agentrob.board.robots.front import best_picture
from agentrob.board.robots.live import RoomView
from agentrob.board.robots.view import RobotView
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError, HttpError
from agentrob.model import AccountKind, CommandState, Role, StatusCard
from agentrob.model.lifecycle import ACTIVE_STATES, CARD_STATES

HERE = Path(__file__).parent
NAME = re.compile(r"[a-z][a-z0-9_-]{0,63}\Z")
_NOT_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

#: The states of a command as words for people, and those whose card shows a progress bar.
STATES = {str(state): state.label for state in CARD_STATES}
_S = CommandState
PROGRESS_BAR = frozenset({_S.RUNNING, _S.DONE, _S.FAILED, _S.STOPPED, _S.INTERRUPTED})
BADGES = {
    AccountKind.ROBOT_AGENT: "robot",
    AccountKind.COMMANDING_AGENT: "agent",
    AccountKind.MONITORING_AGENT: "monitor",
}
KINDS = {
    AccountKind.HUMAN: "a person",
    AccountKind.ROBOT_AGENT: "a robot",
    AccountKind.COMMANDING_AGENT: "a program that commands robots",
    AccountKind.MONITORING_AGENT: "a program that only reads",
}
ROLES = {
    Role.GUEST: "guest: can read, and stop robots",
    Role.MEMBER: "member: can read, write, and stop robots",
    Role.OPERATOR: "operator: can command robots",
    Role.MODERATOR: "moderator: can command robots and moderate",
    Role.ADMIN: "administrator",
}

#: Pages are personal and always current; `SecurityMiddleware` adds the headers of all responses.
_HEADERS = {"Cache-Control": "private, no-cache"}
_MEDIA_TYPES = {".css": "text/css; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".svg": "image/svg+xml"}
_STATIC = {path.name: path.read_bytes() for path in sorted((HERE / "static").iterdir()) if path.suffix in _MEDIA_TYPES}
_HASHES = {name: hashlib.sha256(content).hexdigest()[:12] for name, content in _STATIC.items()}


# ------------------------------------------------------------------ what templates call
def static_url(name: str) -> str:
    """The URL of a static file, which contains the hash of its content."""
    return f"/static/{_HASHES[name]}/{name}"


def stamp(at: datetime) -> str:
    """`21 Nov 2026, 09:31 UTC`; scripts replace it by the viewer's local time."""
    return f"{at.astimezone(UTC):%-d %b %Y, %H:%M} UTC"


def iso(at: datetime) -> str:
    return at.astimezone(UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def word(value: object) -> str:
    """A state reduced to letters, for use in a CSS class."""
    return re.sub(r"[^a-z_]", "", str(value))[:24]


def tone(name: str) -> int:
    """One of five colours, always the same for a name."""
    return sum(name.encode()) % 5


def inline_code(text: str) -> Markup:
    """A text with the words between backticks as code, like those of the OpenAPI document."""
    return Markup(re.sub(r"`([^`\n]+)`", r"<code>\1</code>", str(escape(text))))


def status_card(card: Mapping[str, Any]) -> StatusCard:
    """A card from a robot's agent, with every field converted to the type that pages expect."""
    values = {f.name: card.get(f.name) for f in fields(StatusCard)}
    robot, left_to = str(values["robot"] or ""), str(values["left_to"] or "")
    return StatusCard(
        robot=robot if NAME.match(robot) else "",
        state=word(values["state"]),
        step=_count(values["step"]),
        steps=_count(values["steps"]),
        doing=str(values["doing"] or "")[:200],
        place=_count(values["place"]) or None,
        trace_id=str(values["trace_id"] or "")[:64],
        until=str(values["until"] or "")[:40],
        part=_count(values["part"]),
        bid_s=_count(values["bid_s"]),
        near_cm=_count(values["near_cm"]),
        takes=_count(values["takes"]),
        left_to=left_to if NAME.match(left_to) else "",
    )


def _rooms(
    robots: Sequence[RobotView], board: str = "", robot: str = "", first: Collection[str] = ()
) -> Sequence[RoomView]:
    """The rooms of the robots that act on a board, or the room of one robot; by default all. Those with most of the
    robots `first` come first."""
    chosen = [one for one in robots if not board or board in one.boards]
    found = live.rooms((one.name, one.map) for one in chosen)
    shown = [room for room in found if not robot or robot in (name for name, _ in room.robots)]
    return sorted(shown, key=lambda room: -sum(name in first for name, _ in room.robots))


def _example_of(robots: Sequence[RobotView]) -> str:
    """A post that the first of these robots whose abilities are known carries out; empty without one."""
    return next(iter(example_commands([(robot.name, robot.can) for robot in robots if robot.can][:1])), "")


def _count(value: object) -> int:
    return min(max(value, 0), 10_000) if isinstance(value, int) else 0


def _environment() -> Environment:
    made = Environment(
        loader=FileSystemLoader(HERE / "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        auto_reload=False,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"stamp": stamp, "iso": iso, "word": word, "tone": tone, "excerpt": excerpt}
    made.filters |= {"inline_code": inline_code, "report_parts": report_parts, "best_picture": best_picture}
    made.filters |= {"status_card": status_card, "time": from_text}
    made.globals |= {"static": static_url, "states": STATES, "badges": BADGES, "kinds": KINDS, "roles": ROLES}
    made.globals |= {"active_states": ACTIVE_STATES, "progress_bar": PROGRESS_BAR}
    made.globals["rooms"] = _rooms
    made.globals["example_of"] = _example_of
    made.globals["maps"] = made.get_template("live_view.html").module
    made.globals["parts"] = made.get_template("parts.html").module
    return made


_TEMPLATES = _environment()


# ------------------------------------------------------------------ answers
def render_page(
    request: Request, viewer: Viewer, template: str, data: Mapping[str, Any], *, status: int = 200, here: str = ""
) -> HTMLResponse:
    """A page for this viewer. `here` marks the part of the navigation it belongs to."""
    services = get_services(request)
    settings = services.settings
    frame: dict[str, Any] = {"receipt": receipt_of(request, viewer)}
    frame |= {"site": settings.title, "public_read": settings.public_read, "sign_up": settings.sign_up}
    frame["reads"] = services.reading is not None  # commands while they are written
    if services.reading is not None and viewer.account is not None:
        services.reading.warm()  # whoever looks at a page may write a command next
    frame["unread"] = _unread(services, viewer)
    frame["asked"] = _asked(services, viewer)
    html = _TEMPLATES.get_template(template).render(
        {"viewer": viewer, "here": here, "title": settings.title, "problem": "", "feed": ""} | frame | dict(data)
    )
    response = HTMLResponse(html, status, headers=_HEADERS)
    if viewer.account is None:
        access.keep(response, services, viewer)
    return response


def _unread(services: Services, viewer: Viewer) -> int:
    """The number of unread notifications, counted once between two commits."""
    account, reader = viewer.account, services.store.reader
    if account is None or account.suspended:
        return 0
    read = services.marks.unwritten(account)
    key = ("unread", account.id, reader.seen(), tuple(read.items()))
    return reader.kept(key, lambda: notifications.unread(reader, account, read))


def _asked(services: Services, viewer: Viewer) -> int | None:
    """The number of commands that wait for the viewer's approval, counted once between two commits; None for a viewer
    who may approve nothing."""
    account, reader = viewer.account, services.store.reader
    if account is None or account.suspended:
        return None

    def count() -> int | None:
        return len(approvals.asked_of(services, account)) if approvals.may_any(services, account) else None

    return reader.kept(("asked", account.id, reader.seen()), count)


def render_feed(data: Mapping[str, Any]) -> str:
    """An Atom feed, without characters that XML does not allow."""
    return _NOT_XML.sub("", _TEMPLATES.get_template("feed.xml").render(data))


def render_fragment(template: str, data: Mapping[str, Any]) -> str:
    """A part of a page as safe HTML."""
    return Markup(_TEMPLATES.get_template(template).render(data))  # made by a template that escapes


@dataclass(frozen=True, slots=True)
class Receipt:
    """Confirms on the next page that a button was pressed. `action` is stop, estop, approve, deny, cancel, release,
    home or reset."""

    action: str
    robot: str
    at: datetime


def with_receipt(path: str, viewer: Viewer, action: str, robot: str) -> str:
    """The path of the next page with a receipt that is sealed for this viewer's session, so that no foreign link can
    make a page say that a robot was stopped."""
    receipt = f"{action}.{robot}.{int(time.time())}"
    return f"{path.partition('?')[0]}?done={receipt}.{_seal(viewer, receipt)}"


def receipt_of(request: Request, viewer: Viewer) -> Receipt | None:
    receipt, _, seal = request.query_params.get("done", "").rpartition(".")
    if not receipt or not hmac.compare_digest(seal.encode(), _seal(viewer, receipt).encode()):
        return None
    action, robot, at = receipt.split(".")
    return Receipt(action, robot, datetime.fromtimestamp(int(at), UTC))


def _seal(viewer: Viewer, receipt: str) -> str:
    return hmac.digest(viewer.secret.encode(), f"receipt:{receipt}".encode(), "sha256").hex()[:32]


def redirect(path: str) -> RedirectResponse:
    """Redirect the browser to a path with GET."""
    return RedirectResponse(path, 303, headers={"Cache-Control": "no-store"})


def own_path(path: object, otherwise: str = "/") -> str:
    """`path` if it is a path of this forum, else `otherwise`, so that no link to us leads to another site."""
    text = str(path or "")
    safe = re.fullmatch(r"/(?![/\\])[^\x00-\x20\\\x7f]*", text) and len(text) <= 500
    return quote(text, safe="/?&=#%:@,;+~.-_!$'()*") if safe else otherwise


HEADINGS = {
    401: "Please sign in",
    403: "This is not allowed",
    404: "Not found",
    405: "This address does not accept this request",
    409: "That is taken",
    413: "That is too long",
    422: "Something is missing",
    429: "Too fast",
    500: "Something broke here",
    503: "Not possible right now",
}
HINTS = {
    401: "You are signed out. Sign in, then try again.",
    403: "If you need access, ask an administrator of this forum.",
    404: "It may have been moved or mistyped. The boards are a good place to look.",
    500: "It is not your fault, and it was written to the log. Try again in a moment.",
    503: "Try again in a moment.",
}
#: Replaces the short messages of the framework.
_DETAILS = {
    "not_found": "there is no page at this address",
    "method_not_allowed": "this address does not accept this request",
}


async def error_page(request: Request, error: HttpError, draft: str = "") -> Response:
    """The page of an error: what went wrong and what to do. Redirects to the sign-in page if that is all that is
    missing.

    `draft` is a text that was being posted; it is shown so that it is not lost.
    """
    status = error.status
    if status == 401 and not draft and request.method in ("GET", "HEAD"):
        path = request.url.path + (f"?{request.url.query}" if request.url.query else "")
        return redirect(f"/sign-in?next={quote(own_path(path), safe='')}")
    try:
        viewer = await access.viewer(request)
    except BoardError:
        viewer = Viewer(account=None, csrf="", secret="")
    data = {"status_code": status, "heading": HEADINGS.get(status, "This did not work"), "draft": draft}
    data |= {"detail": sentence(_DETAILS.get(error.code) or str(error)), "hint": sentence(hint_of(error))}
    response = render_page(request, viewer, "error.html", data, status=status)
    if error.retry_after_s is not None:
        response.headers["Retry-After"] = str(max(1, math.ceil(error.retry_after_s)))
    return response


def hint_of(error: HttpError) -> str:
    """Tell people how to fix an error; hints for programs are replaced."""
    if error.retry_after_s is not None and (error.retry_after_s <= 300 or not error.hint):
        return f"wait {max(1, math.ceil(error.retry_after_s))} seconds, then try again"
    if error.status == 401 and error.code != "wrong_password":
        return HINTS[401]
    return error.hint if error.hint and "/api/" not in error.hint else HINTS.get(error.status, "")


def error_text(error: HttpError | None) -> str:
    """Describe an error and its remedy in one line; empty without an error."""
    return f"{sentence(str(error))} {sentence(hint_of(error))}".strip() if error else ""


def sentence(text: str) -> str:
    """The text with a capital letter and a full stop."""
    return text[:1].upper() + text[1:] + ("" if not text or text[-1] in ".!?…" else ".")


@cache
def _gzipped(name: str) -> bytes:
    """A static file compressed; it holds nothing secret, unlike pages."""
    return gzip.compress(_STATIC[name], 9, mtime=0)


def static_file(version: str, name: str, *, compressed: bool = False) -> Response:
    """A static file, gzip-compressed if the browser accepts that; cacheable for a year if requested with its hash.
    Raises `BoardError` 404."""
    if name not in _STATIC:
        raise BoardError(404, "no_such_file", "there is no such file")
    kept = "public, max-age=31536000, immutable" if version == _HASHES[name] else "no-cache"
    headers = {"Cache-Control": kept, "Vary": "Accept-Encoding"} | ({"Content-Encoding": "gzip"} if compressed else {})
    content = _gzipped(name) if compressed else _STATIC[name]
    return Response(content, media_type=_MEDIA_TYPES[Path(name).suffix], headers=headers)
