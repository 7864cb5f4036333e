"""The JSON API for commands: the records that robots' agents keep of them, and approvals."""

from __future__ import annotations

from dataclasses import asdict

from fastapi import APIRouter
from starlette.responses import Response

from agentrob.board.access import Member, ReadingViewer, Stopper
from agentrob.board.api.dependencies import IdempotencyKey, documented, json_response
from agentrob.board.api.forum import post_written
from agentrob.board.api.models import (
    CommandIn,
    CommandOut,
    CommandsOut,
    DecisionIn,
    DraftIn,
    PostWritten,
    ReadingOut,
    RobotReadingOut,
    time_out,
)
from agentrob.board.robots import approvals, commands, reading
from agentrob.board.robots.commands import RECORD_BYTES, RECORD_DEPTH
from agentrob.board.services import AppServices, Services
from agentrob.errors import BoardError
from agentrob.model import AccountKind

router = APIRouter(prefix="/api/v1", responses=documented(404), tags=["commands"])


@router.post("/commands/read", response_model=ReadingOut, responses=documented(429))
async def read_command(services: AppServices, draft: DraftIn, by: Stopper) -> Response:
    """Read a command without carrying it out: what each robot that it addresses would do, by rules alone. Stores
    nothing."""
    found = await reading.read(services, by, draft.text, draft.board_id, draft.topic_id)
    robots = tuple(RobotReadingOut(**asdict(one)) for one in found.robots)
    return json_response(ReadingOut(line=found.line, robots=robots))


@router.get("/commands/{post_id}", response_model=CommandsOut)
async def get_command(services: AppServices, post_id: str, who: ReadingViewer) -> Response:
    """Robots' records of the command in a post; empty until the command has ended, and if the post was removed."""
    return _records(services, post_id)


@router.put("/commands/{post_id}", response_model=CommandsOut)
async def publish_command_record(services: AppServices, post_id: str, entry: CommandIn, by: Member) -> Response:
    """Publish the record of a robot's agent; a later one replaces it."""
    if by.kind is not AccountKind.ROBOT_AGENT:
        raise BoardError(403, "not_a_robot", "only robot agents can record commands", "use a robot agent's token")
    commands.check_robot(by, entry.record.get("robot", by.name), "record")
    services.store.reader.post(post_id)  # 404 also for a post that the agent may not see
    commands.check(entry.record, "record", RECORD_BYTES, RECORD_DEPTH)
    await services.store.do(lambda t: commands.save_record(t, by, post_id, entry.reply_id, entry.record))
    return _records(services, post_id)


@router.post("/commands/{post_id}/approve", response_model=PostWritten, status_code=201, responses=documented(409))
async def approve_command(
    services: AppServices, post_id: str, decision: DecisionIn, by: Member, key: IdempotencyKey = None
) -> Response:
    """Approve a waiting command. Writes a reply by the caller that says so, which has the same effect."""
    return post_written(services, by, await approvals.say(services, by, post_id, decision.robot, True, key))


@router.post("/commands/{post_id}/deny", response_model=PostWritten, status_code=201, responses=documented(409))
async def deny_command(
    services: AppServices, post_id: str, decision: DecisionIn, by: Member, key: IdempotencyKey = None
) -> Response:
    """Deny a waiting command. Writes a reply by the caller that says so, which has the same effect."""
    return post_written(services, by, await approvals.say(services, by, post_id, decision.robot, False, key))


def _records(services: Services, post_id: str) -> Response:
    post, records = commands.records_of(services.store.reader, post_id)
    url = f"{services.settings.base_url}/c/{post.id}"
    items = (
        CommandOut(
            robot=t.robot,
            post_id=post.id,
            reply_id=t.reply.id if t.reply else None,
            at=time_out(t.at),
            url=url,
            record=dict(t.record),
        )
        for t in records
    )
    return json_response(CommandsOut(items=tuple(items), url=url))
