"""A TCP proxy that behaves as a bad link: everything takes its time, lost packets come later, and a cut loses all."""

from __future__ import annotations

import asyncio
import contextlib
import random
from collections.abc import AsyncIterator


class SlowLink:
    """Forwards TCP connections with `delay_s` each way. A share `loss` of the packets is lost; as TCP sends a lost one
    again, it arrives late, and what follows it on its connection waits for it. After `cut()` nothing arrives at all."""

    def __init__(self, target: str, delay_s: float, loss: float, seed: int = 0) -> None:
        self._host, _, port = target.rpartition(":")
        self._target_port, self._delay_s, self._loss = int(port), delay_s, loss
        self._random = random.Random(seed)
        self._tasks: set[asyncio.Task[None]] = set()
        self._cut = False
        self.lost = 0
        self.port = 0
        #: Connections that are open on both sides.
        self.connections = 0

    def cut(self) -> None:
        self._cut = True

    def _extra_s(self) -> float:
        """How much later a packet arrives because it, and perhaps its repetition, was lost."""
        extra_s, again_s = 0.0, 0.2 + 2 * self._delay_s
        while self._random.random() < self._loss:
            self.lost += 1
            extra_s, again_s = extra_s + again_s, 2 * again_s
        return extra_s

    async def _accepted(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        loop = asyncio.get_running_loop()
        await asyncio.sleep(2 * self._delay_s)  # for SYN and its answer
        if self._cut:
            return
        try:
            there = await asyncio.open_connection(self._host, self._target_port)
        except OSError:
            writer.close()
            return
        self.connections += 1
        for source, sink in ((reader, there[1]), (there[0], writer)):
            queue: asyncio.Queue[tuple[float, bytes]] = asyncio.Queue()
            for work in (self._read(source, queue, loop), self._write(sink, queue, loop)):
                task = loop.create_task(work)
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)

    async def _read(
        self, source: asyncio.StreamReader, queue: asyncio.Queue[tuple[float, bytes]], loop: asyncio.AbstractEventLoop
    ) -> None:
        data, due_s = b"begin", 0.0
        while data:
            try:
                data = await source.read(1400)
            except OSError:
                data = b""
            due_s = max(due_s, loop.time() + self._delay_s + self._extra_s())
            queue.put_nowait((due_s, data))

    async def _write(
        self, sink: asyncio.StreamWriter, queue: asyncio.Queue[tuple[float, bytes]], loop: asyncio.AbstractEventLoop
    ) -> None:
        data = b"begin"
        while data:
            due_s, data = await queue.get()
            await asyncio.sleep(due_s - loop.time())
            if self._cut:
                return
            if data:
                sink.write(data)
        sink.close()

    @contextlib.asynccontextmanager
    async def open(self) -> AsyncIterator[SlowLink]:
        server = await asyncio.start_server(self._accepted, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        try:
            yield self
        finally:
            server.close()
            for task in self._tasks:
                task.cancel()
