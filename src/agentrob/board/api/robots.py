"""The JSON API's robots and pictures: what robots' agents publish, who looks, the buttons, uploads."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, UploadFile
from starlette.responses import FileResponse, Response

from agentrob.board.api.forum import Key, Member, Reading, Stopper, out, shaper, still_allowed
from agentrob.board.api.models import (
    EventOut,
    ImageOut,
    Items,
    RightsOut,
    RobotIn,
    RobotOut,
    Viewers,
    rights_out,
    robot_out,
)
from agentrob.board.api.problem import documented
from agentrob.board.auth.access import Viewer
from agentrob.board.content import images, uploads
from agentrob.board.db.reader import not_found
from agentrob.board.db.records import Image
from agentrob.board.robots import actions, commands, rights
from agentrob.board.robots.presence import CameraStream
from agentrob.board.services import Services, get_services
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind

router = APIRouter(prefix="/api/v1", responses=documented(404))
#: Pictures in posts, beside the API since pages show them.
files = APIRouter()

#: Bytes of JSON and levels of nesting that a robot's card may have.
CARD_BYTES, CARD_DEPTH = 16 * 1024, 20
#: What a browser may keep of a picture.
_KEPT = {"Cache-Control": "private, max-age=3600"}
_JPEG = {"content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}}


# -------------------------------------------------------------------- robots
@router.get("/robots", response_model=Items[RobotOut])
async def robots(request: Request, who: Reading) -> Response:
    """All robots that have an agent's account."""
    parts = get_services(request)
    return out(Items(items=tuple(_robot(parts, account) for account in parts.store.robots())))


@router.get("/robots/{name}", response_model=RobotOut)
async def robot(request: Request, name: str, who: Reading) -> Response:
    """One robot as its agent last told."""
    parts = get_services(request)
    return out(_robot(parts, actions.known_robot(parts, name)))


@router.get("/robots/{name}/rights", response_model=RightsOut)
async def robot_rights(
    request: Request, name: str, who: Reading, board: Annotated[str, Query(max_length=32)]
) -> Response:
    """Who may do what with this robot on this board now: what its agent asks again before every motion."""
    store = get_services(request).store
    kept = rights.settings_of(store.reader, actions.known_robot(get_services(request), name).name)
    return out(rights_out(kept, store.board(board), datetime.now(UTC)))


@router.put("/robots/{name}", response_model=RobotOut)
async def publish(request: Request, name: str, told: RobotIn, by: Member) -> Response:
    """The robot's agent tells of it, at least every 5 s while it lives."""
    parts = get_services(request)
    _own(by, name)
    _check_card(told.card)
    if parts.presence.publish(name, told.card).kept_waiting:
        actions.watch(parts, name)
    return out(_robot(parts, by))


@router.put(
    "/robots/{name}/frame",
    response_model=Viewers,
    responses=documented(404, 415),
    openapi_extra={"requestBody": _JPEG | {"required": True}},
)
async def show(request: Request, name: str, by: Member) -> Response:
    """The robot's agent shows a live picture; it learns how many look."""
    _own(by, name)
    jpeg = await request.body()
    images.check_frame(jpeg)
    return out(Viewers(viewers=get_services(request).presence.show(name, jpeg)))


@router.get("/robots/{name}/frame.jpg", response_class=Response, responses={200: _JPEG | {"description": "JPEG"}})
async def frame(request: Request, name: str, who: Reading) -> Response:
    """The last live picture."""
    parts = get_services(request)
    actions.check_camera(parts, name, who.account)
    jpeg = parts.presence.live_frame(actions.known_robot(parts, name).name)
    if jpeg is None:
        raise not_found("picture", name, "there is one while somebody looks at the camera")
    return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


@router.get(
    "/robots/{name}/camera.mjpg",
    response_class=Response,
    responses={200: {"description": "live", "content": {"multipart/x-mixed-replace": {"schema": {"type": "string"}}}}},
)
async def camera(request: Request, name: str, who: Reading) -> Response:
    """Live pictures as a multipart stream. Whoever opens it is a viewer; the first one makes a `robot.watch` event."""
    parts = get_services(request)
    name = actions.known_robot(parts, name).name

    def check(account: Account | None) -> None:
        actions.check_camera(parts, name, account)

    check(who.account)
    if parts.presence.robot(name).viewers == 0:
        actions.watch(parts, name)
    return CameraStream(parts.presence, name, still_allowed(parts, who, check))


