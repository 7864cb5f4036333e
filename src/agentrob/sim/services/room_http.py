"""The room's HTTP server on loopback: overview camera, film, scene, geometry, reset, faults, ground truth, health.

It represents the room, not a robot: programs that drive a robot must not read `/truth`.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from agentrob.errors import SimError

LOOPBACK = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True, slots=True)
class Room:
    """The callbacks of the server; each is called from one of its threads."""

    overview: Callable[[], bytes | None]
    scene: Callable[[], Mapping[str, Any]]
    reset: Callable[[], bool]
    truth: Callable[[], Mapping[str, Any]]
    health: Callable[[], Mapping[str, Any]]
    faults: Callable[[Any], bool]  # raises SimError for what cannot be
    geometry: Callable[[str], bytes | None] = lambda robot: None  # gzipped; None for a robot that is not here
    film: Callable[[str, float], bytes | None] = lambda robot, ago_s: None  # the robot's JPEG of so many seconds ago


class RoomServer:
    """Serves `url` in the background until closed."""

    def __init__(self, room: Room, port: int) -> None:
        handler = type("Handler", (_Handler,), {"room": room})
        try:
            self._server = ThreadingHTTPServer(("127.0.0.1", port), handler)
        except OSError as e:
            raise SimError(f"the room's HTTP port {port} on 127.0.0.1 cannot be used: {e.strerror}") from None
        self._server.daemon_threads = True
        self.url = f"http://127.0.0.1:{self._server.server_address[1]}"
        self._thread = threading.Thread(
            target=self._server.serve_forever, kwargs={"poll_interval": 0.1}, name="room", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    room: Room
    protocol_version = "HTTP/1.1"
    timeout = 30
    disable_nagle_algorithm = True  # head and body are two writes: else each answer waits 40 ms for the other side

    def do_GET(self) -> None:
        path = urlsplit(self.path).path
        if not self._local():
            return
        if path == "/overview.jpg":
            jpeg = self.room.overview()
            if jpeg:
                self._send(200, "image/jpeg", jpeg)
            else:
                self._json(503, {"error": "no picture now; see /health"})
        elif path == "/scene":
            self._json(200, self.room.scene())
        elif path == "/truth":
            self._json(200, self.room.truth())
        elif path.startswith("/geometry/"):
            shape = self.room.geometry(path.removeprefix("/geometry/"))
            if shape:
                self._send(200, "application/gzip", shape)
            else:
                self._json(404, {"error": "no such robot in this world"})
        elif path.startswith("/film/"):
            self._film(path.removeprefix("/film/").removesuffix(".jpg"))
        elif path == "/health":
            self._json(200, self.room.health())
        else:
            seen = "/overview.jpg, /film/ROBOT.jpg?ago_s=SECONDS, /scene, /geometry/ROBOT, /truth, /health"
            valid = f"GET {seen}; POST /reset, /faults"
            self._json(404, {"error": f"valid here: {valid}"})

    def do_POST(self) -> None:
        body = self.rfile.read(min(int(self.headers.get("Content-Length") or 0), 65536))
        if not self._local():
            return
        path = urlsplit(self.path).path
        if path == "/reset":
            self._done("reset", self.room.reset())
        elif path == "/faults":
            try:
                self._done("faults", self.room.faults(json.loads(body or b"{}")))
            except (ValueError, SimError) as e:
                self._json(422, {"error": str(e)})
        else:
            self._json(404, {"error": "valid here: POST /reset, /faults"})

    def _film(self, robot: str) -> None:
        asked = parse_qs(urlsplit(self.path).query).get("ago_s", ["0"])[-1]
        try:
            jpeg = self.room.film(robot, float(asked))
        except ValueError:
            jpeg = None
        if jpeg:
            self._send(200, "image/jpeg", jpeg)
        else:
            wanted = "a robot of this world, and ago_s from 0 to 120 seconds"
            self._json(404, {"error": f"no picture of {robot!r} from {asked!r} seconds ago; valid: {wanted}"})

    def _done(self, what: str, done: bool) -> None:
        if done:
            self._json(200, {what: True})
        else:
            self._json(503, {"error": "the world did not answer"})

    def _local(self) -> bool:
        """Refuse requests that a web page could send: another site's origin, or a DNS name that points here."""
        host = urlsplit("//" + (self.headers.get("Host") or "")).hostname
        if host in LOOPBACK and "Origin" not in self.headers:
            return True
        self._json(403, {"error": "only for programs on this machine"})
        return False

    def _json(self, status: int, body: Mapping[str, Any]) -> None:
        self._send(status, "application/json", json.dumps(body).encode())

    def _send(self, status: int, kind: str, body: bytes) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing: the terminal belongs to the demo."""
