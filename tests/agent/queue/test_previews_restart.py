"""A preview that was shown before the agent was restarted: approvals stay bound to it (law 7)."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterator
from contextlib import asynccontextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from agentrob.agent.store.journal import Journal
from agentrob.errors import ForumUnreachable
from agentrob.forums.memory.forum import MemoryForum
from agentrob.model import Capabilities, Direction, Op, Plan, Post, Primitive, Role
from agentrob.rehearsal.geometry import geometry_preview
from agentrob.rehearsal.preview import Basis, Missing, Preview, PreviewRequest
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings

pytestmark = pytest.mark.usefixtures("database")
WALK, YES, BOUND = f"@{ROBOT} walk forward 0.5 m", f"@{ROBOT} approve", "bound to this preview"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    made = Driver(tmp_path_factory.mktemp("driver"), robot_settings())
    yield made
    made.end()


class Rehearsals:
    """Previews by geometry, that say they are of the simulator; each has another seed, and so another hash."""

    def __init__(self) -> None:
        self.made: list[Preview] = []

    async def __call__(self, request: PreviewRequest, capabilities: Capabilities) -> Preview:
        found = geometry_preview(request, capabilities, Missing.NO_WORLD)
        self.made.append(replace(found, basis=Basis.SIMULATION, missing=None, seed=len(self.made)))
        return self.made[-1]


@pytest.fixture
def rehearsals() -> Rehearsals:
    return Rehearsals()


@pytest.fixture(params=[None, 9], ids=["edits", "few edits"])
def scene(request: pytest.FixtureRequest, driver: Driver, tmp_path: Path) -> Scene:
    """A robot all of whose walks need an approval, on a forum with and without a limit of edits."""
    made = make_scene(driver, tmp_path, model="go2", rehearsal={"world": "room"}, approval={"classes": ["move"]})
    made.world.max_edits = request.param
    made.person("carol", Role.MODERATOR)
    return made


@asynccontextmanager
async def agent(scene: Scene, rehearsals: Rehearsals, **more: Any) -> Any:
    async with scene.agent(**more) as running:
        running.pipeline.answers.previews.rehearse = rehearsals
        yield running


async def shown(scene: Scene, post: Post) -> Post:
    return await scene.until(lambda: next((p for p in scene.replies(post) if BOUND in p.raw), None))


def record(scene: Scene, post: Post) -> dict[str, Any]:
    return json.loads((scene.folder / f"agents/{ROBOT}/records/{post.id}.json").read_text())


async def report(scene: Scene, post: Post, state: str = "done") -> Post:
    final = await scene.final(post)
    assert final.card.state == state, final.raw
    return final


async def approve(scene: Scene, post: Post) -> None:
    await scene.post("carol", YES, topic=post.topic_id, reply_to=post.id)


@pytest.mark.parametrize("down", [False, True], ids=["after the restart", "while it is down"])
async def test_law_7_an_approval_after_a_restart_is_bound_to_the_preview_that_was_shown_before(
    scene: Scene, rehearsals: Rehearsals, down: bool
) -> None:
    async with agent(scene, rehearsals):
        post = await scene.post("alice", WALK)
        question = await shown(scene, post)
    if down:
        await approve(scene, post)
    async with agent(scene, rehearsals) as running:
        if not down:
            await scene.until(lambda: (job := running.queue.find(post.id)) is not None and job.shown is not None)
            await approve(scene, post)
        await report(scene, post)
    (made,) = rehearsals.made  # it is not made again
    assert made.hash[:12] in question.raw
    assert record(scene, post)["approval"]["preview"] == record(scene, post)["preview"]["hash"] == made.hash
    assert await scene.until(lambda: [p for p in scene.replies(post) if "Preview and measured: " in p.raw])
    assert len([p for p in scene.replies(post) if BOUND in p.raw]) == (0 if scene.world.max_edits is None else 1)
    pictures = [name for p in scene.replies(post) for name in p.images if name in question.images]
    assert sorted(pictures) == sorted(question.images)


async def test_law_7_a_walk_from_another_place_is_refused_after_a_restart_too(
    scene: Scene, rehearsals: Rehearsals
) -> None:
    async with agent(scene, rehearsals):
        post = await scene.post("alice", WALK)
        await shown(scene, post)
    async with agent(scene, rehearsals) as running:
        async with running.driver.lease("a person at its machine") as lease:
            step = Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.6)
            assert (await running.driver.step(lease, step, 20.0)).ok
        await approve(scene, post)
        await report(scene, post, "refused")
    assert await scene.until(lambda: [p for p in scene.replies(post) if "the approved preview begins" in p.raw])


@pytest.mark.parametrize(("write", "when"), [("keep_preview", "after"), ("set_preview_shown", "before")])
async def test_law_7_killed_while_the_preview_is_shown_an_approval_is_bound_to_what_is_on_the_forum(
    scene: Scene, rehearsals: Rehearsals, monkeypatch: pytest.MonkeyPatch, write: str, when: str
) -> None:
    """Where the agent dies, its write never returns."""
    original, dead = getattr(Journal, write), asyncio.Event()

    async def dies(self: Journal, *args: object) -> None:
        if when == "after":
            await original(self, *args)
        dead.set()
        await asyncio.Event().wait()

    with monkeypatch.context() as patched:
        patched.setattr(Journal, write, dies)
        async with agent(scene, rehearsals):
            post = await scene.post("alice", WALK)
            async with asyncio.timeout(60):
                await dead.wait()
    async with agent(scene, rehearsals):
        question = await shown(scene, post)
        await approve(scene, post)
        await report(scene, post)
    assert len(rehearsals.made) == (2 if write == "keep_preview" else 1)
    assert rehearsals.made[-1].hash[:12] in question.raw
    assert record(scene, post)["approval"]["preview"] == rehearsals.made[-1].hash


async def test_law_7_a_preview_of_another_plan_is_made_again(
    scene: Scene, rehearsals: Rehearsals, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another version of AgentRob may read the post otherwise."""
    async with agent(scene, rehearsals):
        post = await scene.post("alice", WALK)
        await shown(scene, post)
    kept = rehearsals.made[0]
    old = replace(kept, plan=Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=0.4),)))
    monkeypatch.setattr("agentrob.agent.queue.approvals.read_preview", lambda _: old)
    async with agent(scene, rehearsals):
        await scene.until(lambda: len(rehearsals.made) == 2)
        await scene.until(lambda: any(rehearsals.made[1].hash[:12] in p.raw for p in scene.replies(post)))
        await approve(scene, post)
        await report(scene, post)
    assert record(scene, post)["approval"]["preview"] == rehearsals.made[1].hash


