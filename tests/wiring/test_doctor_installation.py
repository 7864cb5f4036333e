"""`agentrob doctor` without a robot: the forum, its services, and the agent of each robot, with what mends them."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from agentrob.config import load as configuration
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.wiring.doctor import installation, robot
from tests.deploy.command_line import parse_command
from tests.forked_process import ForkedCommand, end_all
from tests.in_process import agentrob


def doctor(folder: Path, *words: str, **env: str) -> tuple[int, dict[str, Any]]:
    """Run it in a folder; return its exit code and what it found."""
    done = agentrob(folder, "doctor", *words, "--json", AGENTROB_RUNTIME=str(folder / "run"), **env)
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)


def by_check(findings: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {one["check"]: one for one in findings}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a forum and a fake robot, of which nothing runs."""
    for variable in ("AGENTROB_TOKEN", "AGENTROB_TOKEN_REX"):
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("AGENTROB_DATA", str(tmp_path / "data"))
    options = ("--robot", "rex", "--model", "fake", "--listen", "127.0.0.1:1", "--data", str(tmp_path / "data"))
    done = agentrob(tmp_path, "init", "--admin", "chief", *options)
    assert done.returncode == 0, done.stderr
    return tmp_path


def test_without_a_configuration_it_says_how_to_begin(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AGENTROB_DATA", str(tmp_path / "data"))
    code, told = doctor(tmp_path)
    assert code == 1
    (only,) = told["findings"]
    assert (only["check"], only["status"], only["command"]) == ("configuration", "bad", "agentrob init")
    assert told["robots"] == []


def test_each_finding_of_a_forum_that_does_not_run_names_a_valid_command(folder: Path) -> None:
    code, told = doctor(folder)
    assert code == 1
    forum = by_check(told["findings"])
    assert (forum["database"]["status"], forum["forum"]["status"]) == ("ok", "bad")
    assert forum["forum"]["command"] == "agentrob board serve"
    (rex,) = told["robots"]
    found = by_check(rex["findings"])
    assert found["account"]["status"] == "ok"
    start = f"set -a; . {folder}/data/agents.env; agentrob agent run rex"
    assert (found["agent"]["status"], found["agent"]["command"]) == ("bad", start)
    *_, rex = doctor(folder, AGENTROB_TOKEN_REX="known")[1]["robots"]
    assert by_check(rex["findings"])["agent"]["command"] == "agentrob agent run rex"
    for one in (*told["findings"], *rex["findings"]):
        assert one["status"] == "ok" or one["command"], one
        if one["command"].startswith("agentrob "):
            parse_command(shlex.split(one["command"])[1:])


def test_commands_name_the_configuration_that_was_given(folder: Path) -> None:
    file = str(folder / "agentrob.toml")
    _, told = doctor(folder, "--config", file)
    assert by_check(told["findings"])["forum"]["command"] == f"agentrob board serve --config {file}"


def test_an_account_that_is_missing_or_suspended_is_found(folder: Path) -> None:
    config = configuration.load(folder / "agentrob.toml")
    agentrob(folder, "board", "account", "change", "rex", "--suspend")
    suspended = installation.of_agent(config, "rex")[0]
    assert (suspended.check, suspended.status) == ("account", Status.BAD)
    assert suspended.command == "agentrob board account change rex --unsuspend"
    missing = installation.of_agent(config.model_copy(update={"robots": {"ada": config.robots["rex"]}}), "ada")[0]
    assert missing.command == "agentrob board account add ada --kind robot_agent"


def test_the_token_of_init_is_found_without_the_environment(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = configuration.load(folder / "agentrob.toml")
    assert installation.token_of(config, "rex").startswith("agentrob_")
    monkeypatch.setenv("AGENTROB_TOKEN_REX", "another")
    assert installation.token_of(config, "rex") == "another"


def test_a_unit_that_does_not_run_is_named_with_its_log(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    units, program = folder / "config/systemd/user", folder / "systemctl"
    units.mkdir(parents=True)
    for name in ("agentrob-board", "agentrob-agent-rex"):
        (units / f"{name}.service").write_text("[Service]\n")
    program.write_text("#!/bin/sh\ncase $3 in *agent-rex*) echo failed; exit 3;; *) echo active;; esac\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    agent, board = installation.of_services({"XDG_CONFIG_HOME": str(folder / "config")})
    assert (board.status, board.found) == (Status.OK, "agentrob-board.service is active")
    assert (agent.status, agent.command) == (Status.BAD, "systemctl --user restart agentrob-agent-rex.service")
    assert "journalctl --user -u agentrob-agent-rex.service" in agent.advice


def test_what_only_hands_can_mend_names_the_command_that_checks_again() -> None:
    found = [Finding("battery", Status.BAD, "3 %", "Charge it."), Finding("mode", Status.OK, "idle")]
    assert [one.command for one in robot.with_commands(found, "agentrob doctor rex")] == ["agentrob doctor rex", ""]


# ------------------------------------------------------------------ a forum that runs
@pytest.fixture
def running(folder: Path) -> Iterator[Path]:
    """Start the forum, driver and agent of the folder."""
    env = {"AGENTROB_RUNTIME": str(folder / "run")}
    config = folder / "agentrob.toml"
    config.write_text(config.read_text().replace("127.0.0.1:1", "127.0.0.1:0"))
    board = ForkedCommand(folder, "board", "serve", log=folder / "board.log", **env)
    processes = [board]
    try:
        config.write_text(config.read_text().replace("127.0.0.1:0", board.ready["url"].removeprefix("http://")))
        token = (folder / "data/agents.env").read_text().strip().partition("=")[2]
        processes.append(ForkedCommand(folder, "driver", "rex", log=folder / "driver.log", **env))
        assert processes[-1].ready
        agent = ForkedCommand(folder, "agent", "run", "rex", log=folder / "agent.log", AGENTROB_TOKEN=token, **env)
        processes.append(agent)
        assert agent.ready
        yield folder
    finally:
        end_all(processes)


def test_a_whole_installation_that_works_is_told_as_such_and_a_wrong_token_is_found(running: Path) -> None:
    code, told = doctor(running)
    (rex,) = told["robots"]
    found = by_check([*told["findings"], *rex["findings"]])
    assert {found[check]["status"] for check in ("database", "forum", "account", "token", "agent", "driver")} == {"ok"}
    assert found["agent"]["found"].endswith(" serves it")
    assert code == 0, told
    _, told = doctor(running, AGENTROB_TOKEN_REX="agentrob_wrong")
    wrong = by_check(told["robots"][0]["findings"])["token"]
    assert (wrong["status"], wrong["command"]) == ("bad", "agentrob board account token rex")
