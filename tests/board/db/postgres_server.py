"""A separate PostgreSQL server for tests: a fresh cluster in a folder, on a Unix socket, as a user other than root."""

from __future__ import annotations

import os
import pwd
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

FLAGS = "-c fsync=off -c listen_addresses='' -c max_connections=200"


def tool(name: str) -> str:
    """Return the path of a PostgreSQL program, including Debian's location."""
    found = shutil.which(name) or next(map(str, sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))), None)
    assert found, f"PostgreSQL's {name} is not installed: run scripts/system-packages postgres"
    return found


@contextmanager
def postgres_server(folder: Path, address: str = "") -> Iterator[str]:
    """Yield the SQLAlchemy URL of a running server, which ends with the block; its files are deleted.

    With an IP `address` it listens there too, for everybody.
    """
    data, user = folder / "pg", None
    folder.mkdir(exist_ok=True)
    data.mkdir()
    if os.getuid() == 0:  # PostgreSQL refuses to run as root
        user = "nobody"
        for path in (folder, data):
            os.chown(path, pwd.getpwnam(user).pw_uid, -1)
    run(user, [tool("initdb"), "-D", str(data), "-A", "trust", "-U", "tester", "-E", "UTF8", "--no-sync"])
    if address:
        with (data / "pg_hba.conf").open("a") as rules:
            rules.write("host all all 0.0.0.0/0 trust\n")
    control = [tool("pg_ctl"), "-D", str(data), "-w", "-t", "30"]
    flags = f"{FLAGS} -c unix_socket_directories={data} -c listen_addresses='{address}'"
    run(user, [*control, "-l", str(data / "log"), "-o", flags, "start"])
    try:
        yield f"postgresql+psycopg://tester@/postgres?host={data}"
    finally:
        run(user, [*control, "-m", "immediate", "stop"])


def run(user: str | None, command: list[str]) -> None:
    """Run a command as that user; on failure, show all of its output."""
    done = subprocess.run(
        command,
        user=user,
        cwd="/",
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stdout


def open_to_all(folder: Path) -> None:
    """Let another user traverse the parent folders, which pytest keeps private."""
    for parent in [folder, *folder.parents]:
        if parent == Path("/tmp") or parent == parent.parent:
            return
        parent.chmod(parent.stat().st_mode | 0o011)
