"""The command `agentrob doctor`: examine, print, and return the exit code."""

from __future__ import annotations

import contextlib
import io
import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.wiring.doctor import installation, robot

_STYLE = {Status.OK: "green", Status.WARNING: "yellow", Status.BAD: "bold red", Status.UNKNOWN: "cyan"}


def run_robot(
    name: str | None,
    config: Config,
    interface: str | None,
    domain: int | None,
    move: bool,
    as_json: bool,
    file: Path | None = None,
) -> int:
    """Examine one robot; `file` is the configuration that commands are to name. 0 if nothing is bad, else 1."""
    name, settings = robot.chosen(name, config, interface, domain)
    with _no_chatter():
        found = robot.examine(name, settings, config)
        moved = move and not is_bad(found)
        if move:
            found.append(robot.walk(name, settings, config, found))
    found = _naming(file, found)
    if as_json:
        print(json.dumps({**_facts(name, settings, found), "moved": moved}, ensure_ascii=False))  # noqa: T201
    else:
        _show(_title(name, settings), found)
        _conclude(found, "It walked 10 cm." if moved else "Nothing was moved.")
    return int(is_bad(found))


def run_all(config: Config, as_json: bool, file: Path | None = None) -> int:
    """Examine the forum, its services, and each robot with its agent. 0 if nothing is bad, else 1."""
    forum = [installation.of_configuration(config, file)]
    if not is_bad(forum):
        forum += [*installation.of_forum(config), *installation.of_services(os.environ)]
    forum = _naming(file, robot.with_commands(forum, "agentrob doctor"))
    if not as_json:
        _show("installation", forum)
    robots = dict[str, list[Finding]]()
    for name, settings in config.robots.items():
        with _no_chatter():
            agent = robot.with_commands(installation.of_agent(config, name), f"agentrob doctor {name}")
            robots[name] = _naming(file, [*robot.examine(name, settings, config), *agent])
        if not as_json:
            _show(f"\n{_title(name, settings)}", robots[name])
    found = [*forum, *(one for each in robots.values() for one in each)]
    if as_json:
        facts = {
            "ok": not is_bad(found),
            "findings": [asdict(one) for one in forum],
            "robots": [_facts(name, config.robots[name], each) for name, each in robots.items()],
        }
        print(json.dumps(facts, ensure_ascii=False))  # noqa: T201
    else:
        _conclude(found, "Nothing was moved.")
    return int(is_bad(found))


def is_bad(found: Sequence[Finding]) -> bool:
    """Whether one of the findings keeps something from working."""
    return any(one.status is Status.BAD for one in found)


def _naming(file: Path | None, found: Sequence[Finding]) -> list[Finding]:
    """The findings, whose commands of ours name the configuration."""
    if file is None:
        return list(found)
    plain = ("agentrob init", "agentrob stop", "agentrob sim")
    return [
        replace(one, command=f"{one.command} --config {file}")
        if "agentrob " in one.command and not one.command.startswith(plain)
        else one
        for one in found
    ]


def _facts(name: str, settings: RobotConfig, found: Sequence[Finding]) -> dict[str, Any]:
    who = {"robot": name, "model": settings.model, "interface": settings.interface, "domain": settings.domain}
    return {**who, "ok": not is_bad(found), "findings": [asdict(one) for one in found]}


# ---------------------------------------------------------------------- what is shown
@contextlib.contextmanager
def _no_chatter() -> Iterator[None]:
    """Silence the SDK, which prints what the findings say already."""
    with contextlib.redirect_stdout(io.StringIO()):
        yield


def _title(name: str, settings: RobotConfig) -> str:
    kind = f"{'simulated ' if settings.simulated else ''}{settings.model}"
    where = "" if settings.model == "fake" else f" on {settings.interface}, domain {settings.domain}"
    return f"{name}: {kind}{where}"


def _show(title: str, found: Sequence[Finding]) -> None:
    """Print the findings as a table; a command has a line of its own, to be copied."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", show_edge=False, pad_edge=False)
    for head in ("check", "", "found, and what to do"):
        table.add_column(head, no_wrap=head != "found, and what to do", overflow="fold")
    for one in found:
        text = Text(one.found)
        if one.advice:
            text.append(f"\n→ {one.advice}", style="dim" if one.status is Status.OK else "")
        if one.command:
            text.append(f"\n  {one.command}", style="dim" if one.status is Status.OK else "bold")
        table.add_row(one.check, Text(str(one.status), style=_STYLE[one.status]), text)
    Console().print(table)


def _conclude(found: Sequence[Finding], motion: str) -> None:
    from rich.console import Console

    end = "It does not work like this: run the commands above, from the first to the last."
    if not is_bad(found):
        minded = any(one.status is not Status.OK for one in found)
        end = "Nothing bad was found; mind what is said above." if minded else "Nothing is wrong."
    Console().print(f"\n{end} {motion}", highlight=False)
