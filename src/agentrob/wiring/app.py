"""Build forums, minds, robots and agents from a configuration."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import signal
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agentrob.config import load as configuration
from agentrob.config.load import Config
from agentrob.config.robots import RehearsalConfig, RobotConfig
from agentrob.errors import BoardError, ConfigError
from agentrob.model import Account, AccountKind, Capabilities, Role, StopResult
from agentrob.plugins import find
from agentrob.process.child import print_line, print_ready
from agentrob.process.interpreter import freeze_objects, prefer_event_loop
from agentrob.process.logs import log_to_stderr

if TYPE_CHECKING:
    from agentrob.agent.agent import RobotAgent
    from agentrob.agent.understanding.second_opinion import SecondOpinion
    from agentrob.board.settings import BoardSettings
    from agentrob.eyes.protocol import Detector
    from agentrob.forums.protocol import Forum
    from agentrob.minds.llm.probe import ProbeResult
    from agentrob.minds.protocol import Mind
    from agentrob.worker.metrics import WorkerMetrics

load = configuration.load


def make_forum(config: Config, token: str) -> Forum:
    """The configured forum, signed in by a token."""
    forum: Forum = find("forums", config.forum.kind)(config.forum, token)
    return forum


def make_mind(name: str, config: Config | None = None) -> Mind:
    """A mind of the configuration, or one found by its entry point."""
    from agentrob.minds.rules import RulesMind

    minds = config.minds if config else {}
    if config and name in minds:
        from agentrob.minds.extraction.mind import ModelMind
        from agentrob.minds.llm.fallback import model_with_fallbacks

        chain = model_with_fallbacks(name, minds, minds_ledger(config))
        return ModelMind(chain, rules_first=minds[name].reads == "unclear")
    try:
        kind = find("minds", name)
    except ConfigError as e:
        configured = f"; configured as [minds.NAME]: {', '.join(sorted(minds)) or 'none'}"
        raise ConfigError(f"{e}{configured}") from None
    if kind is RulesMind:
        return RulesMind()
    from agentrob.minds.isolated import IsolatedMind

    return IsolatedMind(kind)  # whoever wrote it: its code may hang


def minds_ledger(config: Config) -> Path:
    """The file that keeps what the minds used today."""
    return config.data_dir / "minds.sqlite"


def check_minds(config: Config, name: str | None) -> list[ProbeResult]:
    """Ask the configured models, or one of them, whether they can be used."""
    from agentrob.minds.llm.probe import probe_all

    if name is not None and name not in config.minds:
        raise ConfigError(f"no mind named {name!r} in the configuration; valid: {', '.join(sorted(config.minds))}")
    wanted = config.minds if name is None else {name: config.minds[name]}
    return asyncio.run(probe_all(wanted, minds_ledger(config)))


def secret(config: Config, robot: str = "") -> str:
    """A forum token, from the environment: the robot's own variable (`AGENTROB_TOKEN_REX`), else the common one."""
    common, own = config.forum.token_env, token_variable(config, robot)
    token = os.environ.get(own) or os.environ.get(common, "")
    if not token:
        either = common if own == common else f"{own} or {common}"
        raise ConfigError(f"the environment variable {either} must hold the agent's forum token")
    return token


def token_variable(config: Config, robot: str = "") -> str:
    """The environment variable that holds the token of this robot only; without a robot, the common one."""
    common = config.forum.token_env
    return f"{common}_{robot.upper().replace('-', '_')}" if robot else common


def only_robot(config: Config, name: str | None) -> str:
    """The robot of this name, or the only one of the configuration."""
    if name is not None:
        config.robot(name)
        return name
    if len(config.robots) == 1:
        return next(iter(config.robots))
    known = ", ".join(sorted(config.robots)) or "none is configured"
    raise ConfigError(f"which robot? Name one of: {known}")


def some_robots(config: Config, names: Sequence[str]) -> tuple[str, ...]:
    """These robots of the configuration, each once; without names, all of them."""
    if not config.robots:
        raise ConfigError("no robot is configured; add a table [robots.NAME]")
    for name in names:
        config.robot(name)
    return tuple(dict.fromkeys(names)) or tuple(config.robots)


