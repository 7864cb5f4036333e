"""The references of the HTTP APIs, made from their OpenAPI documents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fastapi import FastAPI

FORUM = """# HTTP API of the forum

The embedded forum's API, below `/api/v1`, from its OpenAPI document (`/api/v1/openapi.json`; a running forum shows it
at `/docs`). Programs send `Authorization: Bearer TOKEN`. [Interfaces between processes](interfaces.md) describes what
the calls have in common: errors, paging, idempotency keys, rights and streams; [events](events.md) what a stream
delivers.

"""
ROBOT = """# HTTP API of a robot

The API of `agentrob agent serve`, the agent of one robot as a service, from its OpenAPI document
(`/api/v1/openapi.json`). [The HTTP service](../agents/service.md) describes how to set it up, its tokens and scopes.

"""


def forum_page() -> str:
    """Return the page of the embedded forum's API."""
    from agentrob.board.server import create_app
    from agentrob.board.settings import BoardSettings
    from agentrob.config.board import BoardConfig

    with TemporaryDirectory() as folder:
        return FORUM + render(create_app(BoardSettings.from_config(BoardConfig(), Path(folder))).openapi())


def robot_page() -> str:
    """Return the page of a robot's service."""
    from agentrob.service import api

    app = FastAPI(title="Agent of a robot")
    app.include_router(api.router)
    app.include_router(api.public)
    return ROBOT + render(app.openapi())


def render(document: Mapping[str, Any]) -> str:
    """Return an OpenAPI document as Markdown: the operations by tag, then the schemas."""
    described = {tag["name"]: tag.get("description", "") for tag in document.get("tags", [])}
    by_tag: dict[str, list[str]] = {name: [] for name in described}
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            tag = (operation.get("tags") or ["calls"])[0]
            by_tag.setdefault(tag, []).extend(_operation(method, path, operation))
    lines = []
    for tag, text in by_tag.items():
        if text:
            lines += [f"## {tag.capitalize()}", "", described.get(tag, ""), "", *text]
    lines += ["## Schemas", ""]
    for name, schema in sorted(document.get("components", {}).get("schemas", {}).items()):
        lines += _schema(name, schema)
    return "\n".join(lines)


def _operation(method: str, path: str, operation: Mapping[str, Any]) -> Iterator[str]:
    yield from (f"### `{method.upper()} {path}`", "", operation.get("description", ""), "")
    if parameters := operation.get("parameters"):
        yield from ("| parameter | in | type | |", "|---|---|---|---|")
        for one in parameters:
            words = " ".join([one.get("description", ""), "" if not one.get("required") else "required"]).strip()
            yield f"| `{one['name']}` | {one['in']} | {_type(one.get('schema', {}))} | {words} |"
        yield ""
    for kind, content in operation.get("requestBody", {}).get("content", {}).items():
        yield from (f"Body: {_type(content.get('schema', {}))} (`{kind}`)", "")
    for status, answer in sorted(operation["responses"].items()):
        if status < "300":
            types = [_type(c["schema"]) for c in answer.get("content", {}).values() if c.get("schema")]
            yield f"Answer {status}: {', '.join(types) or answer.get('description', '')}"
    errors = [f"`{status}`" for status in sorted(operation["responses"]) if status >= "400"]
    yield from ("", f"Errors: {', '.join(errors)}" if errors else "", "")


def _schema(name: str, schema: Mapping[str, Any]) -> Iterator[str]:
    yield from (f"### {name}", "", " ".join(str(schema.get("description", "")).split()), "")
    if "enum" in schema:
        yield from ("One of " + ", ".join(f"`{value}`" for value in schema["enum"]), "")
    if properties := schema.get("properties"):
        needed = schema.get("required", ())
        yield from ("| field | type | |", "|---|---|---|")
        for field, about in properties.items():
            words = [about.get("description", ""), "required" if field in needed else ""]
            yield f"| `{field}` | {_type(about)} | {' '.join(filter(None, words))} |"
        yield ""


def _type(schema: Mapping[str, Any]) -> str:
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if options := schema.get("anyOf"):
        return " or ".join(dict.fromkeys(map(_type, options)))
    if "enum" in schema:
        return ", ".join(f"`{value}`" for value in schema["enum"])
    if "const" in schema:
        return f"`{schema['const']}`"
    if schema.get("type") == "array":
        return f"list of {_type(schema.get('items', {}))}"
    return str(schema.get("format") or schema.get("type", "any"))
