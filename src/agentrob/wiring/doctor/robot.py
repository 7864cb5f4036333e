"""Find what keeps one robot from being driven, and what to do about it. Moves nothing unless asked.

A robot that a driver holds is not touched: its driver is asked instead. Any other is looked at over its network, by
reading only. `--move` lets it walk 10 cm forward through a driver with the guard, when nothing bad was found.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
from collections.abc import Sequence
from dataclasses import replace

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.errors import AgentRobError, ConfigError, RobotError, RobotUnreachable
from agentrob.model import ActionResult, Direction, Op, Primitive
from agentrob.plugins import find
from agentrob.process import host_lock
from agentrob.robots.diagnostics import findings, network
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.robots.diagnostics.protocol import Examinable
from agentrob.robots.driver.client import DriverClient
from agentrob.robots.driver.process import lock_name
from agentrob.robots.driver.remote import driver_client
from agentrob.robots.safety.guard import BLIND_MPS, STATE_AGE_S
from agentrob.robots.safety.lock import Halt
from agentrob.semantic import harm_classifier
from agentrob.wiring import app, drive

STEP_M = 0.1
MOVE_S = 20.0


def chosen(robot: str | None, config: Config, interface: str | None, domain: int | None) -> tuple[str, RobotConfig]:
    """The name and settings of a robot of the configuration or of a kind, with the network given. Raises
    `ConfigError`."""
    if robot is None or robot in config.robots:
        name = app.only_robot(config, robot)
        settings = config.robots[name]
    else:
        name = robot
        find("robots", robot)
        simulated = interface in (None, "lo")
        settings = app.simulated_robot(robot, 0) if simulated else RobotConfig(model=robot)
    given = {"interface": interface, "domain": domain}
    changed = {key: value for key, value in given.items() if value is not None}
    try:
        return name, RobotConfig.model_validate({**settings.model_dump(), **changed})
    except ValueError:
        raise ConfigError(f"--domain {domain} is out of range; valid: 0 to 230") from None


def examine(name: str, settings: RobotConfig, config: Config) -> list[Finding]:
    """All findings that need no motion. Those that are not good name a command."""
    classifier = [_classifier()] if settings.harm_classifier else []
    return with_commands([*_examined(name, settings, config), *classifier], f"agentrob doctor {name}")


def with_commands(found: Sequence[Finding], again: str) -> list[Finding]:
    """The findings, with the command that checks `again` where only hands can mend something."""
    return [one if one.command or one.status is Status.OK else replace(one, command=again) for one in found]


def walk(name: str, settings: RobotConfig, config: Config, found: Sequence[Finding]) -> Finding:
    """Walk 10 cm if nothing bad was found."""
    if any(one.status is Status.BAD for one in found):
        again = f"agentrob doctor {name} --move"
        return Finding("move", Status.UNKNOWN, "not tried: something is bad", "Mend that first.", again)
    return _walk(name, settings, config)


def _examined(name: str, settings: RobotConfig, config: Config) -> list[Finding]:
    why = Halt(config.data_dir / "drivers" / f"{name}.halt").why
    halted = [] if why is None else [_halted(name, why)]
    if settings.driver_url or lock_name(name, settings) in host_lock.held("driver/"):
        return [*asyncio.run(_asked(name, settings)), *halted]
    if settings.model == "fake":
        text = "a fake robot needs no network; no driver holds it"
        return [Finding("driver", Status.OK, text, "Start one.", _driver(name)), *halted]
    free = Finding("driver", Status.OK, "no driver on this machine holds it", "Start one.", _driver(name))
    if settings.model in ("go2", "g1"):
        from agentrob.robots.diagnostics import examine as checkup

        return [free, *checkup.examine(settings), *halted]
    kind = find("robots", settings.model)
    if isinstance(kind, Examinable):
        return [free, *kind.examine(settings), *halted]
    text = f"what a {settings.model} needs is not known here, and no driver holds it"
    advice = "Start its driver and ask again."
    return [Finding("driver", Status.UNKNOWN, text, advice, _driver(name)), *halted]


def _driver(name: str) -> str:
    return f"agentrob driver {name}"


def _classifier() -> Finding:
    """Whether the harm classifier of the configuration answers."""
    try:
        seconds = harm_classifier.check_harm_classifier()
    except AgentRobError as e:
        advice = "Until it answers, the rules decide alone. Fix it, or set harm_classifier = false."
        return Finding("harm classifier", Status.WARNING, str(e), advice)
    return Finding("harm classifier", Status.OK, f"it answers {seconds:.1f} s after its start")


def _halted(name: str, why: str) -> Finding:
    advice = "When you know why and the robot stands safely, release it (its driver must run)."
    return Finding("halt", Status.BAD, why, advice, f"agentrob release {name}")


# ------------------------------------------------------------------ a robot that is held
async def _asked(name: str, settings: RobotConfig) -> list[Finding]:
    """The findings of the driver that holds the robot."""
    lock = settings.driver_url or lock_name(name, settings)
    async with driver_client(name, settings) as driver:
        try:
            state, holder = await driver.state(), await driver.holder()
        except RobotUnreachable as e:
            if settings.driver_url:
                return [Finding("driver", Status.BAD, str(e), "See docs/forum/deploy.md, a robot on its own computer.")]
            found = f"a driver holds it ({lock}), but none answers at {driver.address}"
            advice = "It runs under another name or user, or hangs. A stop reaches it all the same."
            return [Finding("driver", Status.BAD, found, advice, "agentrob stop --all")]
    used = f", and {holder} uses it now" if holder else ""
    results = [Finding("driver", Status.OK, f"its driver holds it ({lock}){used}; this is what it says")]
    if settings.model in ("go2", "g1") and not settings.driver_url:
        results.insert(0, network.interface_finding(settings))
    if state.age_s >= STATE_AGE_S:
        age = "no state ever came" if math.isinf(state.age_s) else f"its last state is {state.age_s:.0f} s old"
        advice = "Is the robot on, and the cable in? End the driver and run this again to look at its network."
        return [*results, Finding("state", Status.BAD, age, advice)]
    results.append(Finding("state", Status.OK, f"{1000 * state.age_s:.0f} ms old"))
    results += findings.of_state(state)
    if not state.homed:
        advice = "Until then nothing moves it. Where it stands becomes its home."
        results.append(Finding("home", Status.WARNING, "not set yet", advice, f"agentrob home {name}"))
    return [*results, findings.of_battery(state.battery_percent, settings), *findings.of_settings(settings)]


# ------------------------------------------------------------------ ten centimetres
def _walk(name: str, settings: RobotConfig, config: Config) -> Finding:
    """Walk 10 cm through a driver; a robot without a home takes the place where it stands as its home."""
    step = Primitive(Op.MOVE, Direction.FORWARD, distance_m=STEP_M, speed_mps=BLIND_MPS)
    own = config.model_copy(update={"robots": {**config.robots, name: settings}})
    try:
        with drive._driver(name, settings, own) as client:
            result = asyncio.run(_one_step(client, step))
    except AgentRobError as e:
        return Finding("move", Status.BAD, str(e), "Read it, mend it, and try again.")
    if result.ok:
        return Finding("move", Status.OK, result.message)
    word = result.reason.replace("_", " ")
    return Finding("move", Status.BAD, f"{result.outcome} ({word}): {result.message}", "See docs/safety/faults.md.")


async def _one_step(robot: DriverClient, step: Primitive) -> ActionResult:
    async with robot:
        end_s = asyncio.get_running_loop().time() + 5.0
        while not (await robot.state()).homed and asyncio.get_running_loop().time() < end_s:
            with contextlib.suppress(RobotError):
                await robot.home("doctor")
            await asyncio.sleep(0.1)
        async with robot.lease("doctor") as lease:
            return await robot.step(lease, step, MOVE_S)
