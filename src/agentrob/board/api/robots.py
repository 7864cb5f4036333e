"""The JSON API for robots and pictures: what robots' agents publish, cameras, a robot's buttons, uploads."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, UploadFile
from starlette.responses import FileResponse, Response

from agentrob.board.access import Member, ReadingViewer, Stopper, Viewer
from agentrob.board.api.dependencies import IdempotencyKey, documented, json_response, serializer, still_allowed
from agentrob.board.api.models import (
    EventOut,
    ImageOut,
    Items,
    RightsOut,
    RobotIn,
    RobotOut,
    ScheduleOut,
    Viewers,
    rights_out,
    robot_out,
    time_out,
)
from agentrob.board.auth import rights
from agentrob.board.content import images, uploads
from agentrob.board.db.reader import not_found
from agentrob.board.db.records import THUMB, Image, StoredEvent
from agentrob.board.events.presence import CameraStream
from agentrob.board.robots import actions, commands, schedules
from agentrob.board.robots.actions import check_own_robot
from agentrob.board.robots.schedules import ScheduleView
from agentrob.board.services import AppServices, Services
from agentrob.errors import BoardError
from agentrob.model import Account

router = APIRouter(prefix="/api/v1", responses=documented(404))
#: Files of pictures in posts. They are not below `/api/v1` since pages show them too.
files = APIRouter()

#: Bytes of JSON and levels of nesting that a robot's card may have.
CARD_BYTES, CARD_DEPTH = 16 * 1024, 20
#: Fields of a card that have rights of their own, and so paths of their own.
_NOT_IN_CARD = frozenset({"map", "schedules", "schedules_more"})
_CACHED = {"Cache-Control": "private, max-age=3600"}
_JPEG = {"content": {"image/jpeg": {"schema": {"type": "string", "format": "binary"}}}}


# -------------------------------------------------------------------- robots
@router.get("/robots", response_model=Items[RobotOut], tags=["robots"])
async def list_robots(
    services: AppServices,
    who: ReadingViewer,
    cards: Annotated[bool, Query(description="false leaves out the cards")] = True,
) -> Response:
    """All robots that have an agent's account."""
    robots = services.store.reader.robots()
    return json_response(Items(items=tuple(_robot(services, account, with_card=cards) for account in robots)))


