"""The memory forum fulfils the contract in each of its variants."""

from typing import Any

import pytest

from agentrob.forums.contract import ForumContract, KeyedEditsContract, World
from agentrob.forums.memory.forum import MemoryForum
from agentrob.forums.protocol import Forum, RobotPages
from agentrob.model import AccountKind, Role


class MemoryContractWorld:
    """The contract's asynchronous interface to a `MemoryWorld`."""

    def __init__(self, **settings: Any) -> None:
        self.world = MemoryForum.world(**settings)

    async def sign_in(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER) -> Forum:
        return self.world.sign_in(name, kind=kind, role=role)

    async def suspend(self, name: str) -> None:
        self.world.suspend(name)

    async def remove(self, post_id: str) -> None:
        self.world.remove(post_id)

    async def unreachable(self) -> Forum:
        nowhere = MemoryForum.world()
        forum = nowhere.sign_in("lost")
        nowhere.reachable = False
        return forum


class TestMemoryForum(ForumContract, KeyedEditsContract):
    @pytest.fixture(params=[{}, {"max_edits": 3}, {"max_edits": 0}, {"live": False}], ids=str)
    async def world(self, request: pytest.FixtureRequest) -> World:
        return MemoryContractWorld(**request.param)


def test_the_memory_forum_has_robot_presence_too() -> None:
    assert isinstance(MemoryForum.world().sign_in("quadruped"), RobotPages)
