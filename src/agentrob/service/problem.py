"""Error responses of the service: RFC 9457 problem details with a stable code and a hint of what is valid."""

from __future__ import annotations

import math
from http import HTTPStatus
from typing import Any

import structlog
from fastapi import FastAPI
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import Response

from agentrob.errors import (
    AgentRobError,
    ForumDenied,
    ForumError,
    ForumLimited,
    ForumNotFound,
    ForumUnreachable,
    JournalError,
    RobotBusy,
    RobotError,
    RobotUnreachable,
    ServiceError,
)
from agentrob.service.models import Problem

MEDIA_TYPE = "application/problem+json"
_WHEN = {
    400: "the request cannot be read",
    401: "no valid token",
    403: "not allowed",
    404: "not found",
    409: "this cannot be done now",
    413: "the body is too large",
    421: "the Host header does not name this service",
    422: "a value is not valid",
    429: "too many requests; Retry-After says when to retry",
    503: "forum, driver or agent cannot be reached now",
}
_log = structlog.get_logger()


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint: these, and those that every endpoint can give."""
    content = {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    every = {400, 401, 403, 404, 413, 421, 422, 429}
    return {s: {"description": _WHEN[s], "content": content} for s in sorted(every | set(statuses))}


def problem(error: ServiceError) -> Response:
    """The response to an error."""
    headers = {"Cache-Control": "no-store"}
    if error.retry_after_s is not None:
        headers["Retry-After"] = str(max(1, math.ceil(error.retry_after_s)))
    if error.status == 401:
        headers["WWW-Authenticate"] = "Bearer"
    phrase = HTTPStatus(error.status).phrase
    body = Problem(title=phrase, status=error.status, detail=str(error), code=error.code, hint=error.hint)
    return Response(body.model_dump_json(), error.status, headers, MEDIA_TYPE)


def as_service_error(error: AgentRobError) -> ServiceError:
    """The HTTP status and code of an error of the product."""
    text = str(error)
    match error:
        case ServiceError():
            return error
        case ForumLimited():
            hint = "send it again with the same Idempotency-Key"
            return ServiceError(429, "forum_limited", text, hint, error.retry_after_s)
        case ForumUnreachable():
            hint = "send it again with the same Idempotency-Key"
            return ServiceError(503, "forum_unreachable", text, hint, 1.0)
        case ForumDenied():
            return ServiceError(403, "forum_denied", text, "the forum does not let this token's account do it")
        case ForumNotFound():
            return ServiceError(404, "not_found", text)
        case ForumError():
            return ServiceError(422, "forum_refused", text)
        case RobotBusy():
            return ServiceError(429, "busy", text, "ask again in a moment", 1.0)
        case RobotUnreachable():
            return ServiceError(503, "driver_unreachable", text, "", 1.0)
        case RobotError():
            return ServiceError(409, "robot", text)
        case JournalError():
            return ServiceError(503, "journal", text)
    return ServiceError(503, "unavailable", text)


def add_errors(app: FastAPI) -> None:
    """Answer every error of the app with problem details."""

    async def ours(request: Request, error: Exception) -> Response:
        assert isinstance(error, AgentRobError)
        return problem(as_service_error(error))

    async def not_valid(request: Request, error: Exception) -> Response:
        # Say what is wrong with the values, without repeating them.
        assert isinstance(error, RequestValidationError)
        found = [f"{'.'.join(str(p)[:40] for p in e['loc'])}: {e['msg']}" for e in error.errors()]
        detail = "; ".join(found)[:1000].encode("utf-8", "replace").decode()
        return problem(ServiceError(422, "not_valid", detail, "see /api/v1/openapi.json"))

    async def http_error(request: Request, error: Exception) -> Response:
        assert isinstance(error, HTTPException)
        code = HTTPStatus(error.status_code).name.lower()
        response = problem(ServiceError(error.status_code, code, str(error.detail), "see /api/v1/openapi.json"))
        response.headers.update(error.headers or {})
        return response

    async def unexpected(request: Request, error: Exception) -> Response:
        _log.error("service.unexpected", path=request.url.path, exc_info=error)
        return problem(ServiceError(500, "internal", "something went wrong; it is in the service's log"))

    app.add_exception_handler(AgentRobError, ours)
    app.add_exception_handler(RequestValidationError, not_valid)
    app.add_exception_handler(HTTPException, http_error)
    app.add_exception_handler(Exception, unexpected)
