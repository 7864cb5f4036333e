"""The help of every command describes the command and each of its options and arguments."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
import typer

from agentrob.cli.main import cli
from tests.in_process import agentrob


def commands(group: object, words: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], object]]:
    yield words, group
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, (*words, name))


ALL = dict(commands(typer.main.get_command(cli)))


@pytest.mark.parametrize("words", ALL, ids=lambda words: " ".join(words) or "agentrob")
def test_every_command_option_and_argument_has_help(words: tuple[str, ...]) -> None:
    command = ALL[words]
    assert getattr(command, "help", ""), words
    for parameter in getattr(command, "params", ()):
        assert getattr(parameter, "help", ""), f"{' '.join(words)} {parameter.name}"


def test_help_separates_commands_for_newcomers_from_internal_processes(tmp_path: object) -> None:
    said = agentrob(tmp_path, "--help").stdout  # type: ignore[arg-type]
    assert said.index("First steps") < said.index("demo ") < said.index("Processes that others start")
    internal = said[said.index("Processes that others start") :]
    assert internal.index(" driver ") < internal.index(" sim ")
