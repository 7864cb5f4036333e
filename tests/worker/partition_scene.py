"""Two workers on hosts of their own, each with one link to the database, one to the forum and one to the driver.

Run as `unshare --net python -m tests.worker.partition_scene FOLDER`. The hosts are network namespaces, the links pairs
of virtual interfaces, one of which is set down to cut the link. Prints one line of JSON: what happened in each case.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx2
import psycopg

from agentrob.config.board import BoardConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.journal import JournalConfig
from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.model import AccountKind, Role
from agentrob.robots.driver.client import DriverClient
from agentrob.wiring import app
from tests.agent.agent_scene import FINAL, ROBOT, robot_settings
from tests.board.board_processes import fresh_postgres
from tests.robots.driver.network_scene import Authority
from tests.robots.driver_scene import at_rest
from tests.waiting import until
from tests.worker import late_worker

SERVICES = {"database": "10.99.0.1", "forum": "10.99.0.2", "driver": "10.99.0.3"}
FORUM, DRIVER = f"http://{SERVICES['forum']}:8088", f"{SERVICES['driver']}:8093"
LIMIT_S = 45.0
#: Takes 25 s, so that it does not end by itself.
FAR, GESTURE = f"@{ROBOT} walk forward 5 m", f"@{ROBOT} wave"


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True)


class Host:
    """A network namespace that reaches each service over an interface of its own."""

    def __init__(self, name: str, number: int) -> None:
        self.name = name
        self._keeper = subprocess.Popen(
            ["unshare", "--net", "sh", "-c", "echo up && exec cat"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        assert self._keeper.stdout is not None
        assert self._keeper.stdout.readline() == b"up\n"
        self.addresses: dict[str, str] = {}
        for place, (service, address) in enumerate(SERVICES.items(), 10 * number):
            here, network = self._interface(service), f"10.99.{place}"
            self.addresses[service] = f"{network}.2"
            ip("link", "add", "name", here, "type", "veth", "peer", "name", service)
            ip("link", "set", service, "netns", str(self._keeper.pid))
            ip("addr", "add", f"{network}.1/24", "dev", here)
            ip("link", "set", here, "up")
            for words in (
                f"addr add {network}.2/24 dev {service}",
                f"link set {service} up",
                f"route add {address} via {network}.1",
            ):
                subprocess.run(self.inside("ip", *words.split()), check=True)

    def _interface(self, service: str) -> str:
        return f"{self.name}-{service}"

    def inside(self, *command: str) -> list[str]:
        return ["nsenter", "--target", str(self._keeper.pid), "--net", "--", *command]

    def cut(self, *services: str) -> float:
        """Cut the links to these services; return the time."""
        for service in services:
            ip("link", "set", self._interface(service), "down")
        return time.monotonic()

    def mend(self, *services: str) -> None:
        for service in services:
            ip("link", "set", self._interface(service), "up")

    def end(self) -> None:
        self._keeper.kill()
        self._keeper.wait()


class Worker:
    """`agentrob agent run --all` on a host of its own."""

    def __init__(self, host: Host, config: Config, folder: Path, env: dict[str, str]) -> None:
        self.host = host
        self._path, self._log = folder / f"{host.name}.toml", folder / f"{host.name}.log"
        config.model_copy(update={"data": str(folder / host.name)}).write(self._path)
        (folder / f"run-{host.name}").mkdir()
        self._env = {**os.environ, **env, "AGENTROB_RUNTIME": str(folder / f"run-{host.name}")}
        self._process: asyncio.subprocess.Process | None = None
        #: When it last began to serve the robot.
        self._served_s, self._changed = -math.inf, asyncio.Event()

    async def start(self) -> None:
        command = ["-m", "agentrob", "agent", "run", "--all", "--name", self.host.name, "--config", str(self._path)]
        with self._log.open("ab") as log:
            self._process = await asyncio.create_subprocess_exec(
                *self.host.inside(sys.executable, *command), stdout=asyncio.subprocess.PIPE, stderr=log, env=self._env
            )
        assert self._process.stdout is not None
        self._reading = asyncio.create_task(self._read(self._process.stdout))

    async def _read(self, lines: asyncio.StreamReader) -> None:
        async for line in lines:
            if json.loads(line).get("robot") == ROBOT:
                self._served_s = time.monotonic()
                self._changed.set()
        self._changed.set()  # it has ended

    async def served(self, after_s: float) -> None:
        """Wait until it begins to serve the robot after this time."""
        async with asyncio.timeout(LIMIT_S):
            while self._served_s < after_s:
                assert not self._reading.done(), self._log.read_text()[-3000:]
                self._changed.clear()
                await self._changed.wait()

    async def end(self) -> None:
        if self._process is not None:
            self._process.kill()
            await self._process.wait()
            await self._reading

    def late(self, settings: RobotConfig, leased: dict[str, Any]) -> dict[str, str]:
        """The driver's answers on this host to a worker that still has this old lease's number, or none."""
        facts = json.dumps([settings.model_dump(mode="json"), leased["store"], leased["number"]])
        command = self.host.inside(sys.executable, late_worker.__file__, ROBOT, facts)
        done = subprocess.run(command, env=self._env, capture_output=True, text=True, timeout=LIMIT_S, check=False)
        assert done.returncode == 0, done.stderr
        found: dict[str, str] = json.loads(done.stdout)
        return found


class Scene:
    """Database, forum, driver and the two workers."""

    def __init__(self, folder: Path, database: str, stack: contextlib.ExitStack) -> None:
        self.folder = folder
        self.url = f"postgresql+psycopg://tester@{SERVICES['database']}/postgres"
        self._database = psycopg.connect(database.replace("+psycopg", ""), autocommit=True)
        stack.callback(self._database.close)
        authority = Authority(folder / "authority")
        base = robot_settings(
            options={"time_scale": 1}, limits={"speed_mps": 0.2}, recording={"view": "none"}
        ).model_dump(mode="json")
        self.remote = RobotConfig.model_validate(
            {**base, "driver_url": f"https://{DRIVER}", **authority.issue("agent")}
        )
        local = RobotConfig.model_validate(
            {**base, "driver_listen": DRIVER, **authority.issue("driver", SERVICES["driver"])}
        )
        self.config = Config(
            data=str(folder), board=BoardConfig(listen=f"{SERVICES['forum']}:8088", base_url=FORUM),
            forum=ForumConfig(url=FORUM), journal=JournalConfig(database=self.url), robots={ROBOT: self.remote},
        )  # fmt: skip
        path = folder / "board.toml"
        self.config.write(path)
        app.board_account(self.config, "op", AccountKind.HUMAN, Role.OPERATOR)
        app.board_account(self.config, ROBOT, AccountKind.ROBOT_AGENT, Role.MEMBER)
        stack.enter_context(_running(["-m", "agentrob", "board", "serve", "--config", str(path)], folder / "board.log"))
        words = ["-m", "tests.worker.ledger_driver", ROBOT, local.model_dump_json(), str(folder)]
        stack.enter_context(_running(words, folder / "driver.log"))
        self.hosts = [Host("a", 1), Host("b", 2)]
        for host in self.hosts:
            stack.callback(host.end)
        env = {"AGENTROB_TOKEN": app.board_token(self.config, ROBOT)}
        self.workers = [Worker(host, self.config, folder, env) for host in self.hosts]
        headers = {"Authorization": f"Bearer {app.board_token(self.config, 'op')}"}
        self.http = httpx2.AsyncClient(base_url=f"{FORUM}/api/v1", headers=headers, timeout=LIMIT_S)
        self.robot = DriverClient(ROBOT, folder / f"{ROBOT}.sock")

    def ledger(self) -> list[dict[str, Any]]:
        return [json.loads(line) for line in (self.folder / "ledger.jsonl").read_text().splitlines()]

    async def post(self, body: str) -> str:
        content = {"board_id": "robots", "title": "A topic", "body": body}
        return str((await self.http.post("/topics", json=content)).raise_for_status().json()["topic"]["id"])

    async def cards(self, topic: str) -> list[dict[str, Any]]:
        """The cards of the robot's status posts in a topic."""
        items = (await self.http.get(f"/topics/{topic}/posts")).raise_for_status().json()["items"]
        return [item["card"] for item in items if item["card"]]

    async def until(self, topic: str, *states: str) -> list[dict[str, Any]]:
        """Wait until the command of this topic has one of these states; return its cards."""
        async with asyncio.timeout(LIMIT_S):
            while True:
                cards = await self.cards(topic)
                if any(card["state"] in states for card in cards):
                    return cards
                await asyncio.sleep(0.05)

    async def final(self, topic: str) -> dict[str, Any]:
        """Wait for the end of the command; return its states and the steps that reached the robot for it."""
        cards = await self.until(topic, *FINAL)
        of_it = [line for line in self.ledger() if cards[0]["trace_id"] in line.get("holder", "")]
        return {"states": [card["state"] for card in cards], "steps": [x for x in of_it if x["what"] != "leased"]}

    async def walking(self) -> str:
        """Post a walk, wait until the robot walks, and return its topic."""
        topic = await self.post(FAR)
        await self.until(topic, "running")
        await self.reaches(lambda state: not at_rest(state))
        return topic

    async def reaches(self, true: Any) -> float:
        await until(self.robot.state, true, limit_s=LIMIT_S)
        return time.monotonic()

    async def connected(self, host: Host, since_s: float) -> None:
        """Wait until the worker on this host has a session of the database that began after `since_s`."""
        query = (
            "SELECT count(*) FROM pg_stat_activity "
            "WHERE client_addr = %s AND extract(epoch FROM backend_start) > %s AND query LIKE 'SELECT%%'"
        )
        given = host.addresses["database"], since_s
        await until(lambda: self._database.execute(query, given).fetchone(), lambda row: row != (0,), limit_s=LIMIT_S)

    # ------------------------------------------------------------------ what happens
    async def loses_the_driver(self) -> dict[str, Any]:
        """The first worker keeps the database, so nobody takes over. The robot stops by the lease."""
        holder = self.workers[0].host
        walk, wave = await self.walking(), await self.post(GESTURE)
        cut_s = holder.cut("driver")
        rest_s = await self.reaches(at_rest)
        ended = await self.final(walk)
        told_s = time.monotonic()
        holder.mend("driver")
        waved = await self.final(wave)
        again = await self.final(await self.post(GESTURE))
        return {
            "rest_s": rest_s - cut_s, "told_s": told_s - cut_s, "walk": ended, "wave": waved, "again": again
        }  # fmt: skip

    async def loses(self, holder: Worker, other: Worker, *services: str) -> dict[str, Any]:
        """The holder loses the database, and perhaps more, but keeps the driver. The other worker takes over."""
        walk, wave = await self.walking(), await self.post(GESTURE)
        await self.until(wave, "queued")
        old = next(line for line in reversed(self.ledger()) if line["what"] == "leased")
        cut_s = holder.host.cut(*services)
        clock_s = time.time() - time.monotonic()
        rest_s = await self.reaches(at_rest)
        await other.served(cut_s)
        late, ended, waved = await asyncio.gather(
            asyncio.to_thread(holder.late, self.remote, old), self.final(walk), self.final(wave)
        )
        again = await self.final(await self.post(GESTURE))
        new = [line["number"] for line in self.ledger() if line["at_s"] > cut_s and line["what"] == "leased"]
        # A fencing number is the time in milliseconds at which the database gave the robot to its worker.
        return {
            "rest_s": rest_s - cut_s, "taken_s": new[0] / 1000 - clock_s - cut_s, "walk": ended, "wave": waved,
            "again": again, "late": late, "old_number": old["number"], "new_numbers": new,
        }  # fmt: skip

    async def run(self) -> dict[str, Any]:
        a, b = self.workers
        async with self.http, self.robot:
            try:
                await a.start()
                await a.served(0.0)
                since_s = time.time()
                await b.start()
                found = {"driver": await self.loses_the_driver()}
                await self.connected(b.host, since_s)
                found["database"] = await self.loses(a, b, "database")
                since_s = time.time()
                a.host.mend("database")
                await self.connected(a.host, since_s)
                found["database and forum"] = await self.loses(b, a, "database", "forum")
                found["ledger"] = self.ledger()  # type: ignore[assignment]
                return found
            finally:
                await asyncio.gather(a.end(), b.end())


@contextlib.contextmanager
def _running(command: list[str], log: Path) -> Iterator[None]:
    """Run a Python process until the block ends; it prints a line when it is ready."""
    with log.open("ab") as errors:
        process = subprocess.Popen([sys.executable, *command], stdout=subprocess.PIPE, stderr=errors)
    assert process.stdout is not None
    try:
        assert process.stdout.readline(), log.read_text()[-3000:]
        yield
    finally:
        process.terminate()
        process.wait(LIMIT_S)


def main() -> None:
    ip("link", "set", "lo", "up")
    for address in SERVICES.values():
        ip("addr", "add", f"{address}/32", "dev", "lo")
    with contextlib.ExitStack() as stack:
        database = stack.enter_context(fresh_postgres(SERVICES["database"]))
        scene = Scene(Path(sys.argv[1]), database, stack)
        print(json.dumps(asyncio.run(scene.run())))  # noqa: T201


if __name__ == "__main__":
    main()
