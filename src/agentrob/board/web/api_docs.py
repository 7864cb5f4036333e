"""The API page: the OpenAPI document as HTML, rendered by the server, so that it needs no scripts."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import Any

from fastapi import APIRouter, FastAPI, Request
from starlette.responses import HTMLResponse, Response

from agentrob.board.access import AnyViewer
from agentrob.board.web.templating import render_fragment, render_page

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)


@dataclass(frozen=True, slots=True)
class Operation:
    """An operation of the API. `title` names it for people; `answers` are the successful responses, `problems` the
    statuses of errors."""

    method: str
    path: str
    id: str
    title: str
    description: str
    parameters: tuple[dict[str, Any], ...]
    body: dict[str, Any]
    answers: dict[str, dict[str, Any]]
    problems: tuple[str, ...]


@router.get("/docs")
async def api_docs(request: Request, viewer: AnyViewer) -> Response:
    """Public, like the document itself."""
    state = request.app.state
    if not hasattr(state, "api_reference"):  # takes long enough to delay a stop on the event loop
        state.api_reference = await asyncio.to_thread(_reference, request.app)
    return render_page(request, viewer, "api.html", {"reference": state.api_reference}, here="api")


def _reference(app: FastAPI) -> str:
    document = app.openapi()
    data = {"tags": document["tags"], "operations": operations_by_tag(document)}
    return render_fragment("api_reference.html", data | {"schemas": document["components"]["schemas"]})


def operations_by_tag(document: dict[str, Any]) -> dict[str, list[Operation]]:
    """The operations of an OpenAPI document by tag, in the order of the document."""
    found: dict[str, list[Operation]] = {tag["name"]: [] for tag in document["tags"]}
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            answers = operation["responses"]
            found[operation["tags"][0]].append(
                Operation(
                    method=method.upper(),
                    path=path,
                    id=operation["operationId"],
                    title=operation["summary"],
                    description=operation.get("description", ""),
                    parameters=tuple(operation.get("parameters", ())),
                    body=operation.get("requestBody", {}).get("content", {}),
                    answers={s: a.get("content", {}) for s, a in sorted(answers.items()) if s < "300"},
                    problems=tuple(sorted(s for s in answers if s >= "400")),
                )
            )
    return found