@router.post("/robots/{name}/stop", response_model=EventOut)
async def stop(request: Request, name: str, by: Stopper, key: Key = None) -> Response:
    """Stop a robot: every signed-in account may, and nothing stands in its way."""
    return out(shaper(request, by).event(await actions.stop(get_services(request), name, by, key)))


@router.post("/robots/{name}/estop", response_model=EventOut)
async def emergency_stop(request: Request, name: str, by: Stopper, key: Key = None) -> Response:
    """Stop a robot and lock it: it refuses all motion until its owner releases it. Every signed-in account may."""
    return out(shaper(request, by).event(await actions.emergency_stop(get_services(request), name, by, key)))


@router.post("/robots/{name}/release", response_model=EventOut)
async def release(request: Request, name: str, by: Member, key: Key = None) -> Response:
    """Release a locked robot: its owner and admins. What came of it is in its card, `told`."""
    return out(shaper(request, by).event(await actions.release(get_services(request), name, by, key)))


@router.post("/robots/{name}/home", response_model=EventOut)
async def home(request: Request, name: str, by: Member, key: Key = None) -> Response:
    """Make the robot's home where it stands: its owner and admins. What came of it is in its card, `told`."""
    return out(shaper(request, by).event(await actions.home(get_services(request), name, by, key)))


@router.post("/robots/{name}/reset", response_model=EventOut)
async def reset(request: Request, name: str, by: Member, key: Key = None) -> Response:
    """Put a simulated room back: operators only."""
    return out(shaper(request, by).event(await actions.reset(get_services(request), name, by, key)))


def _robot(parts: Services, account: Account) -> RobotOut:
    now = parts.presence.robot(account.name)
    url, shown = f"{parts.settings.base_url}/robots/{now.name}", parts.presence.live_frame(account.name) is not None
    return robot_out(now.name, url, now.card, now.seen_at, now.watched, shown)


def _check_card(card: dict[str, Any]) -> None:
    """413 for a card that is too large, 422 for what is no JSON or cannot be shown."""
    commands.check(card, "card", CARD_BYTES, CARD_DEPTH)


def _own(by: Account, name: str) -> None:
    if by.kind is not AccountKind.ROBOT_AGENT or by.name != name:
        raise BoardError(403, "not_this_robot", f"only the robot agent {name[:64]!r} may do this", "use its token")


# -------------------------------------------------------------------- images
@router.post("/images", response_model=ImageOut, status_code=201, responses=documented(415, 429))
async def upload(request: Request, file: UploadFile, by: Member, key: Key = None) -> Response:
    """A picture for a post: JPEG, PNG, WebP or GIF, at most 8 MiB. Robot agents, operators and admins."""
    if not uploads.may(by):  # before reading it
        raise BoardError(403, "no_uploads", "only robot agents, operators and admins may upload", "ask an admin")
    image, created = await uploads.take(get_services(request), by, await file.read(images.MAX_BYTES + 1), key)
    return out(shaper(request, by).image(image), 201 if created else 200)


@files.get("/images/{image_id}", include_in_schema=False)
async def picture(request: Request, image_id: str, who: Reading) -> Response:
    """The file of a picture, for those who may read a post that shows it."""
    return await _file(get_services(request), *_seen(get_services(request), image_id, who))


@files.get("/images/{image_id}/small", include_in_schema=False)
async def thumbnail(request: Request, image_id: str, who: Reading) -> Response:
    """A picture small enough for a list of posts."""
    parts = get_services(request)
    image, digest = _seen(parts, image_id, who)
    if not image.shrinks:
        return await _file(parts, image, digest)
    small = await asyncio.to_thread(images.small, images.path_of(parts.settings.images_dir, digest))
    return Response(small, media_type="image/webp", headers=_KEPT)


async def _file(parts: Services, image: Image, digest: str) -> Response:
    path, stat = await uploads.file_of(parts, image, digest)
    shown = {"media_type": image.media_type, "headers": _KEPT, "content_disposition_type": "inline"}
    return FileResponse(path, stat_result=stat, **shown)  # type: ignore[arg-type]


def _seen(parts: Services, image_id: str, who: Viewer) -> tuple[Image, str]:
    """A picture and the hash that names its file, for those who may see it. 403, 404."""
    image, digest = parts.store.reader.image(image_id)
    if not parts.store.reader.image_shown(image.id, who.account):
        raise not_found("image", image_id)
    if (robot := parts.store.reader.image_robot(image.id)) is not None:
        actions.check_camera(parts, robot, who.account)
    return image, digest
