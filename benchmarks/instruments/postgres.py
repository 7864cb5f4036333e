"""A PostgreSQL server of a benchmark, which may be killed."""

from __future__ import annotations

import contextlib
import os
import pwd
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

#: How long a killed server may take until it answers again.
AGAIN_S = 30.0
#: Data that a killed process wrote is not lost; only a machine that dies could lose it.
_FLAGS = "-c fsync=off -c listen_addresses='' -c max_connections=200"


class PostgresServer:
    """A server in a folder of its own, on a Unix socket, as a user other than root."""

    def __init__(self, folder: Path) -> None:
        self.data = folder / "pg"
        self.data.mkdir(parents=True)
        self._user = "nobody" if os.getuid() == 0 else None  # PostgreSQL refuses to run as root
        if self._user:
            for path in (folder, self.data):
                os.chown(path, pwd.getpwnam(self._user).pw_uid, -1)
        self.url = f"postgresql+psycopg://tester@/postgres?host={self.data}"
        self._run("initdb", "-A", "trust", "-U", "tester", "-E", "UTF8", "--no-sync")
        self.start()

    def start(self) -> None:
        flags = f"{_FLAGS} -c unix_socket_directories={self.data}"
        self._run("pg_ctl", "-w", "-t", "30", "-l", str(self.data / "log"), "-o", flags, "start")

    def stop(self) -> None:
        self._run("pg_ctl", "-w", "-m", "immediate", "stop")

    @property
    def leader(self) -> int | None:
        """The id of its first process, while it runs."""
        with contextlib.suppress(OSError, ValueError, IndexError):
            return int((self.data / "postmaster.pid").read_text().split()[0])
        return None

    def kill(self) -> None:
        """End all its processes by SIGKILL, and start it again."""
        leader = self.leader
        assert leader is not None
        children = Path(f"/proc/{leader}/task/{leader}/children").read_text().split()
        for pid in [leader, *map(int, children)]:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        until_s = time.monotonic() + AGAIN_S
        while True:
            try:
                return self.start()
            except subprocess.SubprocessError:  # its shared memory is not released yet
                if time.monotonic() > until_s:
                    raise
                time.sleep(0.2)

    def _run(self, program: str, *arguments: str) -> None:
        command = [_path_of(program), "-D", str(self.data), *arguments]
        subprocess.run(command, user=self._user, cwd="/", check=True, timeout=100, stdout=subprocess.DEVNULL)


def _path_of(program: str) -> str:
    """The path of a PostgreSQL program, including Debian's location."""
    found = shutil.which(program) or next(map(str, Path("/usr/lib/postgresql").glob(f"*/bin/{program}")), None)
    if found is None:
        raise SystemExit(f"PostgreSQL's {program} is not installed: run scripts/system-packages postgres")
    return found


@contextlib.contextmanager
def postgres(folder: Path) -> Iterator[PostgresServer]:
    """Run a server in this folder until the block ends."""
    for parent in [folder, *folder.parents]:  # its user must be able to enter
        if parent in (Path("/tmp"), parent.parent):
            break
        parent.chmod(parent.stat().st_mode | 0o011)
    server = PostgresServer(folder / "postgres")
    try:
        yield server
    finally:
        server.stop()
