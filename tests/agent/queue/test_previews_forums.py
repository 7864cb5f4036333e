"""A command with a preview that waits for an approval, on forums that delay or limit what robots write: it is carried
out after the approval and ends, whatever becomes of the preview."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.agent import RobotAgent
from agentrob.errors import ForumError, ForumLimited
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import Post, Role, StatusCard
from agentrob.rehearsal.client import rehearse
from agentrob.rehearsal.preview import Preview
from tests.agent.agent_scene import FINAL, ROBOT, Driver, Scene, make_scene, robot_settings
from tests.waiting import until

DRAWS = True
WALK, YES, NO = f"@{ROBOT} walk forward 0.3 m", f"@{ROBOT} approve", f"@{ROBOT} deny"
SHOWN = "**Preview: nothing moved.**"
#: A process of a preview that never answers.
HANGS = (sys.executable, "-c", "import time; time.sleep(1000)")


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


def asks(driver: Driver, folder: Path, **forum: Any) -> Scene:
    """A scene in which walks need an approval; the preview is made of geometry, so it is there at once."""
    scene = make_scene(driver, folder, MemoryForum.world(**forum), approval={"classes": ["move"]})
    scene.person("carol", Role.MODERATOR)
    return scene


class DelayingForum(MemoryForum):
    """A forum that takes its time with edits, as a server does: one that has reached it is made, although the client
    does not wait for it any more. `delayed` says which texts wait for `let`."""

    def __init__(self, scene: Scene, delayed: Callable[[str], bool]) -> None:
        super().__init__(scene.world, ROBOT)
        self.let, self.reached = asyncio.Event(), asyncio.Event()
        self._delayed, self._made = delayed, set[asyncio.Task[Post]]()

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        async def made() -> Post:
            if self._delayed(body):
                self.reached.set()
                await self.let.wait()
            return await super(DelayingForum, self).edit(post_id, body, images=images, card=card)

        task = asyncio.create_task(made())
        self._made.add(task)
        return await asyncio.shield(task)


async def until_moved(agent: RobotAgent, post: Post) -> None:
    """Wait until the journal has the measured result of the command."""
    await until(lambda: agent.journal.motion_result(post.id), lambda text: text is not None)


@pytest.mark.parametrize("delayed", [SHOWN, "Waits for approval"])
async def test_law_7_a_command_moves_after_its_approval_although_the_forum_delays_what_was_asked(
    driver: Driver, tmp_path: Path, delayed: str
) -> None:
    scene = asks(driver, tmp_path)
    forum = DelayingForum(scene, lambda text: delayed in text)
    async with scene.agent(forum=forum) as agent:
        post = await scene.post("alice", WALK)
        await asyncio.wait_for(forum.reached.wait(), 60)
        await scene.post("carol", YES, topic=post.topic_id)
        await until_moved(agent, post)
        assert not forum.let.is_set()
        forum.let.set()
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        assert "No preview was shown when it was approved" in final.raw
        await asyncio.gather(*forum._made)
        assert scene.replies(post)[0].raw == final.raw  # what came late replaced nothing


async def test_an_approval_that_is_read_while_the_preview_is_shown_is_bound_to_the_post_alone(
    driver: Driver, tmp_path: Path
) -> None:
    """Nobody approves what was not there when they wrote."""
    scene = asks(driver, tmp_path)
    forum = DelayingForum(scene, lambda text: SHOWN in text)
    async with scene.agent(forum=forum) as agent:
        post = await scene.post("alice", WALK)
        await asyncio.wait_for(forum.reached.wait(), 60)
        record, read = agent.pipeline.approvals.record_decision, asyncio.Event()

        async def late(*given: Any) -> None:
            read.set()
            await scene.until(lambda: (job := agent.queue.find(post.id)) is not None and job.shown is not None)
            await record(*given)

        agent.pipeline.approvals.record_decision = late  # type: ignore[method-assign]
        await scene.post("carol", YES, topic=post.topic_id)
        await asyncio.wait_for(read.wait(), 60)
        forum.let.set()
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        assert "No preview was shown when it was approved" in final.raw


@pytest.mark.parametrize(("text", "state"), [(NO, "refused"), ("stop", "cancelled")])
async def test_law_14_a_denial_and_a_stop_do_not_wait_for_a_forum_that_delays_the_preview(
    driver: Driver, tmp_path: Path, text: str, state: str
) -> None:
    scene = asks(driver, tmp_path)
    forum = DelayingForum(scene, lambda text: SHOWN in text)
    async with scene.agent(forum=forum) as agent:
        post = await scene.post("alice", WALK)
        await asyncio.wait_for(forum.reached.wait(), 60)
        await scene.post("carol", text, topic=post.topic_id)
        await scene.until(lambda: agent.queue.find(post.id) is None)  # it has ended; its reply comes after the edit
        assert not forum.let.is_set()
        forum.let.set()
        assert (await scene.final(post)).card.state == state


class RefusingForum(MemoryForum):
    """A forum that writes what `wanted` accepts, and answers anything else with an error."""

    def __init__(self, scene: Scene, error: ForumError, wanted: Callable[[str, Sequence[bytes]], bool]) -> None:
        super().__init__(scene.world, ROBOT)
        self._error, self._wanted = error, wanted

    async def edit(
        self, post_id: str, body: str, *, images: Sequence[bytes] = (), card: StatusCard | None = None
    ) -> Post:
        if not self._wanted(body, images):
            raise self._error
        return await super().edit(post_id, body, images=images, card=card)


@pytest.mark.parametrize("error", [ForumError("it is too long"), ForumLimited("too many edits", 1000.0)])
async def test_a_forum_that_refuses_the_preview_lets_the_command_be_approved(
    driver: Driver, tmp_path: Path, error: ForumError
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent(forum=RefusingForum(scene, error, lambda text, _: SHOWN not in text)):
        post = await scene.post("alice", WALK)
        await scene.state(post, "waiting")
        await scene.post("carol", YES, topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        assert "No preview was shown when it was approved" in final.raw


async def test_a_forum_that_takes_no_picture_shows_the_preview_without(driver: Driver, tmp_path: Path) -> None:
    scene = asks(driver, tmp_path)
    no = ForumError("no pictures")
    async with scene.agent(forum=RefusingForum(scene, no, lambda text, images: SHOWN not in text or not images)):
        post = await scene.post("alice", WALK)
        shown = await scene.until(lambda: next((p for p in scene.replies(post) if SHOWN in p.raw), None))
        assert shown.images == ()
        await scene.post("carol", YES, topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        assert "Preview and measured: " in final.raw


async def test_the_picture_of_the_paths_is_beside_the_question_and_once_in_the_report(
    driver: Driver, tmp_path: Path
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent():
        post = await scene.post("alice", WALK)
        shown = await scene.until(lambda: next((p for p in scene.replies(post) if SHOWN in p.raw), None))
        assert [scene.world.pictures[name][:4] for name in shown.images] == [b"\x89PNG"]
        await scene.post("carol", YES, topic=post.topic_id)
        final = await scene.final(post)
        assert final.images[0] == shown.images[0]
        assert len({scene.world.pictures[name] for name in final.images}) == len(final.images)
        assert "the paths of the preview" in final.raw


@pytest.mark.parametrize("edits", [0, 1, 3])
async def test_where_edits_are_limited_the_preview_is_a_reply_of_its_own_and_may_be_approved_there(
    driver: Driver, tmp_path: Path, edits: int
) -> None:
    scene = asks(driver, tmp_path, max_edits=edits)
    async with scene.agent():
        post = await scene.post("alice", WALK)
        shown = await scene.until(lambda: next((p for p in scene.replies(post) if SHOWN in p.raw), None))
        asked = next(p for p in scene.replies(post) if "Waits for approval" in p.raw)
        assert shown.id != asked.id
        assert len(shown.images) == 1
        await scene.post("carol", YES, topic=post.topic_id, reply_to=shown.id)
        final = await scene.until(
            lambda: next((p for p in scene.replies(post) if "Preview and measured" in p.raw), None)
        )
        assert final.card.state == "done", final.raw


@pytest.mark.parametrize("edits", [None, 0])
async def test_a_preview_that_hangs_delays_neither_the_question_nor_the_approval_nor_the_end(
    driver: Driver, tmp_path: Path, edits: int | None
) -> None:
    world = MemoryForum.world(max_edits=edits)
    scene = make_scene(
        driver, tmp_path, world, model="go2", rehearsal={"world": "room"}, approval={"classes": ["move"]}
    )
    scene.person("carol", Role.MODERATOR)
    async with scene.agent() as agent:
        agent.pipeline.answers.previews.rehearse = partial(rehearse, command=HANGS)
        post = await scene.post("alice", WALK)
        await scene.until(lambda: any("A preview follows here." in p.raw for p in scene.replies(post)))
        await scene.post("carol", YES, topic=post.topic_id)
        final = await scene.until(
            lambda: next((p for p in scene.replies(post) if "counts for the post" in p.raw), None)
        )
        assert final.card.state == "done", final.raw


async def test_a_preview_that_cannot_be_made_is_said_and_the_command_may_be_approved(
    driver: Driver, tmp_path: Path
) -> None:
    scene = asks(driver, tmp_path)
    async with scene.agent() as agent:

        async def fails(*_: object) -> Preview:
            raise RuntimeError("our own fault")

        agent.pipeline.answers.previews.rehearse = fails
        post = await scene.post("alice", WALK)
        await scene.until(lambda: any("There is no preview" in p.raw for p in scene.replies(post)))
        await scene.post("carol", YES, topic=post.topic_id)
        final = await scene.final(post)
        assert final.card.state == "done", final.raw
        assert "counts for the post alone" in final.raw
        assert {p.card.state for p in scene.replies(post) if p.card} <= FINAL
