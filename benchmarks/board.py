"""Measure the speed of the embedded forum: topics as JSON and as pages, replies, events, with few and many posts.

    python benchmarks/board.py [--posts 1000] [--seconds 5] [--listeners 200]
    python benchmarks/board.py --posts 1000000

The board runs in its own process (SQLite, with limits of posts, commands and uploads) with its database in a temporary
folder; this process generates the load, on the same cores. Every request is authenticated, by token or by session, and
authorized. Topics have 20 posts each; the 50 newest are the hot ones that are read. `CPU` is the server's processor
time per request. Figures depend on the machine and its load, which the first line shows.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import random
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import count
from pathlib import Path

from agentrob.board.admin import local_admin
from agentrob.board.auth import accounts
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig
from agentrob.model import Role

SERVE = """
import sys
from pathlib import Path
import structlog
from agentrob.board import server
from agentrob.board.settings import BoardSettings
from agentrob.config.board import BoardConfig, BoardLimitsConfig
structlog.configure(logger_factory=structlog.PrintLoggerFactory(sys.stderr))
limits = BoardLimitsConfig(posts=10**6, commands=10**6, uploads=10**6, sign_ups=10**6)
settings = BoardSettings.from_config(BoardConfig(listen="127.0.0.1:0", limits=limits), Path(sys.argv[1]))
server.serve(settings, lambda s: print(s.port, flush=True))
"""
RAW = (
    "The robot walked **0.98 m** of 1 m, then turned left by 91° and waved.\n\n"
    "Trace `3f2a`, asked 1.0 m, measured 0.98 m."
)
HTML = (
    "<p>The robot walked <strong>0.98 m</strong> of 1 m, then turned left by 91° and waved.</p>\n"
    "<p>Trace <code>3f2a</code>, asked 1.0 m, measured 0.98 m.</p>\n"
)
PER_TOPIC, HOT = 20, 50
WRITES_PER_S, WRITERS = 50.0, 4
#: The author is not the account that replies; posts of all topics alternate, as on a forum.
SEED = (
    """INSERT INTO topics (id, board_id, title, author_id, created_us, last_post_id, last_post_us, posts, locked)
       WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < :topics)
       SELECT i, 'talk', 'Topic ' || i, 2, i, :posts - :topics + i, i, :per, 0 FROM n""",
    """INSERT INTO posts (id, topic_id, author_id, raw, html, version, created_us, removed, mentions)
       WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < :posts)
       SELECT i, (i - 1) % :topics + 1, 2, :raw, :html, 1, i, 0, '[]' FROM n""",
    """INSERT INTO events (id, kind, at_us, topic_id, post_id)
       SELECT id, 'post.created', created_us, topic_id, id FROM posts ORDER BY id""",
)


# -------------------------------------------------------------------- the load
class Client(asyncio.Protocol):
    """A minimal HTTP/1.1 connection, to keep the client's share of the time small."""

    def __init__(self, port: int, credential: str) -> None:
        self.port, self.head = port, f"Host: 127.0.0.1:{port}\r\n{credential}\r\n"
        self.got, self.answer = b"", asyncio.get_running_loop().create_future()

    async def open(self) -> Client:
        self.transport, _ = await asyncio.get_running_loop().create_connection(lambda: self, "127.0.0.1", self.port)
        return self

    def request(self, method: str, path: str, body: dict[str, object] | None = None) -> bytes:
        data = json.dumps(body).encode() if body is not None else b""
        head = f"{method} {path} HTTP/1.1\r\n{self.head}"
        head += f"Content-Type: application/json\r\nContent-Length: {len(data)}\r\n\r\n"
        return head.encode() + data

    async def call(self, request: bytes) -> bytes:
        self.got, self.answer = b"", asyncio.get_running_loop().create_future()
        self.transport.write(request)
        return await self.answer

    def data_received(self, data: bytes) -> None:
        self.got += data
        end = self.got.find(b"\r\n\r\n")
        if end < 0 or self.answer.done():
            return
        at = self.got.lower().find(b"content-length: ", 0, end) + 16
        if len(self.got) - end - 4 >= int(self.got[at : self.got.index(b"\r", at)]):
            assert self.got[9:11] == b"20", self.got[:400]
            self.answer.set_result(self.got[end + 4 :])


