"""The JSON API of live maps and replays: poses of robots, their shapes for the 3D view, and replays of commands."""

from __future__ import annotations

import asyncio
import gzip
import re
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request
from pydantic import BaseModel, ConfigDict, Field
from starlette.responses import Response

from agentrob.board.access import Member, ReadingViewer
from agentrob.board.api.dependencies import documented, json_response, still_allowed
from agentrob.board.api.models import GeometryOut, MapOut, PoseViewers, Viewers
from agentrob.board.db.reader import not_found
from agentrob.board.events.poses import BODY_EVERY_S, MAP_EVERY_S, PoseStream
from agentrob.board.robots import actions, geometry, live, replays
from agentrob.board.robots.actions import check_own_robot
from agentrob.board.services import AppServices
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind

router = APIRouter(prefix="/api/v1", responses=documented(404))

#: 1 to 20 names of robots.
ROBOTS = r"^[a-z0-9_-]{1,32}(,[a-z0-9_-]{1,32}){0,19}$"
_FOREVER = {"Cache-Control": "private, max-age=31536000, immutable"}
_KEPT = {"Cache-Control": "private, no-cache"}
_GZIP: dict[str, Any] = {"content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}}}
_Metres = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
_Point = Annotated[list[_Metres], Field(min_length=2, max_length=2)]


class PoseIn(BaseModel):
    """A pose in metres and radians of the robot's room; `body`: height, tilt (w, x, y, z), joint angles. `plan` and
    `trail`, the requested and the measured path, come with the first pose of a command."""

    model_config = ConfigDict(extra="forbid", strict=True)

    pose: Annotated[list[_Metres], Field(min_length=3, max_length=3)]
    body: Annotated[list[_Metres], Field(max_length=80)] = []
    plan: Annotated[list[_Point], Field(max_length=200)] | None = None
    trail: Annotated[list[_Point], Field(max_length=500)] = []


@router.put("/robots/{name}/pose", response_model=PoseViewers, tags=["robots"])
async def publish_pose(services: AppServices, name: str, frame: PoseIn, by: Member) -> Response:
    """Publish where the robot is. Returns the number of viewers, and after how many seconds to send the next pose."""
    check_own_robot(by, name)
    viewers, body = services.presence.poses.show(name, frame.model_dump(exclude_none=True))
    every_s = BODY_EVERY_S if body else MAP_EVERY_S
    return json_response(PoseViewers(viewers=viewers, every_s=every_s, body=body))


@router.get(
    "/poses",
    response_class=Response,
    responses={200: {"description": "live", "content": {"text/event-stream": {"schema": {"type": "string"}}}}},
    tags=["robots"],
)
async def stream_poses(
    services: AppServices,
    who: ReadingViewer,
    robots: Annotated[str, Query(pattern=ROBOTS, description="names, separated by commas")],
    body: Annotated[bool, Query(description="also how each robot holds its body")] = False,
) -> Response:
    """Poses of robots as server-sent events. The first viewer causes a `robot.poses` event."""
    names = tuple(sorted({actions.known_robot(services, name).name for name in robots.split(",")}))

    def check(account: Account | None) -> None:
        for name in names:
            live.check(services, name, account)

    check(who.account)
    poses, account = services.presence.poses, who.account.id if who.account else None
    poses.check(account)
    for name in names:
        actions.watch_poses(services, name)
    return PoseStream(poses, names, body, account, still_allowed(services, who, check), services.presence.closed)


@router.get("/robots/{name}/map", response_model=MapOut, tags=["robots"])
async def get_map(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """The room of a robot as its owner describes it, and the name of the robot's geometry."""
    name = actions.known_robot(services, name).name
    live.check(services, name, who.account)
    map_data = services.presence.robot(name).card.get("map")
    if live.map_view(map_data) is None:
        raise not_found("map", name, "there is one while its agent runs")
    assert isinstance(map_data, dict)
    return json_response(MapOut(robot=name, map=map_data, geometry=_geometry(map_data)))


def _geometry(map_data: dict[str, Any]) -> str | None:
    name = map_data.get("geometry")
    return name if isinstance(name, str) and re.fullmatch(r"[0-9a-f]{32}", name) else None


# -------------------------------------------------------------------- geometry
@router.put(
    "/robots/{name}/geometry",
    response_model=GeometryOut,
    responses=documented(404, 413),
    openapi_extra={"requestBody": _GZIP | {"required": True}},
    tags=["robots"],
)
async def publish_geometry(request: Request, services: AppServices, name: str, by: Member) -> Response:
    """Store the shape of a robot, gzipped, for the 3D view (`docs/reference/interfaces.md`). Returns the name it is
    stored under."""
    check_own_robot(by, name)
    data = await request.body()
    stored = await asyncio.to_thread(geometry.store, services.settings.images_dir, data)
    return json_response(GeometryOut(name=stored))


@router.get("/geometry/{name}", response_class=Response, responses={200: _GZIP}, tags=["robots"])
async def get_geometry(services: AppServices, name: str, who: ReadingViewer) -> Response:
    """A stored geometry, to keep for ever: another shape has another name."""
    data = await asyncio.to_thread(geometry.read, services.settings.images_dir, name)
    if data is None:
        raise not_found("geometry", name)
    return Response(data, media_type="application/octet-stream", headers=_FOREVER | {"Content-Encoding": "gzip"})


# -------------------------------------------------------------------- replays
@router.put(
    "/commands/{post_id}/replay",
    response_model=Viewers,
    responses=documented(404, 413),
    openapi_extra={"requestBody": _GZIP | {"required": True}},
    tags=["commands"],
)
async def publish_replay(request: Request, services: AppServices, post_id: str, by: Member) -> Response:
    """Publish how a robot moved in a command (`docs/reference/interfaces.md`); a later one replaces it."""
    if by.kind is not AccountKind.ROBOT_AGENT:
        raise BoardError(403, "not_a_robot", "only robot agents publish replays", "use a robot agent's token")
    services.store.reader.post(post_id)  # 404 also for a post that the agent may not see
    replay = await request.body()
    await asyncio.to_thread(replays.unpacked, replay)
    await services.store.do(lambda t: replays.save(t, by, post_id, replay))
    return json_response(Viewers(viewers=0))


@router.get(
    "/commands/{post_id}/replay",
    response_class=Response,
    responses={200: {"content": {"application/json": {"schema": {"type": "object"}}}, "description": "the replay"}},
    tags=["commands"],
)
async def get_replay(
    request: Request,
    services: AppServices,
    post_id: str,
    robot: Annotated[str, Query(max_length=32)],
    who: ReadingViewer,
) -> Response:
    """How a robot moved in a command, for those who may read its post."""
    replay = replays.replay_of(services.store.reader, post_id, robot)
    if replay is None:
        raise not_found("replay", f"{post_id} of {robot}")
    if "gzip" in request.headers.get("accept-encoding", ""):
        return Response(replay, media_type="application/json", headers=_KEPT | {"Content-Encoding": "gzip"})
    return Response(gzip.decompress(replay), media_type="application/json", headers=_KEPT)
