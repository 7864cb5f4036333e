"""Serve a real forum on a free port with a few accounts, for the tests of its pages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2

from agentrob.board.admin import local_admin
from agentrob.model import Role
from tests.board.running_board import RunningBoard, running_board

PASSWORD = "correct horse battery"
CARD = {
    "model": "go2",
    "ops": ["move", "turn", "hello", "get_front_image"],
    "limits": {"speed_mps": 0.5, "command_m": 10.0, "command_s": 60.0},
    "state": "idle",
    "battery_percent": 83.4,
    "board": "robots",
    "simulated": True,
    "can_reset": True,
}


class Site:
    """A forum served at `base`; `alice` is an operator, `bob` a member, `quadruped` a robot, `root` an admin."""

    def __init__(self, board: RunningBoard) -> None:
        self.board = board
        self.base = board.url
        self.settings = board.settings
        for name, role in {"alice": Role.OPERATOR, "bob": Role.MEMBER, "root": Role.ADMIN}.items():
            board.add(name, role=role, password=PASSWORD)

    def api(self, name: str) -> httpx2.Client:
        """Return a client of the JSON API that is signed in as this account."""
        return self.board.client(name)

    def admin_api(self) -> httpx2.Client:
        """Return a client of the JSON API as `root`, with a token of scope `admin`."""
        admin_api, scopes = local_admin.find_account(self.settings, "root"), ("read", "write", "admin")
        client = self.board.client()
        client.headers["Authorization"] = f"Bearer {local_admin.issue_token(self.settings, admin_api, scopes=scopes)}"
        return client

    def browser(self, name: str | None = None) -> PageClient:
        """Return a browser without scripts, signed in by a one-time link if a name is given."""
        client = self.board.browser()
        client.follow_redirects = True
        visitor = PageClient(client)
        if name:
            visitor.send(self.link(name))
        return visitor

    def link(self, name: str) -> str:
        """Return the path of a new one-time link."""
        return local_admin.issue_link(self.settings, local_admin.find_account(self.settings, name))


@dataclass
class PageClient:
    """Reads pages and submits their forms, like a browser without scripts."""

    client: httpx2.Client

    def get(self, path: str) -> httpx2.Response:
        return self.client.get(path)

    def csrf(self, path: str) -> str:
        found = re.search(r'name="csrf" value="([^"]*)"', self.get(path).text)
        assert found, f"no form on {path}"
        return found[1]

    def send(self, path: str, page: str | None = None, **fields: str) -> httpx2.Response:
        """Submit the form whose action is `path`, with the CSRF token and hidden fields of its page."""
        page = page or path
        text = self.get(page).text
        form = re.search(rf'<form[^>]*action="{re.escape(path)}".*?</form>', text, re.DOTALL)
        assert form, f"no form for {path} on {page}"
        hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form[0]))
        return self.client.post(path, data=hidden | fields)


@contextmanager
def running_site(folder: Path, **options: Any) -> Iterator[Site]:
    """Serve the forum from a thread until the block ends."""
    with running_board(folder, **options) as board:
        yield Site(board)
