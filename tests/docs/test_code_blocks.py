"""The code blocks of the pages: commands exist, Python compiles, configurations are valid, JSON parses."""

from __future__ import annotations

import ast
import json
import re
import shlex
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from agentrob.config.load import parse
from scripts.documentation.pages import DOCS, INCLUDED, ROOT
from tests.deploy.command_line import parse_command

SOURCES = [*sorted(DOCS.rglob("*.md")), *(ROOT / source for source in INCLUDED.values()), ROOT / "README.md"]
_BLOCK = re.compile(r"^(?P<indent> *)```(?P<kind>\w*).*?\n(?P<text>.*?)^(?P=indent)```", re.MULTILINE | re.DOTALL)
#: Words in commands that a reader replaces.
PLACEHOLDERS = {"HOST:PORT": "127.0.0.1:9000", "[--account": "--account", "NAME]": "NAME"}
#: Keys by which TOML blocks of other files are recognised: pyproject.toml, a client of MCP, a world.
OTHER_TOML = {"project", "mcp_servers", "thing"}


def blocks(*kinds: str) -> Iterator[tuple[Path, str]]:
    """The code blocks of these languages on all pages."""
    for source in SOURCES:
        for match in _BLOCK.finditer(source.read_text(encoding="utf-8")):
            if match["kind"] in kinds:
                yield source, textwrap.dedent(match["text"])


def named(*kinds: str) -> list[object]:
    """The blocks as parameters of a test, named by page."""
    count: dict[str, int] = {}
    found = []
    for source, text in blocks(*kinds):
        page = source.relative_to(ROOT).as_posix()
        count[page] = count.get(page, 0) + 1
        found.append(pytest.param(text, id=f"{page}:{count[page]}"))
    return found


def commands(text: str) -> Iterator[list[str]]:
    """The arguments of each `agentrob` in a shell block; in a `console` block only lines after `$ ` are commands."""
    for line in text.replace("\\\n", " ").splitlines():
        for part in re.split(r"&&|\||;|<\(|\$\(", line.removeprefix("$ ")):
            words = (
                shlex.split(part, comments=True) if part.count("'") % 2 == part.count('"') % 2 == 0 else part.split()
            )
            while words and re.match(r"[A-Z_]+=", words[0]):
                words.pop(0)
            if words and Path(words[0]).name == "agentrob":
                yield [PLACEHOLDERS.get(word, word) for word in _arguments(words[1:])]


def _arguments(words: list[str]) -> Iterator[str]:
    for word in words:
        if re.match(r"[12]?>|&$|…$", word):
            return
        yield word.rstrip(")")


def test_there_are_commands() -> None:
    found = [one for _, text in blocks("sh", "console") for one in commands(text)]
    assert len(found) > 60


@pytest.mark.parametrize("text", named("sh"))
def test_each_command_of_a_shell_block_exists(text: str) -> None:
    for arguments in commands(text):
        parse_command(arguments)


@pytest.mark.parametrize("text", named("console"))
def test_each_command_of_a_console_block_exists(text: str) -> None:
    typed = [line for line in text.splitlines() if line.startswith("$ ")]
    assert typed, "a console block shows what is typed after `$ `"
    for arguments in commands("\n".join(typed)):
        parse_command(arguments)


@pytest.mark.parametrize("text", named("toml"))
def test_each_toml_block_is_valid_configuration(text: str) -> None:
    table = tomllib.loads(text)
    if not OTHER_TOML & set(table):
        parse(table)


@pytest.mark.parametrize("text", named("python"))
def test_each_python_block_compiles(text: str) -> None:
    compile(text, "page", "exec", flags=ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)


@pytest.mark.parametrize("text", named("json"))
def test_each_json_block_parses(text: str) -> None:
    json.loads(text)


def test_code_is_fenced_and_names_its_language() -> None:
    for source in SOURCES:
        text = source.read_text(encoding="utf-8")
        unnamed = [m["text"][:60] for m in _BLOCK.finditer(text) if not m["kind"]]
        assert unnamed == [], f"{source.relative_to(ROOT)}: name the language of the block, or `text`"
