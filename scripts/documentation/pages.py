"""Put the pages of the site together: those of docs/, files of the repository that are pages too, and generated
ones."""

from __future__ import annotations

import os
import re
import shutil
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from scripts.documentation import command_line, commonmark, configuration, http_api, python_api

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
#: Files elsewhere in the repository that are pages of the site, by the page's path.
INCLUDED = {
    "robots/ros2.md": "plugins/ros2/README.md",
    "robots/reachy-mini.md": "plugins/reachy-mini/README.md",
    "robots/so101.md": "plugins/so101/README.md",
    "inside/contribute.md": "CONTRIBUTING.md",
    "inside/changes.md": "CHANGELOG.md",
}
#: Pages that are made from the code, by the page's path.
GENERATED: dict[str, Callable[[], str]] = {
    "reference/configuration.md": configuration.page,
    "reference/command-line.md": command_line.page,
    "reference/http-forum.md": http_api.forum_page,
    "reference/http-robot.md": http_api.robot_page,
    "reference/python.md": python_api.page,
}
_PAGE_OF = {source: page for page, source in INCLUDED.items()}
_LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^)\s]+)\)")
_FENCE = re.compile(r"(^ *```.*?^ *```)", re.MULTILINE | re.DOTALL)


def write_pages(folder: Path) -> None:
    """Write all pages and pictures into `folder`, which is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(DOCS, folder)
    for page in sorted(DOCS.rglob("*.md")):
        name = page.relative_to(DOCS).as_posix()
        text = commonmark.rewrite(page.read_text(encoding="utf-8"))
        _write(folder / name, site_links(text, f"docs/{name}", name))
    for name, source in INCLUDED.items():
        text = commonmark.rewrite((ROOT / source).read_text(encoding="utf-8"))
        _write(folder / name, site_links(text, source, name))
    for name, generate in GENERATED.items():
        _write(folder / name, generate())


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def links(text: str) -> Iterator[str]:
    """The targets of a Markdown text's links and pictures, outside code."""
    for match in _LINK.finditer(_FENCE.sub("", text)):
        yield match[3]


def site_links(text: str, source: str, page: str) -> str:
    """Return the text of a repository's file with its links as they are on the site.

    Links to pages become relative to `page`. Links to other files of the repository, which the site does not have,
    become plain text: a reader of the site sees the file's name.
    """

    def convert(match: re.Match[str]) -> str:
        mark, words, target = match.groups()
        path, hash_, anchor = target.partition("#")
        if not path or re.match(r"[a-z]+:", target):
            return match[0]
        file = os.path.normpath(os.path.join(os.path.dirname(source), path))
        known = _PAGE_OF.get(file) or (file.removeprefix("docs/") if file.startswith("docs/") else None)
        if known is None:
            return words
        return f"{mark}[{words}]({os.path.relpath(known, os.path.dirname(page) or '.')}{hash_}{anchor})"

    parts = _FENCE.split(text)
    return "".join(part if n % 2 else _LINK.sub(convert, part) for n, part in enumerate(parts))


def unlisted(folder: Path) -> list[str]:
    """The pages in `folder` that the navigation does not list."""
    nav = tomllib.loads((ROOT / "zensical.toml").read_text(encoding="utf-8"))["project"]["nav"]
    listed = set(_pages_of(nav))
    return sorted({page.relative_to(folder).as_posix() for page in folder.rglob("*.md")} - listed)


def _pages_of(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    else:
        for entry in nav.values() if isinstance(nav, dict) else nav:
            yield from _pages_of(entry)
