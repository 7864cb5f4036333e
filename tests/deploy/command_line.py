"""Parse command lines of `agentrob` as the program does, without running them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import typer

from agentrob.cli.main import cli


def parse_command(arguments: Sequence[str]) -> None:
    """Raise the error that the program would show."""
    command: Any = typer.main.get_command(cli)
    parent, rest = None, list(arguments)
    while hasattr(command, "resolve_command"):
        parent = command.make_context(command.name or "agentrob", rest, parent=parent)
        words = [*parent._protected_args, *parent.args]
        if not words and command.invoke_without_command:
            return
        _, command, rest = command.resolve_command(parent, words)
    command.make_context(command.name, rest, parent=parent)