# ---------------------------------------------------------------------- board
def board_settings(config: Config) -> BoardSettings:
    from agentrob.board.settings import BoardSettings

    return BoardSettings.from_config(config.board, config.data_dir)


def serve_board(config: Config) -> None:
    """Run the embedded forum until SIGTERM or Ctrl-C; prints the ready line with its address."""
    from agentrob.board.server import serve
    from agentrob.wiring.command_reader import ReaderProcess

    log_to_stderr()
    serve(board_settings(config), ready=lambda settings: print_ready(url=settings.base_url), reader=ReaderProcess)


def board_account(config: Config, name: str, kind: AccountKind, role: Role) -> Account:
    """The account of that name, made when it is not there yet; works while the forum runs.

    `BoardError` 409 when it is there and is something else: a credential is never given out for another account.
    """
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    local_admin.ensure_database(settings)
    try:
        found = local_admin.find_account(settings, name)
    except BoardError as e:
        if e.status != 404:
            raise
        return local_admin.create_account(settings, name, kind=kind, role=role)
    if (found.kind, found.role) != (kind, role):
        what = f"{name!r} is there already, as {found.kind} with the role {found.role}"
        raise BoardError(409, "other_account", f"{what}; choose another name, or change it with: account change {name}")
    return found


def own_board_account(config: Config, name: str, kind: AccountKind, role: Role, display_name: str = "") -> Account:
    """The account of that name with this role and not suspended, whatever somebody changed; made when it is not there.

    `BoardError` 409 when the name belongs to another kind of account: its kind never changes.
    """
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    local_admin.bootstrap(settings)
    try:
        found = local_admin.find_account(settings, name)
    except BoardError as e:
        if e.status != 404:
            raise
        return local_admin.create_account(settings, name, kind=kind, role=role, display_name=display_name)
    if found.kind is not kind:
        what = f"the account {name!r} of this forum is a {found.kind}, and a {kind} is needed"
        raise BoardError(409, "other_account", what, f"start with another data folder; this one is {config.data_dir}")
    local_admin.change_account(settings, found, role=role, suspended=False)
    return local_admin.find_account(settings, name)


def own_board_robot(config: Config, name: str, owner: str) -> None:
    """Make `owner` the robot's owner on the forum, unless somebody else was made so since."""
    from agentrob.board.admin import local_admin

    local_admin.claim_robot(board_settings(config), name, owner)


def change_board_account(
    config: Config, name: str, role: Role | None, suspended: bool | None, commands_simulated: bool | None
) -> Account:
    """Change an account's role or right to command simulated robots, suspend it or let it in again."""
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    changes: dict[str, Any] = {"role": role, "suspended": suspended, "commands_simulated": commands_simulated}
    local_admin.change_account(settings, local_admin.find_account(settings, name), **changes)
    return local_admin.find_account(settings, name)


def board_token(config: Config, name: str, label: str = "", scopes: tuple[str, ...] = ("read", "write")) -> str:
    """A new bearer token of an account."""
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    return local_admin.issue_token(settings, local_admin.find_account(settings, name), label, scopes)


def revoke_board_tokens(config: Config, name: str, label: str | None = None) -> int:
    """Revoke the tokens of an account, all or those of one label; return how many."""
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    return local_admin.revoke_tokens(settings, local_admin.find_account(settings, name), label)


def board_link(config: Config, name: str) -> str:
    """A one-time sign-in address of this account."""
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    return settings.base_url + local_admin.issue_link(settings, local_admin.find_account(settings, name))


# ---------------------------------------------------------------------- agents
def make_agent(config: Config, name: str, forum: Forum | None = None, **more: Any) -> RobotAgent:
    """The agent of one robot, wired to the configured forum, mind and driver; `more` are arguments of its own."""
    from agentrob.agent.agent import RobotAgent
    from agentrob.agent.media.image_store import make_store
    from agentrob.agent.store.journals import make_journals
    from agentrob.robots.driver.remote import driver_client

    settings = config.robot(name)
    if "open_journal" not in more:
        more["open_journal"] = partial(make_journals(config.journal.database, config.data_dir).open, name)
    return RobotAgent(
        name=name,
        settings=settings,
        forum=forum if forum is not None else make_forum(config, secret(config, name)),
        driver=driver_client(name, settings),
        mind=make_mind(settings.mind, config),
        data=config.data_dir,
        store=make_store(config.images),
        opinion=make_second_opinion() if settings.harm_classifier else None,
        detector=make_detector(settings),
        worker=config.worker.name,
        **more,
    )


