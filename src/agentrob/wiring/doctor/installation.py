"""Find what keeps a forum and the agents of its robots from working, and the command that mends it. Changes nothing."""

from __future__ import annotations

import asyncio
import shlex
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import urlsplit

import httpx2

from agentrob.config.load import Config
from agentrob.errors import AgentRobError, BoardError, ConfigError, ForumDenied
from agentrob.forums.protocol import Fleet
from agentrob.process.listen import is_loopback
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.wiring import app
from agentrob.worker import control

#: Written by `agentrob init` into the data folder.
TOKENS = "agents.env"
_ANSWER_S = 5.0


def of_configuration(config: Config, file: Path | None) -> Finding:
    """Whether there is a configuration."""
    file = file or Path("agentrob.toml")
    if not config.robots and not file.exists():
        advice = "Name another one with --config, or create a forum with a robot."
        return Finding("configuration", Status.BAD, f"there is no {file}, and no demo runs", advice, "agentrob init")
    robots = ", ".join(sorted(config.robots)) or "no robot"
    return Finding("configuration", Status.OK, f"{robots}; data in {config.data_dir}")


def of_forum(config: Config) -> list[Finding]:
    """The forum's database, if it is on this machine, and whether the forum answers."""
    if config.forum.kind != "board":
        return [_other_forum(config)]
    here = is_loopback(urlsplit(config.forum.url).hostname or "")
    database = [_database(config)] if here else []
    start = "agentrob board serve" if here else f"curl {config.forum.url}/healthz"
    try:
        httpx2.get(f"{config.forum.url}/healthz", timeout=_ANSWER_S).raise_for_status()
    except httpx2.HTTPStatusError as e:
        found = f"{config.forum.url} answers {e.response.status_code}"
        return [*database, Finding("forum", Status.BAD, found, "Its log says why; its database may be missing.", start)]
    except httpx2.HTTPError as e:
        found = f"nothing answers at {config.forum.url} ({type(e).__name__})"
        return [*database, Finding("forum", Status.BAD, found, "Start the forum.", start)]
    return [*database, Finding("forum", Status.OK, f"it answers at {config.forum.url}")]


def _database(config: Config) -> Finding:
    from agentrob.board.db.database import check_version

    settings = app.board_settings(config)
    try:
        there = check_version(settings)
    except BoardError as e:
        mend = "agentrob board migrate" if e.status == 409 else "agentrob board serve"
        return Finding("database", Status.BAD, str(e), e.hint or "Its server may be down.", mend)
    if not there:
        found = f"there is none yet in {settings.database_shown}"
        return Finding("database", Status.BAD, found, "The forum creates it.", "agentrob board serve")
    return Finding("database", Status.OK, settings.database_shown)


def _other_forum(config: Config) -> Finding:
    """Whether a forum of another kind answers."""
    where = f"{config.forum.kind} at {config.forum.url}"
    token = next((found for name in config.robots if (found := token_of(config, name))), "")
    if not token:
        return Finding(
            "forum", Status.UNKNOWN, f"{where} was not asked: no robot's token is known here", *_no_token(config)
        )
    try:
        asyncio.run(_ask(config, token))
    except (AgentRobError, TimeoutError) as e:
        why = str(e) or f"no answer within {_ANSWER_S:g} s"
        return Finding(
            "forum", Status.BAD, f"{where}: {why}", "Start it, or correct url in [forum].", f"curl {config.forum.url}"
        )
    return Finding("forum", Status.OK, f"{where} answers")


async def _ask(config: Config, token: str) -> None:
    """Make a request as the account of this token. Raises `ForumError`, or `TimeoutError` after `_ANSWER_S`."""
    forum = app.make_forum(config, token)
    try:
        async with asyncio.timeout(_ANSWER_S):
            await forum.now()
    finally:
        await forum.close()


# ---------------------------------------------------------------------- services
def of_services(environment: Mapping[str, str]) -> list[Finding]:
    """Whether the units that `agentrob init` wrote run."""
    if shutil.which("systemctl") is None:
        return []
    home = Path(environment.get("XDG_CONFIG_HOME") or Path(environment.get("HOME", "/")) / ".config")
    found = []
    for folder, systemctl in (
        (home / "systemd/user", ["systemctl", "--user"]),
        (Path("/etc/systemd/system"), ["systemctl"]),
    ):
        for unit in sorted(folder.glob("agentrob-*.service")):
            if unit.name == "agentrob-backup.service":
                continue  # it runs once a day
            asked = subprocess.run([*systemctl, "is-active", unit.name], capture_output=True, text=True, check=False)
            state = asked.stdout.strip() or asked.stderr.strip().partition("\n")[0] or "unknown"
            log = f"Its log: journalctl {'--user ' if '--user' in systemctl else ''}-u {unit.name}"
            mend = f"{' '.join(systemctl)} restart {unit.name}"
            good = state == "active"
            found.append(
                Finding(
                    "service",
                    Status.OK if good else Status.BAD,
                    f"{unit.name} is {state}",
                    "" if good else log,
                    "" if good else mend,
                )
            )
    return found


