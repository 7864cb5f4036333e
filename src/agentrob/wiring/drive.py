"""Drive a robot by words without a forum: `agentrob drive`, and the calls that the paper names.

A robot of the configuration is driven through its running driver when there is one, on another machine if `driver_url`
says so, else through one started for this call. A robot that is only named by its kind gets a driver of its own: on the
real robot when a network interface is given, else on a simulated robot in a simulated room.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotUnreachable
from agentrob.language.goal import Goal
from agentrob.model import (
    Account,
    ActionResult,
    Capabilities,
    CommandState,
    Decision,
    Intent,
    Outcome,
    Plan,
    Role,
    Understanding,
    Verdict,
)
from agentrob.plugins import find
from agentrob.process import host_lock
from agentrob.process.child import Child, terminate_all
from agentrob.process.signals import delayed_signals, sigterm_interrupts
from agentrob.sim.domains import PrivateDomain
from agentrob.wiring import app, simulators

if TYPE_CHECKING:
    from agentrob.agent.execution.execute import Execution
    from agentrob.minds.protocol import Addressee
    from agentrob.robots.driver.client import DriverClient

#: The person at the keyboard of the robot's own machine.
LOCAL = Account(id="local", name="local", role=Role.OPERATOR)
T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Driven:
    """The result of one command: its final state, plan and steps. `message` says why when nothing moved."""

    status: CommandState
    plan: Plan = Plan()
    results: tuple[ActionResult, ...] = ()
    message: str = ""


def robot_command_driver(
    command: str,
    robot: str = "go2",
    network_interface: str | None = None,
    config: Config | None = None,
    on_step: Callable[[ActionResult], None] = lambda _: None,
    mind: str | None = None,
) -> Driven:
    """Understand `command`, screen it, and drive `robot` (a name in the configuration, or a kind such as go2).

    Blocks; may be called from any thread, also inside a running event loop. `on_step` hears of each step as it ends.
    `mind` reads instead of the robot's own; when it is a model with images, it may also look and steer ("walk to the
    red ball"), within the budgets of the robot's `look` settings: who names it here consents.
    Raises `ConfigError` for a robot that is not known, `RobotError` or `ChildError` when it cannot be reached or held.
    """
    config = config or Config()
    with _robot(robot, config, network_interface) as (name, settings):
        return _drive(command, name, settings, config, mind, on_step)


def _drive(
    command: str,
    name: str,
    settings: RobotConfig,
    config: Config,
    mind: str | None,
    on_step: Callable[[ActionResult], None],
) -> Driven:
    from agentrob.robots.driver.client import run_plan

    capabilities: Capabilities = app.capabilities_of(settings.model, settings)
    if mind is not None:
        settings = settings.model_copy(
            update={"mind": mind, "look": settings.look.model_copy(update={"allowed": True})}
        )
    if (later := _later(command, name, settings, capabilities)) is not None:
        return Driven(CommandState.REFUSED, message=later)
    if (goal := _goal(command, name, settings, config, capabilities)) is not None:
        return _look(goal, command, name, settings, config, on_step)
    understood, verdict = _outside_loop(lambda: asyncio.run(_judged(command, name, capabilities, settings, config)))
    if verdict is None:
        return Driven(CommandState.ASKS_BACK, message=understood.question or f"nothing to do in {command!r}")
    if verdict.decision is not Decision.ALLOW:
        asks = verdict.decision is Decision.ASK_BACK
        status = CommandState.ASKS_BACK if asks else CommandState.REFUSED
        return Driven(status, understood.plan, message=f"{verdict.reason} ({verdict.rule})")
    limit_s, holder = capabilities.limits.command_s, f"drive {os.getpid()}"
    with _driver(name, settings, config) as client:
        results = _outside_loop(
            lambda: run_plan(name, understood.plan, holder, client=client, deadline_s=limit_s, on_result=on_step)
        )
    status = CommandState.DONE if all(r.ok for r in results) else CommandState.FAILED
    return Driven(status, understood.plan, results)


def _later(text: str, name: str, settings: RobotConfig, capabilities: Capabilities) -> str | None:
    """Why a text that says when is not carried out now; None if it does not, or if the rules understand every word as
    a command of now."""
    from agentrob.language.messages.catalog import say
    from agentrob.language.registry import language_of
    from agentrob.minds.rules import RulesMind
    from agentrob.wiring.plan import when_of

    visible, addressee = _heard(text, name, capabilities, settings)
    if (timed := when_of(visible, addressee.names, settings.time_zone)) is None:
        return None
    if timed.schedule is None and not timed.surely_later:
        understood = _outside_loop(lambda: asyncio.run(RulesMind().understand(visible, addressee)))
        if understood.intent is Intent.COMMAND:
            return None
    return say("drive.later", language_of(visible))


async def _judged(
    text: str, name: str, capabilities: Capabilities, settings: RobotConfig, config: Config
) -> tuple[Understanding, Verdict | None]:
    """How the robot's mind understands a text, and the verdict by its owner's settings; None if it is not a command."""
    from agentrob.minds.extraction.trial import reviewed_verdict
    from agentrob.minds.protocol import ManagedMind, read
    from agentrob.screening.audience import text_for_robot
    from agentrob.screening.screen import screen

    visible, addressee = _heard(text, name, capabilities, settings)
    mind = app.make_mind(settings.mind, config)
    try:
        reading = await read(mind, visible, addressee)
        understood = reading.understanding
        if understood.intent is not Intent.COMMAND:
            return understood, None
        verdict = screen(
            understood.plan,
            text=visible,
            author=LOCAL,
            capabilities=capabilities,
            language=understood.language,
            consents=settings.consents,
            scene=settings.scene,
            part=text_for_robot(visible, addressee.names, addressee.others),
        )
        if settings.screen != "rules":
            required = settings.screen == "required"
            verdict, _ = await reviewed_verdict(
                mind, reading, verdict, visible, addressee, settings.scene, required=required
            )
        return understood, verdict
    finally:
        if isinstance(mind, ManagedMind):
            await mind.close()


def _heard(text: str, name: str, capabilities: Capabilities, settings: RobotConfig) -> tuple[str, Addressee]:
    """The visible text, addressed to the robot by one of its names, and the addressee for the mind."""
    from agentrob.language.visible_text import mentions, visible_text
    from agentrob.minds.protocol import Addressee

    names = (name, *(n.lower().lstrip("@") for n in settings.mentions))
    visible = visible_text(text)
    if not set(names) & set(mentions(visible)):
        visible = f"@{name} {visible}"
    others = tuple(other for other in mentions(visible) if other not in names)
    return visible, Addressee(names, others, capabilities, settings.step_length_m)


def drive_go2_robot(command: str, network_interface: str | None = None) -> Driven:
    """The paper's call for a Go2: simulated, or real on `network_interface`."""
    return robot_command_driver(command, "go2", network_interface)


