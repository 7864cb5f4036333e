"""Run the command `agentrob` inside the test process, with the output and exit code of a real process.

For words that are read, refused or answered at once; at least one test of each command starts a real process.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import NamedTuple

from typer.testing import CliRunner

from agentrob.cli.main import cli, error_line
from agentrob.errors import AgentRobError


class Said(NamedTuple):
    """The result of a command."""

    returncode: int
    stdout: str
    stderr: str


def agentrob(folder: Path, *args: str, **env: str) -> Said:
    """Run a command in a folder. An unexpected error is raised; a real process would print its traceback."""
    with contextlib.chdir(folder):
        done = CliRunner().invoke(cli, args, env=env)
    match done.exception:
        case None | SystemExit():
            return Said(done.exit_code, done.stdout, done.stderr)
        case AgentRobError() as error:
            return Said(1, done.stdout, f"{done.stderr}{error_line(error)}\n")
        case error:
            raise error
