"""Errors of the JSON API: RFC 9457 problem details with a stable code and a hint that says what would be valid."""

from __future__ import annotations

import math
from http import HTTPStatus
from typing import Any

from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import Response

from agentrob.board.api.models import Problem
from agentrob.errors import BoardError

MEDIA_TYPE = "application/problem+json"

_WHEN = {
    400: "the request cannot be read",
    401: "nobody is signed in, or the token is not valid",
    403: "not allowed",
    404: "there is no such thing",
    409: "this cannot be done any more",
    413: "the body is too large",
    415: "the body is not of a type that is read here",
    421: "this address is not the forum's",
    422: "a value is not valid",
    429: "too many requests; Retry-After says when again",
    503: "the database or disk cannot be used now; nothing was written",
}


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint: these statuses, and those that every endpoint can return."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    every = {400, 401, 403, 413, 421, 422, 503}
    return {s: {"description": _WHEN[s], "content": content} for s in sorted(every | set(statuses))}


def problem(error: BoardError) -> Response:
    """The answer to an error."""
    headers = {}
    if error.retry_after_s is not None:
        headers["Retry-After"] = str(max(1, math.ceil(error.retry_after_s)))
    if error.status == 401:
        headers["WWW-Authenticate"] = "Bearer"
    phrase = HTTPStatus(error.status).phrase
    body = Problem(title=phrase, status=error.status, detail=str(error), code=error.code, hint=error.hint)
    return Response(body.model_dump_json(), error.status, headers, MEDIA_TYPE)


def of_validation(error: RequestValidationError) -> BoardError:
    """Say what was wrong with the values of a request, but not the values: one may be a password."""
    found = [f"{'.'.join(str(p) for p in e['loc'])}: {e['msg']}" for e in error.errors()]
    detail = "; ".join(found)[:1000].encode("utf-8", "replace").decode()
    return BoardError(422, "not_valid", detail, "see /api/v1/openapi.json")


def of_http(error: HTTPException) -> BoardError:
    """Errors of the framework: unknown paths, methods, bodies that cannot be read."""
    code = HTTPStatus(error.status_code).name.lower()
    hint = "see /api/v1/openapi.json" if error.status_code in (400, 404, 405) else ""
    return BoardError(error.status_code, code, str(error.detail), hint)
