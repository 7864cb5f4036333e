"""The built site: each link and picture has a target, and nothing is loaded from elsewhere."""

from __future__ import annotations

import dataclasses
import os
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import get_args, get_origin
from urllib.parse import unquote, urlsplit

import pytest
from pydantic import BaseModel, TypeAdapter

from agentrob.config.load import Config
from scripts.documentation import configuration
from scripts.documentation.pages import DOCS, GENERATED, INCLUDED, ROOT, links

#: Attributes whose address a browser loads by itself, by tag. A link (`a`) is loaded only when it is followed.
LOADED = {
    "script": ("src",), "img": ("src", "srcset"), "link": ("href",), "iframe": ("src",), "source": ("src", "srcset"),
    "video": ("src", "poster"), "audio": ("src",), "object": ("data",), "embed": ("src",), "use": ("href",
    "xlink:href"),
}  # fmt: skip
#: `link` elements that only describe the page.
DESCRIPTIONS = {"canonical", "prev", "next", "alternate", "edit"}
EXTERNAL = re.compile(r"^(?:[a-z]+:)?//", re.IGNORECASE)


@dataclass
class Page(HTMLParser):
    """A page's anchors, its links, and what it loads."""

    anchors: set[str] = dataclasses.field(default_factory=set)
    links: list[str] = dataclasses.field(default_factory=list)
    loaded: list[str] = dataclasses.field(default_factory=list)

    def __post_init__(self) -> None:
        super().__init__()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if given.get(name)}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag == "link" and DESCRIPTIONS & set(given.get("rel", "").split()):
            return
        self.loaded += [given[name] for name in LOADED.get(tag, ()) if given.get(name)]
        self.loaded += re.findall(r"url\(['\"]?([^'\")]+)", given.get("style", ""))


@cache
def parsed(path: Path) -> Page:
    page = Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page


def pages(site: Path) -> list[Path]:
    found = [path for path in sorted(site.rglob("*.html")) if path.name != "404.html"]
    assert len(found) > 30
    return found


def test_every_link_and_anchor_has_a_target(site: Path) -> None:
    missing = []
    for path in pages(site):
        for link in parsed(path).links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            target = target / "index.html" if target.is_dir() else target
            anchor = unquote(parts.fragment)
            if not target.exists() or (anchor and target.suffix == ".html" and anchor not in parsed(target).anchors):
                missing.append(f"{path.relative_to(site)}: {link}")
    assert missing == []


def test_no_page_loads_anything_from_elsewhere(site: Path) -> None:
    for path in pages(site):
        for address in parsed(path).loaded:
            assert not EXTERNAL.match(address), f"{path.relative_to(site)} loads {address}"
            file = (path.parent / unquote(urlsplit(address).path)).resolve()
            assert address.startswith("data:") or file.exists(), f"{path.relative_to(site)}: {address} is missing"
        assert 'class="mermaid"' not in path.read_text(encoding="utf-8"), "the theme would load a script for it"


def test_no_style_loads_anything_from_elsewhere(site: Path) -> None:
    for path in site.rglob("*.css"):
        addresses = re.findall(r"(?:url\(|@import )['\"]?([^'\")]+)", path.read_text(encoding="utf-8"))
        assert [address for address in addresses if EXTERNAL.match(address)] == [], path.name


def test_links_into_the_repository_have_targets() -> None:
    """The site shows them as plain text; who reads the pages in the repository follows them."""
    made = {DOCS / page for page in (*GENERATED, *INCLUDED)}
    sources = [*DOCS.rglob("*.md"), *(ROOT / source for source in INCLUDED.values()), ROOT / "README.md"]
    for source in sources:
        for target in links(source.read_text(encoding="utf-8")):
            path = target.partition("#")[0]
            if path and not re.match(r"[a-z]+:", path):
                file = Path(os.path.normpath(source.parent / path))
                assert file.exists() or file in made, f"{source.relative_to(ROOT)}: {target}"


def test_the_reference_lists_every_key_of_the_configuration_with_a_valid_example() -> None:
    listed = {table.path: table for table in configuration.tables()}
    for path, model in models("", Config):
        keys = {key.name for key in listed[path].keys}
        start = f"{path}." if path else ""
        below = {inner.removeprefix(start).split(".")[0] for inner in listed if inner.startswith(start)}
        assert set(model.model_fields) <= keys | below, path
        for key in listed[path].keys:
            assert key.example, f"[{path}] {key.name} has no example: add one to scripts/documentation/configuration.py"
            value = tomllib.loads(key.example)[key.name]
            TypeAdapter(model.model_fields[key.name].rebuild_annotation()).validate_python(value)


def models(path: str, model: type[BaseModel]) -> Iterator[tuple[str, type[BaseModel]]]:
    """Each table's path in the reference, and its model."""
    yield path, model
    for name, info in model.model_fields.items():
        named = f".{configuration.NAME}" if get_origin(info.annotation) is dict else ""
        for kind in (info.annotation, *get_args(info.annotation)):
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                yield from models(f"{path}.{name}{named}".removeprefix("."), kind)


def test_the_files_that_pages_name_exist() -> None:
    named = re.compile(r"`(?:[^`\n]* )?((?:benchmarks|deploy|examples|plugins|scripts|src|tests)/[\w./-]*\w)")
    for source in [*DOCS.rglob("*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        missing = [path for path in named.findall(source.read_text(encoding="utf-8")) if not (ROOT / path).exists()]
        assert missing == [], source.relative_to(ROOT)


def test_pages_show_all_pictures() -> None:
    shown = {name for page in DOCS.rglob("*.md") for name in re.findall(r"images/([\w/.-]+)", page.read_text("utf-8"))}
    shown |= set(re.findall(r"docs/images/([\w/.-]+)", (ROOT / "README.md").read_text(encoding="utf-8")))
    stored = {path.relative_to(DOCS / "images").as_posix() for path in (DOCS / "images").rglob("*.*")}
    assert stored - shown == set(), "no page shows these; remove them"


@pytest.mark.parametrize(
    "task",
    ["become admin", "invite a colleague", "let somebody command", "release a robot", "stop a robot", "back it up",
     "approve a command", "understand what *refused*", "cancel a schedule", "use a model on my own machine"],
)  # fmt: skip
def test_the_index_lists_what_people_ask_for(task: str) -> None:
    rows = (DOCS / "tasks.md").read_text(encoding="utf-8").splitlines()
    assert sum(row.startswith(f"| {task}") and "](" in row for row in rows) >= 1
