"""The driver's API for other machines: HTTPS on a TCP port, for clients with a certificate or a token.

It runs in a thread and an event loop of its own, beside the Unix socket's.
"""

from __future__ import annotations

import asyncio
import contextlib
import errno
import hashlib
import hmac
import logging
import socket
import ssl
import threading
from collections.abc import Iterator
from types import TracebackType
from typing import Self

from starlette.datastructures import Headers
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.h11_impl import H11Protocol

from agentrob.config.robots import RobotConfig
from agentrob.errors import HttpError, RobotBusy, RobotError
from agentrob.process.http_server import HttpServer, check_length
from agentrob.process.listen import host_in_url, open_listener, parse_listen
from agentrob.robots.driver.admission import STRANGER_S, Admission, Peer
from agentrob.robots.driver.credentials import load_certificates, token_of

log = logging.getLogger(__name__)

#: No request of the API is longer.
BODY_BYTES = 64 * 1024
HEADER_BYTES = 16 * 1024
#: An idle connection is closed after this time; a client uses each of its own more often.
IDLE_S = 60
HANDSHAKE_S = 4.0
#: A connection that acknowledges nothing for this long is closed by the kernel.
SILENT_MS = 15_000


def server_tls(settings: RobotConfig) -> ssl.SSLContext | None:
    """The TLS context of `driver_listen`; None for plain HTTP on this machine. Raises `ConfigError`."""
    if not settings.driver_cert:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    load_certificates(context, settings)
    if settings.driver_ca:
        context.verify_mode = ssl.CERT_REQUIRED
    return context


class Gate:
    """Lets a request through to the API if it carries the token, and is not too long. Without a token to compare,
    the certificate of the TLS handshake was enough."""

    def __init__(self, api: ASGIApp, token: str, admission: Admission) -> None:
        self._api, self._admission = api, admission
        self._digest = _digest(token) if token else b""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        peer: Peer = tuple(scope["client"] or ("", 0))[:2]
        headers = Headers(scope=scope)
        if self._digest and not self._known(headers.get("authorization", "")):
            if self._admission.wrong(peer):
                log.warning("wrong token from %s; at most one line a minute", peer[0])
            await _refused(401, "bad_token", "send the driver's token: Authorization: Bearer TOKEN")(
                scope, receive, send
            )
            return
        self._admission.trust(peer)
        try:
            check_length(headers, BODY_BYTES)
        except HttpError as e:
            await _refused(413, "too_large", f"{e}; {e.hint}")(scope, receive, send)
            return
        await self._api(scope, _limited(receive), send)

    def _known(self, authorization: str) -> bool:
        kind, _, token = authorization.partition(" ")
        return kind.lower() == "bearer" and hmac.compare_digest(_digest(token.strip()), self._digest)


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).digest()


def _refused(status: int, code: str, detail: str) -> JSONResponse:
    headers = {"Connection": "close"}
    return JSONResponse({"status": status, "code": code, "detail": detail}, status, headers)


def _limited(receive: Receive) -> Receive:
    """The same messages; a body without a stated length ends the connection when it is too long."""
    length = 0

    async def limited() -> Message:
        nonlocal length
        message = await receive()
        length += len(message.get("body", b""))
        if length > BODY_BYTES:
            raise RobotError(f"the body is too large; at most {BODY_BYTES} bytes")
        return message

    return limited


class _Protocol(H11Protocol):
    """HTTP, and an event that is set when the connection has ended."""

    ended: asyncio.Event

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self.ended.set()


class NetworkServer(HttpServer):
    """Serves the API on a TCP listener. It accepts connections itself, to refuse a flood before its TLS handshakes."""

    def __init__(self, api: ASGIApp, listener: socket.socket, tls: ssl.SSLContext | None, token: str) -> None:
        self.admission = Admission()
        super().__init__(
            Gate(api, token, self.admission), handle_signals=False, lifespan="off", ws="none", http=_Protocol,
            h11_max_incomplete_event_size=HEADER_BYTES, timeout_keep_alive=IDLE_S, timeout_graceful_shutdown=None,
        )  # fmt: skip
        self._listener, self._tls, self._token = listener, tls, token
        self._opening: set[asyncio.Task[None]] = set()

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        await super().startup([])
        self._listener.setblocking(False)
        asyncio.get_running_loop().add_reader(self._listener, self._accept)

    async def shutdown(self, sockets: list[socket.socket] | None = None) -> None:
        asyncio.get_running_loop().remove_reader(self._listener)
        await super().shutdown([self._listener])

    def _accept(self) -> None:
        """Accept one connection; the event loop calls again for the next, after whatever else is ready."""
        try:
            connection, address = self._listener.accept()
        except OSError:
            return
        peer: Peer = address[:2]
        if not self.admission.admit(peer):
            connection.close()
            return
        connection.setblocking(False)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 5)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 5)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, SILENT_MS)
        opening = asyncio.get_running_loop().create_task(self._open(connection, peer))
        self._opening.add(opening)
        opening.add_done_callback(self._opening.discard)

    async def _open(self, connection: socket.socket, peer: Peer) -> None:
        """Do the TLS handshake and hand the connection to the HTTP protocol; close it if it stays a stranger."""
        protocol = _Protocol(self.config, self.server_state, {})
        protocol.ended = asyncio.Event()
        limit_s = None if self._tls is None else HANDSHAKE_S
        try:
            try:
                await asyncio.get_running_loop().connect_accepted_socket(
                    lambda: protocol, connection, ssl=self._tls, ssl_handshake_timeout=limit_s
                )
            except (OSError, ssl.SSLError) as e:
                log.debug("no TLS connection with %s (%s)", peer[0], e)
                connection.close()
                return
            if not self._token:
                self.admission.trust(peer)  # its certificate was verified
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(STRANGER_S):
                    await protocol.ended.wait()
            if not protocol.ended.is_set() and not self.admission.trusted(peer):
                protocol.transport.abort()
            await protocol.ended.wait()
        finally:
            self.admission.closed(peer)


class NetworkListener:
    """The TCP port of `driver_listen`; serves the API there in a thread while the context of `serve` is open.

    Raises `ConfigError` and `RobotError` before it serves anything.
    """

    def __init__(self, settings: RobotConfig) -> None:
        self._tls, self._token = server_tls(settings), token_of(settings)
        host, port = parse_listen(settings.driver_listen)
        try:
            self._listener = open_listener(host, port)
        except OSError as e:
            kind = RobotBusy if e.errno == errno.EADDRINUSE else RobotError
            raise kind(f"cannot listen on {settings.driver_listen}: {e.strerror or e}") from None
        self.address = f"{host_in_url(host)}:{self._listener.getsockname()[1]}"

    @contextlib.contextmanager
    def serve(self, api: ASGIApp) -> Iterator[None]:
        server = NetworkServer(api, self._listener, self._tls, self._token)
        thread = threading.Thread(target=server.run, name="network", daemon=True)
        thread.start()
        try:
            yield
        finally:
            server.should_exit = True
            thread.join(0.3)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._listener.close()
