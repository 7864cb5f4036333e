"""docs/forum/deploy.md: its commands exist, its configurations are valid and fit together, its pictures can be
shown."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from agentrob.config.load import parse
from tests.deploy.command_line import parse_command

DOCS = Path(__file__).parents[2] / "docs/forum"
PAGE = (DOCS / "deploy.md").read_text(encoding="utf-8")
SIZES = dict(re.findall(r"^## (One machine|A lab|A fleet)\n(.*?)(?=^## )", PAGE, re.MULTILINE | re.DOTALL))
COMMAND = re.compile(r"\bagentrob ((?:[\w./:=-]+ ?)+)")
PICTURES = re.findall(r"\]\((../images/deploy-[\w-]+\.svg)\)", PAGE)
SVG = "{http://www.w3.org/2000/svg}"


def blocks(kind: str, text: str = PAGE) -> list[str]:
    return re.findall(rf"^```{kind}\n(.*?)^```", text, re.MULTILINE | re.DOTALL)


def commands() -> list[str]:
    """The commands of the shell blocks."""
    lines = [line for block in blocks("sh") for line in block.splitlines()]
    return [found for line in lines for found in COMMAND.findall(re.sub(r" +[#\[|].*| +> .*", "", line))]


def test_each_size_has_a_picture_a_configuration_commands_and_what_dies() -> None:
    assert list(SIZES) == ["One machine", "A lab", "A fleet"]
    for size, text in SIZES.items():
        assert len(re.findall(r"^!\[.+\]\(\.\./images/deploy-", text, re.MULTILINE)) == 1, size
        assert blocks("sh", text), size
        assert blocks("toml", text), size
        assert "| what dies |" in text
        assert "not protect from" in text.replace("\n", " ")


@pytest.mark.parametrize("command", sorted(set(commands())))
def test_a_command_exists(command: str) -> None:
    parse_command(shlex.split(command.replace("HOST:PORT", "127.0.0.1:9000")))


def test_the_page_has_commands() -> None:
    assert len(set(commands())) > 8


@pytest.mark.parametrize("text", blocks("toml"))
def test_a_configuration_is_valid(text: str) -> None:
    parse(tomllib.loads(text))


def test_in_a_lab_the_worker_and_the_driver_of_a_robot_fit_together() -> None:
    driver, worker = (parse(tomllib.loads(text)).robots["rex"] for text in blocks("toml", SIZES["A lab"]))
    assert worker.driver_url == f"https://{driver.driver_listen}"
    assert Path(worker.driver_ca).name == Path(driver.driver_ca).name


def test_links_to_sections_and_pictures_have_targets() -> None:
    headings = re.findall(r"^#+ (.*)$", PAGE, re.MULTILINE)
    anchors = {re.sub(r"[^\w -]", "", heading).lower().replace(" ", "-") for heading in headings}
    assert {anchor for anchor in re.findall(r"\]\(#([\w-]+)\)", PAGE) if anchor not in anchors} == set()
    assert len(PICTURES) == 3
    assert all((DOCS / picture).exists() for picture in PICTURES)


@pytest.mark.parametrize("picture", PICTURES)
def test_a_picture_is_told_in_words_runs_nothing_and_suits_both_colour_schemes(picture: str) -> None:
    root = ElementTree.parse(DOCS / picture).getroot()
    names = {element.tag.removeprefix(SVG) for element in root.iter()}
    assert names <= {"svg", "title", "desc", "style", "defs", "marker", "path", "rect", "text"}
    title, desc = (root.findtext(f"{SVG}{name}") for name in ("title", "desc"))
    assert title
    assert len(desc or "") > 80
    style: Any = root.findtext(f"{SVG}style")
    assert "prefers-color-scheme: dark" in style
    assert int(root.attrib["width"]) <= 440, "on a phone its text is still readable"
