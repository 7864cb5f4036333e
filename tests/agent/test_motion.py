"""Law 13: a command ends when a stop in its thread would not arrive, since its post was moved or cannot be read."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from agentrob.agent import motion
from agentrob.errors import ForumDenied, ForumNotFound, ForumUnreachable
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.model import AccountKind, Post
from tests.agent.agent_scene import ROBOT, Scene

OK, REMOVED, MOVED = "ok", "removed", "moved"
GONE = "The post is no longer there."
DENIED, NOT_FOUND, UNREACHABLE = ForumDenied("no"), ForumNotFound("gone"), ForumUnreachable("away")


class ScriptedForum(MemoryForum):
    """Answers the reads of one post by `answers`, once these are set, and then as usual."""

    def __init__(self, world: MemoryWorld, name: str) -> None:
        super().__init__(world, name)
        self.answers: list[Exception | str] = []
        self.scripted = ""
        self.all_read = asyncio.Event()

    async def post(self, post_id: str) -> Post:
        found = await super().post(post_id)
        if post_id != self.scripted:
            return found
        answer = self.answers.pop(0) if self.answers else OK
        if not self.answers:
            self.all_read.set()
        if isinstance(answer, Exception):
            raise answer
        return replace(found, removed=answer == REMOVED, topic_id="999" if answer == MOVED else found.topic_id)


@pytest.mark.parametrize(
    ("answers", "why"),
    [
        ([NOT_FOUND], GONE),
        ([REMOVED], GONE),
        ([DENIED, DENIED], GONE),
        ([DENIED, OK, DENIED, OK], ""),
        ([UNREACHABLE, UNREACHABLE, OK], ""),
        ([DENIED, UNREACHABLE, DENIED], GONE),
        ([MOVED], "Its post was moved to another thread"),
    ],
    ids=["not found", "removed", "denied", "denied once", "unreachable", "denied twice", "in another thread"],
)
async def test_law_13_a_command_ends_when_a_stop_in_its_thread_would_not_arrive(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, answers: list[Exception | str], why: str
) -> None:
    monkeypatch.setattr(motion, "READ_AGAIN_S", 0.02)
    scene.person(ROBOT, kind=AccountKind.ROBOT_AGENT)
    forum = ScriptedForum(scene.world, ROBOT)
    async with scene.agent(forum=forum):
        post = await scene.post("alice", "@quadruped walk forward 4 metres slowly")
        await scene.state(post, "running")
        forum.answers, forum.scripted = list(answers), post.id
        async with asyncio.timeout(60):
            await forum.all_read.wait()
        ended = await scene.final(post)
        assert ended.card is not None
        assert ended.card.state == ("failed" if why else "done"), ended.raw
        assert why in ended.raw


async def test_law_13_a_command_whose_post_is_in_another_thread_now_does_not_move(scene: Scene) -> None:
    scene.person(ROBOT, kind=AccountKind.ROBOT_AGENT)
    forum = ScriptedForum(scene.world, ROBOT)
    async with scene.agent(forum=forum):
        walk = await scene.post("alice", "@quadruped walk forward 4 metres slowly")
        await scene.state(walk, "running")
        turn = await scene.post("alice", "@quadruped turn left")
        forum.answers, forum.scripted = [MOVED] * 100, turn.id
        ended = await scene.final(turn)
        assert ended.card is not None
        assert ended.card.state == "cancelled", ended.raw
        assert "Its post was moved to another thread" in ended.raw
