"""Drive a robot by words without a forum: `agentrob drive`, and the calls that the paper names.

A running driver of that robot is used when there is one. Otherwise one is started for this call: on the real robot when
a network interface is given, else on a simulated robot in a simulated room.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agentrob import app, demo
from agentrob.child import Child, end_all
from agentrob.config import Config, RobotConfig
from agentrob.errors import ConfigError, RobotUnreachable
from agentrob.model import Account, ActionResult, Capabilities, Decision, Intent, Outcome, Plan, Role

#: The person at the keyboard of the robot's own machine.
LOCAL = Account(id="local", name="local", role=Role.OPERATOR)


@dataclass(frozen=True, slots=True)
class Driven:
    """What came of it. `status`: done, failed, asks_back, refused. `message` says why when nothing moved."""

    status: str
    plan: Plan = Plan()
    results: tuple[ActionResult, ...] = ()
    message: str = ""


def robot_command_driver(
    command: str,
    robot: str = "go2",
    network_interface: str | None = None,
    config: Config | None = None,
    on_step: Callable[[ActionResult], None] | None = None,
) -> Driven:
    """Understand `command`, screen it, and drive `robot` (a name in the configuration, or a kind such as go2).

    `on_step` hears of each step as it ends. Raises `RobotError` when no robot can be reached.
    """
    from agentrob.judge.screen import screen

    config = config or Config()
    name, settings = _settings(robot, config, network_interface)
    capabilities: Capabilities = app.capabilities_of(settings.model, settings)
    understood = asyncio.run(app.understand(command, name, capabilities, settings.mind))
    if understood.intent is not Intent.COMMAND:
        return Driven("asks_back", message=understood.question or f"nothing to do in {command!r}")
    verdict = screen(
        understood.plan, text=command, author=LOCAL, capabilities=capabilities, language=understood.language
    )
    if verdict.decision is not Decision.ALLOW:
        return Driven("refused", understood.plan, message=f"{verdict.reason} ({verdict.rule})")
    with _driver(name, settings, config):
        results = asyncio.run(_execute(name, understood.plan, capabilities, on_step))
    done = len(results) == len(understood.plan.steps) and all(r.ok for r in results)
    return Driven("done" if done else "failed", understood.plan, tuple(results))


def drive_go2_robot(command: str, network_interface: str | None = None) -> Driven:
    """The paper's call for a Go2: simulated, or real on `network_interface`."""
    return robot_command_driver(command, "go2", network_interface)


# ---------------------------------------------------------------------- how
def _settings(robot: str, config: Config, interface: str | None) -> tuple[str, RobotConfig]:
    if robot in config.robots:
        return robot, config.robots[robot]
    named = [n for n, r in config.robots.items() if r.model == robot]
    if len(named) == 1:
        return named[0], config.robots[named[0]]
    app.find("robots", robot)
    if interface:
        return robot, RobotConfig(model=robot, interface=interface)
    return robot, RobotConfig(model=robot, domain=demo.free_domain(), simulated=True, home_on_start=True)


@contextlib.contextmanager
def _driver(name: str, settings: RobotConfig, config: Config) -> Iterator[None]:
    """Make sure that a driver of this robot runs."""
    if asyncio.run(_reachable(name)):
        yield
        return
    children: list[Child] = []
    with tempfile.TemporaryDirectory(prefix="agentrob-drive-") as folder, demo.sigterm_interrupts():
        work = Path(folder)
        try:
            if settings.simulated and settings.model != "fake":
                world = Child("world", ["sim", "--domain", f"{settings.model}={settings.domain}"], work / "world.log")
                children.append(world)
                world.wait_ready()
            path = work / "agentrob.toml"
            path.write_text(_toml(name, settings))
            env = {} if config.data or os.environ.get("AGENTROB_DATA") else {"AGENTROB_DATA": str(config.data_dir)}
            driver = Child("driver", ["driver", name, "--config", str(path)], work / "driver.log", env)
            children.append(driver)
            driver.wait_ready()
            yield
        finally:
            end_all(children)


