"""A model server on loopback, in its own process, that answers immediately and records its own time."""

from __future__ import annotations

import statistics
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

#: `called(body)`, from the source prepended to it, returns the answer to a question: a tool name and its arguments.
_SERVER = """
import json, time
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
spent = []
class Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True
    def do_POST(self):
        raw = self.rfile.read(int(self.headers["content-length"]))
        began = time.perf_counter()
        name, arguments = called(json.loads(raw))
        call = {"id": "c", "type": "function", "function": {"name": name, "arguments": json.dumps(arguments)}}
        message = {"role": "assistant", "content": None, "tool_calls": [call]}
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


@contextmanager
def loopback_model(called: str) -> Iterator[int]:
    """Run a model until the block ends and yield its port; `called` is the Python source of `called(body)`."""
    server = subprocess.Popen([sys.executable, "-c", called + _SERVER], stdout=subprocess.PIPE, text=True)
    try:
        assert server.stdout is not None
        yield int(server.stdout.readline())
    finally:
        server.kill()
        server.wait()


def served_s(port: int) -> list[float]:
    """The seconds that the model itself took for each answer."""
    import httpx2

    times: list[float] = httpx2.get(f"http://127.0.0.1:{port}/", trust_env=False).json()
    return times


HEAD = "| what | times | p50 | p95 | worst |\n|---|---|---|---|---|"


def row(name: str, seconds: Sequence[float]) -> str:
    """One line of the table below `HEAD`."""
    ordered = sorted(seconds)
    p95 = ordered[int(0.95 * (len(ordered) - 1))]
    median = statistics.median(ordered)
    return f"| {name} | {len(ordered)} | {median * 1e3:.1f} ms | {p95 * 1e3:.1f} ms | {ordered[-1] * 1e3:.1f} ms |"
