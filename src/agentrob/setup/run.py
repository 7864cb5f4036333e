"""Run the steps of `agentrob init`; each says what it did and how to undo it, in reverse order.

The forum is created first, then the robot with its account and token, then the processes are started, and at last the
robot gets its home and walks. A step that fails ends the command; those before it are done.
"""

from __future__ import annotations

import asyncio
import os
import shlex
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx2

from agentrob.config import load as configuration
from agentrob.config.load import Config
from agentrob.config.robots import FenceConfig, LimitsConfig, RobotConfig
from agentrob.demo import visitor
from agentrob.errors import ConfigError, ForumError, RobotError, RobotUnreachable
from agentrob.model import AccountKind, CommandState, Role
from agentrob.process import host_lock
from agentrob.setup.answers import Answers, RobotAnswers, Services, check_address
from agentrob.setup.service_manager import Done, SetupError, install, place_of
from agentrob.setup.units import processes
from agentrob.wiring import app, simulators, unlock

#: Seconds until the forum, the driver and the agent must answer.
READY_S = 90.0
#: How far a robot walks at the end: a simulated and a real one.
SIMULATED_WALK, REAL_WALK = "walk forward 0.3 metres", "walk forward 0.1 metres"
#: Of the temporary token with which the first walk is posted.
LABEL = "agentrob init"
DOMAINS = range(1, 40)


def set_up(answers: Answers, say: Callable[[str], None]) -> None:
    """Set everything up; `say` gets lines for the person. Raises `AgentRobError` when a step fails."""
    if answers.config.exists():
        raise ConfigError(
            f"{answers.config} already exists; to add an admin: agentrob board account add NAME --role admin"
        )
    if answers.services is not Services.NONE:  # services do not run in this folder
        data = Path(answers.data).expanduser() if answers.data else configuration.default_data_dir()
        answers = replace(answers, config=answers.config.absolute(), data=str(data.absolute()))
    config = _configuration(answers)
    if answers.services is not Services.NONE:
        check_address(answers.listen)
    say("Each step prints the commands that undo it. Undo the steps in reverse order.")
    numbered = _Steps(say)
    numbered.show("Forum", _forum(answers, config))
    tokens = config.data_dir / "agents.env"
    if answers.robot:
        numbered.show(f"Robot {answers.robot.name}", _robot(answers, answers.robot, config, tokens))
    world = _world(answers.robot, config) if answers.robot else ()
    found = processes(answers.config, answers.robot.name if answers.robot else "", world)
    place = place_of(answers.services, answers.config, config.data_dir, tokens)
    numbered.show("Processes", install(answers.services, found, place))
    if answers.services is Services.NONE:
        return
    wait_for_forum(config)
    say(f"   the forum answers at {config.board.base_url or config.forum.url}")
    if answers.robot:
        numbered.show("Home", _home(answers.robot, config, answers.config))
        if answers.walk:
            numbered.show("First walk", _first_walk(answers, answers.robot, config))


class _Steps:
    """Prints the steps with their numbers."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say, self._number = say, 0

    def show(self, title: str, done: Done) -> None:
        self._number += 1
        self._say(f"{self._number}. {title}")
        for line in done.did:
            self._say(f"   {line}")
        for line in done.undo:
            self._say(f"   undo: {line}")


# ---------------------------------------------------------------------- forum
def _configuration(answers: Answers) -> Config:
    """The configuration; raises `ConfigError` for answers that are not valid, before anything is written."""
    board = {
        "listen": answers.listen, "base_url": answers.url, "title": answers.title, "database": answers.database,
        "sign_up": False,
    }  # fmt: skip
    raw: dict[str, Any] = {"data": answers.data, "board": board}
    if answers.robot:
        raw["robots"] = {answers.robot.name: _robot_settings(answers.robot, answers.admin).model_dump()}
    return configuration.parse(raw, "agentrob init")


def _forum(answers: Answers, config: Config) -> Done:
    """Create the database with its first admin and write the configuration."""
    from agentrob.board.admin import management
    from agentrob.board.admin.local_admin import bootstrap, writing
    from agentrob.board.db.audit import SHELL

    settings = app.board_settings(config)
    bootstrap(settings)
    with writing(settings) as connection:
        management.add_account(connection, SHELL, answers.admin, kind=AccountKind.HUMAN, role=Role.ADMIN)
        link = management.link(connection, SHELL, answers.admin, "password")
        invite = management.invite(connection, SHELL, Role.MEMBER, answers.invites, 30) if answers.invites else ""
    config.write(answers.config, "Written by agentrob init. docs/forum/tls.md describes further settings.")
    done = Done([f"configuration: {answers.config}", f"database: {settings.database_shown}"])
    done.did.append(f"set the password of {answers.admin}, once, within a day: {settings.base_url}{link}")
    if invite:
        done.did.append(f"invite {answers.invites} members within 30 days: {settings.base_url}{invite}")
    done.undo.append(shlex.join(["rm", str(answers.config)]))
    if settings.database_path is not None:
        done.undo.append(shlex.join(["rm", "-r", str(settings.database_path.parent)]))
    return done


# ---------------------------------------------------------------------- robot
def _robot_settings(robot: RobotAnswers, owner: str) -> RobotConfig:
    """The robot's table: a simulated one as in the demo; a real one with the limits of its first day."""
    app.capabilities_of(robot.model)
    if robot.simulated:
        if not (app.in_world(robot.model) or simulators.has_simulator(robot.model) or robot.model == "fake"):
            raise ConfigError(f"a {robot.model} cannot be simulated; for a real one give its --interface")
        domain = robot.domain if robot.domain is not None else free_domain()
        return app.simulated_robot(robot.model, domain).model_copy(update={"owner": owner})
    return RobotConfig(
        model=robot.model,
        interface=robot.interface,
        domain=robot.domain or 0,
        owner=owner,
        least_battery_percent=30,
        limits=LimitsConfig(speed_mps=0.2, turn_dps=20, step_m=0.5, command_m=1.0, command_steps=3),
        fence=FenceConfig(x_min_m=-0.5, x_max_m=1.0, y_min_m=-0.5, y_max_m=0.5),
    )