def drive_g1_robot(command: str, network_interface: str | None = None) -> Driven:
    """The paper's call for a G1: simulated, or real on `network_interface`.

    A real one does not move this way: it sees nothing around it, so its owner must consent in a configuration first.
    """
    return robot_command_driver(command, "g1", network_interface)


# ---------------------------------------------------------------------- what needs eyes
def _goal(text: str, name: str, settings: RobotConfig, config: Config, capabilities: Capabilities) -> Goal | None:
    """The visual goal of a text, if it has one and the robot's mind reads images."""
    if not settings.look.allowed or settings.mind not in config.minds or not config.minds[settings.mind].images:
        return None
    from agentrob.minds.rules import RulesMind
    from agentrob.minds.visual_loop.pursuit import for_model, goal_for

    visible, addressee = _heard(text, name, capabilities, settings)
    understood = _outside_loop(lambda: asyncio.run(RulesMind().understand(visible, addressee)))
    goal = goal_for(visible, addressee, understood)
    return goal if goal is not None and for_model(goal, capabilities) else None


def _look(
    goal: Goal, text: str, name: str, settings: RobotConfig, config: Config, on_step: Callable[[ActionResult], None]
) -> Driven:
    """Let the mind steer the robot by its camera."""
    from agentrob.agent.execution.visual_local import judge, run_visual_task_locally
    from agentrob.agent.reporting import visual_text
    from agentrob.language.registry import language_of
    from agentrob.language.visible_text import visible_text
    from agentrob.minds.llm.fallback import model_with_fallbacks
    from agentrob.minds.visual_loop.pursuit import judged_plan

    visible, language = visible_text(text), language_of(text)
    capabilities = app.capabilities_of(settings.model, settings)
    verdict = judge(judged_plan(goal), visible, LOCAL, capabilities, language, settings)
    if verdict.decision is not Decision.ALLOW:
        return Driven(CommandState.REFUSED, Plan(goal.steps), message=f"{verdict.reason} ({verdict.rule})")

    async def steer(client: DriverClient) -> Execution:
        chain = model_with_fallbacks(settings.mind, config.minds, app.minds_ledger(config))
        try:
            vision_model = chain.with_images()
            assert vision_model is not None
            return await run_visual_task_locally(
                client, goal, vision_model, settings, visible, LOCAL, language, on_step
            )
        finally:
            await chain.close()

    with _driver(name, settings, config) as client:
        done = _outside_loop(lambda: asyncio.run(steer(client)))
    sentences = [done.message, visual_text.why(done.looked, language)]
    sentences += visual_text.paragraphs(done.looked, done.results, language)
    return Driven(done.status, Plan(goal.steps), done.results, "\n".join(part for part in sentences if part))


