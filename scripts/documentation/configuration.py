"""The reference of agentrob.toml, made from the models that check it: each key with type, default and example."""

from __future__ import annotations

import importlib
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from agentrob.config.load import Config
from agentrob.config.section import Listening, WithMetrics

DOCS = Path(__file__).parents[2] / "docs"
INTRODUCTION = """# Configuration

AgentRob reads one file, `agentrob.toml`: the file named by `--config`, else that in the current folder. This page lists
every table and key, generated from the models that check the file. A key or value that is not valid is refused with an
error that says what is; secrets are never in the file, which names the environment variables that hold them (`…_env`).

A number in a key's name has its unit at the end: `_m` metres, `_mps` metres per second, `_deg` degrees, `_dps` degrees
per second, `_s` seconds.

"""
#: Examples of keys that no page shows.
EXAMPLES: dict[str, Any] = {
    "images.path_style": True,
    "images.key_env": "PICTURES_KEY",
    "images.secret_env": "PICTURES_SECRET",
    "mcp.public_url": "https://forum.example.org/mcp",
    "mcp.issuer": "https://login.example.org",
    "mcp.jwks_url": "https://login.example.org/keys.json",
    "mcp.users.NAME.subject": "planner@example.org",
    "minds.NAME.fallbacks": ["own", "rules"],
    "forum.options": {"operators": ["staff"]},
    "robots.NAME.options": {"time_scale": 10},
    "robots.NAME.eyes.options": {"least": 240},
    "robots.NAME.moderators": ["ann", "bob"],
    "robots.NAME.mentions": ["dog"],
    "robots.NAME.scene": "stairs 2 m behind its home",
    "robots.NAME.step_length_m": 0.35,
    "robots.NAME.map.things.turned_deg": 30,
    "robots.NAME.allow_risky": ["jump"],
    "robots.NAME.room_camera": "http://127.0.0.1:9000/room.jpg",
    "robots.NAME.room_reset": "http://127.0.0.1:9000/reset",
    "robots.NAME.driver_token_env": "REX_DRIVER_TOKEN",
    "robots.NAME.recording.camera": "http://127.0.0.1:9000/camera.jpg",
    "service.hosts": ["rex.example.org"],
}
#: The word that stands for a name in the path of a table.
NAME = "NAME"
#: Tables that hold a table for each name.
NAMED = {
    "robots", "minds", "board.hooks", "mcp.users", "mcp_robot.services", "service.tokens", "service.hooks_in",
    "service.hooks_out",
}  # fmt: skip
#: Tables of which there may be several.
LISTS = {"robots.NAME.map.things"}


def _sentences(text: str) -> list[str]:
    """The sentences of a docstring."""
    return re.split(r"(?<=[.)]) (?=[A-Z`])", " ".join(text.split())) if text else []


#: What the models of several tables say about their common keys.
INHERITED = [*_sentences(WithMetrics.__doc__ or ""), *_sentences(Listening.__doc__ or "")]


@dataclass(frozen=True)
class Key:
    """A key of a table: its type in words, its default and an example as TOML, and what its model says about it.

    An empty default means that the key has none.
    """

    name: str
    type: str
    default: str
    example: str
    about: str


@dataclass(frozen=True)
class Table:
    """A table: its path such as `robots.NAME.limits`, the description of its model, and its keys."""

    path: str
    description: str
    keys: tuple[Key, ...]
    example: str


def page() -> str:
    """Return the page: a section for each table."""
    return INTRODUCTION + "\n".join(_section(table) for table in tables())


def _section(table: Table) -> str:
    title = f"`[{table.path}]`" if table.path else "Top level"
    if table.path in LISTS:
        title = f"`[[{table.path}]]`"
    example = f"```toml\n{table.example.strip()}\n```\n" if table.example else ""
    return "\n".join([f"## {title}\n", table.description, "", example, *map(_entry, table.keys), ""])


def _entry(key: Key) -> str:
    """A key as an entry of a definition list."""
    default = f", by default `{key.default}`" if key.default else ""
    about = f"<br>{key.about}" if key.about else ""
    return f"`{key.name}`\n:   {key.type}{default}. Example: `{key.example}`{about}\n"


@cache
def tables() -> tuple[Table, ...]:
    """All tables of the configuration, each after the one that contains it."""
    schema = Config.model_json_schema()
    return tuple(_tables("", schema, schema["$defs"], Config))


def _tables(path: str, model: Mapping[str, Any], defs: Mapping[str, Any], kind: type) -> Iterator[Table]:
    keys, below = [], []
    sentences = _sentences(str(model.get("description", "")))
    for name, field in model.get("properties", {}).items():
        inner = f"{path}.{name}" if path else name
        nested = _nested(field, defs)
        if nested is None:
            keys.append(_key(inner, name, field, defs, sentences))
        else:
            below.append((inner + nested[0], nested[1]))
    general = " ".join(one for one in sentences if not any(one in key.about for key in keys))
    yield Table(path, general or " ".join(sentences), tuple(keys), _module_example(path))
    for inner, definition in below:
        yield from _tables(inner, definition, defs, kind)