def free_domain() -> int:
    """A DDS domain on loopback that nothing on this host uses now. Raises `ConfigError` if there is none."""
    taken = {host_lock.without_namespace(name) for name in host_lock.held_anywhere()}
    for number in DOMAINS:
        if not {f"{kind}/lo/{number}" for kind in ("world", "driver", "domain")} & taken:
            return number
    raise ConfigError(
        f"all DDS domains from {DOMAINS.start} to {DOMAINS.stop - 1} are in use; choose one with --domain"
    )


def _world(robot: RobotAnswers, config: Config) -> tuple[str, ...]:
    """The words of the command that simulates the robot; none for one that is real or needs no world."""
    domain = config.robots[robot.name].domain
    if not robot.simulated:
        return ()
    if simulators.has_simulator(robot.model):
        return ("simulator", robot.model, "--domain", str(domain))
    if app.in_world(robot.model):
        return ("sim", "--robot", robot.model, "--domain", f"{robot.model}={domain}")
    return ()  # such as the fake robot, which needs no world


def _robot(answers: Answers, robot: RobotAnswers, config: Config, tokens: Path) -> Done:
    """Create the robot's account with its token and owner."""
    app.board_account(config, robot.name, AccountKind.ROBOT_AGENT, Role.MEMBER)
    app.own_board_robot(config, robot.name, answers.admin)
    variable = app.token_variable(config, robot.name)
    # readable by its user only, from its first byte
    with os.fdopen(os.open(tokens, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600), "a") as file:
        file.write(f"{variable}={app.board_token(config, robot.name, LABEL)}\n")
    settings = config.robots[robot.name]
    kind = f"{'simulated ' if robot.simulated else ''}{robot.model} on {settings.interface}, domain {settings.domain}"
    done = Done([f"[robots.{robot.name}] in {answers.config}: a {kind}; its owner is {answers.admin}"])
    done.did.append(f"the token of its account: {tokens} ({variable})")
    at = shlex.join(["--config", str(answers.config)])
    done.undo = [
        f"agentrob board account revoke {robot.name} {at}",
        f"agentrob board account change {robot.name} --suspend {at}",
        shlex.join(["rm", str(tokens)]),
    ]
    return done


# ---------------------------------------------------------------------- once everything runs
def wait_for_forum(config: Config) -> None:
    """Return when the forum answers. Raises `SetupError` after `READY_S`."""
    end_s = time.monotonic() + READY_S
    while True:
        try:
            httpx2.get(f"{config.forum.url}/healthz", timeout=5, trust_env=False).raise_for_status()
        except httpx2.HTTPError as e:
            if time.monotonic() > end_s:
                raise SetupError(f"the forum does not answer at {config.forum.url} ({e}); see its log") from None
            time.sleep(0.2)
        else:
            return


def _home(robot: RobotAnswers, config: Config, file: Path) -> Done:
    """Set the home where the robot stands; a simulated one has it from its start."""
    end_s = time.monotonic() + READY_S
    while True:
        try:
            line = unlock.home(robot.name, config)
        except (RobotUnreachable, RobotError) as e:
            if time.monotonic() > end_s:
                doctor = shlex.join(["agentrob", "doctor", robot.name, "--config", str(file)])
                raise SetupError(f"{robot.name} has no home: {e}; what is wrong, says: {doctor}") from None
            time.sleep(0.5)
        else:
            again = shlex.join(["agentrob", "home", robot.name, "--config", str(file)])
            return Done([line, f"another home, when it stands elsewhere: {again}"])


def _first_walk(answers: Answers, robot: RobotAnswers, config: Config) -> Done:
    """Post a short walk as the admin, and return the robot's reply."""
    words = f"@{robot.name} {SIMULATED_WALK if robot.simulated else REAL_WALK}"
    token = app.board_token(config, answers.admin, LABEL)
    try:
        asyncio.run(_served(config, token, robot.name))
        outcome = asyncio.run(visitor.ask(config, token, words, lambda: None))
    except ForumError as e:
        raise SetupError(f"the first walk could not be posted: {e}") from e
    finally:
        app.revoke_board_tokens(config, answers.admin, LABEL)
    if outcome["status"] != CommandState.DONE:
        doctor = shlex.join(["agentrob", "doctor", robot.name, "--config", str(answers.config)])
        reply = outcome["reply_markdown"].partition("\n")[0] or outcome["error"]
        raise SetupError(f"{robot.name} did not walk: {reply}; what is wrong, says: {doctor}")
    (first, *_) = outcome["reply_markdown"].splitlines()
    return Done([f"posted: {words}", f"{robot.name} replied: {first}", f"the thread: {outcome['topic_url']}"])


async def _served(config: Config, token: str, robot: str) -> None:
    """Return when the robot's agent serves it. Raises `SetupError` after `READY_S`."""
    from agentrob.forums.protocol import Fleet

    forum = app.make_forum(config, token)
    assert isinstance(forum, Fleet), "the embedded forum keeps cards"
    try:
        async with asyncio.timeout(READY_S):
            while True:
                if any(one.name == robot and one.served for one in await forum.fleet()):
                    return
                await asyncio.sleep(0.2)
    except TimeoutError:
        raise SetupError(f"no agent serves {robot}; see its log") from None
    finally:
        await forum.close()