# ---------------------------------------------------------------------- how
def _outside_loop(work: Callable[[], T]) -> T:
    """Do blocking work that runs its own event loop; in another thread if one runs in this thread."""
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return work()
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(work).result()


@contextlib.contextmanager
def _robot(robot: str, config: Config, interface: str | None) -> Iterator[tuple[str, RobotConfig]]:
    """The robot's name and settings; a simulated robot that is not configured gets a DDS domain of its own
    meanwhile."""
    if (found := _configured(robot, config, interface)) is not None:
        yield found
        return
    with contextlib.closing(PrivateDomain()) as domain:
        yield robot, app.simulated_robot(robot, domain.number)


def _configured(robot: str, config: Config, interface: str | None) -> tuple[str, RobotConfig] | None:
    """A robot of the configuration by its name or kind, or a real one on an interface; None if there is none."""
    named = [robot] if robot in config.robots else [n for n, r in config.robots.items() if r.model == robot]
    if len(named) == 1:
        settings = config.robots[named[0]]
        if interface not in (None, settings.interface):
            raise ConfigError(
                f"{named[0]} is configured on interface {settings.interface!r}, not {interface!r}; "
                "change the configuration, or leave --interface out"
            )
        return named[0], settings
    find("robots", robot)
    if interface:
        return robot, RobotConfig(model=robot, interface=interface)
    return None


@contextlib.contextmanager
def _driver(name: str, settings: RobotConfig, config: Config) -> Iterator[DriverClient]:
    """A client of this robot's driver, which is started here unless it runs already, or on another machine."""
    from agentrob.robots.driver.client import DriverClient
    from agentrob.robots.driver.remote import driver_client

    elsewhere = bool(settings.driver_url)
    if elsewhere or (name in config.robots and _outside_loop(lambda: asyncio.run(_reachable(name)))):
        yield driver_client(name, settings)
        return
    children: list[Child] = []
    with tempfile.TemporaryDirectory(prefix="agentrob-drive-") as folder:
        work = Path(folder)
        try:
            if settings.simulated and simulators.world_lock(settings) not in host_lock.held("world/"):
                for command in simulation_of(settings):
                    with delayed_signals():
                        children.append(Child("world", command, work / "world.log"))
                    children[0].wait_ready()
            # the same data folder as always: a halt that is kept there holds for us too
            own = Config(data=str(config.data_dir.absolute()), robots={name: settings})
            own.write(work / "agentrob.toml")
            arguments = ["driver", name, "--config", str(work / "agentrob.toml")]
            with delayed_signals():
                driver = Child("driver", arguments, work / "driver.log", {"AGENTROB_RUNTIME": folder})
                children.append(driver)
            yield DriverClient(name, Path(driver.wait_ready()["socket"]))
        finally:
            terminate_all(children)


