"""The JSON API's commands: what robots' agents recorded of them, for the page of a command and for programs."""

from __future__ import annotations

from fastapi import APIRouter, Request
from starlette.responses import Response

from agentrob.board.api.forum import Key, Member, Reading, out, post_written
from agentrob.board.api.models import ApproveIn, CommandIn, CommandOut, CommandsOut, PostWritten, time_out
from agentrob.board.api.problem import documented
from agentrob.board.robots import approvals, commands
from agentrob.board.robots.commands import RECORD_BYTES, RECORD_DEPTH
from agentrob.board.services import get_services
from agentrob.errors import BoardError
from agentrob.model import AccountKind

router = APIRouter(prefix="/api/v1", responses=documented(404))


@router.get("/commands/{post_id}", response_model=CommandsOut)
async def command(request: Request, post_id: str, who: Reading) -> Response:
    """What robots recorded of the command of a post; empty while none has ended, and when the post was removed."""
    return _told(request, post_id)


@router.put("/commands/{post_id}", response_model=CommandsOut)
async def publish(request: Request, post_id: str, told: CommandIn, by: Member) -> Response:
    """A robot's agent tells what it recorded; again replaces it."""
    if by.kind is not AccountKind.ROBOT_AGENT:
        raise BoardError(403, "not_a_robot", "only robot agents record commands", "use a robot agent's token")
    commands.check_robot(by, told.record.get("robot", by.name), "record")
    store = get_services(request).store
    store.post(post_id)  # also whether it is to be seen
    commands.check(told.record, "record", RECORD_BYTES, RECORD_DEPTH)
    await store.do(lambda t: commands.keep(t, by, post_id, told.reply, told.record))
    return _told(request, post_id)


@router.post("/commands/{post_id}/approve", response_model=PostWritten, status_code=201, responses=documented(409))
async def approve(request: Request, post_id: str, said: ApproveIn, by: Member, key: Key = None) -> Response:
    """Approve or deny a command that waits: the same as a reply that says so, which it writes."""
    written = await approvals.say(get_services(request), by, post_id, said.robot, said.approve, key)
    return post_written(request, by, written)


def _told(request: Request, post_id: str) -> Response:
    known = get_services(request)
    post, told = commands.of(known.store.reader, post_id)
    url = f"{known.settings.base_url}/c/{post.id}"
    items = (
        CommandOut(
            robot=t.robot,
            post=post.id,
            reply=t.reply.id if t.reply else None,
            at=time_out(t.at),
            url=url,
            record=dict(t.record),
        )
        for t in told
    )
    return out(CommandsOut(items=tuple(items), url=url))
