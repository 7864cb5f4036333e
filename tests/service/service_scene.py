"""A served agent: real sockets, a memory forum, a fake robot behind a real driver process."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2

from agentrob.agent.agent import RobotAgent
from agentrob.config.service import Scope
from agentrob.forums.memory.forum import MemoryWorld
from agentrob.model import AccountKind, Report, Role
from agentrob.process.webhooks import Outbox, Receiver
from agentrob.service.auth import Caller, TokenAuthenticator
from agentrob.service.commands import CommandService
from agentrob.service.dependencies import Parts
from agentrob.service.metrics import ServiceMetrics
from agentrob.service.server import serving
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene
from tests.waiting import until, walks

ALL: frozenset[Scope] = frozenset(("look", "preview", "command", "stop"))
#: The callers: role and kind of their forum account, and the scopes of their token.
PEOPLE: Mapping[str, tuple[Role, AccountKind, frozenset[Scope]]] = {
    "alice": (Role.OPERATOR, AccountKind.HUMAN, ALL),
    "bob": (Role.MEMBER, AccountKind.HUMAN, ALL),
    "planner": (Role.OPERATOR, AccountKind.COMMANDING_AGENT, ALL),
    "other-robot": (Role.OPERATOR, AccountKind.ROBOT_AGENT, ALL),
    "watcher": (Role.OPERATOR, AccountKind.HUMAN, frozenset(("look",))),
}


@dataclass
class Service:
    """A served agent. `await service.call("alice", "POST", "/stop")` sends a request; paths are below the robot's."""

    scene: Scene
    agent: RobotAgent
    parts: Parts
    url: str
    http: httpx2.AsyncClient

    async def call(self, who: str, method: str, path: str, body: Any = None, **headers: str) -> httpx2.Response:
        sent = {"Authorization": f"Bearer {token(who)}", **headers}
        return await self.http.request(method, f"{self.url}/api/v1/robots/{ROBOT}{path}", json=body, headers=sent)

    async def submit(self, who: str, text: str, key: str | None = None, **more: Any) -> dict[str, Any]:
        headers = {"Idempotency-Key": key} if key else {}
        answer = await self.call(who, "POST", "/commands", {"text": text, **more}, **headers)
        assert answer.status_code in (200, 201), answer.text
        found: dict[str, Any] = answer.json()["command"]
        return found

    async def end(self, command: dict[str, Any]) -> dict[str, Any]:
        """Wait until a command has ended; return it."""
        for _ in range(3):
            answer = await self.call("watcher", "GET", f"/commands/{command['id']}?wait_s=20")
            found: dict[str, Any] = answer.json()
            if found["ended"]:
                break
        assert found["ended"], found
        return found

    async def moving(self, command: dict[str, Any]) -> None:
        """Wait until a command moves the robot."""
        async with self.scene.driver.client() as client:
            await until(client.state, walks)
        job = self.agent.queue.moving
        assert job is not None
        assert job.command.post_id == command["id"]

    async def ready(self) -> httpx2.Response:
        """Return the answer of `/readyz` once it is ready; on a busy machine forum or driver may answer late."""
        async with asyncio.timeout(60):
            while (answer := await self.http.get(f"{self.url}/readyz")).status_code == 503:
                pass
        return answer

    async def x_m(self) -> float:
        async with self.scene.driver.client() as client:
            state = await client.state()
        assert state.pose is not None
        return state.pose.x_m


def token(who: str) -> str:
    return f"the-token-of-{who}"


@asynccontextmanager
async def make_service(
    driver: Driver,
    folder: Path,
    *,
    world: MemoryWorld | None = None,
    per_minute: int = 10_000,
    receivers: tuple[Receiver, ...] = (),
    pauses_s: tuple[float, ...] = (0.01, 0.01),
    hooks_in: Mapping[str, Any] | None = None,
    wait: bool = True,
    listens: bool = True,
    **settings: Any,
) -> AsyncIterator[Service]:
    """Serve an agent. `wait=False` does not wait for the agent, for forums that do not answer."""
    scene = make_scene(driver, folder, world, **settings)
    callers = {}
    for name, (role, kind, scopes) in PEOPLE.items():
        callers[token(name)] = Caller(name, scopes, scene.person(name, role, kind))
    callers[token("button")] = Caller("button", frozenset(("stop",)))
    metrics = ServiceMetrics(ROBOT)
    outbox = Outbox(receivers, metrics.webhook_delivered, pauses_s)
    made: list[CommandService] = []

    def ended(report: Report) -> None:
        made[0].ended(report)

    agent = scene.make(on_end=ended, listens=listens)
    made.append(CommandService(agent, metrics, outbox))
    parts = Parts(made[0], TokenAuthenticator(callers, per_minute), metrics, outbox, hooks_in or {}, ("127.0.0.1",))
    listener = socket.create_server(("127.0.0.1", 0))
    running = asyncio.create_task(agent.run())
    try:
        if wait:
            ready = asyncio.create_task(agent.ready.wait())
            await asyncio.wait({running, ready}, return_when=asyncio.FIRST_COMPLETED)
            ready.cancel()
        url = f"http://127.0.0.1:{listener.getsockname()[1]}"
        async with serving(parts, listener), httpx2.AsyncClient(timeout=100, trust_env=False) as http:
            yield Service(scene, agent, parts, url, http)
    finally:
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)
        await agent.close()
        listener.close()