def simulation_of(settings: RobotConfig) -> list[list[str]]:
    """The command that simulates this robot; none if it simulates itself."""
    if app.in_world(settings.model):
        where = ["--domain", f"{settings.model}={settings.domain}", "--interface", settings.interface]
        return [["sim", *where]]
    if simulators.has_simulator(settings.model):
        return [["simulator", settings.model, "--domain", str(settings.domain), "--interface", settings.interface]]
    return []


async def _reachable(name: str) -> bool:
    from agentrob.robots.driver.client import DriverClient

    client = DriverClient(name)
    try:
        await client.state()
    except RobotUnreachable:
        return False
    finally:
        await client.close()
    return True


# ---------------------------------------------------------------------- the command line
def run(
    robot: str, text: str, config: Config, interface: str | None, pictures: Path, as_json: bool, mind: str | None = None
) -> int:
    """`agentrob drive`; returns the exit code: 0 done, 1 not done, 2 not understood or refused."""
    from rich.console import Console

    console = Console(stderr=as_json)
    shown: list[dict[str, Any]] = []

    def on_step(result: ActionResult) -> None:
        facts = result.as_data() | ({"animated": True} if result.animated else {})
        if result.image:
            facts["image"] = str(_save(result.image, pictures))
        shown.append(facts)
        mark = "[green]✓[/]" if result.ok else "[red]✗[/]"
        console.print(f"{mark} {_sentence(result, facts)}", highlight=False, soft_wrap=True)

    if not pictures.is_dir():
        raise ConfigError(f"--pictures {pictures} is not a folder")
    if mind is not None and mind != "rules" and mind not in config.minds:
        raise ConfigError(f"no mind named {mind!r} in the configuration; valid: {', '.join(sorted(config.minds))}")
    with sigterm_interrupts():
        driven = robot_command_driver(text, robot, interface, config, on_step, mind)
    if driven.message:
        console.print(driven.message, markup=False, highlight=False)
    for hint in _ways_out(driven, robot):
        console.print(hint, highlight=False)
    for note in driven.plan.notes:
        console.print(f"[dim]{note}[/]", highlight=False)
    if as_json:
        print(json.dumps({"status": driven.status, "message": driven.message, "steps": shown}, ensure_ascii=False))  # noqa: T201
    return {CommandState.DONE: 0, CommandState.FAILED: 1}.get(driven.status, 2)


def _ways_out(driven: Driven, robot: str) -> list[str]:
    """Hints on the commands that release a robot or set its home."""
    reasons = {result.reason for result in driven.results}
    hints = [f"To release it: agentrob release {robot}"] if "halted" in reasons else []
    return hints + ([f"To set its home where it stands: agentrob home {robot}"] if "not_homed" in reasons else [])


def _sentence(result: ActionResult, facts: dict[str, Any]) -> str:
    from agentrob.language.messages.plan_text import step_sentence

    text = step_sentence(result.primitive, "en")
    if "distance_m" in result.measured:
        text += f"  [bold]measured {result.measured['distance_m']:.2f} m[/]"
    if "degrees" in result.measured:
        text += f"  [bold]measured {result.measured['degrees']:.1f}°[/]"
    if result.unmeasured:
        text += f"  [bold]measured unknown[/] ({result.unmeasured.replace('_', ' ')})"
    if "image" in facts:
        text += f"  {facts['image']}"
    if result.outcome is not Outcome.DONE:
        text += f"  {result.outcome}: {result.message}"
    return f"{text}  [dim]{result.duration_s:.1f} s[/]"


def _save(image: bytes, folder: Path) -> Path:
    for number in range(1000):
        path = folder / (time.strftime("agentrob-%Y%m%d-%H%M%S") + (f"-{number}" if number else "") + ".jpg")
        with contextlib.suppress(FileExistsError), path.open("xb") as file:
            file.write(image)
            return path
    raise ConfigError(f"no free name for a picture in {folder}")
