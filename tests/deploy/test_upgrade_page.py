"""The commands of docs/forum/upgrade.md parse; tests/wiring/test_older_files.py shows that the data is carried over."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.deploy.command_line import parse_command

PAGE = (Path(__file__).parents[2] / "docs/forum/upgrade.md").read_text(encoding="utf-8")
COMMANDS = re.findall(r"^ +(agentrob .*)$", PAGE, re.MULTILINE)


def test_the_commands_are_found() -> None:
    assert len(COMMANDS) == 5


@pytest.mark.parametrize("command", [one for one in COMMANDS if one != "agentrob --version"])
def test_a_command_parses(command: str) -> None:
    parse_command(shlex.split(command)[1:])
