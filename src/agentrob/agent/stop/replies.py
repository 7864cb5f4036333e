"""Send stops straight to the driver and reply to stop posts: no model, journal, queue or limit delays a stop (laws 13
to 17)."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, replace
from datetime import datetime
from functools import partial

import structlog

from agentrob.agent.intake.event_stream import STEP
from agentrob.agent.reporting.status_post import SOON_S, retry_until_answered, retry_while_denied
from agentrob.config.robots import RobotConfig
from agentrob.errors import ForumError, RobotError
from agentrob.forums.bounded import BoundedDict
from agentrob.forums.protocol import Forum, Written
from agentrob.model import Language, Post, StopResult
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.stop import stop_robot

#: The shortest time between two updates of a reply that several stops share.
FOLD_S = 1.0
#: How often the reply to a stop is tried, which takes about 50 s.
TRIES = 9
#: Topics whose reply to a stop is remembered, until a new command comes.
THREADS = 100
_log = structlog.get_logger()
#: The message of the second channel's answer to a halt: it can only stop.
ONLY_STOPPED = "only stopped"
#: If a stop seems later than this, its latency is computed once the clocks are compared.
LATE_MS = STEP.total_seconds() * 1000


@dataclass
class StopReply:
    """The reply to a stop, and to the stops that followed it in its topic.

    `ended` counts commands. `halted` is None if a halt was asked for and could not be done. `taken`: the post is not a
    plain stop. `result` is what the stop did, None if the driver was not reached.
    """

    language: Language
    ended: int
    halted: bool | None
    taken: bool = False
    result: StopResult | None = None
    folded: int = 0
    post_id: str = ""
    edits: int = 0
    updating: asyncio.Task[None] | None = None


class StopReplies:
    """Stops one robot and answers stop posts, with one reply per topic until a new command comes.

    `now` is the forum's clock, `settled` waits until it is known, `render` returns the Markdown of a reply.
    `on_stop` is called with what each stop did.
    """

    def __init__(
        self,
        forum: Forum,
        driver: DriverClient,
        settings: RobotConfig,
        now: Callable[[], datetime],
        render: Callable[[StopReply], Awaitable[str]],
        settled: Callable[[], Awaitable[object]],
        on_stop: Callable[[StopResult | None], None] = lambda _: None,
    ) -> None:
        self._forum = forum
        self._driver = driver
        self._settings = settings
        self._now = now
        self._render = render
        self._settled = settled
        self._on_stop = on_stop
        self._under_way: set[asyncio.Future[None]] = set()
        self._ended_s = -math.inf
        self._replies = BoundedDict[str, asyncio.Task[StopReply | None]](THREADS)

    async def stop(self, by: str, at: datetime, halt: bool = False) -> StopResult | None:
        """Stop or halt the robot. The latency counts from `at`, when the forum accepted the stop.

        None if no driver could be reached on either of its two channels.
        """
        with self._counted():
            result = await self._stop(by, at, halt)
            if result is not None:
                self._ended_s = max(self._ended_s, math.nextafter(result.ended_s, math.inf))
            self._on_stop(result)
            return result

    async def stop_running(self, why: str) -> None:
        """Stop because a command of ours ended early. Raises `RobotError`. It is not a person's stop: commands that
        wait are left alone, unless an earlier stop ends them (law 14)."""
        with self._counted():
            await self._driver.stop(f"agent: {why}", running_only=True)

    async def wait_for_stops(self) -> None:
        """Wait until the driver has answered the stops sent so far."""
        if self._under_way:
            await asyncio.wait(tuple(self._under_way))

    @contextlib.contextmanager
    def _counted(self) -> Iterator[None]:
        done = asyncio.get_running_loop().create_future()
        self._under_way.add(done)
        try:
            yield
        finally:
            self._under_way.discard(done)
            done.set_result(None)

    async def since(self, accepted_s: float) -> float:
        """The time since which no stop may have reached the driver, for a command accepted at `accepted_s` (monotonic)
        that we did not end. Waits for our own stops, which were for earlier commands, and counts from when the driver
        ended those: they do not hide a stop by a person at the robot while it still comes to rest."""
        await self.wait_for_stops()
        return max(accepted_s, self._ended_s)

    async def _stop(self, by: str, at: datetime, halt: bool) -> StopResult | None:
        heard_s = time.monotonic()
        try:
            result = await (self._driver.halt(by) if halt else self._driver.stop(by))
        except RobotError as e:
            _log.warning("driver does not take the stop, trying its second channel", error=str(e))
            first_s = time.monotonic() - heard_s
            try:
                result = await asyncio.to_thread(stop_robot, self._driver.robot, self._settings, by)
                result = replace(result, message=ONLY_STOPPED) if halt else result
            except RobotError as second:
                _log.error("robot not stopped", robot=self._driver.robot, error=str(second))
                return None
        else:
            first_s = 0.0
        if abs(self._late_ms(at, heard_s)) > LATE_MS:
            await self._settled()
        late_ms = max(0.0, self._late_ms(at, heard_s)) + first_s * 1000
        _log.info("stopped", robot=self._driver.robot, by=by, latency_ms=late_ms + result.latency_ms)
        return replace(result, latency_ms=late_ms + result.latency_ms)

    def _late_ms(self, at: datetime, heard_s: float) -> float:
        """How long after the forum accepted it a stop was received, by the forum's clock as it is set now."""
        return ((self._now() - at).total_seconds() - (time.monotonic() - heard_s)) * 1000

    def new_command(self) -> None:
        """Give the next stop a reply of its own."""
        self._replies.clear()

    async def answer(self, post: Post, stopping: asyncio.Task[StopResult | None], reply: StopReply) -> None:
        """Reply to a stop post, or fold it into the reply that its thread already has."""
        if (first := self._replies.get(post.topic_id)) is None:
            replying = asyncio.create_task(self._reply(post, stopping, reply))
            self._replies[post.topic_id] = replying
            await asyncio.shield(replying)
        elif (shown := await asyncio.shield(first)) is not None:
            shown.folded += 1
            if shown.updating is None or shown.updating.done():
                shown.updating = asyncio.create_task(self._update(shown))

    async def _reply(self, post: Post, stopping: asyncio.Task[StopResult | None], reply: StopReply) -> StopReply | None:
        reply.result = await asyncio.shield(stopping)
        if reply.halted and reply.result is not None and reply.result.message == ONLY_STOPPED:
            reply.halted = None
        text = await self._render(reply)

        async def write() -> Written:
            return await self._forum.reply(post.topic_id, text, key=f"stop:{post.id}", reply_to=post.id)

        try:
            written = await retry_while_denied(partial(retry_until_answered, write, TRIES), SOON_S)
        except ForumError as e:
            _log.warning("stop not answered", post=post.id, error=str(e))
            return None
        reply.post_id = written.post.id
        return reply

    async def _update(self, reply: StopReply) -> None:
        await asyncio.sleep(FOLD_S)
        if self._forum.max_edits is not None and reply.edits >= self._forum.max_edits:
            return
        reply.edits += 1
        try:
            await self._forum.edit(reply.post_id, await self._render(reply))
        except ForumError as e:
            _log.info("stop reply not updated", error=str(e))