class Listener(Client):
    """An open event stream that records when each event of a post arrived."""

    async def listen(self) -> Listener:
        self.heard, self.more = list[float](), asyncio.Event()
        self.begun = asyncio.get_running_loop().create_future()
        self.transport.write(self.request("GET", "/api/v1/events?heartbeat=30"))
        await self.begun
        return self

    def data_received(self, data: bytes) -> None:
        now = time.perf_counter()
        if not self.begun.done() and b"retry: " in data:
            self.begun.set_result(None)
        self.heard += [now] * (b"\n" + data).count(b"\nevent: post.")
        self.more.set()

    async def until(self, count: int) -> None:
        while len(self.heard) < count:
            self.more.clear()
            await self.more.wait()


@dataclass
class Server:
    """The board's process: its address, and the resources it has used."""

    port: int
    pid: int
    token: str
    session: str
    listening: list[str]  # tokens of other accounts: an account may have 50 streams
    topics: int

    def api(self) -> Client:
        return Client(self.port, f"Authorization: Bearer {self.token}")

    def browser(self) -> Client:
        return Client(self.port, f"Cookie: agentrob_{self.port}={self.session}")

    def cpu_s(self) -> float:
        fields = Path(f"/proc/{self.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def most_memory_mb(self) -> float:
        lines = Path(f"/proc/{self.pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmHWM")).split()[1]) / 1024


def at(values_s: list[float], share: float) -> float:
    """A percentile in milliseconds."""
    ordered = sorted(values_s)
    return ordered[min(len(ordered) - 1, int(len(ordered) * share))] * 1000


def row(name: str, figure: str, took_s: list[float], cpu_ms: float | None = None) -> None:
    shares = " | ".join(f"{at(took_s, share):.1f} ms" for share in (0.5, 0.95, 0.99))
    print(f"| {name} | {figure} | {shares} | {f'{cpu_ms:.2f} ms' if cpu_ms is not None else ''} |")


async def load(name: str, server: Server, clients: list[Client], requests: list[list[bytes]], seconds: float) -> None:
    """Each client repeats its requests, one after the other."""
    end, took = time.perf_counter() + seconds, list[float]()

    async def one(client: Client, mine: list[bytes]) -> None:
        n = 0
        while (start := time.perf_counter()) < end:
            await client.call(mine[n % len(mine)])
            took.append(time.perf_counter() - start)
            n += 1

    cpu_s, start = server.cpu_s(), time.perf_counter()
    await asyncio.gather(*map(one, clients, requests))
    rate = len(took) / (time.perf_counter() - start)
    row(name, f"{rate:.0f}/s", took, (server.cpu_s() - cpu_s) / len(took) * 1000)


async def writing(server: Server, seconds: float) -> float:
    """Write replies at a steady rate with several writers, half of them in hot topics; return the rate per second."""
    chance, numbers = random.Random(5), count()
    start = time.perf_counter()

    async def one() -> None:
        client = await server.api().open()
        while (due := (n := next(numbers)) / WRITES_PER_S) < seconds:
            await asyncio.sleep(max(0.0, start + due - time.perf_counter()))
            topic = chance.randint(max(1, server.topics - HOT) if n % 2 else 1, server.topics)
            await client.call(client.request("POST", f"/api/v1/topics/{topic}/posts", {"body": RAW}))

    await asyncio.gather(*(one() for _ in range(WRITERS)))
    return seconds * WRITES_PER_S / (time.perf_counter() - start)


