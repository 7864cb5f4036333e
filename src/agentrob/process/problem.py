"""Error responses of the HTTP APIs: RFC 9457 problem details with a stable code and a hint of what is valid."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Awaitable, Callable, Iterable
from http import HTTPStatus
from typing import Any, Final

from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from pydantic import BaseModel, ConfigDict
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from agentrob.errors import AgentRobError, HttpError

MEDIA_TYPE: Final = "application/problem+json"
_SEE: Final = "see /api/v1/openapi.json"
_DESCRIPTIONS: Final = {
    400: "the request cannot be read",
    401: "not signed in, or the token is not valid",
    403: "not allowed",
    404: "not found",
    409: "this cannot be done now",
    413: "the body is too large",
    415: "the body is not of a supported type",
    421: "the Host header does not name this server",
    422: "a value is not valid",
    429: "too many requests; Retry-After says when to retry",
    503: "not available now; try again later",
}


class Problem(BaseModel):
    """RFC 9457 problem details; `code` is a stable word, `hint` says what would be valid."""

    model_config = ConfigDict(frozen=True)

    type: str = "about:blank"
    title: str
    status: int
    detail: str
    code: str
    hint: str


def problem_responses(statuses: Iterable[int]) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint for these statuses. The OpenAPI document must have the schema `Problem`."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    return {status: {"description": _DESCRIPTIONS[status], "content": content} for status in sorted(set(statuses))}


def problem_response(error: HttpError) -> Response:
    """The response to an error."""
    headers = {"Cache-Control": "no-store"}
    if error.retry_after_s is not None:
        headers["Retry-After"] = str(max(1, math.ceil(error.retry_after_s)))
    if error.status == 401:
        headers["WWW-Authenticate"] = "Bearer"
    phrase = HTTPStatus(error.status).phrase
    body = Problem(title=phrase, status=error.status, detail=str(error), code=error.code, hint=error.hint)
    return Response(body.model_dump_json(), error.status, headers, MEDIA_TYPE)


def add_error_handlers(
    app: FastAPI, kind: type[AgentRobError], respond: Callable[[Request, Exception], Awaitable[Response]]
) -> None:
    """Let `respond` answer every exception of an app: those of `kind`, the framework's, and unexpected ones."""

    async def handle(request: Request, error: Exception) -> Response:
        response = await respond(request, error)
        if isinstance(error, HTTPException):
            response.headers.update(error.headers or {})
        return response

    for handled in (kind, RequestValidationError, HTTPException, Exception):
        app.add_exception_handler(handled, handle)


async def refuse_repeated_parameters(request: Request) -> None:
    """Refuse a query parameter that is given more than once, as a dependency of endpoints without lists among them.

    The framework would use the last value and ignore the others. Only GET has parameters: a stop is never refused.
    """
    if request.method == "GET":
        given = Counter(name for name, _ in request.query_params.multi_items())
        repeated = [
            {"loc": ("query", name), "msg": f"given {count} times; give it once", "type": "repeated"}
            for name, count in given.items()
            if count > 1
        ]
        if repeated:
            raise RequestValidationError(repeated)


def http_error(error: Exception) -> HttpError:
    """An exception of an endpoint or of the framework as an error with a status; 500 for an unexpected one."""
    match error:
        case HttpError():
            return error
        case RequestValidationError():
            return _validation_error(error)
        case HTTPException():
            code = HTTPStatus(error.status_code).name.lower()
            hint = _SEE if error.status_code in (400, 404, 405) else ""
            return HttpError(error.status_code, code, str(error.detail), hint)
    return HttpError(500, "internal", "something went wrong; it is in the server's log")


def _validation_error(error: RequestValidationError) -> HttpError:
    """Names the fields that are not valid, but not their values: one may be a password."""
    found = [f"{'.'.join(str(part)[:40] for part in e['loc'])}: {e['msg']}" for e in error.errors()]
    detail = "; ".join(found)[:1000].encode("utf-8", "replace").decode()
    return HttpError(422, "not_valid", detail, _SEE)
