"""The needed part of Discourse's OpenAPI document: the double's responses are built from it and validated against it.

`openapi.json` is an extract of https://docs.discourse.org/openapi.json (MIT licence). The document is generated from
examples of one test run, so parts of it are narrower than real responses; `DEPARTURES` lists where and why.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from typing import Any

Schema = dict[str, Any]
_NUMBER: Schema = {"type": ["integer", "null"]}
_TEXT: Schema = {"type": "string"}

#: (operation, beside, property, real schema, reason): each object of the operation that has the property `beside` also
#: has this property. The operation `*` means all.
DEPARTURES: tuple[tuple[str, str, str, Schema, str], ...] = (
    ("*", "reply_to_post_number", "reply_to_post_number", _NUMBER, "null in the example; it is a number"),
    ("*", "reviewable_id", "reviewable_id", _NUMBER, "null in some examples, 0 in others"),
    ("get /u/{username}.json", "trust_level", "suspended_till", _TEXT, "only a suspended account has it"),
    ("get /u/{username}.json", "trust_level", "suspend_reason", _TEXT, "the same"),
    ("get /user_actions.json", "post_id", "post_id", _NUMBER, "null in the example"),
    ("get /user_actions.json", "hidden", "hidden", {"type": ["boolean", "null"]}, "the same"),
    ("get /user_actions.json", "post_type", "post_type", _NUMBER, "the same"),
    ("get /c/{slug}/{id}.json", "topics", "more_topics_url", _TEXT, "only where there is a next page"),
    ("get /categories.json", "slug", "parent_category_id", _NUMBER, "only a subcategory has it"),
    ("post /users.json", "email", "password_confirmation", _TEXT, "visitors send the honeypot's value"),
    ("post /users.json", "email", "challenge", _TEXT, "and its challenge, backwards"),
)


@cache
def paths() -> dict[str, dict[str, Any]]:
    """Return the paths of the extract with the departures applied."""
    text = (files(__package__) / "openapi.json").read_text(encoding="utf-8")
    found: dict[str, dict[str, Any]] = json.loads(text)["paths"]
    for path, methods in found.items():
        for method, operation in methods.items():
            for where, beside, name, schema, _ in DEPARTURES:
                if where in ("*", f"{method} {path}"):
                    _depart(operation, beside, name, schema)
    return found


def _depart(at: Any, beside: str, name: str, schema: Schema) -> None:
    for item in at.values() if isinstance(at, dict) else at if isinstance(at, list) else ():
        _depart(item, beside, name, schema)
    if isinstance(at, dict) and isinstance(properties := at.get("properties"), dict) and beside in properties:
        properties[name] = schema


def response_schema(method: str, path: str) -> Schema:
    """Return the schema of a successful response."""
    answer = paths()[path][method]["responses"]["200"]
    schema: Schema = answer["content"]["application/json"]["schema"]
    return schema


def filled(method: str, path: str, known: Mapping[str, Any]) -> dict[str, Any]:
    """Return the known fields; other required fields get the emptiest value that the document allows."""
    answer: dict[str, Any] = _fill(response_schema(method, path), known)
    return answer


def _fill(schema: Schema, known: Any) -> Any:
    if isinstance(known, list | tuple):
        items = schema.get("items", {})
        return [_fill(items, item) for item in known]
    properties = schema.get("properties")
    if properties is None or (known is not ... and not isinstance(known, Mapping)):
        return _empty(schema) if known is ... else known
    given: Mapping[str, Any] = {} if known is ... else known
    wanted = [name for name in properties if name in given or name in schema.get("required", ())]
    result = {name: _fill(properties[name], given.get(name, ...)) for name in wanted}
    return result | {name: value for name, value in given.items() if name not in properties}


def _empty(schema: Schema) -> Any:
    kinds = schema.get("type", "object")
    kinds = kinds if isinstance(kinds, list) else [kinds]
    if "null" in kinds:
        return None
    return {"string": "", "integer": 0, "number": 0, "boolean": False, "array": [], "object": {}}[kinds[0]]
