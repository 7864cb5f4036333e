"""Errors of the service: the status and code of every error of the product, and the statuses in its API document."""

from __future__ import annotations

from typing import Any

import structlog
from fastapi import FastAPI
from starlette.requests import Request
from starlette.responses import Response

from agentrob.errors import (
    AgentRobError,
    ForumDenied,
    ForumError,
    ForumLimited,
    ForumNotFound,
    ForumUnreachable,
    HttpError,
    JournalError,
    RobotBusy,
    RobotError,
    RobotUnreachable,
    ServiceError,
)
from agentrob.process.problem import add_error_handlers, http_error, problem_response, problem_responses

_log = structlog.get_logger()


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint: these statuses, and those that every endpoint can return."""
    return problem_responses((400, 401, 403, 404, 413, 421, 422, 429, *statuses))


def as_http_error(error: AgentRobError) -> HttpError:
    """The HTTP status and code of an error of the product."""
    text = str(error)
    match error:
        case HttpError():
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

    async def respond(request: Request, error: Exception) -> Response:
        converted = as_http_error(error) if isinstance(error, AgentRobError) else http_error(error)
        if converted.status == 500:
            _log.error("service.unexpected", path=request.url.path, exc_info=error)
        return problem_response(converted)

    add_error_handlers(app, AgentRobError, respond)
