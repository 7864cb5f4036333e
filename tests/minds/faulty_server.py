"""A small loopback server that responds or fails like a model provider; each path is named after its behaviour."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, cast

KEY = "sk-test-0123456789-secret"


class FaultyServer(ThreadingHTTPServer):
    """Records requests. `script` lists the responses (status, headers, body) in order; the last one is repeated."""

    daemon_threads = True
    block_on_close = False

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.requests: list[dict[str, Any]] = []
        self.headers: list[dict[str, str]] = []
        self.paths: list[str] = []
        self.answer: Callable[[_Handler, dict[str, Any]], None] = lambda handler, _: handler.send(200, b"{}")
        self.released = threading.Event()
        self.came = threading.Event()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_port}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore clients that hang up, because these tests provoke that."""


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"

    def do_POST(self) -> None:
        server = cast(FaultyServer, self.server)
        body = json.loads(self.rfile.read(int(self.headers["content-length"])))
        server.requests.append(body)
        server.headers.append({k.lower(): v for k, v in self.headers.items()})
        server.paths.append(self.path)
        server.came.set()
        server.answer(self, body)

    def send(self, status: int, body: bytes, **headers: str) -> None:
        self.send_response(status)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", str(len(body)))
        for name, value in headers.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        self.wfile.write(body)

    def break_off(self) -> None:
        """Send half of a response and then nothing more."""
        self.send_response(200)
        self.send_header("content-type", "application/json")
        self.send_header("content-length", "1000")
        self.end_headers()
        self.wfile.write(b'{"id": "x", "choices": [')
        self.wfile.flush()
        self.close_connection = True

    def hang(self) -> None:
        cast(FaultyServer, self.server).released.wait(60)
        self.close_connection = True

    def flood(self, size: int) -> None:
        """Send a valid response of this many bytes."""
        self.send(200, json.dumps(said("x" * size)).encode())

    def log_message(self, format: str, *args: Any) -> None:
        pass


@contextmanager
def faulty_server() -> Iterator[FaultyServer]:
    server = FaultyServer()
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.02}, daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.released.set()
        server.shutdown()
        server.server_close()
        thread.join(60)


# ---------------------------------------------------------------------- responses of the OpenAI API
def said(text: str, tokens: tuple[int, int] | None = (100, 20), finish: str = "stop") -> dict[str, Any]:
    return _completion({"role": "assistant", "content": text}, tokens, finish)


def called(name: str, arguments: Any, tokens: tuple[int, int] | None = (100, 20)) -> dict[str, Any]:
    raw = arguments if isinstance(arguments, str) else json.dumps(arguments)
    call = {"id": "call_1", "type": "function", "function": {"name": name, "arguments": raw}}
    return _completion({"role": "assistant", "content": None, "tool_calls": [call]}, tokens, "tool_calls")


def _completion(message: dict[str, Any], tokens: tuple[int, int] | None, finish: str) -> dict[str, Any]:
    usage = (
        {"prompt_tokens": tokens[0], "completion_tokens": tokens[1], "total_tokens": sum(tokens)} if tokens else None
    )
    choice = {"index": 0, "message": message, "finish_reason": finish}
    return {
        "id": "c1",
        "object": "chat.completion",
        "created": 1,
        "model": "served-model",
        "choices": [choice],
        **({"usage": usage} if usage else {}),
    }


def anthropic_called(name: str, arguments: Any) -> dict[str, Any]:
    return {
        "id": "m1",
        "type": "message",
        "role": "assistant",
        "model": "served-model",
        "content": [{"type": "tool_use", "id": "toolu_1", "name": name, "input": arguments}],
        "stop_reason": "tool_use",
        "stop_sequence": None,
        "usage": {"input_tokens": 100, "output_tokens": 20},
    }
