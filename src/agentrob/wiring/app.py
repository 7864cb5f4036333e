"""Build forums, minds, robots and agents from a configuration."""

from __future__ import annotations

import asyncio
import json
import os
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

from agentrob.config import load as configuration
from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.errors import BoardError, ConfigError
from agentrob.model import Account, AccountKind, Capabilities, Role, StopResult
from agentrob.plugins import find
from agentrob.process.child import print_ready
from agentrob.process.logs import log_to_stderr

if TYPE_CHECKING:
    from agentrob.agent.agent import RobotAgent
    from agentrob.agent.understanding.second_opinion import SecondOpinion
    from agentrob.board.settings import BoardSettings
    from agentrob.forums.protocol import Forum
    from agentrob.minds.llm.probe import ProbeResult
    from agentrob.minds.protocol import Mind

load = configuration.load


def make_forum(config: Config, token: str) -> Forum:
    """The configured forum, signed in by a token."""
    forum: Forum = find("forums", config.forum.kind)(config.forum, token)
    return forum


def make_mind(name: str, config: Config | None = None) -> Mind:
    """A mind of the configuration, or one found by its entry point."""
    minds = config.minds if config else {}
    if config and name in minds:
        from agentrob.minds.extraction.mind import ModelMind
        from agentrob.minds.llm.fallback import model_with_fallbacks

        chain = model_with_fallbacks(name, minds, minds_ledger(config))
        return ModelMind(chain, rules_first=minds[name].reads == "unclear")
    try:
        mind: Mind = find("minds", name)()
    except ConfigError as e:
        configured = f"; configured as [minds.NAME]: {', '.join(sorted(minds)) or 'none'}"
        raise ConfigError(f"{e}{configured}") from None
    return mind


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


def secret(config: Config) -> str:
    """The agent's token, from the environment."""
    token = os.environ.get(config.forum.token_env, "")
    if not token:
        raise ConfigError(f"the environment variable {config.forum.token_env} must hold the agent's forum token")
    return token


def only_robot(config: Config, name: str | None) -> str:
    """The robot of this name, or the only one of the configuration."""
    if name is not None:
        config.robot(name)
        return name
    if len(config.robots) == 1:
        return next(iter(config.robots))
    known = ", ".join(sorted(config.robots)) or "none is configured"
    raise ConfigError(f"which robot? Name one of: {known}")


# ---------------------------------------------------------------------- board
def board_settings(config: Config) -> BoardSettings:
    from agentrob.board.settings import BoardSettings

    return BoardSettings.from_config(config.board, config.data_dir)


def serve_board(config: Config) -> None:
    """Run the embedded forum until SIGTERM or Ctrl-C; prints the ready line with its address."""
    from agentrob.board.server import serve

    log_to_stderr()
    serve(board_settings(config), ready=lambda settings: print_ready(url=settings.base_url))


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


def change_board_account(config: Config, name: str, role: Role | None, suspended: bool | None) -> Account:
    """Give an account another role, suspend it or let it in again."""
    from agentrob.board.admin import local_admin

    settings = board_settings(config)
    local_admin.change_account(settings, local_admin.find_account(settings, name), role=role, suspended=suspended)
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
def make_agent(config: Config, name: str, **more: Any) -> RobotAgent:
    """The agent of one robot, wired to the configured forum, mind and driver; `more` are arguments of its own."""
    from agentrob.agent.agent import RobotAgent
    from agentrob.agent.media.image_store import make_store
    from agentrob.robots.driver.client import DriverClient

    settings = config.robot(name)
    return RobotAgent(
        name=name,
        settings=settings,
        forum=make_forum(config, secret(config)),
        driver=DriverClient(name),
        mind=make_mind(settings.mind, config),
        data=config.data_dir,
        store=make_store(config.images),
        opinion=make_second_opinion() if settings.harm_classifier else None,
        **more,
    )


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
    """Run an agent as a service until SIGTERM or Ctrl-C, or one single scan."""

    log_to_stderr()

    async def serve() -> None:
        agent = make_agent(config, name)
        running = asyncio.ensure_future(agent.once() if once else agent.run())
        for sign in (signal.SIGTERM, signal.SIGINT):
            asyncio.get_running_loop().add_signal_handler(sign, running.cancel)
        try:
            if not once:
                readying = asyncio.ensure_future(agent.ready.wait())
                await asyncio.wait((readying, running), return_when=asyncio.FIRST_COMPLETED)
                readying.cancel()
                if not running.done():
                    print_ready(robot=name)
            await running
        except asyncio.CancelledError:
            pass
        finally:
            await agent.close()

    asyncio.run(serve())


