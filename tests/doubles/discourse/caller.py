"""The account that sends a request to the double, and what it may see."""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from tests.doubles.discourse.site import Post, Refusal, Site, Topic, User, denied, missing
from tests.doubles.discourse.visitors import Visitors

Handler = Callable[[Request, "Caller"], Awaitable[Response]]


class Caller:
    """The caller, identified by headers or by the session cookie."""

    def __init__(self, site: Site, visitors: Visitors, user: User | None, by_api: bool) -> None:
        self.site, self.visitors, self._user, self.by_api = site, visitors, user, by_api

    @property
    def user(self) -> User:
        if self._user is None:
            raise Refusal(403, "You need to be logged in to do that.", "not_logged_in")
        return self._user

    @property
    def known(self) -> User | None:
        return self._user

    def post(self, request: Request) -> Post:
        found = self.site.posts.get(int(request.path_params["id"]))
        if found is None or not self.site.visible(self.user, found):
            raise missing()
        return found

    def topic(self, request: Request) -> Topic:
        found = self.site.topics.get(int(request.path_params["id"]))
        if found is None or (found.deleted and not self.user.staff):
            raise missing()
        if not self.site.sees(self.user, found):
            raise denied()
        return found


async def body(request: Request) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(await request.body() or b"{}")
    return found