def make_detector(settings: RobotConfig) -> Detector | None:
    """The detector of a robot, found by its entry point; None if its owner wants none. Raises `ConfigError`."""
    name = settings.eyes.detector
    if not name:
        return None
    from agentrob.eyes.protocol import Detector

    detector = find("detectors", name)(settings.eyes.options)
    if not isinstance(detector, Detector):
        raise ConfigError(f"the detector {name!r} lacks one of things, colours and detect(picture): {detector!r}")
    return detector


def make_second_opinion() -> SecondOpinion | None:
    """The harm classifier beside the rules; None, and a line in the log, if it cannot be loaded."""
    import structlog

    from agentrob.agent.understanding.second_opinion import SecondOpinion
    from agentrob.semantic.harm_classifier import HarmDetector

    try:
        detector = HarmDetector()
    except ConfigError as e:
        structlog.get_logger().warning("no harm classifier; the rules decide alone", error=str(e))
        return None
    return SecondOpinion(detector.suspects, detector.close)


def run_agent(config: Config, name: str, once: bool) -> None:
    """Run an agent as a service until SIGTERM, Ctrl-C or `agentrob agent drain`, or one single scan."""
    from agentrob.worker.control import draining_on_request

    log_to_stderr()
    prefer_event_loop()
    metrics = make_metrics(config) if not once else None

    async def serve() -> None:
        agent = make_agent(config, name, **(metrics.hooks(name) if metrics else {}))

        def on_ready() -> None:
            print_ready(robot=name)
            if metrics is not None:
                metrics.serve(agent)

        running = asyncio.ensure_future(agent.once() if once else agent.run(on_ready))
        _cancel_on_signals(running)

        def drain() -> None:
            if agent.ready.is_set() and not once:
                agent.drain()
            else:
                running.cancel()

        try:
            async with draining_on_request(agent.activity.worker, [name], drain):
                await running
        except asyncio.CancelledError:
            pass
        finally:
            await agent.close()

    with offered(metrics, config):
        asyncio.run(serve())


def with_worker(config: Config, **given: str | None) -> Config:
    """The configuration with the given settings of `[worker]` (name, metrics). Raises `ConfigError`."""
    worker = config.worker.model_dump() | {key: value for key, value in given.items() if value is not None}
    return config.model_copy(update={"worker": configuration.parse({"worker": worker}, "command line").worker})


def make_metrics(config: Config) -> WorkerMetrics | None:
    """The metrics of a worker, if they are configured."""
    if not config.worker.metrics:
        return None
    from agentrob.worker.metrics import WorkerMetrics

    return WorkerMetrics()


@contextlib.contextmanager
def offered(metrics: WorkerMetrics | None, config: Config) -> Iterator[None]:
    """Offer the metrics, if there are some, while the block runs."""
    if metrics is None:
        yield
        return
    from agentrob.process.metrics import serving_metrics

    with serving_metrics(metrics.registry, config.worker.metrics):
        yield