def _toml(name: str, settings: RobotConfig) -> str:
    """The settings as a configuration file (JSON values are valid TOML for all that a robot's table holds)."""
    lines = [f"[robots.{name}]"]
    tables = []
    for key, value in settings.model_dump(mode="json").items():
        if isinstance(value, dict):
            tables += [f"[robots.{name}.{key}]", *(f"{k} = {json.dumps(v)}" for k, v in value.items())]
        else:
            lines.append(f"{key} = {json.dumps(value)}")
    return "\n".join([*lines, *tables]) + "\n"


async def _reachable(name: str) -> bool:
    from agentrob.robots.client import DriverClient

    client = DriverClient(name)
    try:
        await client.state()
    except RobotUnreachable:
        return False
    finally:
        await client.close()
    return True


async def _execute(
    name: str, plan: Plan, capabilities: Capabilities, on_step: Callable[[ActionResult], None] | None
) -> list[ActionResult]:
    from agentrob.judge.mandate import mandate_of, within
    from agentrob.robots.client import DriverClient

    client = DriverClient(name)
    mandate = mandate_of(plan, capabilities)
    deadline = time.monotonic() + capabilities.limits.command_s
    results: list[ActionResult] = []
    try:
        async with client.lease(f"drive-{os.getpid()}") as lease:
            for step in plan.steps:
                if within(mandate, results, step) is not None:
                    break
                result = await client.step(lease, step, max(1.0, deadline - time.monotonic()))
                results.append(result)
                if on_step:
                    on_step(result)
                if not result.ok:
                    break
    finally:
        await client.close()
    return results


# ---------------------------------------------------------------------- the command line
def run(robot: str, text: str, config: Config, interface: str | None, pictures: Path, as_json: bool) -> int:
    """`agentrob drive`; returns the exit code: 0 done, 1 not done, 2 not understood or refused."""
    from rich.console import Console

    console = Console(stderr=as_json)
    shown: list[dict[str, Any]] = []

    def on_step(result: ActionResult) -> None:
        facts = describe(result)
        if result.image:
            facts["image"] = str(_save(result.image, pictures))
        shown.append(facts)
        mark = "[green]✓[/]" if result.ok else "[red]✗[/]"
        console.print(f"{mark} {_sentence(facts)}  [dim]{result.duration_s:.1f} s[/]", highlight=False)

    driven = robot_command_driver(text, robot, interface, config, on_step)
    if driven.message:
        console.print(driven.message, markup=False, highlight=False)
    for note in driven.plan.notes:
        console.print(f"[dim]{note}[/]", highlight=False)
    if as_json:
        print(json.dumps({"status": driven.status, "message": driven.message, "steps": shown}, ensure_ascii=False))  # noqa: T201
    return {"done": 0, "failed": 1}.get(driven.status, 2)


def describe(result: ActionResult) -> dict[str, Any]:
    """A step as data: what was asked beside what was measured."""
    facts: dict[str, Any] = {
        "op": str(result.primitive.op),
        "asked": result.primitive.asked(),
        "measured": {k: round(v, 3) for k, v in result.measured.items()},
        "outcome": str(result.outcome),
        "duration_s": round(result.duration_s, 2),
    }
    if result.outcome is not Outcome.DONE:
        facts |= {"reason": result.reason, "message": result.message}
    if result.animated:
        facts["animated"] = True
    return facts


def _sentence(facts: dict[str, Any]) -> str:
    parts = [facts["op"], *(f"{k}={v}" for k, v in facts["asked"].items())]
    measured = ", ".join(f"{k} {v}" for k, v in facts["measured"].items())
    text = " ".join(parts) + (f"  measured: {measured}" if measured else "")
    if "image" in facts:
        text += f"  picture: {facts['image']}"
    return text + (f"  {facts['outcome']}: {facts['message']}" if "message" in facts else "")


def _save(image: bytes, folder: Path) -> Path:
    if not folder.is_dir():
        raise ConfigError(f"--pictures {folder} is not a folder")
    path = folder / time.strftime("agentrob-%Y%m%d-%H%M%S.jpg")
    path.write_bytes(image)
    return path
