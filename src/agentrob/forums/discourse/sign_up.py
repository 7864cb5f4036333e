"""Making an account on a Discourse: with an admin's key at once, or as a visitor who waits for an e-mail."""

from __future__ import annotations

from typing import Any

from agentrob.errors import ForumError
from agentrob.forums.discourse.http import Wire


async def signed_up(wire: Wire, name: str, email: str, password: str, display_name: str = "") -> bool:
    """Whether the new account can be used at once. `ForumError` says what is wrong with it."""
    wanted: dict[str, Any] = {"name": display_name or name, "username": name, "email": email, "password": password}
    if wire.credentials.by_api_key:
        wanted |= {"active": True, "approved": True}
    else:  # a visitor shows by the honeypot that it has read the form
        honeypot = await wire.get("/session/hp.json")
        wanted |= {"password_confirmation": honeypot["value"], "challenge": honeypot["challenge"][::-1]}
    answer = await wire.ask("POST", "/users.json", json=wanted)
    if not answer.get("success"):  # refused with 200
        raise ForumError(f"the forum does not take the account {name}: {answer.get('message')}")
    return bool(answer.get("active"))