def run_worker(config: Config, names: Sequence[str], most: int | None = None, standby: bool = False) -> None:
    """Run the agents of several robots in one process until SIGTERM, Ctrl-C or `agentrob agent drain`.

    Prints the ready line of each robot when its posts are answered; a standby prints one when it waits.
    """
    from agentrob.agent.reporting.activity import process_name
    from agentrob.agent.store.journal import Journal
    from agentrob.agent.store.journals import make_journals
    from agentrob.forums.http import shared_connections
    from agentrob.worker.control import draining_on_request
    from agentrob.worker.preload import preload
    from agentrob.worker.shared_events import SharedEvents
    from agentrob.worker.worker import Worker

    log_to_stderr()
    metrics = make_metrics(config)
    tokens = {name: secret(config, name) for name in names}
    if shared := [name for name in names if list(tokens.values()).count(tokens[name]) > 1]:
        raise ConfigError(f"{', '.join(shared)} have the same forum token; each robot needs an account of its own")
    preload()
    freeze_objects()
    prefer_event_loop()

    async def serve() -> None:
        events = SharedEvents()
        agents: dict[str, RobotAgent] = {}

        def report_ready(name: str) -> None:
            print_line(ready=True, robot=name)
            if metrics is not None:
                metrics.serve(agents[name])
            freeze_objects()  # of this agent; those of all that start together would take 0.1 s or more

        def make(name: str, journal: Journal) -> RobotAgent:
            async def opened() -> Journal:
                return journal

            forum = make_forum(config, tokens[name])
            more = metrics.hooks(name) if metrics else {}
            agent = make_agent(config, name, forum=forum, events=events.of(forum), open_journal=opened, **more)
            agents[name] = agent
            return agent

        async def sharing(worker: Worker) -> None:
            async with shared_connections():
                await worker.run()

        worker = Worker(
            names, make_journals(config.journal.database, config.data_dir), make, most, standby, report_ready, metrics,
        )  # fmt: skip
        running = asyncio.ensure_future(sharing(worker))
        _cancel_on_signals(running)
        if standby:
            print_line(ready=True, standby=list(names))
        with contextlib.suppress(asyncio.CancelledError):
            async with draining_on_request(config.worker.name or process_name(), worker.serving, worker.drain):
                await running

    with offered(metrics, config):
        asyncio.run(serve())


def drain_workers(names: Sequence[str]) -> Iterator[str]:
    """Drain the workers and agents of this machine that have these names or serve these robots, or all; lines for
    people, the last ones when they have ended. Raises `ConfigError` if there are none."""
    from agentrob.worker import control

    draining = control.drain(names)
    if not draining:
        raise ConfigError(f"no worker on this machine serves {', '.join(names) or 'a robot'}")
    for process in draining:
        yield f"{process.worker}: draining; it serves {', '.join(process.robots) or 'no robot'}"
    for process in draining:
        process.wait()
        yield f"{process.worker}: ended"


def _cancel_on_signals(task: asyncio.Future[Any]) -> None:
    for number in (signal.SIGTERM, signal.SIGINT):
        asyncio.get_running_loop().add_signal_handler(number, task.cancel)


def run_driver(config: Config, name: str, listen: str | None = None) -> None:
    """Hold one robot until SIGTERM or Ctrl-C. `listen` (host:port) replaces its `driver_listen`."""
    from agentrob.robots.driver.process import run_driver as run

    settings = config.robot(name)
    if listen is not None:
        settings = configuration.changed(settings, "--listen", driver_listen=listen)
    with contextlib.ExitStack() as stack:
        if settings.metrics:
            from agentrob.process.metrics import new_registry, serving_metrics
            from agentrob.wiring.driver_metrics import DriverCollector

            registry = new_registry()
            registry.register(DriverCollector(name))
            stack.enter_context(serving_metrics(registry, settings.metrics))
        run(name, settings, data=config.data_dir)


def stop(robot: str | None, config_file: Path | None) -> tuple[list[str], int]:
    """Stop one robot of the configuration, or all that drivers on this machine hold and all of the configuration whose
    drivers are elsewhere; lines for people, exit code.

    In doubt all are stopped: when the name is not configured, or the configuration cannot be read.
    """
    import getpass

    from agentrob.errors import RobotUnreachable
    from agentrob.robots.driver import stop as stopping

    who, lines = f"{getpass.getuser()} at the shell", []
    try:
        robots = load(config_file).robots
        doubt = f"{robot!r} is not in the configuration"
    except ConfigError as e:
        robots, doubt = {}, str(e)
    settings = None if robot is None else robots.get(robot)
    if robot is not None and settings is None:
        lines.append(f"{doubt}: stopping every robot on this machine")
    results: dict[str, StopResult | RobotUnreachable]
    if robot is None or settings is None:
        remote = {name: at for name, at in robots.items() if at.driver_url}
        results = stopping.stop_all(who, remote=remote)
        if not results:
            return [*lines, "no driver runs on this machine, so no robot is moved by us"], 0
    else:
        try:
            results = {robot: stopping.stop_robot(robot, settings, who)}
        except RobotUnreachable as e:
            results = {robot: e}
    for name, result in results.items():
        if isinstance(result, RobotUnreachable):
            lines.append(f"{name}: NOT STOPPED: {result}")
        else:
            rest = "stands still" if result.confirmed else "DID NOT CONFIRM that it stands still: use its own stop"
            lines.append(f"{name}: zero velocity commanded after {result.latency_ms:.0f} ms; {rest}")
    sure = all(isinstance(r, StopResult) and r.confirmed for r in results.values())
    return lines, 0 if sure else 1


