"""The questions, files and errors of `agentrob init`."""

from __future__ import annotations

import io
import json
import os
import re
import shlex
import socket
from pathlib import Path

import pytest
from rich.console import Console

from agentrob.config import load as configuration
from agentrob.setup import dialogue, service_manager, units
from agentrob.setup.answers import Answers, RobotAnswers, Services
from agentrob.setup.dialogue import Dialogue
from agentrob.setup.service_manager import SetupError
from tests.host_numbers import free_port
from tests.in_process import agentrob

#: Stands for an address where nothing listens.
FREE = "a free address"
ALL = ("admin", "title", "listen", "robot", "services", "walk")


def answered(*lines: str, asked: tuple[str, ...] = ALL, given: Answers | None = None) -> tuple[Answers, str]:
    """Answer the questions with these lines; return the answers and what was shown."""
    shown = io.StringIO()
    console = Console(file=shown, width=200, highlight=False)
    stream = io.StringIO("".join(f"{line}\n" for line in lines))
    return Dialogue(console, stream).complete(given or Answers(""), asked=asked), shown.getvalue()


# ------------------------------------------------------------------ the dialogue
def test_a_simulated_robot_needs_few_answers() -> None:
    listen = f"127.0.0.1:{free_port()}"
    answers, shown = answered("chief", "Lab", listen, "simulated", "spot", "g1", "none")
    assert answers == Answers("chief", title="Lab", listen=listen, robot=RobotAnswers("spot", "g1"))
    assert "walk" not in shown, "nothing would run that could walk"


def test_a_real_robot_is_asked_for_its_network_and_walks_only_if_somebody_watches_it() -> None:
    answers, shown = answered("real", "rex", "go2", "lo", "0", "user", "", asked=("robot", "services", "walk"))
    assert answers.robot == RobotAnswers("rex", "go2", False, "lo", 0)
    assert answers.services is Services.USER
    assert "somebody at its remote" in shown
    assert not answers.walk, "not without a yes"


@pytest.mark.parametrize(
    ("asked", "lines", "said"),
    [
        ("admin", ["Big Chief", "chief"], "'Big Chief' is not valid: 2 to 32 of a-z"),
        ("listen", ["nowhere", FREE], "nowhere"),
        ("listen", ["0.0.0.0:70000", FREE], "70000"),
        ("robot", ["real", "rex", "go2", "nosuch0", "lo", "400", "0"], "'nosuch0' is not on this machine; valid: lo"),
        ("robot", ["real", "rex", "go2", "lo", "400", "0"], "'400' is not a DDS domain; valid: 0 to 230"),
    ],
)
def test_an_answer_that_is_not_valid_is_asked_again(asked: str, lines: list[str], said: str) -> None:
    free = f"127.0.0.1:{free_port()}"
    _, shown = answered(*(free if line == FREE else line for line in lines), asked=(asked,))
    assert said in shown


def test_what_an_option_gave_is_not_asked() -> None:
    given = Answers("", robot=RobotAnswers("rex"), services=Services.USER, title="Lab", walk=True)
    answers, shown = answered("chief", asked=("admin",), given=given)
    assert answers.robot == RobotAnswers("rex")
    assert shown.count("?") + shown.count(":") <= 2, shown


def test_without_a_service_manager_nothing_is_proposed(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert dialogue.available() is Services.NONE


# ------------------------------------------------------------------ by options
def test_by_options_a_robot_is_added_and_the_commands_that_start_it_are_told(tmp_path: Path) -> None:
    options = ("--admin", "chief", "--data", "./data", "--robot", "rex", "--model", "g1", "--domain", "7")
    done = agentrob(tmp_path, "init", *options)
    assert done.returncode == 0, done.stderr
    config = configuration.load(tmp_path / "agentrob.toml")
    rex = config.robots["rex"]
    assert (rex.model, rex.domain, rex.simulated, rex.owner, rex.home_on_start) == ("g1", 7, True, "chief", True)
    commands = [line.partition("agentrob ")[2] for line in done.stdout.splitlines() if line.startswith("   then: ")]
    assert commands == [
        "board serve --config agentrob.toml",
        "sim --robot g1 --domain g1=7",
        "driver rex --config agentrob.toml",
        "agent run rex --config agentrob.toml",
    ]
    tokens = (tmp_path / "data/agents.env").read_text()
    assert re.fullmatch(r"AGENTROB_TOKEN_REX=agentrob_\S+\n", tokens)
    assert tokens.strip().partition("=")[2] not in done.stdout
    owner = agentrob(tmp_path, "board", "robot", "show", "rex").stdout
    assert "owner: chief\n" in owner


def test_a_real_robot_begins_with_the_limits_of_its_first_day(tmp_path: Path) -> None:
    done = agentrob(tmp_path, "init", "--admin", "chief", "--data", "./data", "--robot", "rex", "--interface", "eth7")
    assert done.returncode == 0, done.stderr
    rex = configuration.load(tmp_path / "agentrob.toml").robots["rex"]
    assert (rex.simulated, rex.interface, rex.domain, rex.home_on_start) == (False, "eth7", 0, False)
    assert (rex.limits.speed_mps, rex.limits.command_m, rex.least_battery_percent) == (0.2, 1.0, 30)
    assert rex.fence.x_max_m - rex.fence.x_min_m <= 1.5
    assert "agentrob sim" not in done.stdout


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "there is no terminal to ask on; give the first admin's handle: --admin NAME"),
        (("--admin", "chief", "--walk"), "--walk needs --robot NAME and --services"),
        (("--admin", "chief", "--robot", "Rex!"), "robots.Rex!"),
        (("--admin", "chief", "--robot", "rex", "--model", "unicorn"), "installed robots: fake, g1, go2"),
        (("--admin", "chief", "--listen", "nowhere"), "nowhere"),
    ],
)
def test_an_invalid_option_is_refused_before_anything_is_written(
    tmp_path: Path, options: tuple[str, ...], said: str
) -> None:
    done = agentrob(tmp_path, "init", "--data", "./data", *options)
    assert done.returncode == 1
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


