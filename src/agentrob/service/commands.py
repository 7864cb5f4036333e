"""The operations of the service on one robot's agent: state, preview, submit, cancel, stop, scan.

A submitted command becomes a post on the forum by the caller's account, and the agent handles it like any other post.
Operations that bypass the forum only end motion (stop, cancel) or cause none (preview, reads).
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import math
import time
import traceback
from collections import OrderedDict
from collections.abc import Callable, Coroutine
from contextlib import AbstractAsyncContextManager
from dataclasses import asdict
from datetime import datetime
from typing import Any, Generic, TypeVar
from uuid import uuid4

import structlog

from agentrob.agent.agent import RobotAgent
from agentrob.agent.intake.triage import Route
from agentrob.agent.queue.queue import QueuedCommand
from agentrob.agent.understanding.extract import Assessment
from agentrob.errors import ForumError, RobotError, ServiceError
from agentrob.language.visible_text import mentions, visible_text
from agentrob.model import Account, Command, CommandState, EndReason, Intent, Post, Report, Understanding, Verdict
from agentrob.model.lifecycle import stored_state
from agentrob.model.operations.data import as_data
from agentrob.process.webhooks import Outbox
from agentrob.service import models
from agentrob.service.auth import Caller
from agentrob.service.metrics import ServiceMetrics

#: Submitted posts kept, so that a caller can read a command before the agent has received it.
REMEMBERED = 1000
SCAN_S = 10.0
_log = structlog.get_logger()
#: Gives up the request's slot while it waits.
Released = Callable[[], AbstractAsyncContextManager[None]]
T = TypeVar("T")
#: The state of a post that is not a command.
NO_COMMAND = {
    Route.STOP: CommandState.STOP, Route.HALT: CommandState.STOP, Route.NOTHING: CommandState.NOTHING
}  # fmt: skip


class CommandService:
    """Serves one agent. `ended` must be called with every final report."""

    def __init__(self, agent: RobotAgent, metrics: ServiceMetrics, outbox: Outbox) -> None:
        self.agent = agent
        self.metrics = metrics
        self._outbox = outbox
        self._submitted: OrderedDict[str, tuple[Post, CommandState]] = OrderedDict()
        self._newest_at: datetime | None = None
        self._news = asyncio.Event()
        self._scans: set[asyncio.Task[None]] = set()
        self._robot, self._readiness = _Coalesced(self._ask_robot), _Coalesced(self._ask_readiness)
        queue = agent.queue
        metrics.watch(lambda: len(queue), lambda: float(queue.moving is not None), lambda: agent.event_stream.silent_s)

    def ended(self, report: Report) -> None:
        """Count a final report and notify webhooks and waiting requests. Never raises: the agent must go on."""
        try:
            self.metrics.ended(report)
            self._outbox.send("command.ended", _of_report(report).model_dump(mode="json"))
        except Exception:
            _log.error("end not reported", post=report.command.post_id, trace=traceback.format_exc())
        news, self._news = self._news, asyncio.Event()
        news.set()

    # ------------------------------------------------------------------ look
    async def robot(self) -> models.Robot:
        return await self._robot.get()

    async def _ask_robot(self) -> models.Robot:
        agent, silent_s = self.agent, self.agent.event_stream.silent_s
        moving = agent.queue.moving
        facts: dict[str, Any] = {
            "name": agent.name, "model": agent.settings.model, "simulated": agent.settings.simulated,
            "state": "offline", "boards": list(agent.settings.boards), "waiting": len(agent.queue),
            "moving": moving.command.post_id if moving else None,
            "forum_silent_s": round(silent_s, 3) if math.isfinite(silent_s) else None,
        }  # fmt: skip
        with contextlib.suppress(RobotError):
            capabilities, state = await asyncio.gather(agent.driver.capabilities(), agent.driver.state())
            facts |= {
                "model": capabilities.model, "ops": sorted(str(op) for op in capabilities.ops),
                "operations": [as_data(operation) for operation in capabilities.declared],
                "limits": asdict(capabilities.limits), "state": "halted" if state.halted else state.mode,
                "battery_percent": state.battery_percent, "homed": state.homed,
                "state_age_s": state.age_s if math.isfinite(state.age_s) else None,
            }  # fmt: skip
        return models.Robot.model_validate(_finite(facts))

    async def picture(self) -> bytes:
        """A JPEG of the robot's own camera. Raises `RobotError`."""
        return await self.agent.driver.look()

    def queue(self) -> models.Queue:
        return models.Queue(items=[self._of_job(job) for job in self.agent.queue])

    async def command(self, post_id: str, wait_s: float, released: Released) -> models.Command:
        """A command as it is now; waits at most `wait_s` for its end. 404 when this agent does not know it."""
        until_s = time.monotonic() + wait_s
        while True:
            news, found = self._news, await self._find(post_id)
            left_s = until_s - time.monotonic()
            if found.ended or left_s <= 0:
                return found
            with contextlib.suppress(TimeoutError):
                async with released(), asyncio.timeout(left_s):
                    await news.wait()

    async def _find(self, post_id: str) -> models.Command:
        agent = self.agent
        if (job := agent.queue.find(post_id)) is not None:
            return self._of_job(job)
        if (record := await asyncio.to_thread(agent.records.read, post_id)) is not None:
            return _of_record(record)
        if agent.ready.is_set() and (claim := await agent.journal.claimed(post_id)) is not None:
            return _of_command(claim.command, claim.final or CommandState.SEEN)
        if post_id in self._submitted:
            post, state = self._submitted[post_id]
            return self._of_post(post, state)
        raise ServiceError(404, "no_such_command", f"this robot's agent knows no command {post_id!r}")

    # ------------------------------------------------------------------ ask
    async def preview(self, caller: Caller, text: str) -> models.Preview:
        """Plan and verdict of this text as if the caller's account had posted it. Posts nothing and moves nothing."""
        self._ready()
        author = await caller.refresh()
        assert author is not None  # the configuration says so
        assessment = await self._assess(self._addressed(text), author)
        understood = assessment.understanding
        return models.Preview(
            intent=str(understood.intent), language=understood.language, plan=understood.plan.as_data(),
            notes=list(understood.plan.notes), question=understood.question, mind=assessment.mind, author=author.name,
            verdict=_judged(assessment.verdict) if understood.intent in (Intent.COMMAND, Intent.ASK_BACK) else None,
        )  # fmt: skip

    async def _assess(self, text: str, author: Account) -> Assessment:
        agent = self.agent
        now, board = agent.event_stream.now(), next(iter(agent.settings.boards), "")
        heard = agent.triage(
            Post("preview", "preview", board, author, text, now, mentions=mentions(visible_text(text)))
        )
        if heard.route is not Route.READ:
            intents = {Route.STOP: Intent.STOP, Route.HALT: Intent.HALT}
            return Assessment(Understanding(intents.get(heard.route, Intent.NOTHING), heard.language), "rules")
        trace = uuid4().hex[:12]
        command = Command("", "preview", "", author, agent.name, heard.text, heard.language, now, trace)
        return await agent.pipeline.assessor.consider(QueuedCommand(command), agent.pipeline.motion.terms)

    async def submit(self, caller: Caller, new: models.NewCommand, key: str | None) -> models.Submitted:
        """Post the command on the forum by the caller's account; the agent receives it from there."""
        self._ready()
        forum, settings = caller.forum, self.agent.settings
        assert forum is not None  # the configuration says so
        if not settings.boards:
            raise ServiceError(409, "no_board", "this robot may be commanded on no board", "set its boards")
        text = self._addressed(new.text)
        key = f"http:{caller.name}:{hashlib.sha256((key or uuid4().hex).encode()).hexdigest()[:40]}"
        if new.topic is not None:
            written = await forum.reply(new.topic, text, key=key)
        else:
            title = new.title or f"A command for {self.agent.name}"
            written = await forum.create_topic(settings.boards[0], title, text, key=key)
        post = written.post
        self._newest_at = max(self._newest_at or post.created_at, post.created_at)
        if written.created or post.id not in self._submitted:
            self._submitted[post.id] = post, NO_COMMAND.get(self.agent.triage(post).route, CommandState.POSTED)
            while len(self._submitted) > REMEMBERED:
                self._submitted.popitem(last=False)
        self._begin_scan()
        return models.Submitted(command=await self._find(post.id), created=written.created)

    async def cancel(self, caller: Caller, post_id: str) -> models.Command:
        """Cancel a command of the caller's own that does not move the robot yet."""
        self._ready()
        author, job = await caller.refresh(), self.agent.queue.find(post_id)
        if job is None:
            found = await self._find(post_id)
            if found.ended:
                return found
            raise ServiceError(409, "not_yet", "the agent has not received it yet", "try again in a moment", 1.0)
        if author is None or job.command.author.id != author.id:
            raise ServiceError(403, "not_yours", "only its author may cancel a command", "anybody may stop the robot")
        if not job.moving:
            job.end(EndReason.TAKEN_BACK)
            await self.agent.journal.end([post_id], EndReason.TAKEN_BACK)
        if job.moving or await self.agent.journal.moved(post_id):
            raise ServiceError(409, "moving", "the command already moves the robot", "stop the robot instead")
        return await self._find(post_id)

    async def stop(self, caller: Caller, received_s: float) -> models.Stopped:
        """Stop the robot: no forum, model, journal, queue or limit stands in the way (laws 13 to 17)."""
        if not caller.may_stop(self.agent.me):
            raise ServiceError(
                403,
                "may_not_stop",
                "this account may not stop the robot: it is suspended, or of a kind that robots do not obey",
            )
        by = caller.account.name if caller.account else f"{caller.name} (HTTP)"
        late_ms = (time.monotonic() - received_s) * 1000
        ended, stopping = self.agent.stop(by, self._newest_at)
        result = await asyncio.shield(stopping)
        if result is None:
            self.metrics.stopped(None, math.inf)
            message = "NOT STOPPED: no driver of this robot answers; use the robot's own stop"
            return models.Stopped(robot=self.agent.name, reached=False, ended=ended, message=message)
        latency_ms = late_ms + result.latency_ms
        self.metrics.stopped(result, latency_ms)
        message = result.message or ("" if result.confirmed else "the robot DID NOT CONFIRM that it stands still")
        return models.Stopped(
            robot=self.agent.name, reached=True, confirmed=result.confirmed, latency_ms=round(latency_ms, 1),
            was_moving=result.was_moving, coasted_m=result.coasted_m, ended=ended, message=message,
        )  # fmt: skip

    async def scan(self) -> models.Scanned:
        """Read the forum now. `heard` is false if it does not answer in time."""
        self._ready()
        heard = False
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(SCAN_S):
                await self.agent.event_stream.poll_now()
                heard = await self.agent.event_stream.prove()
        return models.Scanned(heard=heard, waiting=len(self.agent.queue))

    def _begin_scan(self) -> None:
        """Scan in the background. At most one scan runs and one waits, which covers all requests until it starts."""
        if len(self._scans) >= 2:
            return

        async def scanning() -> None:
            with contextlib.suppress(ServiceError):
                await self.scan()

        task = asyncio.create_task(scanning())
        self._scans.add(task)
        task.add_done_callback(self._scans.discard)

    def wake(self) -> None:
        """Scan the forum because a webhook arrived; the webhook's content is not used."""
        self._begin_scan()

    async def readiness(self) -> models.Readiness:
        return await self._readiness.get()

    async def _ask_readiness(self) -> models.Readiness:
        agent, ready = self.agent, self.agent.ready.is_set()

        async def forum() -> bool:
            if agent.event_stream.silent_s < 5.0:
                return True
            try:
                async with asyncio.timeout(3.0):
                    await agent.forum.now()
            except (ForumError, TimeoutError):
                return False
            return True

        async def driver() -> bool:
            try:
                async with asyncio.timeout(3.0):
                    await agent.driver.state()
            except (RobotError, TimeoutError):
                return False
            return True

        heard, drives = await asyncio.gather(forum(), driver())
        return models.Readiness(ready=ready and heard and drives, agent=ready, forum=heard, driver=drives)

    # ------------------------------------------------------------------ how
    def _ready(self) -> None:
        if not self.agent.ready.is_set():
            raise ServiceError(503, "starting", "the agent has not reached the forum yet", "", 1.0)

    def _addressed(self, text: str) -> str:
        me = self.agent.me
        assert me is not None  # it is ready
        names = {me.name, *(name.lower().lstrip("@") for name in self.agent.settings.mentions)}
        return text if names & set(mentions(visible_text(text))) else f"@{me.name} {text}"

    def _of_job(self, job: QueuedCommand) -> models.Command:
        shown = job.status.shown if job.status is not None else None
        state = CommandState(shown.state) if shown else CommandState.SEEN
        if state.is_final:  # its end counts when its record is there
            state = CommandState.RUNNING if job.moving else CommandState.QUEUED
        found = _of_command(job.command, state)
        if shown is not None:
            found.step, found.steps, found.doing = shown.step, shown.steps, shown.doing
        found.place = self.agent.queue.place(job)
        if job.assessment is not None:
            found.plan, found.verdict = job.assessment.understanding.plan.as_data(), _judged(job.assessment.verdict)
        return found

    def _of_post(self, post: Post, state: CommandState) -> models.Command:
        return models.Command(
            id=post.id, robot=self.agent.name, state=state, ended=state.is_final, topic=post.topic_id, url=post.url,
            author=post.author.name, text=visible_text(post.raw), posted_at=post.created_at,
        )  # fmt: skip


