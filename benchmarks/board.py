"""How fast the embedded forum is: replies, topic pages and event latency, between processes on loopback.

    python benchmarks/board.py [--seconds 5] [--listeners 200]

The board is a process of its own with its database in a temporary folder; this process makes the load, on the same
cores. Every request signs in by token and is checked for its right. Figures are of this machine at this moment.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from agentrob.board import admin
from agentrob.board.settings import BoardSettings
from agentrob.config import BoardConfig
from agentrob.model import Role

SERVE = """
import sys
from pathlib import Path
import structlog
from agentrob.board import server
from agentrob.board.settings import BoardSettings
from agentrob.config import BoardConfig
structlog.configure(logger_factory=structlog.PrintLoggerFactory(sys.stderr))
settings = BoardSettings.from_config(BoardConfig(listen="127.0.0.1:0"), Path(sys.argv[1]))
server.serve(settings, lambda s: print(s.port, flush=True))
"""


class Client:
    """A bare HTTP/1.1 connection, so that little of what is measured is the client."""

    def __init__(self, port: int, token: str) -> None:
        self.port, self.token = port, token

    async def open(self) -> Client:
        self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.port)
        return self

    async def send(self, method: str, path: str, body: dict[str, str] | None = None) -> None:
        data = json.dumps(body).encode() if body is not None else b""
        head = f"{method} /api/v1{path} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {self.token}\r\n"
        head += f"Content-Type: application/json\r\nContent-Length: {len(data)}\r\n\r\n"
        self.writer.write(head.encode() + data)
        await self.writer.drain()

    async def call(self, method: str, path: str, body: dict[str, str] | None = None) -> dict:
        await self.send(method, path, body)
        head = (await self.reader.readuntil(b"\r\n\r\n")).lower()
        length = int(head.split(b"content-length: ")[1].split(b"\r\n")[0])
        answer = json.loads(await self.reader.readexactly(length))
        assert b" 20" in head.split(b"\r\n")[0], answer
        return answer

    async def listen(self) -> Client:
        await self.send("GET", "/events?heartbeat=30")
        await self.reader.readuntil(b"retry: 1000\n\n")
        return self

    async def next_post(self) -> str:
        while True:
            line = await self.reader.readline()
            if line.startswith(b"data: "):
                return json.loads(line[6:])["post"]["id"]


def percentiles(values_s: list[float]) -> str:
    ordered = sorted(values_s)
    p50, p95, p99 = (ordered[min(len(ordered) - 1, int(len(ordered) * q))] * 1000 for q in (0.5, 0.95, 0.99))
    return f"p50 {p50:.1f} ms, p95 {p95:.1f} ms, p99 {p99:.1f} ms"


async def load(name: str, clients: list[Client], seconds: float, path: str, body: dict[str, str] | None) -> None:
    end, took = time.perf_counter() + seconds, []

    async def worker(client: Client) -> None:
        while (start := time.perf_counter()) < end:
            await client.call("POST" if body else "GET", path, body)
            took.append(time.perf_counter() - start)

    start = time.perf_counter()
    await asyncio.gather(*map(worker, clients))
    print(f"{name}: {len(took) / (time.perf_counter() - start):.0f}/s, {percentiles(took)}")


async def event_latency(port: int, token: str, topic: str, listeners: int, posts: int) -> None:
    """From the moment the request is sent, and from its answer, until every listener has read the event."""
    writer = await Client(port, token).open()
    streams = [await (await Client(port, token).open()).listen() for _ in range(listeners)]
    first_s, all_s = [], []
    for n in range(posts):
        heard = [asyncio.ensure_future(s.next_post()) for s in streams]
        start = time.perf_counter()
        await writer.send("POST", f"/topics/{topic}/posts", {"body": f"post {n}"})
        await asyncio.wait(heard, return_when=asyncio.FIRST_COMPLETED)
        first_s.append(time.perf_counter() - start)
        await asyncio.gather(*heard)
        all_s.append(time.perf_counter() - start)
        head = (await writer.reader.readuntil(b"\r\n\r\n")).lower()
        await writer.reader.readexactly(int(head.split(b"content-length: ")[1].split(b"\r\n")[0]))
        await asyncio.sleep(0.01)
    print(f"post sent -> event read by the first of {listeners}: {percentiles(first_s)}")
    print(f"post sent -> event read by all {listeners}: {percentiles(all_s)}")
    for stream in streams:
        stream.writer.close()


async def measure(port: int, token: str, seconds: float, listeners: int) -> None:
    client = await Client(port, token).open()
    text = "The robot walked **0.98 m** of 1 m, then turned left by 91° and waved. `trace 3f2a`\n\n" * 5
    topic = (await client.call("POST", "/topics", {"board": "talk", "title": "t", "body": text}))["topic"]["id"]
    for _ in range(19):
        await client.call("POST", f"/topics/{topic}/posts", {"body": text})
    hot = f"/topics/{topic}/posts?limit=20"
    size = len(json.dumps(await client.call("GET", hot)))
    eight = [await Client(port, token).open() for _ in range(8)]
    sixteen = [await Client(port, token).open() for _ in range(16)]
    await load(f"GET 20 posts ({size // 1000} kB), 16 connections", sixteen, seconds, hot, None)
    await load("GET /me, 16 connections", sixteen, seconds, "/me", None)
    other = (await client.call("POST", "/topics", {"board": "talk", "title": "t", "body": "x"}))["topic"]["id"]
    await load("replies, 1 connection", eight[:1], seconds, f"/topics/{other}/posts", {"body": text})
    await load("replies, 8 connections", eight, seconds, f"/topics/{other}/posts", {"body": text})
    await event_latency(port, token, other, 1, 200)
    await event_latency(port, token, other, listeners, 50)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seconds", type=float, default=5.0, help="how long each load lasts")
    parser.add_argument("--listeners", type=int, default=200)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        settings = BoardSettings.from_config(BoardConfig(), Path(folder))
        admin.bootstrap(settings)
        account = admin.create_account(settings, "bench", role=Role.OPERATOR)
        token = admin.issue_token(settings, account)
        with subprocess.Popen([sys.executable, "-c", SERVE, folder], stdout=subprocess.PIPE, text=True) as board:
            try:
                assert board.stdout is not None
                port = int(board.stdout.readline())
                asyncio.run(measure(port, token, given.seconds, given.listeners))
            finally:
                board.terminate()


if __name__ == "__main__":
    main()