def _nested(field: Mapping[str, Any], defs: Mapping[str, Any]) -> tuple[str, Mapping[str, Any]] | None:
    """The table that a field or its list holds, and `.NAME` if it holds one for each name; None for a plain value."""
    for option in field.get("anyOf", [field]):
        if found := _definition(option, defs):
            return ("", found)
        if found := _definition(option.get("items") or {}, defs):
            return ("", found)
        more = option.get("additionalProperties")
        patterns = option.get("patternProperties", {})
        for value in [more, *patterns.values()]:
            if isinstance(value, dict) and (found := _definition(value, defs)):
                return (f".{NAME}", found)
    return None


def _definition(field: Mapping[str, Any], defs: Mapping[str, Any]) -> Mapping[str, Any] | None:
    found = defs.get(field.get("$ref", "").rpartition("/")[2])
    return found if found is not None and "properties" in found else None


def _key(path: str, name: str, field: Mapping[str, Any], defs: Mapping[str, Any], sentences: Sequence[str]) -> Key:
    default = field.get("default")
    shown = "" if default is None else toml(default)
    example = EXAMPLES[path] if path in EXAMPLES else shown_values().get(path, default)
    if isinstance(example, bool) and example == default:
        example = not default
    said = [one for one in (*sentences, *INHERITED) if re.search(rf"`{name}(`| = )", one)]
    about = " ".join(one for one in said if one in sentences) or " ".join(said)
    return Key(name, in_words(field, defs), shown, f"{name} = {toml(example)}" if example is not None else "", about)


def in_words(field: Mapping[str, Any], defs: Mapping[str, Any]) -> str:
    """The type of a value, such as "number, more than 0, at most 90"."""
    if "anyOf" in field:
        return " or ".join(in_words(option, defs) for option in field["anyOf"] if option.get("type") != "null")
    if "$ref" in field:
        return in_words(defs[field["$ref"].rpartition("/")[2]], defs)
    if "enum" in field:
        return "one of " + ", ".join(f"`{value}`" for value in field["enum"])
    if field.get("type") == "array":
        if "prefixItems" in field:
            return f"{len(field['prefixItems'])} × {in_words(field['prefixItems'][0], defs)}"
        return f"list of {in_words(field.get('items', {}), defs)}"
    kinds = {
        "string": "text",
        "integer": "whole number",
        "number": "number",
        "boolean": "`true` or `false`",
        "object": "table",
    }
    bounds = {
        "exclusiveMinimum": "more than", "minimum": "at least", "exclusiveMaximum": "less than", "maximum": "at most",
    }  # fmt: skip
    limits = [f"{words} {field[key]:g}" for key, words in bounds.items() if key in field]
    return ", ".join([kinds.get(field.get("type", ""), "any value"), *limits])


def toml(value: Any) -> str:
    """A value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:g}" if value == int(value) and abs(value) < 1e6 else repr(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {toml(v)}" for k, v in value.items()) + " }" if value else "{}"
    return f'"{value}"' if isinstance(value, str) else str(value)


@cache
def shown_values() -> Mapping[str, Any]:
    """The value of each key that the pages or the modules of the configuration show, by its path."""
    found: dict[str, Any] = {}
    texts = [page.read_text(encoding="utf-8") for page in sorted(DOCS.rglob("*.md"))]
    blocks = [block for text in texts for block in re.findall(r"^```toml\n(.*?)^```", text, re.MULTILINE | re.DOTALL)]
    for block in [*_module_examples().values(), *blocks]:
        _collect("", tomllib.loads(block), found)
    return found


def _collect(path: str, value: Any, found: dict[str, Any]) -> None:
    if value not in ("", [], {}, None):
        found.setdefault(path, value)
    if isinstance(value, dict):
        for key, inner in value.items():
            _collect(f"{path}.{NAME if path in NAMED else key}".removeprefix("."), inner, found)
    elif path in LISTS:
        for one in value:
            _collect(path, one, found)


@cache
def _module_examples() -> Mapping[str, str]:
    """The examples in the docstrings of the modules, by their first table."""
    found: dict[str, str] = {}
    for name in ("board", "forum", "images", "journal", "map", "mcp", "minds", "robots", "service", "worker"):
        text = importlib.import_module(f"agentrob.config.{name}").__doc__ or ""
        for block in re.split(r"\n(?=\[)", text.partition("\n\n")[2]):
            found.setdefault(_table_of(block), block)
    return found


def _table_of(block: str) -> str:
    """The path of a block's first table, as the reference writes it."""
    header = re.match(r"\[([^\]]+)\]", block)
    path = ""
    for part in header[1].split(".") if header else ():
        path = f"{path}.{NAME if path in NAMED else part}".removeprefix(".")
    return path


def _module_example(path: str) -> str:
    return _module_examples().get(path, "") if path else 'data = "/var/lib/agentrob"'