def try_mind(config: Config, name: str, text: str, model: str) -> list[str]:
    """How a mind understands a text, and its usage, as lines for people. Nothing moves."""
    from agentrob.minds.extraction.trial import try_mind

    return asyncio.run(try_mind(make_mind(name, config), name, text, model, capabilities_of(model)))


def read_record(data: Path, robot: str, post_id: str) -> dict[str, Any]:
    """The agent's record of a command (law 19); empty if there is none."""
    path = data / "agents" / robot / "records" / f"{post_id}.json"
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    return record


def capabilities_of(model: str, settings: RobotConfig | None = None) -> Capabilities:
    """The capabilities of a kind of robot, without a connection to one."""
    kind = find("robots", model)
    if not callable(getattr(kind, "describe", None)):
        raise ConfigError(f"the robot {model!r} has no describe(settings), which says what it can do: {kind!r}")
    try:
        capabilities: Capabilities = kind.describe(settings or RobotConfig(model=model))
    except ValueError as e:
        raise ConfigError(f"the robot {model!r} declares what is not possible: {e}") from None
    if capabilities.declared:
        from agentrob.language.operations.clashes import refuse_clashes

        refuse_clashes(capabilities)
    return capabilities


def in_world(model: str) -> bool:
    """Whether the simulated world has a body for this kind of robot; any other brings its own."""
    from agentrob.sim.server import ROBOTS

    return model in ROBOTS


def simulated_robot(model: str, domain: int, world: str = "room") -> RobotConfig:
    """Settings of a robot in a simulated world, at home where it starts, with a description of what is in it.

    The G1 sees nothing around it: whoever runs the simulation is its owner, consents (law 8), and fences it in where
    the world says that nothing stands. A robot of another package is simulated by that package (`simulators.py`).
    Raises `SimError` when there is no such world, or no place in it, or when its simulation cannot run here.
    """
    from agentrob.sim.world.scene import load
    from agentrob.wiring.room_map import map_of
    from agentrob.wiring.simulators import prepared

    settings = RobotConfig(model=model, domain=domain, simulated=True, home_on_start=True)
    if not in_world(model):
        return prepared(settings)
    place = load(world)
    changes: dict[str, Any] = {"scene": place.in_words, "map": map_of(place, model)}
    changes["rehearsal"] = RehearsalConfig(world=world)
    if model == "g1" and (free := place.place(model).free) is not None:  # a world in which a G1 starts says so
        changes |= {"allow_unknown_ranges": True, "fence": free.fence}
    return settings.model_copy(update=changes)


# ---------------------------------------------------------------------- understanding
async def understand(text: str, name: str, capabilities: Any, mind: str = "rules", config: Config | None = None) -> Any:
    """How a mind, perhaps a configured one, understands a text for this robot."""
    from agentrob.language.visible_text import mentions, visible_text
    from agentrob.minds.protocol import Addressee, ManagedMind

    visible = visible_text(text)
    if name not in mentions(visible):
        visible = f"@{name} {visible}"
    others = tuple(other for other in mentions(visible) if other != name)
    made = make_mind(mind, config)
    try:
        return await made.understand(visible, Addressee((name,), others, capabilities))
    finally:
        if isinstance(made, ManagedMind):
            await made.close()


# ---------------------------------------------------------------------- world
def serve_world(
    robots: list[str], domains: list[str], world: str, interface: str, http_port: int, ledger: Path | None
) -> None:
    """Run a simulated world until SIGTERM or Ctrl-C. `domains` are ROBOT=DOMAIN, for robots that shall not have their
    usual one; without both there is a Go2."""
    from agentrob.sim.server import WorldSettings, choose_domains, serve

    settings = WorldSettings(
        domains=choose_domains(robots, domains), interface=interface, http_port=http_port, world=world, event_log=ledger
    )
    serve(settings)
