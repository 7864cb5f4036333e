"""Shared by the endpoints of the JSON API: parameters, responses, and the check that keeps a stream open."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Final

from fastapi import Header, Query
from pydantic import BaseModel
from starlette.responses import Response

from agentrob.board.access import Viewer
from agentrob.board.admin.management import BOARD_ID
from agentrob.board.api.models import Serializer
from agentrob.board.auth import accounts, visibility
from agentrob.board.content import tags
from agentrob.board.db.reader import MAX_LIMIT
from agentrob.board.services import Services
from agentrob.errors import BoardError
from agentrob.model import Account
from agentrob.process.problem import problem_responses

KEY: Final = r"^[!-~]{1,200}$"
EVENT_ID: Final = r"^[0-9]{1,18}(-[0-9a-f]{1,16})?$"
IdempotencyKey = Annotated[str | None, Header(alias="Idempotency-Key", pattern=KEY)]
Cursor = Annotated[str | None, Query(pattern=r"^[0-9a-f]{1,15}$", description="`next` of the previous page")]
Limit = Annotated[int, Query(ge=1, le=MAX_LIMIT, description="items per page")]
AfterEvent = Annotated[str | None, Query(pattern=EVENT_ID, description="an event id")]
BoardFilter = Annotated[str | None, Query(pattern=rf"^{BOARD_ID.pattern}$", description="only on this board")]
TagFilter = Annotated[str | None, Query(max_length=tags.LENGTH, description="only of topics with this tag")]


def documented(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """The `responses` of an endpoint: these statuses, and those that every endpoint can return."""
    return problem_responses((400, 401, 403, 413, 421, 422, 503, *statuses))


def json_response(model: BaseModel, status: int = 200) -> Response:
    """The model as JSON. Endpoints declare the same model as their `response_model`."""
    return Response(model.model_dump_json(), status, media_type="application/json")


def serializer(services: Services, account: Account | None) -> Serializer:
    """Makes models for this account."""
    return Serializer(services.settings.base_url, account)


def still_allowed(
    services: Services, who: Viewer, check: Callable[[Account | None], None] = lambda account: None
) -> Callable[[], bool]:
    """Return a function that says whether the viewer who opened a stream may still see all that it shows.

    It returns False when the viewer signed out or was suspended, the token was revoked, or a board was closed to the
    viewer. `check` repeats with the account of that moment what the endpoint checked when it opened the stream; it
    raises `BoardError` when the viewer is not allowed any more.
    """
    opened_with = visibility.readable_boards()

    def allowed() -> bool:
        account = None
        if who.account is not None:
            signed_in = accounts.by_token if who.by_token else accounts.by_session
            account = signed_in(services.store.reader, who.secret)
            if account is None or account.suspended:
                return False
        check(account)
        boards = services.store.everything.all_boards()
        return opened_with <= visibility.boards_readable_by(boards, account, services.settings.public_read)

    def checked() -> bool:
        try:
            return allowed()
        except BoardError:
            return False

    return checked
