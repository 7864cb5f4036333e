"""Authentication of the double: keys, sessions with their CSRF token, and sign-up."""

from __future__ import annotations

import secrets
from typing import Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from tests.doubles.discourse.site import Refusal, Site, User, denied


class Visitors:
    """Sessions of one site."""

    def __init__(self, site: Site) -> None:
        self._site = site
        #: Session cookie: CSRF token and account.
        self.sessions: dict[str, tuple[str, int | None]] = {}
        self._honeypot = {"value": secrets.token_hex(16), "challenge": secrets.token_hex(16)}

    def who(self, request: Request) -> tuple[User | None, bool]:
        """Return the account, and whether an API key identified it. Rate limits by address and key are checked
        first."""
        site, address = self._site, request.client.host if request.client else ""
        for count, seconds in (("per_minute", 60), ("per_10_seconds", 10)):
            site.limit(f"ip_{seconds}", address, site.settings[f"max_reqs_per_ip_{count}"], seconds, plain=True)
        if key := request.headers.get("api-key"):
            site.limit("admin_api", key, site.settings["max_admin_api_reqs_per_minute"], 60)
            return self._active(self._of_api_key(key, request.headers.get("api-username"))), True
        if key := request.headers.get("user-api-key"):
            site.limit("user_api", key, site.settings["max_user_api_reqs_per_minute"], 60)
            return self._active(site.users.get(site.user_keys.get(key, 0))), False
        token, number = self.sessions.get(request.cookies.get("_forum_session", ""), ("", None))
        free = request.method in ("GET", "HEAD") or request.url.path.startswith("/message-bus/")
        if not free and (not token or request.headers.get("x-csrf-token") != token):
            raise Refusal(403, "BAD CSRF")
        return site.users.get(number or 0), False

    def who_or_nobody(self, request: Request) -> tuple[User | None, bool]:
        """Identify a caller of the message bus, which treats a rejected or limited key as anonymous without an
        error."""
        try:
            return self.who(request)
        except Refusal:
            return None, False

    def _of_api_key(self, key: str, name: str | None) -> User | None:
        """Return the account of an API key: a key for one account allows no other, a key for all needs a name."""
        if key not in self._site.api_keys:
            return None
        number = self._site.api_keys[key]
        if number is None:
            return self._site.named(name) if name else None
        user = self._site.users[number]
        return user if name is None or user.username.lower() == name.lower() else None

    def _active(self, user: User | None) -> User:
        if user is None or user.suspended_till or not user.active:
            raise denied()
        return user

    # ---------------------------------------------------------------- sessions
    def csrf(self, request: Request) -> Response:
        cookie = request.cookies.get("_forum_session", "")
        if cookie not in self.sessions:
            cookie = secrets.token_hex(16)
            self.sessions[cookie] = (secrets.token_hex(16), None)
        response = JSONResponse({"csrf": self.sessions[cookie][0]})
        response.set_cookie("_forum_session", cookie, httponly=True)
        return response

    def sign_in(self, request: Request, given: dict[str, Any]) -> Response:
        """Sign in; like Discourse, answer a wrong password with status 200."""
        user = self._site.named(str(given.get("login", "")))
        if user is None or not user.password or user.password != given.get("password"):
            return JSONResponse({"error": "Incorrect username, email or password"})
        if user.suspended_till:
            return JSONResponse({"error": "You are suspended.", "reason": "suspended"})
        cookie = secrets.token_hex(16)
        self.sessions[cookie] = (secrets.token_hex(16), user.id)
        response = JSONResponse({"user": {"id": user.id, "username": user.username}})
        response.set_cookie("_forum_session", cookie, httponly=True)
        return response

    # ---------------------------------------------------------------- sign-up
    def honeypot(self) -> dict[str, str]:
        return self._honeypot

    def sign_up(self, given: dict[str, Any], admin: User | None) -> dict[str, Any]:
        """Create an account: active at once with an admin's key; a visitor needs the honeypot and confirms by
        e-mail."""
        by_admin = admin is not None and admin.admin
        read = given.get("password_confirmation") == self._honeypot["value"]
        if not by_admin and not (read and given.get("challenge") == self._honeypot["challenge"][::-1]):
            return {
                "success": True,
                "active": False,
                "message": "You're all set! Check your email.",
            }  # the honeypot caught a bot: no account
        try:
            names = {k: str(given.get(k, "")) for k in ("name", "email", "password")}
            user = self._site.add_user(str(given["username"]), **names, active=by_admin and bool(given.get("active")))
        except Refusal as e:
            return {"success": False, "active": False, "message": e.said}
        said = "Your account is activated and ready to use." if user.active else "Check your email."
        return {"success": True, "active": user.active, "message": said, "user_id": user.id}
