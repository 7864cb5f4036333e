"""The notebook keeps the contract that every forum keeps."""

from __future__ import annotations

from pathlib import Path

import pytest
from agentrob_notebook import Notebook

from agentrob import AccountKind, ConfigError, ForumConfig, ForumContract, Role, World


class NotebookWorld:
    """The contract's face of a notebook."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.rights: dict[str, list[str]] = {"operators": [], "admins": [], "robot_agents": [], "commanding_agents": []}

    async def sign_in(self, name: str, *, kind: AccountKind = AccountKind.HUMAN, role: Role = Role.MEMBER) -> Notebook:
        if (option := f"{kind}s") in self.rights:
            self.rights[option].append(name)
        if (option := f"{role}s") in self.rights:
            self.rights[option].append(name)
        return self._at(self.folder, name).open()

    def _at(self, folder: Path, name: str) -> Notebook:
        return Notebook(ForumConfig(kind="notebook", url=str(folder), options=self.rights), name)

    async def suspend(self, name: str) -> None:
        self._at(self.folder, "moderator").suspend(name)

    async def remove(self, post_id: str) -> None:
        self._at(self.folder, "moderator").remove(post_id)

    async def unreachable(self) -> Notebook:
        return self._at(self.folder / "nowhere", "alice")


class TestNotebook(ForumContract):
    @pytest.fixture
    async def world(self, tmp_path: Path) -> World:
        return NotebookWorld(tmp_path / "notebook")


def test_an_option_that_it_does_not_know_is_refused_with_those_that_it_knows() -> None:
    with pytest.raises(ConfigError, match="has no colour; valid are: operators"):
        Notebook(ForumConfig(options={"colour": "red"}), "alice")
