"""The processes of a forum and a robot, as systemd units and as a Compose file. Pure."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Process:
    """One process: `agentrob WORDS`. `secrets`: it reads the robots' tokens; `after` names processes it needs."""

    name: str
    what: str
    words: tuple[str, ...]
    after: tuple[str, ...] = ()
    secrets: bool = False


@dataclass(frozen=True, slots=True)
class Place:
    """Where the processes run: the program, its configuration and data, and the file with the robots' tokens.

    `user` (a name for systemd, UID:GID for Compose) is empty where the service manager is the user's own.
    """

    program: tuple[str, ...]
    config: Path
    data: Path
    tokens: Path
    user: str = ""
    environment: Mapping[str, str] = field(default_factory=dict)


def processes(config: Path, robot: str, world: tuple[str, ...]) -> tuple[Process, ...]:
    """The processes of the forum and, unless `robot` is empty, of its world, driver and agent; `world` are the words
    that simulate it, empty for a real robot."""
    at = ("--config", str(config))
    found = [Process("agentrob-board", "AgentRob: the forum", ("board", "serve", *at))]
    if robot:
        driver, agent = f"agentrob-driver-{robot}", f"agentrob-agent-{robot}"
        before = []
        if world:
            before = [f"agentrob-world-{robot}"]
            found.append(Process(before[0], f"AgentRob: the simulated world of {robot}", world))
        found.append(Process(driver, f"AgentRob: the driver of {robot}", ("driver", robot, *at), tuple(before)))
        words = ("agent", "run", robot, *at)
        found.append(Process(agent, f"AgentRob: the agent of {robot}", words, ("agentrob-board", driver), True))
    return tuple(found)


# ---------------------------------------------------------------------- systemd
def systemd_unit(process: Process, place: Place) -> str:
    """Return the text of a unit."""
    after = " ".join(f"{name}.service" for name in process.after) or "network-online.target"
    lines = ["[Unit]", f"Description={process.what}", f"After={after}"]
    if process.after:
        lines.append(f"Wants={after}")
    lines += ["StartLimitIntervalSec=0", "", "[Service]"]
    lines.append("ExecStart=" + " ".join(_word(word) for word in (*place.program, *process.words)))
    lines.append(f"WorkingDirectory={_escaped(str(place.config.parent))}")
    lines += [f"Environment={_word(f'{key}={value}')}" for key, value in place.environment.items()]
    if process.secrets:
        lines.append(f"EnvironmentFile={_escaped(str(place.tokens))}")
    # `agentrob agent drain` ends with 0, and is not started again
    lines += ["Restart=on-failure", "RestartSec=2", "UMask=0077", "NoNewPrivileges=yes"]
    if place.user:
        lines += [f"User={place.user}", "RuntimeDirectory=agentrob", "RuntimeDirectoryPreserve=yes"]
        lines += ["ProtectSystem=full"]
    target = "multi-user.target" if place.user else "default.target"
    return "\n".join([*lines, "", "[Install]", f"WantedBy={target}", ""])


def _escaped(text: str) -> str:
    return text.replace("%", "%%")


def _word(text: str) -> str:
    """One word of a command line or an assignment of systemd."""
    escaped = _escaped(text).replace("\\", "\\\\").replace('"', '\\"').replace("$", "$$")
    return f'"{escaped}"' if set(escaped) & set(" \t'\"\\;") else escaped


# ---------------------------------------------------------------------- Compose
def compose_file(found: Iterable[Process], place: Place, image: str) -> str:
    """Return a Compose file. All containers use the host's network: DDS, and the host locks through which a robot is
    stopped, belong to a network namespace."""
    folders = {str(place.config.parent), str(place.data), place.environment["AGENTROB_RUNTIME"]}
    lines = ["# Written by agentrob init.", "name: agentrob", "services:"]
    for process in found:
        settings = {
            "image": image,
            "command": ["agentrob", *process.words],
            "user": place.user,
            "network_mode": "host",
            "init": True,
            "restart": "on-failure",
            "environment": dict(place.environment),
            "volumes": [f"{folder}:{folder}" for folder in sorted(folders)],
        }
        if process.secrets:
            settings["env_file"] = str(place.tokens)
        if process.after:
            settings["depends_on"] = [name.removeprefix("agentrob-") for name in process.after]
        lines.append(f"  {process.name.removeprefix('agentrob-')}:")
        # JSON is YAML, and `$` begins a variable of Compose
        lines += [f"    {key}: {json.dumps(value).replace('$', '$$')}" for key, value in settings.items()]
    return "\n".join([*lines, ""])
