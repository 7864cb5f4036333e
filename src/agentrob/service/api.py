"""The endpoints of the agent's HTTP service."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Depends, Header, Path, Query, Request
from prometheus_client import CONTENT_TYPE_LATEST
from starlette.responses import JSONResponse, Response

from agentrob.errors import RobotBusy, RobotError, RobotUnreachable, ServiceError
from agentrob.service import models, webhooks
from agentrob.service.admission import Slot
from agentrob.service.auth import Caller
from agentrob.service.commands import CommandService
from agentrob.service.dependencies import Parts
from agentrob.service.problem import documented

router = APIRouter(prefix="/api/v1")
public = APIRouter()

Name = Annotated[str, Path(pattern=r"^[a-z][a-z0-9_-]{1,31}$", description="the robot's name")]
PostId = Annotated[str, Path(pattern=r"^[A-Za-z0-9_.:-]{1,80}$", description="the command's post on the forum")]
Key = Annotated[
    str | None,
    Header(
        alias="Idempotency-Key",
        pattern=r"^[!-~]{1,200}$",
        description="idempotency key: requests with the same key submit one command",
    ),
]


def parts(request: Request) -> Parts:
    found: Parts = request.app.state.parts
    return found


def slot(request: Request) -> Slot:
    """The request's slot in the concurrency limit."""
    found: Slot = request.scope["state"]["slot"]
    return found


# Coroutines, so that FastAPI runs them in the event loop: a stop never waits for a thread pool.
async def looker(request: Request) -> Caller:
    return parts(request).auth.authenticate(request.headers.get("authorization"), "look")


async def previewer(request: Request) -> Caller:
    return parts(request).auth.authenticate(request.headers.get("authorization"), "preview")


async def commander(request: Request) -> Caller:
    return parts(request).auth.authenticate(request.headers.get("authorization"), "command")


async def stopper(request: Request) -> Caller:
    return parts(request).auth.authenticate(request.headers.get("authorization"), "stop")


async def commands(request: Request, robot: Name) -> CommandService:
    """The service of the named robot. Raises 404 if another robot is served here."""
    found = parts(request).commands
    if robot != found.agent.name:
        raise ServiceError(404, "no_such_robot", f"no robot {robot!r} is served here", found.agent.name)
    return found


Looker = Annotated[Caller, Depends(looker)]
Previewer = Annotated[Caller, Depends(previewer)]
Commander = Annotated[Caller, Depends(commander)]
Stopper = Annotated[Caller, Depends(stopper)]
Commands = Annotated[CommandService, Depends(commands)]


# ---------------------------------------------------------------------- look
@router.get("/robots", responses=documented())
async def list_robots(request: Request, who: Looker) -> models.Robots:
    """List the robot of this service; each robot has its own service."""
    return models.Robots(items=[await parts(request).commands.robot()])


@router.get("/robots/{robot}", responses=documented())
async def robot_status(who: Looker, commands: Commands) -> models.Robot:
    """The robot's current state."""
    return await commands.robot()


@router.get(
    "/robots/{robot}/camera.jpg",
    response_class=Response,
    responses={200: {"content": {"image/jpeg": {}}, "description": "a picture"}, **documented(409, 503)},
)
async def camera_snapshot(who: Looker, commands: Commands) -> Response:
    """A picture of the robot's own camera; at most one every 0.4 s for all clients together (429)."""
    try:
        return Response(await commands.picture(), media_type="image/jpeg")
    except (RobotBusy, RobotUnreachable):
        raise
    except RobotError as e:
        raise ServiceError(409, "no_camera", str(e)) from None


@router.get("/robots/{robot}/queue", responses=documented())
async def list_queue(who: Looker, commands: Commands) -> models.Queue:
    """The running and waiting commands, in order."""
    return commands.queue()


@router.get("/robots/{robot}/commands/{id}", responses=documented(503))
async def get_command(
    request: Request,
    who: Looker,
    commands: Commands,
    post_id: Annotated[PostId, Path(alias="id")],
    wait_s: Annotated[float, Query(ge=0, le=30, description="seconds to wait for its end")] = 0.0,
) -> models.Command:
    """One command: its current state, or its results, requested and measured."""
    return await commands.command(post_id, wait_s, slot(request).released)


# ---------------------------------------------------------------------- ask
@router.post("/robots/{robot}/preview", responses=documented(503))
async def preview_command(who: Previewer, commands: Commands, new: models.NewPreview) -> models.Preview:
    """The plan and verdict of a text. Nothing is posted and nothing moves."""
    return await commands.preview(who, new.text)


@router.post(
    "/robots/{robot}/commands",
    status_code=201,
    responses={200: {"model": models.Submitted, "description": "the key was used before"}, **documented(409, 503)},
)
async def submit_command(
    who: Commander, commands: Commands, new: models.NewCommand, response: Response, key: Key = None
) -> models.Submitted:
    """Post a command on the forum as this token's account; the agent receives it there like any other post."""
    submitted = await commands.submit(who, new, key)
    response.status_code = 201 if submitted.created else 200
    return submitted


@router.post("/robots/{robot}/commands/{id}/cancel", responses=documented(409, 503))
async def cancel_command(
    who: Commander, commands: Commands, post_id: Annotated[PostId, Path(alias="id")]
) -> models.Command:
    """Cancel one of your own commands that does not move the robot yet."""
    return await commands.cancel(who, post_id)


@router.post("/robots/{robot}/scan", responses=documented(503))
async def scan(request: Request, who: Commander, commands: Commands) -> models.Scanned:
    """Read new posts from the forum now; responds when they have been processed."""
    async with slot(request).released():
        return await commands.scan()


@router.post("/robots/{robot}/stop", responses=documented())
async def stop(request: Request, who: Stopper, commands: Commands) -> models.Stopped:
    """Stop the robot and end all commands posted before. Exempt from all limits."""
    return await commands.stop(who, request.scope["state"]["received_s"])


# ---------------------------------------------------------------------- webhooks, health
@router.post("/hooks/{hook}", status_code=202, response_class=Response, responses=documented())
async def hook(request: Request, hook: Annotated[str, Path(pattern=r"^[a-z][a-z0-9_-]{1,31}$")]) -> Response:
    """A webhook of the forum about new posts. Its content is not used; the agent reads the forum."""
    here = parts(request)
    if hook not in here.hooks_in:
        raise ServiceError(404, "no_such_hook", f"no webhook {hook!r} is configured")
    kind, secret = here.hooks_in[hook]
    try:
        webhooks.verify(kind, await request.body(), request.headers, secret)
    except ServiceError:
        here.metrics.count(here.metrics.hooks_in, "false")
        raise
    here.metrics.count(here.metrics.hooks_in, "true")
    here.commands.wake()
    return Response(status_code=202)


@public.get("/healthz")
async def health() -> models.Health:
    """Whether the process responds."""
    return models.Health(status="ok")


@public.get("/readyz", responses={503: {"model": models.Readiness, "description": "not ready"}})
async def readiness(request: Request) -> Response:
    """Whether a command could move the robot now: the state of agent, forum and driver."""
    async with slot(request).released():
        found = await parts(request).commands.readiness()
    return JSONResponse(found.model_dump(), 200 if found.ready else 503)


@public.get(
    "/metrics",
    response_class=Response,
    responses={200: {"content": {"text/plain": {}}, "description": "for Prometheus"}, **documented()},
)
async def metrics(request: Request, who: Looker) -> Response:
    """Metrics for Prometheus; needs a token with the scope look."""
    return Response(parts(request).metrics.text(), media_type=CONTENT_TYPE_LATEST)