def test_an_address_that_another_program_uses_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        listen = f"127.0.0.1:{other.getsockname()[1]}"
        options = ("--admin", "chief", "--data", "./data", "--services", "user", "--listen", listen)
        done = agentrob(tmp_path, "init", *options)
        free = f"127.0.0.1:{free_port()}"
        answers, shown = answered(listen, free, asked=("listen",))
    assert done.returncode == 1
    assert f"{listen} is in use" in done.stderr
    assert "choose another (--listen)" in done.stderr
    assert not list(tmp_path.iterdir())
    assert answers.listen == free
    assert f"{listen} is in use" in shown


# ------------------------------------------------------------------ units and containers
PLACE = units.Place(("/opt/a b/python", "-m", "agentrob"), Path("/etc/ag%rob/agentrob.toml"), Path("/data"),
                    Path("/data/agents.env"), environment={"AGENTROB_DATA": "/my data"})  # fmt: skip


def test_the_units_start_the_processes_in_order_and_only_the_agent_reads_tokens() -> None:
    board, world, driver, agent = units.processes(PLACE.config, "rex", ("sim", "--robot", "go2"))
    assert (driver.after, agent.after) == ((world.name,), (board.name, driver.name))
    texts = {process.name: units.systemd_unit(process, PLACE) for process in (board, world, driver, agent)}
    assert [name for name, text in texts.items() if "EnvironmentFile" in text] == ["agentrob-agent-rex"]
    text = texts["agentrob-agent-rex"]
    words = shlex.split(re.findall("^ExecStart=(.*)$", text, re.MULTILINE)[0].replace("%%", "%"))
    assert words == [*PLACE.program, "agent", "run", "rex", "--config", "/etc/ag%rob/agentrob.toml"]
    assert 'Environment="AGENTROB_DATA=/my data"' in text
    assert "After=agentrob-board.service agentrob-driver-rex.service" in text
    assert "Restart=on-failure" in text, "not after agentrob agent drain"
    assert "WantedBy=default.target" in text


def test_a_real_robot_has_no_world_and_a_forum_may_have_no_robot() -> None:
    names = [process.name for process in units.processes(PLACE.config, "rex", ())]
    assert names == ["agentrob-board", "agentrob-driver-rex", "agentrob-agent-rex"]
    assert [process.name for process in units.processes(PLACE.config, "", ())] == ["agentrob-board"]


def test_units_of_the_machine_run_as_a_user_and_share_a_folder_for_sockets() -> None:
    place = units.Place(PLACE.program, PLACE.config, PLACE.data, PLACE.tokens, "ann", {"AGENTROB_RUNTIME": "/run"})
    text = units.systemd_unit(units.processes(PLACE.config, "", ())[0], place)
    for line in ("User=ann", "RuntimeDirectory=agentrob", "RuntimeDirectoryPreserve=yes", "WantedBy=multi-user.target"):
        assert line in text.splitlines()


def test_the_containers_share_the_hosts_network_and_the_folders() -> None:
    place = units.Place((), Path("/home/ann/$x/agentrob.toml"), Path("/data"), Path("/data/agents.env"), "1000:1000",
                        {"AGENTROB_RUNTIME": "/run/user/1000"})  # fmt: skip
    text = units.compose_file(units.processes(place.config, "rex", ()), place, "agentrob")
    services, name = dict[str, dict[str, object]](), ""
    for line in text.partition("services:\n")[2].splitlines():
        key, _, value = line.strip().partition(": ")
        if value:
            services[name][key] = json.loads(value.replace("$$", "$"))
        else:
            name = key.removesuffix(":")
            services[name] = {}
    assert list(services) == ["board", "driver-rex", "agent-rex"]
    assert all(one["network_mode"] == "host" and one["user"] == "1000:1000" for one in services.values())
    assert services["board"]["volumes"] == [f"{p}:{p}" for p in ("/data", "/home/ann/$x", "/run/user/1000")]
    assert [name for name, one in services.items() if "env_file" in one] == ["agent-rex"]
    assert services["agent-rex"]["depends_on"] == ["board", "driver-rex"]


def test_an_error_of_the_service_manager_is_told_with_its_command(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "systemctl").write_text("#!/bin/sh\necho 'Failed to connect to bus' >&2\nexit 1\n")
    (tmp_path / "systemctl").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    with pytest.raises(SetupError, match="systemctl --user daemon-reload failed: Failed to connect to bus"):
        service_manager.install(Services.USER, units.processes(PLACE.config, "", ()), PLACE)


def test_without_an_image_the_command_that_builds_it_is_told(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "docker").write_text("#!/bin/sh\necho 'No such image: agentrob' >&2\nexit 1\n")
    (tmp_path / "docker").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    monkeypatch.setenv("AGENTROB_RUNTIME", str(tmp_path))
    place = service_manager.place_of(Services.COMPOSE, tmp_path / "agentrob.toml", tmp_path, tmp_path / "agents.env")
    with pytest.raises(SetupError, match=r"no image 'agentrob' .*docker build -f deploy/Dockerfile -t agentrob \."):
        service_manager.install(Services.COMPOSE, units.processes(place.config, "", ()), place)
    assert (tmp_path / "compose.yaml").exists()
    with pytest.raises(SetupError, match="already exists"):
        service_manager.install(Services.COMPOSE, units.processes(place.config, "", ()), place)