async def events(server: Server, listeners: int, posts: int) -> None:
    """Measure the time from sending a reply until each listener, and the last one, has received it."""
    writer = await server.api().open()
    request = writer.request("POST", "/api/v1/topics/1/posts", {"body": RAW})
    listening: list[Listener] = []
    for n in range(listeners):
        stream = Listener(server.port, f"Authorization: Bearer {server.listening[n % len(server.listening)]}")
        await stream.open()
        listening.append(await stream.listen())
    each, last = list[float](), list[float]()
    for n in range(1, posts + 1):
        start = time.perf_counter()
        await writer.call(request)
        for stream in listening:
            await stream.until(n)
        each += [s.heard[n - 1] - start for s in listening]
        last.append(max(s.heard[n - 1] for s in listening) - start)
    row(f"reply sent → read by each of {listeners} listeners", "", each)
    row(f"reply sent → read by the last of {listeners}", "", last)
    for stream in listening:
        stream.transport.close()


async def measure(server: Server, seconds: float, listeners: int) -> None:
    sixteen = [await server.api().open() for _ in range(16)]
    browsers = [await server.browser().open() for _ in range(16)]
    eight = sixteen[:8]
    hot = [str(server.topics - n) for n in range(min(HOT, server.topics))]
    as_json = [[c.request("GET", f"/api/v1/topics/{t}/posts?limit={PER_TOPIC}") for t in hot] for c in sixteen]
    as_page = [[c.request("GET", f"/t/{t}") for t in hot] for c in browsers]
    replies = [[c.request("POST", f"/api/v1/topics/{n + 1}/posts", {"body": RAW})] for n, c in enumerate(eight)]
    size = len(await sixteen[0].call(as_json[0][0])), len(await browsers[0].call(as_page[0][0]))
    print(f"\n20 posts are {size[0] / 1000:.0f} kB of JSON, {size[1] / 1000:.0f} kB of page.\n")
    print("| what | rate | p50 | p95 | p99 | CPU |\n|---|---|---|---|---|---|")
    await load("topic as JSON, 16 connections", server, sixteen, as_json, seconds)
    await load("topic as page, 16 connections", server, browsers, as_page, seconds)
    for name, clients, requests in (("JSON", sixteen, as_json), ("page", browsers, as_page)):
        writes = asyncio.ensure_future(writing(server, seconds))
        await load(f"… as {name}, beside {WRITES_PER_S:.0f} replies/s", server, clients, requests, seconds)
        print(f"| … and the replies beside it | {await writes:.0f}/s | | | | |")
    await load("replies, 8 connections", server, eight, replies, seconds)
    await events(server, listeners, 50)
    print(f"\nThe server used at most {server.most_memory_mb():.0f} MB.")


# -------------------------------------------------------------------- the board
def seed(settings: BoardSettings, posts: int) -> int:
    """Fill an empty board; return the number of topics."""
    topics = max(1, posts // PER_TOPIC)
    values = {"topics": topics, "posts": topics * PER_TOPIC, "per": PER_TOPIC, "raw": RAW, "html": HTML}
    with sqlite3.connect(str(settings.database_path)) as connection:
        for statement in SEED:
            connection.execute(statement, values)
    connection.close()
    return topics


@contextmanager
def serving(folder: str, posts: int) -> Iterator[Server]:
    settings = BoardSettings.from_config(BoardConfig(), Path(folder))
    local_admin.bootstrap(settings)
    account = local_admin.create_account(settings, "bench", role=Role.OPERATOR)
    token = local_admin.issue_token(settings, account)
    with local_admin.writing(settings) as connection:
        session = accounts.new_session(connection, int(account.id))
    others = [local_admin.create_account(settings, f"listener-{n}") for n in range(4)]
    listening = [local_admin.issue_token(settings, other) for other in others]
    topics = seed(settings, posts)
    with subprocess.Popen([sys.executable, "-c", SERVE, folder], stdout=subprocess.PIPE, text=True) as board:
        try:
            assert board.stdout is not None
            yield Server(int(board.stdout.readline()), board.pid, token, session, listening, topics)
        finally:
            board.terminate()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--posts", type=int, default=1000, help="number of posts")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long each load lasts")
    parser.add_argument("--listeners", type=int, default=200)
    given = parser.parse_args()
    print(f"{given.posts:,} posts; load of the machine before: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as folder, serving(folder, given.posts) as server:
        asyncio.run(measure(server, given.seconds, given.listeners))


if __name__ == "__main__":
    main()
