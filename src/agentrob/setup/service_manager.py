"""Install and start the processes with systemd or Docker Compose."""

from __future__ import annotations

import getpass
import os
import shlex
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from agentrob.config import load as configuration
from agentrob.errors import AgentRobError
from agentrob.setup.answers import Services
from agentrob.setup.units import Place, Process, compose_file, systemd_unit

IMAGE = "agentrob"
#: Seconds that a service manager gets to start everything.
START_S = 120.0


class SetupError(AgentRobError):
    """A step of `agentrob init` failed; the steps before it are done."""


@dataclass(slots=True)
class Done:
    """The result of a step, and the commands that undo it."""

    did: list[str] = field(default_factory=list)
    undo: list[str] = field(default_factory=list)


def place_of(services: Services, config: Path, data: Path, tokens: Path) -> Place:
    """Where the processes run with this service manager."""
    program, environment = (sys.executable, "-m", "agentrob"), {"AGENTROB_DATA": str(data)}
    if services is Services.SYSTEM:
        user = os.environ.get("SUDO_USER") or getpass.getuser()
        return Place(program, config, data, tokens, user, {**environment, "AGENTROB_RUNTIME": "/run"})
    if services is Services.COMPOSE:
        runtime = str(configuration.runtime_dir().parent)
        user = f"{os.getuid()}:{os.getgid()}"
        return Place((), config, data, tokens, user, {**environment, "AGENTROB_RUNTIME": runtime})
    given = {key: os.environ[key] for key in ("AGENTROB_RUNTIME",) if key in os.environ}
    return Place(program, config, data, tokens, "", {**environment, **given})


def install(services: Services, found: Sequence[Process], place: Place) -> Done:
    """Write the units or the Compose file, and start everything. Raises `SetupError`."""
    if services is Services.NONE:
        return _by_hand(found, place)
    if services is Services.COMPOSE:
        return _compose(found, place)
    user = services is Services.USER
    folder = _user_units() if user else Path("/etc/systemd/system")
    systemctl = ["systemctl", "--user"] if user else ["systemctl"]
    files = [folder / f"{process.name}.service" for process in found]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for process, file in zip(found, files, strict=True):
            file.write_text(systemd_unit(process, place), encoding="utf-8")
    except OSError as e:
        raise SetupError(f"cannot write the units into {folder}: {e.strerror}; as root, or with --services user") from e
    names = [file.name for file in files]
    _run([*systemctl, "daemon-reload"])
    _run([*systemctl, "enable", "--now", *names])
    done = Done([f"wrote {len(files)} units into {folder} and started them: {', '.join(names)}"])
    done.undo = [shlex.join([*systemctl, "disable", "--now", *names]), shlex.join(["rm", *map(str, files)])]
    if user:
        done.did.append("to run them also while you are not logged in: loginctl enable-linger")
    else:
        done.did.append(
            f"so that commands find the driver: export AGENTROB_RUNTIME={place.environment['AGENTROB_RUNTIME']}"
        )
        os.environ["AGENTROB_RUNTIME"] = place.environment["AGENTROB_RUNTIME"]
    logs = ["journalctl", *(["--user"] if user else []), "-u", "agentrob-*"]
    done.did.append(f"logs: {shlex.join(logs)}")
    return done


def _by_hand(found: Sequence[Process], place: Place) -> Done:
    """Only tell how to start each process."""
    lines = []
    for process in found:
        token = f"set -a; . {shlex.quote(str(place.tokens))}; " if process.secrets else ""
        lines.append(f"then: {token}agentrob {shlex.join(process.words)}")
    return Done(lines)


def _compose(found: Sequence[Process], place: Place) -> Done:
    file = place.config.with_name("compose.yaml")
    if file.exists():
        raise SetupError(f"{file} already exists; move it away, or run agentrob init in another folder")
    file.write_text(compose_file(found, place, IMAGE), encoding="utf-8")
    compose = ["docker", "compose", "--file", str(file)]
    try:
        _run(["docker", "image", "inspect", IMAGE])
    except SetupError as e:
        build = f"docker build -f deploy/Dockerfile -t {IMAGE} ."
        then = f"in a checkout: {build}; then: {shlex.join(compose)} up --detach"
        raise SetupError(f"wrote {file}, but there is no image {IMAGE!r} ({e}); {then}") from None
    _run([*compose, "up", "--detach"])
    return Done(
        [f"wrote {file} and started {len(found)} containers", f"logs: {shlex.join(compose)} logs"],
        [f"{shlex.join(compose)} down", shlex.join(["rm", str(file)])],
    )


def _user_units() -> Path:
    home = os.environ.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    return Path(home) / "systemd/user"


def _run(command: Sequence[str]) -> None:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=START_S, check=False)
    except (OSError, subprocess.TimeoutExpired) as e:
        raise SetupError(f"{shlex.join(command)}: {e}") from e
    if done.returncode:
        lines = (done.stderr or done.stdout).strip().splitlines()
        raise SetupError(f"{shlex.join(command)} failed: {lines[-1] if lines else f'exit code {done.returncode}'}")
