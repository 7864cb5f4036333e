"""Runs the simulated `reachy-mini-daemon` where it reaches no network, and passes HTTP on to it.

    python -m agentrob_reachy_mini.isolated FD -- reachy-mini-daemon --mockup-sim …

The daemon announces its robot by mDNS on every network of its machine, sends usage figures and downloads moves. In a
network namespace with a loopback device of its own it can do none of that. FD is a socket that listens outside.
"""

from __future__ import annotations

import asyncio
import contextlib
import ctypes
import fcntl
import signal
import socket
import struct
import sys

_SIOCGIFFLAGS, _SIOCSIFFLAGS, _IFF_UP = 0x8913, 0x8914, 1
_PR_SET_PDEATHSIG = 1
_PIECE = 65536
END_S = 6.0


def raise_loopback() -> None:
    """Switch the loopback device on, which is off in a new namespace. Raises `OSError`."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        reply = fcntl.ioctl(any_socket, _SIOCGIFFLAGS, struct.pack("16sh14x", b"lo", 0))
        (flags,) = struct.unpack_from("h", reply, 16)
        if not flags & _IFF_UP:
            fcntl.ioctl(any_socket, _SIOCSIFFLAGS, struct.pack("16sh14x", b"lo", flags | _IFF_UP))


def end_with_parent() -> None:
    """Have the kernel send SIGTERM to this process when its parent dies."""
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


async def serve(listening: socket.socket, command: list[str]) -> int:
    """Run the daemon until it ends or SIGTERM comes; returns its exit code."""
    port = free_port()
    daemon = await asyncio.create_subprocess_exec(
        *command, "--fastapi-host", "127.0.0.1", "--fastapi-port", str(port), stdin=asyncio.subprocess.DEVNULL,
        preexec_fn=end_with_parent,
    )  # fmt: skip

    async def relay(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            inner_reader, inner_writer = await asyncio.open_connection("127.0.0.1", port)
        except OSError:  # it has not started yet
            writer.close()
            return
        await asyncio.gather(_copy(reader, inner_writer), _copy(inner_reader, writer))

    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, lambda: _terminate(daemon))
    server = await asyncio.start_server(relay, sock=listening)
    code = await daemon.wait()
    server.close()
    return code


def _terminate(daemon: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        daemon.terminate()
    asyncio.get_running_loop().call_later(END_S, _kill, daemon)


def _kill(daemon: asyncio.subprocess.Process) -> None:
    with contextlib.suppress(ProcessLookupError):
        daemon.kill()


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(ConnectionError):
        while piece := await reader.read(_PIECE):
            writer.write(piece)
            await writer.drain()
    writer.close()


def main() -> None:
    end_with_parent()
    descriptor, command = int(sys.argv[1]), sys.argv[sys.argv.index("--") + 1 :]
    raise_loopback()
    sys.exit(asyncio.run(serve(socket.socket(fileno=descriptor), command)))


if __name__ == "__main__":
    main()
