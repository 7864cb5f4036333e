"""`agentrob driver --listen`, and the commands that reach a driver on another machine, as a person types them."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from uuid import uuid4

import pytest

from tests import in_process
from tests.forked_process import ForkedCommand, agentrob, end_all
from tests.robots.driver.network_scene import TOKEN, TOKEN_ENV

NEAR = """
data = "{data}"
[robots.{name}]
model = "fake"
domain = {domain}
simulated = true
home_on_start = true
driver_token_env = "{variable}"
"""
FAR = """
[robots.{name}]
model = "fake"
driver_url = "http://{listen}"
driver_token_env = "{variable}"
"""


@dataclass
class Machines:
    """The folder of an agent's machine, and the name of a robot whose driver runs on another one."""

    folder: Path
    name: str

    def type(self, *words: str, token: str = TOKEN) -> tuple[int, str]:
        env = {"AGENTROB_RUNTIME": str(self.folder), "AGENTROB_DATA": str(self.folder), TOKEN_ENV: token}
        done = agentrob(self.folder, *words, **env)
        return done.returncode, (done.stdout + done.stderr).strip()


@pytest.fixture
def machines(short_folder: Path) -> Iterator[Machines]:
    name, far, near = f"r{uuid4().hex[:8]}", short_folder / "far", short_folder / "near"
    domain = int(os.environ["AGENTROB_TEST_DOMAIN"])
    for folder in (far, near):
        folder.mkdir()
    (near / "agentrob.toml").write_text(NEAR.format(data=near, name=name, domain=domain, variable=TOKEN_ENV))
    env = {"AGENTROB_RUNTIME": str(near), TOKEN_ENV: TOKEN}
    driver = ForkedCommand(near, "driver", name, "--listen", "127.0.0.1:0", log=near / "driver.log", **env)
    listen = driver.ready["listen"]
    (far / "agentrob.toml").write_text(FAR.format(name=name, listen=listen, variable=TOKEN_ENV))
    yield Machines(far, name)
    end_all([driver])


def test_the_commands_reach_a_driver_on_another_machine(machines: Machines) -> None:
    name = machines.name
    code, said = machines.type("stop", name)
    assert (code, said.split(":")[0]) == (0, name)
    assert "stands still" in said
    code, said = machines.type("stop", "--all")
    assert code == 0
    assert f"{name}: zero velocity commanded" in said, "a robot of the configuration whose driver is elsewhere, too"
    code, said = machines.type("release", name)
    assert code == 0
    assert said.startswith(f"{name}: it was not locked.")
    code, said = machines.type("drive", name, "turn left 30 degrees")
    assert code == 0, said
    code, said = machines.type("doctor", name)
    assert code == 0, said
    assert "its driver holds it" in said


def test_a_driver_on_another_machine_that_cannot_be_reached_is_told_plainly(machines: Machines) -> None:
    name = machines.name
    code, said = machines.type("stop", name, token="not-the-token-of-this-driver")
    assert code == 1
    assert f"{name}: NOT STOPPED: send the driver's token" in said
    code, said = machines.type("stop", "--all", token="")
    assert code == 1
    assert f"{name}: NOT STOPPED: the environment variable {TOKEN_ENV} must hold the driver's token" in said


@pytest.mark.parametrize(
    ("listen", "told"),
    [
        ("0.0.0.0:8093", "driver_listen = '0.0.0.0:8093' is reachable from other machines and needs TLS"),
        ("127.0.0.1:8093", "driver_listen without TLS needs driver_token_env"),
        ("everywhere", "is not host:port, for example 127.0.0.1:8088"),
    ],
)
def test_a_driver_does_not_listen_without_protection(tmp_path: Path, listen: str, told: str) -> None:
    (tmp_path / "agentrob.toml").write_text('[robots.rex]\nmodel = "fake"\n')
    done = in_process.agentrob(tmp_path, "driver", "rex", "--listen", listen, AGENTROB_RUNTIME=str(tmp_path))
    assert done.returncode == 1
    assert done.stderr.startswith("agentrob: --listen: ")
    assert told in done.stderr
