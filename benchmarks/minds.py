"""What minds take of our own: per post that is read, per turn with a picture, and how soon the CLI is there.

    python benchmarks/minds.py [--turns 200]

The model is a server on loopback, in a process of its own, that answers at once; its own time is in a row of its own
(it is in the others too, and small). HTTP, libraries, budgets on disk, prompts, checks and the encoding of pictures are
ours and counted.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

from pydantic import BaseModel

from agentrob.config import MindConfig
from agentrob.minds.chain import ChatChain
from agentrob.minds.chat import Image, Said, Tool
from agentrob.minds.configured import ConfiguredModel
from agentrob.minds.mind import Listener
from agentrob.minds.model_mind import ModelMind
from agentrob.model import Capabilities, Intent, Op

SERVER = """
import json, time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
STEP = {"action": "move", "direction": "forward", "amount": 2, "unit": "m", "words": "meander forward 2 m"}
WANTS = {"intent": "command", "steps": [STEP]}
spent = []
class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    def do_POST(self):
        raw = self.rfile.read(int(self.headers["content-length"]))
        began = time.perf_counter()
        tool = json.loads(raw)["tools"][0]["function"]["name"]
        call = {"name": tool, "arguments": json.dumps(WANTS if tool == "answer" else {"distance_m": 1})}
        calls = [{"id": "c", "type": "function", "function": call}]
        message = {"role": "assistant", "content": None, "tool_calls": calls}
        self.reply({"id": "x", "object": "chat.completion", "created": 1, "model": "m",
            "choices": [{"index": 0, "finish_reason": "tool_calls", "message": message}],
            "usage": {"prompt_tokens": 100, "completion_tokens": 20, "total_tokens": 120}}, began)
    def do_GET(self):
        self.reply(spent, None)
    def reply(self, data, began):
        body = json.dumps(data).encode()
        if began is not None:
            spent.append(time.perf_counter() - began)
        head = f"HTTP/1.1 200 OK\\r\\ncontent-type: application/json\\r\\ncontent-length: {len(body)}\\r\\n\\r\\n"
        self.wfile.write(head.encode() + body)
    def log_message(self, *args):
        pass
server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
print(server.server_port, flush=True)
server.serve_forever()
"""


class Walk(BaseModel):
    distance_m: float


def _row(name: str, seconds: list[float]) -> str:
    ordered = sorted(seconds)
    p95 = ordered[int(0.95 * (len(ordered) - 1))]
    median = statistics.median(ordered)
    return f"| {name} | {len(ordered)} | {median * 1e3:.1f} ms | {p95 * 1e3:.1f} ms | {ordered[-1] * 1e3:.1f} ms |"


async def _measure(port: int, turns: int, folder: Path) -> list[str]:
    config = MindConfig(provider="compatible", model="m", base_url=f"http://127.0.0.1:{port}/v1")
    config = config.model_copy(update={"limits": config.limits.model_copy(update={"day_tokens": 0})})
    model = ConfiguredModel("bench", config, folder / "minds.sqlite")
    mind = ModelMind(ChatChain([model]))
    listener = Listener(("quadruped",), (), Capabilities("go2", frozenset(Op)))
    picture = Image(os.urandom(100_000))

    async def reading() -> None:
        found = await mind.understand("@quadruped be a dear and meander forward 2 m", listener)
        assert found.intent is Intent.COMMAND

    async def turn() -> None:
        answer = await model.turn("You drive.", [Said("Walk.", (picture,))], [Tool("act_move", "Walks.", Walk)])
        assert answer.value.calls[0].arguments == Walk(distance_m=1)

    rows = []
    for name, deed in (("a post read", reading), ("a turn with a picture of 100 kB", turn)):
        await deed()
        rows.append(_row(name, await _times(deed, turns)))
    rows.append(_row("of this the server itself", _server_times(port)))
    await model.close()
    return rows


async def _times(deed: Callable[[], Awaitable[None]], turns: int) -> list[float]:
    found = []
    for _ in range(turns):
        began = time.perf_counter()
        await deed()
        found.append(time.perf_counter() - began)
    return found


def _server_times(port: int) -> list[float]:
    import httpx2

    times: list[float] = httpx2.get(f"http://127.0.0.1:{port}/", trust_env=False).json()
    return times


def _help_times(runs: int) -> list[float]:
    program = str(Path(sys.executable).with_name("agentrob"))
    found = []
    for _ in range(runs):
        began = time.perf_counter()
        subprocess.run([program, "--help"], check=True, stdout=subprocess.DEVNULL)
        found.append(time.perf_counter() - began)
    return found


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--turns", type=int, default=200)
    turns = parser.parse_args().turns
    server = subprocess.Popen([sys.executable, "-c", SERVER], stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        port = int(server.stdout.readline())
        with tempfile.TemporaryDirectory() as folder:
            rows = asyncio.run(_measure(port, turns, Path(folder)))
    finally:
        server.kill()
        server.wait()
    print("| what | times | p50 | p95 | worst |\n|---|---|---|---|---|")
    print("\n".join([*rows, _row("agentrob --help", _help_times(20))]))


if __name__ == "__main__":
    main()