class SilentForum(MemoryForum):
    """A forum that does not show posts of ours for a while."""

    silent = True

    async def post(self, post_id: str) -> Post:
        found = await super().post(post_id)
        if self.silent and found.author.name == ROBOT:
            raise ForumUnreachable("no answer")
        return found

    async def find(self, key: str) -> Post | None:
        if self.silent:
            raise ForumUnreachable("no answer")
        return await super().find(key)


async def test_law_7_while_it_is_not_known_what_was_shown_an_approval_has_no_effect_and_is_asked_for_again(
    scene: Scene, rehearsals: Rehearsals, monkeypatch: pytest.MonkeyPatch
) -> None:
    dead = asyncio.Event()

    async def dies(self: Journal, *args: object) -> None:
        dead.set()
        await asyncio.Event().wait()

    with monkeypatch.context() as patched:
        patched.setattr(Journal, "set_preview_shown", dies)
        async with agent(scene, rehearsals):
            post = await scene.post("alice", WALK)
            async with asyncio.timeout(60):
                await dead.wait()
    forum = SilentForum(scene.world, ROBOT)
    async with agent(scene, rehearsals, forum=forum):
        given = await scene.post("carol", YES, topic=post.topic_id, reply_to=post.id)
        (answer,) = await scene.until(lambda: scene.replies(given))
        assert "which preview was shown" in answer.raw
        forum.silent = False
        await approve(scene, post)
        await report(scene, post)
    assert record(scene, post)["approval"]["preview"] == rehearsals.made[0].hash
