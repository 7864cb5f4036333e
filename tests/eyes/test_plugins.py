"""A detector of another package takes the place of the built-in one, found by its entry point."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.eyes.colours import ColourDetector
from agentrob.eyes.contract import check_detector
from agentrob.wiring.app import make_detector

#: What docs/use/finding-things.md shows, and something that is no detector.
PAGE = Path(__file__).parents[2] / "docs/use/finding-things.md"
SHOWN = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
NOT_ONE = """

def no_detector(options):
    return options
"""


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Install a package with two entry points, as pip would."""
    assert SHOWN is not None
    (tmp_path / "my_eyes.py").write_text(SHOWN[1] + NOT_ONE)
    info = tmp_path / "my_eyes-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-eyes\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[agentrob.detectors]\nlamps = my_eyes:LampDetector\nnone = my_eyes:no_detector\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "my_eyes", raising=False)


def settings(**eyes: object) -> RobotConfig:
    return RobotConfig.model_validate({"model": "fake", "eyes": eyes})


def test_the_detector_of_colours_is_built_in() -> None:
    assert isinstance(make_detector(settings()), ColourDetector)
    assert make_detector(settings(detector="")) is None


def test_a_detector_of_another_package_takes_its_place(installed: None) -> None:
    detector = make_detector(settings(detector="lamps", options={"least": 200}))
    assert detector is not None
    check_detector(detector)
    assert list(detector.things) == ["lamp"]


def test_a_name_that_is_not_installed_is_answered_with_those_that_are() -> None:
    with pytest.raises(ConfigError, match=r"'lamps' is not installed; installed detectors: colours"):
        make_detector(settings(detector="lamps"))


def test_what_is_no_detector_is_refused_by_name(installed: None) -> None:
    with pytest.raises(ConfigError, match=r"'none' lacks one of things, colours and detect"):
        make_detector(settings(detector="none"))