class _Coalesced(Generic[T]):
    """Shares one running request among all concurrent callers."""

    def __init__(self, make: Callable[[], Coroutine[Any, Any, T]]) -> None:
        self._make = make
        self._making: asyncio.Task[T] | None = None

    async def get(self) -> T:
        if self._making is None or self._making.done():
            self._making = asyncio.create_task(self._make())
        return await asyncio.shield(self._making)


def _finite(value: Any) -> Any:
    """Convert to JSON data: infinity and NaN become null."""
    if isinstance(value, dict):
        return {k: _finite(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _judged(verdict: Verdict | None) -> models.Judged | None:
    if verdict is None:
        return None
    return models.Judged(decision=str(verdict.decision), rule=verdict.rule, reason=verdict.reason)


def _of_command(command: Command, state: CommandState) -> models.Command:
    return models.Command(
        id=command.post_id, robot=command.robot, state=state, ended=state.is_final, topic=command.topic_id,
        author=command.author.name, text=command.text, posted_at=command.posted_at, trace_id=command.trace_id,
    )  # fmt: skip


def _of_report(report: Report) -> models.Command:
    found = _of_command(report.command, report.status)
    found.plan, found.verdict, found.message = report.plan.as_data(), _judged(report.verdict), report.message
    found.timings_ms = {k: round(v, 1) for k, v in report.timings_ms.items()}
    found.results = _finite([result.as_data() for result in report.results])
    return found


def _of_record(record: dict[str, Any]) -> models.Command:
    record, verdict = _finite(record), record.get("verdict")
    return models.Command(
        id=record["post"], robot=record["robot"], state=stored_state(record["status"]), ended=True,
        topic=record["topic"],
        author=record["author"]["name"], text=record["text"], posted_at=record["posted_at"],
        trace_id=record["trace_id"], message=record["message"], plan=record["plan"], results=record["steps"],
        verdict=models.Judged.model_validate(verdict) if verdict else None,
        stopped_by=record.get("stopped_by") or "", timings_ms=record["timings_ms"],
    )  # fmt: skip