# ---------------------------------------------------------------------- the agent of one robot
def of_agent(config: Config, name: str) -> list[Finding]:
    """The robot's account and token, and whether an agent serves it."""
    token, served = token_of(config, name), control.serving().get(name, "")
    account = _account(config, name)
    checked = [] if not token else [_token(config, name, token)]
    if not served and token:
        served = _served_elsewhere(config, name, token)
    if served:
        return [*account, *checked, Finding("agent", Status.OK, f"{served} serves it")]
    if not token:
        checked = [
            Finding("token", Status.UNKNOWN, "the token of its account is not known here", *_no_token(config, name))
        ]
    advice = "Posts are not answered until then."
    return [
        *account,
        *checked,
        Finding("agent", Status.BAD, "no agent serves it", advice, _start_agent(config, name)),
    ]


def _start_agent(config: Config, name: str) -> str:
    """The command that starts the agent; it loads the file of `agentrob init` if only that has the token."""
    start = f"agentrob agent run {name}"
    try:
        app.secret(config, name)
    except ConfigError:
        if token_of(config, name):
            return f"set -a; . {shlex.quote(str(config.data_dir / TOKENS))}; {start}"
    return start


def token_of(config: Config, name: str) -> str:
    """The token of a robot's account: from the environment, or from the file of `agentrob init`; else empty."""
    try:
        return app.secret(config, name)
    except ConfigError:
        variable = app.token_variable(config, name)
    try:
        lines = (config.data_dir / TOKENS).read_text(encoding="utf-8").splitlines()
    except OSError:
        return ""
    return next((line.partition("=")[2] for line in reversed(lines) if line.startswith(f"{variable}=")), "")


def _no_token(config: Config, name: str = "") -> tuple[str, str]:
    """The advice and the command where no token is known."""
    variable = app.token_variable(config, name)
    if config.forum.kind == "board" and name:
        return f"Put a new one into {variable}.", f"agentrob board account token {name}"
    return f"Put the token that the forum gave its account into {variable}.", f"export {variable}=…"


def _account(config: Config, name: str) -> list[Finding]:
    """Whether the robot has an account, if the forum's database is on this machine."""
    from agentrob.board.db.database import check_version, open_engine
    from agentrob.board.db.reader import Reader

    if config.forum.kind != "board" or not is_loopback(urlsplit(config.forum.url).hostname or ""):
        return []
    settings = app.board_settings(config)
    try:
        if not check_version(settings):
            return []
    except BoardError:
        return []  # reported as a finding about the database
    engine = open_engine(settings, writes=False)
    try:
        with engine.connect() as connection:
            account = Reader(connection).account(name)
    finally:
        engine.dispose()
    if account is None:
        add = f"agentrob board account add {name} --kind robot_agent"
        return [
            Finding("account", Status.BAD, f"the forum has no account {name}", "Create it; this prints its token.", add)
        ]
    if account.suspended:
        lift = f"agentrob board account change {name} --unsuspend"
        return [Finding("account", Status.BAD, f"the account {name} is suspended", "End the suspension.", lift)]
    return [Finding("account", Status.OK, f"@{name}, {account.kind}")]


def _token(config: Config, name: str, token: str) -> Finding:
    """Whether the forum accepts the token."""
    try:
        asyncio.run(_ask(config, token))
    except ForumDenied as e:
        return Finding("token", Status.BAD, f"the forum refuses its token: {e}", *_no_token(config, name))
    except (AgentRobError, TimeoutError):
        return Finding("token", Status.UNKNOWN, "not checked: the forum does not answer")
    return Finding("token", Status.OK, "the forum accepts it")


def _served_elsewhere(config: Config, name: str, token: str) -> str:
    """The worker that serves the robot by its card on the forum; empty if none does or the forum does not tell."""

    async def read() -> str:
        forum = app.make_forum(config, token)
        try:
            if not isinstance(forum, Fleet):
                return ""
            async with asyncio.timeout(_ANSWER_S):
                return next((one.worker for one in await forum.fleet() if one.name == name and one.served), "")
        finally:
            await forum.close()

    try:
        return asyncio.run(read())
    except (AgentRobError, TimeoutError):
        return ""
