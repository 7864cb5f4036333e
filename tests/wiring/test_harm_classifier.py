"""The configured harm classifier: if its extra is missing or its weights are broken, the robot works without and says
so."""

from __future__ import annotations

from pathlib import Path

import pytest
from structlog.testing import capture_logs

from agentrob.config.load import Config
from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError
from agentrob.robots.diagnostics.findings import Finding, Status
from agentrob.semantic import encoder, harm_classifier
from agentrob.wiring import app
from agentrob.wiring.doctor import robot as doctor


def without_extra(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(encoder, "_PACKAGE", "no_such_package")


def _broken() -> None:
    raise ConfigError("harm_weights.json does not have the expected checksum")


def with_broken_weights(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(encoder, "_PACKAGE", "json")  # any installed library
    patch.setattr(harm_classifier, "load_classifier", _broken)


@pytest.mark.parametrize(("breaks", "said"), [(without_extra, "agentrob[semantic]"), (with_broken_weights, "checksum")])
def test_an_error_on_loading_is_logged_once_and_the_rules_decide(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, breaks: object, said: str
) -> None:
    assert callable(breaks)
    breaks(monkeypatch)
    with capture_logs() as logs:
        assert app.make_second_opinion() is None
    assert [(line["log_level"], said in line["error"]) for line in logs] == [("warning", True)]
    settings = RobotConfig(model="fake", harm_classifier=True)
    found = {one.check: one for one in doctor.examine("spot", settings, Config(data=str(tmp_path)))}
    assert found["harm classifier"].status is Status.WARNING
    assert said in found["harm classifier"].found
    assert "rules decide alone" in found["harm classifier"].advice


def test_the_doctor_measures_the_classifier_only_if_enabled(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(harm_classifier, "check_harm_classifier", lambda: 1.23)
    config = Config(data=str(tmp_path))
    on = doctor.examine("spot", RobotConfig(model="fake", harm_classifier=True), config)
    assert Finding("harm classifier", Status.OK, "it answers 1.2 s after its start") in on
    off = doctor.examine("spot", RobotConfig(model="fake"), config)
    assert "harm classifier" not in [one.check for one in off]
    assert RobotConfig().harm_classifier is False