def run_driver(config: Config, name: str) -> None:
    """Hold one robot until SIGTERM or Ctrl-C."""
    from agentrob.robots.driver.process import run_driver as run

    run(name, config.robot(name), data=config.data_dir)


def stop(robot: str | None, config_file: Path | None) -> tuple[list[str], int]:
    """Stop one robot of the configuration, or all that drivers on this machine hold; lines for people, exit code.

    In doubt all are stopped: when the name is not configured, or the configuration cannot be read.
    """
    import getpass

    from agentrob.errors import RobotUnreachable
    from agentrob.robots.driver import stop as stopping

    who, lines, settings = f"{getpass.getuser()} at the shell", [], None
    if robot is not None:
        try:
            settings = load(config_file).robots.get(robot)
            doubt = f"{robot!r} is not in the configuration"
        except ConfigError as e:
            doubt = str(e)
        if settings is None:
            lines.append(f"{doubt}: stopping every robot on this machine")
    results: dict[str, StopResult | RobotUnreachable]
    if robot is None or settings is None:
        results = stopping.stop_all(who)
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
    """What a kind of robot can do, without connecting to one."""
    kind = find("robots", model)
    if not callable(getattr(kind, "describe", None)):
        raise ConfigError(f"the robot {model!r} has no describe(settings), which says what it can do: {kind!r}")
    capabilities: Capabilities = kind.describe(settings or RobotConfig(model=model))
    return capabilities


def in_world(model: str) -> bool:
    """Whether the simulated world has a body for this kind of robot; any other brings its own."""
    from agentrob.sim.server import ROBOTS

    return model in ROBOTS


def simulated_robot(model: str, domain: int, world: str = "room") -> RobotConfig:
    """Settings of a robot in a simulated world, at home where it starts, told of what is in it.

    The G1 sees nothing around it: whoever runs the simulation is its owner, consents (law 8), and fences it in where
    the world says that nothing stands. Raises `SimError` when there is no such world, or no place in it.
    """
    from agentrob.sim.world.scene import load

    settings = RobotConfig(model=model, domain=domain, simulated=True, home_on_start=True)
    if not in_world(model):
        return settings
    place = load(world)
    changes: dict[str, Any] = {"scene": place.in_words}
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


def plan_text(text: str, model: str) -> dict[str, Any]:
    """How a robot of this kind would understand a text, as data: intent, steps, notes, question, verdict."""
    from agentrob.language.visible_text import mentions, visible_text
    from agentrob.model import Intent
    from agentrob.screening.screen import screen

    capabilities = capabilities_of(model)
    named = mentions(visible_text(text))
    understood = asyncio.run(understand(text, named[0] if named else model, capabilities))
    facts: dict[str, Any] = {
        "intent": str(understood.intent),
        "language": understood.language,
        "plan": understood.plan.as_data(),
        "notes": list(understood.plan.notes),
        "question": understood.question,
    }
    if understood.intent is Intent.COMMAND:
        author = Account(id="local", name="local", role=Role.OPERATOR)
        verdict = screen(
            understood.plan, text=text, author=author, capabilities=capabilities, language=understood.language
        )
        facts["verdict"] = {"decision": str(verdict.decision), "rule": verdict.rule, "reason": verdict.reason}
    return facts


def describe_plan(facts: dict[str, Any]) -> str:
    """`plan_text` for people."""
    lines = [f"{facts['intent']}"]
    for n, step in enumerate(facts["plan"], 1):
        details = " ".join(f"{k}={v}" for k, v in step.items() if k != "op")
        lines.append(f"  {n}. {step['op']} {details}".rstrip())
    lines += [f"  note: {note}" for note in facts["notes"]]
    if facts["question"]:
        lines.append(f"  it would answer: {facts['question']}")
    if verdict := facts.get("verdict"):
        lines.append(f"  verdict: {verdict['decision']} ({verdict['rule']}) {verdict['reason']}".rstrip())
    return "\n".join(lines)


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
