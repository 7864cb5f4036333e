"""Law 13: a command that moves ends when its post can no longer be read, as a stop in its thread would not arrive."""

from __future__ import annotations

import asyncio
from dataclasses import replace

import pytest

from agentrob.agent import motion
from agentrob.errors import ForumDenied, ForumNotFound, ForumUnreachable
from agentrob.forums.memory.forum import MemoryForum, MemoryWorld
from agentrob.model import AccountKind, Post
from tests.agent.agent_scene import ROBOT, Scene

OK, REMOVED = "ok", "removed"
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
        return replace(found, removed=answer == REMOVED)


@pytest.mark.parametrize(
    ("answers", "state"),
    [
        ([NOT_FOUND], "failed"),
        ([REMOVED], "failed"),
        ([DENIED, DENIED], "failed"),
        ([DENIED, OK, DENIED, OK], "done"),
        ([UNREACHABLE, UNREACHABLE, OK], "done"),
        ([DENIED, UNREACHABLE, DENIED], "failed"),
    ],
    ids=["not found", "removed", "denied", "denied once", "unreachable", "denied twice"],
)
async def test_law_13_a_command_ends_when_its_post_can_no_longer_be_read(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, answers: list[Exception | str], state: str
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
        assert ended.card.state == state, ended.raw
        assert ("The post is no longer there." in ended.raw) is (state == "failed")
