"""Simulations that packages of robots bring along: found by entry point, asked for settings, run in a process."""

from __future__ import annotations

from pathlib import Path

import pytest

from agentrob import plugins
from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, SimError
from agentrob.wiring import app, drive, simulators

PACKAGE = """
from agentrob.errors import SimError


class Simulated:
    def settings(self, settings):
        if settings.options.get("missing"):
            raise SimError("the arm's simulation needs: pip install arm-sim")
        return settings.model_copy(update={"scene": "a bench", "options": {"port": settings.domain}})

    def serve(self, settings, ended):
        print(settings.scene, settings.options, settings.domain, settings.interface)
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install a package with a simulation, as pip would."""
    (tmp_path / "some_arm.py").write_text(PACKAGE)
    info = tmp_path / "some_arm-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: some-arm\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[agentrob.simulators]\nsome-arm = some_arm:Simulated\n")
    monkeypatch.syspath_prepend(str(tmp_path))


def test_the_settings_of_a_simulated_robot_are_those_that_its_simulation_wants(installed: None) -> None:
    settings = app.simulated_robot("some-arm", 41)
    assert (settings.simulated, settings.home_on_start, settings.domain) == (True, True, 41)
    assert (settings.scene, settings.options) == ("a bench", {"port": 41})


def test_what_must_be_installed_is_told(installed: None) -> None:
    with pytest.raises(SimError, match="pip install arm-sim"):
        simulators.prepared(RobotConfig(model="some-arm", options={"missing": True}))


def test_a_robot_without_a_simulation_simulates_itself() -> None:
    settings = RobotConfig(model="fake", domain=3, simulated=True)
    assert simulators.prepared(settings) == settings
    assert drive.simulation_of(settings) == []
    with pytest.raises(ConfigError, match="simulator 'fake' is not installed"):
        simulators.make_simulator("fake")


def test_drive_and_demo_run_it_as_a_command(installed: None) -> None:
    settings = RobotConfig(model="some-arm", domain=44, simulated=True)
    command = ["simulator", "some-arm", "--domain", "44", "--interface", "lo"]
    assert drive.simulation_of(settings) == [command]
    assert drive.simulation_of(settings.model_copy(update={"model": "go2"})) == [
        ["sim", "--domain", "go2=44", "--interface", "lo"]
    ]


def test_a_robot_of_our_own_packages_that_is_not_installed_is_told_with_its_package(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(plugins, "installed", lambda family: {})
    with pytest.raises(ConfigError, match=r"robot 'ros2-sim' is not installed: pip install agentrob-ros2; installed"):
        plugins.find("robots", "ros2-sim")
    with pytest.raises(ConfigError, match=r"robot 'nosuch' is not installed; installed robots"):
        plugins.find("robots", "nosuch")
