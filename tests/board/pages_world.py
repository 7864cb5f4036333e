"""A real forum on a free port with a few accounts, for the tests of its pages."""

from __future__ import annotations

import asyncio
import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import httpx2

from agentrob.board import admin
from agentrob.board.server import Server, create_app
from agentrob.board.settings import BoardSettings
from agentrob.config import BoardConfig
from agentrob.model import Account, AccountKind, Role

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


@dataclass
class World:
    """The forum at `base`; `alice` is an operator, `bob` a member, `quadruped` a robot, `root` an admin."""

    base: str
    settings: BoardSettings
    accounts: dict[str, Account]
    clients: list[httpx2.Client] = field(default_factory=list)

    def api(self, name: str) -> httpx2.Client:
        """The JSON API as that account."""
        token = admin.issue_token(self.settings, self.accounts[name])
        return self._client(base_url=self.base + "/api/v1", headers={"Authorization": f"Bearer {token}"})

    def browser(self, name: str | None = None) -> Surfer:
        """A browser without scripts, signed in or not."""
        surfer = Surfer(self._client(base_url=self.base, follow_redirects=True))
        if name:
            surfer.client.post(self.link(name), data={"csrf": surfer.csrf(self.link(name))})
        return surfer

    def link(self, name: str) -> str:
        """The path of a new one-time link."""
        return admin.issue_link(self.settings, self.accounts[name])

    def _client(self, **how: Any) -> httpx2.Client:
        client = httpx2.Client(**how, timeout=20)
        self.clients.append(client)
        return client


@dataclass
class Surfer:
    """Reads pages and sends their forms, as a person without scripts does."""

    client: httpx2.Client

    def get(self, path: str) -> httpx2.Response:
        return self.client.get(path)

    def csrf(self, path: str) -> str:
        found = re.search(r'name="csrf" value="([^"]*)"', self.get(path).text)
        assert found, f"no form on {path}"
        return found[1]

    def send(self, path: str, page: str | None = None, **fields: str) -> httpx2.Response:
        """Sends the form that goes to `path`, with the token and hidden fields of the page it is on."""
        text = self.get(page or path).text
        form = re.search(rf'<form[^>]*action="{re.escape(path)}".*?</form>', text, re.DOTALL)
        assert form, f"no form for {path} on {page or path}"
        hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form[0]))
        return self.client.post(path, data=hidden | fields)


@contextmanager
def running_world(folder: Path, **config: Any) -> Iterator[World]:
    """The forum, served from a thread until the block ends."""
    listener = socket.create_server(("127.0.0.1", 0))
    listen = f"127.0.0.1:{listener.getsockname()[1]}"
    settings = BoardSettings.from_config(BoardConfig(listen=listen, **config), folder)
    admin.bootstrap(settings)
    people = {"alice": Role.OPERATOR, "bob": Role.MEMBER, "root": Role.ADMIN}
    made = {n: admin.create_account(settings, n, role=r, password=PASSWORD) for n, r in people.items()}
    made["quadruped"] = admin.create_account(settings, "quadruped", kind=AccountKind.ROBOT_AGENT)
    server = Server(create_app(settings), settings)
    thread = threading.Thread(target=lambda: asyncio.run(server.serve(sockets=[listener])))
    thread.start()
    world = World(settings.base_url, settings, made)
    try:
        yield world
    finally:
        for client in world.clients:
            client.close()
        server.should_exit = True
        thread.join(10)
        listener.close()
    assert not thread.is_alive()