@router.get("/robots/{name}", response_model=RobotOut, tags=["robots"])
async def get_robot(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """One robot as its agent last published it."""
    return json_response(_robot(services, actions.known_robot(services, name)))


@router.get("/robots/{name}/rights", response_model=RightsOut, tags=["robots"])
async def get_robot_rights(
    services: AppServices, name: str, who: ReadingViewer, board_id: Annotated[str, Query(max_length=32)]
) -> Response:
    """The rights to command this robot on this board now. Its agent asks again before every motion."""
    kept = rights.settings_of(services.store.reader, actions.known_robot(services, name).name)
    return json_response(rights_out(kept, services.store.reader.board(board_id), datetime.now(UTC)))


@router.get("/robots/{name}/schedules", response_model=Items[ScheduleOut], tags=["robots"])
async def list_robot_schedules(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """The robot's schedules whose posts the caller may read, the next run first, as its agent last published them."""
    found = schedules.of_robot(services, name, who.account)
    return json_response(Items(items=tuple(_schedule(one, services.settings.base_url) for one in found)))


@router.put("/robots/{name}", response_model=RobotOut, tags=["robots"])
async def publish_robot(services: AppServices, name: str, robot: RobotIn, by: Member) -> Response:
    """Publish the robot's card. Its agent does so at least every 5 s while it runs."""
    check_own_robot(by, name)
    commands.check(robot.card, "card", CARD_BYTES, CARD_DEPTH)  # 413 too large, 422 not plain JSON
    if services.presence.publish(name, robot.card).kept_waiting:
        actions.watch(services, name)
    if services.presence.poses.robot(name).kept_waiting:
        actions.watch_poses(services, name)
    return json_response(_robot(services, by))


@router.put(
    "/robots/{name}/frame",
    response_model=Viewers,
    responses=documented(404, 415),
    openapi_extra={"requestBody": _JPEG | {"required": True}},
    tags=["robots"],
)
async def publish_frame(request: Request, services: AppServices, name: str, by: Member) -> Response:
    """Publish a live picture. Returns the number of viewers of the camera."""
    check_own_robot(by, name)
    jpeg = await request.body()
    images.check_frame(jpeg)
    return json_response(Viewers(viewers=services.presence.show(name, jpeg)))


@router.get(
    "/robots/{name}/frame.jpg",
    response_class=Response,
    responses={200: _JPEG | {"description": "JPEG"}},
    tags=["robots"],
)
async def get_frame(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """The last live picture."""
    actions.check_camera(services, name, who.account)
    jpeg = services.presence.live_frame(actions.known_robot(services, name).name)
    if jpeg is None:
        raise not_found("picture", name, "there is one while somebody watches the camera")
    return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "no-store"})


@router.get(
    "/robots/{name}/camera.mjpg",
    response_class=Response,
    responses={200: {"description": "live", "content": {"multipart/x-mixed-replace": {"schema": {"type": "string"}}}}},
    tags=["robots"],
)
async def stream_camera(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """Live pictures as a multipart stream. Each stream counts as a viewer; the first one causes a `robot.watch`
    event."""
    name = actions.known_robot(services, name).name

    def check(account: Account | None) -> None:
        actions.check_camera(services, name, account)

    check(who.account)
    if services.presence.robot(name).viewers == 0:
        actions.watch(services, name)
    return CameraStream(services.presence, name, still_allowed(services, who, check))


@router.post("/robots/{name}/stop", response_model=EventOut, tags=["robots"])
async def stop_robot(services: AppServices, name: str, by: Stopper, key: IdempotencyKey = None) -> Response:
    """Stop a robot. Every signed-in account may, without a limit."""
    return _event(services, by, await actions.stop(services, name, by, key))


@router.post("/robots/{name}/estop", response_model=EventOut, tags=["robots"])
async def emergency_stop_robot(services: AppServices, name: str, by: Stopper, key: IdempotencyKey = None) -> Response:
    """Stop a robot and lock it: it refuses all motion until its owner releases it. Every signed-in account may."""
    return _event(services, by, await actions.emergency_stop(services, name, by, key))


@router.post("/robots/{name}/release", response_model=EventOut, tags=["robots"])
async def release_robot(services: AppServices, name: str, by: Member, key: IdempotencyKey = None) -> Response:
    """Release a locked robot. Its owner and admins may. The robot's card reports the result as `last_action`."""
    return _event(services, by, await actions.release(services, name, by, key))


@router.post("/robots/{name}/home", response_model=EventOut, tags=["robots"])
async def set_robot_home(services: AppServices, name: str, by: Member, key: IdempotencyKey = None) -> Response:
    """Set the robot's home where it stands. Its owner and admins may. The robot's card reports the result as
    `last_action`."""
    return _event(services, by, await actions.home(services, name, by, key))


@router.post("/robots/{name}/reset", response_model=EventOut, tags=["robots"])
async def reset_robot(services: AppServices, name: str, by: Member, key: IdempotencyKey = None) -> Response:
    """Reset a simulated room. Operators may."""
    return _event(services, by, await actions.reset(services, name, by, key))


def _schedule(one: ScheduleView, base_url: str) -> ScheduleOut:
    return ScheduleOut(
        post_id=one.post.id, url=f"{base_url}/p/{one.post.id}", author=one.post.author.name, text=one.text,
        time_zone=one.zone, runs=tuple(time_out(at) for at in one.runs),
        until=time_out(one.until) if one.until is not None else None, renewable=one.renewable,
    )  # fmt: skip


def _event(services: Services, by: Account, event: StoredEvent) -> Response:
    return json_response(serializer(services, by).event(event))


def _robot(services: Services, account: Account, *, with_card: bool = True) -> RobotOut:
    now = services.presence.robot(account.name)
    url = f"{services.settings.base_url}/robots/{now.name}"
    has_frame = services.presence.live_frame(account.name) is not None
    card = {key: value for key, value in now.card.items() if key not in _NOT_IN_CARD} if with_card else {}
    return robot_out(now.name, url, card, now.seen_at, now.watched, has_frame)


# -------------------------------------------------------------------- images
@router.post("/images", response_model=ImageOut, status_code=201, responses=documented(415, 429), tags=["posts"])
async def upload_image(services: AppServices, file: UploadFile, by: Member, key: IdempotencyKey = None) -> Response:
    """Upload a picture for a post: JPEG, PNG, WebP or GIF, at most 8 MiB. Needs the role operator, or a robot agent."""
    if not uploads.may(by):  # before reading it
        raise BoardError(403, "no_uploads", "only robot agents, operators and admins may upload", "ask an admin")
    image, created = await uploads.take(services.store, by, await file.read(images.MAX_BYTES + 1), key)
    return json_response(serializer(services, by).image(image), 201 if created else 200)


@files.get("/images/{image_id}", include_in_schema=False)
async def get_image(services: AppServices, image_id: str, who: ReadingViewer) -> Response:
    """The file of a picture, for viewers who may read a post that shows it."""
    return await _file(services, *_visible_image(services, image_id, who))


@files.get("/images/{image_id}/small", include_in_schema=False)
async def get_thumbnail(services: AppServices, image_id: str, who: ReadingViewer) -> Response:
    """A picture small enough for a list of posts."""
    image, digest = _visible_image(services, image_id, who)
    if not image.shrinks:
        return await _file(services, image, digest)
    small = await asyncio.to_thread(images.small, images.path_of(services.settings.images_dir, digest))
    return Response(small, media_type="image/webp", headers=_CACHED)


@files.get("/images/{image_id}/thumb", include_in_schema=False)
async def get_list_picture(services: AppServices, image_id: str, who: ReadingViewer) -> Response:
    """A still picture small enough for a line of a list."""
    digest = _visible_image(services, image_id, who)[1]
    path = images.path_of(services.settings.images_dir, digest)
    return Response(await asyncio.to_thread(images.small, path, THUMB), media_type="image/webp", headers=_CACHED)


async def _file(services: Services, image: Image, digest: str) -> Response:
    path, stat = await uploads.file_of(services.store, image, digest)
    options: dict[str, Any] = {"media_type": image.media_type, "headers": _CACHED}
    return FileResponse(path, stat_result=stat, content_disposition_type="inline", **options)


def _visible_image(services: Services, image_id: str, who: Viewer) -> tuple[Image, str]:
    """A picture and the hash that names its file. 404 or 403 for a viewer who may not see it."""
    image, digest = services.store.reader.image(image_id)
    if not services.store.reader.image_shown(image.id, who.account):
        raise not_found("image", image_id)
    if (robot := services.store.reader.image_robot(image.id)) is not None:
        actions.check_camera(services, robot, who.account)
    return image, digest
