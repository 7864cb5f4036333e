"""The final report of a command: composed of text, pictures and record, and posted exactly once."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import structlog

from agentrob.agent.media.geometry import Geometry
from agentrob.agent.media.image_store import ImageStore
from agentrob.agent.media.pictures import Picture, illustrate, late_recording
from agentrob.agent.media.poses import PoseSampler
from agentrob.agent.media.recorder import Recorder
from agentrob.agent.outcomes import reason_text, report_of
from agentrob.agent.queue.previews import Previews
from agentrob.agent.queue.queue import QueuedCommand, page_post
from agentrob.agent.reporting import report as reply_text
from agentrob.agent.reporting import visual_calls, visual_text
from agentrob.agent.reporting.command_page import TRIES, page_of, publish
from agentrob.agent.reporting.mind_notes import notes, summary_text
from agentrob.agent.reporting.preview_text import preview_paragraphs
from agentrob.agent.reporting.status_post import DeniedWrites, Shown, StatusPost, retry_until_answered
from agentrob.agent.stop.owner import OwnerActions
from agentrob.agent.store.journal import Journal
from agentrob.agent.store.records import Records, approval
from agentrob.agent.understanding.understand import Assessor
from agentrob.errors import ForumError
from agentrob.forums.protocol import Forum, PosePages
from agentrob.model import Command, CommandState, Report

#: How long a report waits for its record.
RECORD_S = 2.0
_log = structlog.get_logger()


@dataclass(frozen=True)
class FinalReport:
    """Posts the final reports of one robot's commands. `ending` returns true while the agent is being ended: then it
    waits for no pictures. `on_end` is called with each final report that was posted."""

    name: str
    forum: Forum
    assessor: Assessor
    journal: Journal
    records: Records
    recorder: Recorder
    store: ImageStore | None
    writes: DeniedWrites
    ending: Callable[[], bool]
    owner: OwnerActions
    on_end: Callable[[Report], None]
    poses: PoseSampler
    geometry: Geometry
    previews: Previews

    async def decline(self, command: Command) -> None:
        """Reply to a command that the journal could not record: its first status is its end."""
        job = QueuedCommand(command)
        report = report_of(job, CommandState.FAILED, message=reason_text(job, "journal"))
        shown = Shown(reply_text.final(report), command.card(CommandState.FAILED))
        await self.writes.when_allowed(partial(StatusPost(self.forum, command).claim, shown))
        self.on_end(report)

    async def post_final(self, job: QueuedCommand, report: Report) -> None:
        """Post the final report exactly once, close the claim, and forget the recording."""
        try:
            await self._post(job, report)
        finally:
            self.recorder.forget(job.command.key)

    async def _post(self, job: QueuedCommand, report: Report) -> None:
        command, text, pictures, facts = job.command, *await self._composed(job, report)
        short = ""
        with job.log_errors("end not shortened"):
            short = reply_text.short(report)
        at = len(report.plan.steps)
        card = command.card(report.status, step=at, steps=at, left_to=job.left_to)
        images = [picture.data for picture in pictures if picture.added]
        measured = any(result.moved for result in report.results)
        # Before it is posted, since its reader may reply "again" at once. A goal is not a plan that can be repeated.
        with job.log_errors("plan not stored"):
            if report.status is CommandState.DONE and not report.goal:
                await self.journal.set_plan(command.key, report.plan)
        page = job.page
        published = False

        async def publish_record() -> None:
            """The forum captions the pictures by the record, so it comes first; but the report does not wait long."""
            nonlocal published
            if not published:
                with job.log_errors("record not published"), contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(RECORD_S):
                        published = await publish(self.forum, page, job.status.post_id, facts, pictures)

        shown = Shown(text(pictures), card)
        close = partial(job.status.close, shown, images, short, measured=measured, before=publish_record)
        try:
            ours = await self.writes.when_allowed(close)
        except ForumError as e:  # the claim stays open, so the next start posts it
            _log.error("final reply not posted", post=command.post_id, error=str(e))
            return
        with job.log_errors("claim not closed in the journal"):
            await self.journal.finish(command.key, report.status)
        if not ours:
            return  # another agent of this account posted the end, and keeps its record and pictures
        if not published:
            with job.log_errors("record not published"):
                await publish(self.forum, page, job.status.post_id, facts, pictures)
        with job.log_errors("replay not published"):
            if measured or job.preview is None:
                await self._publish_replay(command, page)
            elif job.shown is None and not self.ending():  # else it is there already
                await self.previews.publish(job.preview, page)
        with job.log_errors("end not passed on"):
            self.on_end(report)
        with job.log_errors("recording not added"):
            if recording := await late_recording(command.key, self.recorder, self.store):
                late = Shown(text((*pictures, recording)), card)
                added = [recording.data] if recording.attached else []
                # Again the captions first, so that the reader sees one change.
                publish_pictures = partial(publish, self.forum, page, job.status.post_id, facts)
                if not job.status.limited:
                    await publish_pictures((*pictures, recording))
                if not await job.status.add(late, added) and published:
                    await publish_pictures(pictures)

    async def publish_left_replays(self) -> None:
        """Publish the replays of commands that an earlier process reported before it ended."""
        for post_id in await self.poses.left():
            claim = await self.journal.claimed(post_id)
            if claim is None:
                await self.poses.forget(post_id)
            elif claim.final is not None:
                await self._publish_replay(claim.command, page_post(claim.command, claim.status_post))

    async def _publish_replay(self, command: Command, page: str) -> None:
        """Publish how the robot moved, if the forum replays commands. `page` is the post with the command's page."""
        if not isinstance(self.forum, PosePages) or self.ending():
            return
        geometry = await self.geometry.publish()
        replay = await self.poses.replay(command.key, geometry)
        if replay and page:
            await retry_until_answered(partial(self.forum.publish_replay, page, replay), TRIES)
        await self.poses.forget(command.key)

    async def _composed(
        self, job: QueuedCommand, report: Report
    ) -> tuple[Callable[[Sequence[Picture]], str], tuple[Picture, ...], dict[str, Any] | None]:
        """The report as a function of its pictures, the pictures, and the record, which is also written to disk."""
        command, looked, language = job.command, job.looked, job.command.language
        summary, by_model, calls, page = None, "", b"", ""
        pictures: tuple[Picture, ...] = ()
        with job.log_errors("no summary"):
            summary = await self.assessor.summary(job, report)
            by_model = summary_text(summary, language)
        with job.log_errors("calls of the model not listed"):
            calls = visual_calls.lines(looked) if looked else b""
        with job.log_errors("no pictures"):
            once = self.forum.max_edits is not None
            there = (Picture("preview", b"", there=True),) * (job.shown.pictures if job.shown is not None else 0)
            draw = None if job.preview is None or there else partial(self.previews.draw, job.preview)
            pictures = await illustrate(
                report, self.recorder, self.store, hurry=self.ending(), once=once, calls=calls, preview=draw
            )
            pictures = (*there, *pictures)
        with job.log_errors("page of the command not known"):
            page = await page_of(self.forum, job.page, hurry=self.ending())
        facts: dict[str, Any] | None = None
        with job.log_errors("record not written"):
            kept, said = self.recorder.stored_path(command.key), summary and summary.as_data()
            more: dict[str, Any] = {"looked": asdict(job.looked)} if job.looked else {}
            more |= {"stopped_by": job.stopped_by, "recording": kept, "summary": said, "approval": approval(job.asked)}
            more |= {"preview": job.preview.as_data()} if job.preview else {}
            facts = self.records.write(report, job.assessment, **more)
        paragraphs: list[str] = []
        with job.log_errors("notes left out"):
            used = (*(job.looked.usage if job.looked else ()), *(summary.usage if summary else ()))
            paragraphs += visual_text.paragraphs(looked, report.results, language, refused=False)
            paragraphs += preview_paragraphs(
                job.preview, job.decided, report.results, language, rehearsable=not report.goal
            )
            paragraphs += notes(job.assessment, self.assessor.mind.name, language, used)
            paragraphs += await self.owner.release_hints(report)

        def text(pictures: Sequence[Picture]) -> str:
            with job.log_errors("report posted as data"):
                table = visual_calls.table(looked, report.results, pictures, language) if looked else ""
                return reply_text.final(report, pictures, paragraphs, by_model, table, page)
            return reply_text.plain(report)

        return text, pictures, facts
