"""The HTTP server reports when it is ready, ends its streams first, and returns after a signal."""

from __future__ import annotations

import asyncio
import os
import signal
from typing import Any

import pytest

from agentrob.process.http_server import HttpServer
from agentrob.process.listen import open_listener


async def app(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "http.response.start", "status": 204, "headers": []})
    await send({"type": "http.response.body", "body": b""})


async def answered(port: int) -> bytes:
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    writer.write(b"GET / HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
    try:
        return await reader.readline()
    finally:
        writer.close()


@pytest.mark.parametrize("sign", [signal.SIGTERM, signal.SIGINT])
async def test_a_signal_shuts_the_server_down_and_the_process_continues(sign: signal.Signals) -> None:
    told: list[str] = []
    ready = asyncio.Event()

    async def end_streams() -> None:
        told.append("streams ended")

    before = signal.getsignal(sign)
    with open_listener("127.0.0.1", 0) as listener:
        server = HttpServer(app, on_ready=ready.set, on_shutdown=end_streams, lifespan="off")
        serving = asyncio.create_task(server.serve(sockets=[listener]))
        async with asyncio.timeout(20):
            await ready.wait()
            assert b"204" in await answered(listener.getsockname()[1])
            os.kill(os.getpid(), sign)
            await serving
    assert told == ["streams ended"]
    assert signal.getsignal(sign) is before


async def test_the_caller_may_handle_signals_and_end_the_server_itself() -> None:
    ready, before = asyncio.Event(), signal.getsignal(signal.SIGTERM)
    with open_listener("127.0.0.1", 0) as listener:
        server = HttpServer(app, on_ready=ready.set, handle_signals=False, lifespan="off")
        serving = asyncio.create_task(server.serve(sockets=[listener]))
        async with asyncio.timeout(20):
            await ready.wait()
            assert signal.getsignal(signal.SIGTERM) is before
            server.should_exit = True
            await serving


def test_a_second_signal_closes_connections_at_once() -> None:
    server = HttpServer(app)
    server.handle_exit(signal.SIGTERM, None)
    assert (server.should_exit, server.force_exit) == (True, False)
    server.handle_exit(signal.SIGTERM, None)
    assert server.force_exit
