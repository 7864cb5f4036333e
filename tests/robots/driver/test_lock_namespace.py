"""A namespace separates the simulated robots of test processes; it never hides a real robot or gives it two drivers."""

from __future__ import annotations

import os
from contextlib import ExitStack
from uuid import uuid4

import pytest

from agentrob.config.robots import RobotConfig
from agentrob.errors import ConfigError, RobotBusy
from agentrob.process import host_lock
from agentrob.process.host_lock import NAMESPACE, HostLock
from agentrob.robots.driver.process import lock_name

SIMULATED = [
    RobotConfig(model="fake"),
    RobotConfig(model="go2", simulated=True),
    RobotConfig(model="mine", simulated=True),
]
REAL = [
    RobotConfig(model="go2", interface="eth0"),
    RobotConfig(model="go2", interface="eth0", simulated=True),
    RobotConfig(model="g1", interface="lo"),
    RobotConfig(model="mine"),
]


@pytest.mark.parametrize("settings", REAL, ids=str)
def test_law_11_a_real_robot_has_one_lock_in_every_namespace(
    settings: RobotConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = set()
    for namespace in ("", "a", "b"):
        monkeypatch.setenv(NAMESPACE, namespace)
        names.add(lock_name("rex", settings))
    (name,) = names
    assert name == f"driver/{settings.interface}/{settings.domain}"


@pytest.mark.parametrize("settings", SIMULATED, ids=str)
def test_a_simulated_robot_has_a_lock_in_each_namespace(settings: RobotConfig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(NAMESPACE)
    name = lock_name("rex", settings)
    assert "@" not in name
    monkeypatch.setenv(NAMESPACE, "a")
    assert lock_name("rex", settings) == f"{name}@a"


@pytest.mark.parametrize("name", ["domain/lo/41", "world/lo/41", "driver/eth0/0", "driver/lovely0/0", "board/abc"])
def test_law_11_no_other_lock_can_have_a_namespace(name: str) -> None:
    with pytest.raises(ValueError, match="must be unique on this host"):
        host_lock.namespaced(name)


def test_law_13_a_namespace_lists_its_own_robots_and_every_real_one(monkeypatch: pytest.MonkeyPatch) -> None:
    mark = uuid4().hex[:8]
    real = [f"driver/{mark}/0", f"driver/lo/{mark}", f"driver/{mark}@b/0", f"domain/lo/{mark}"]
    simulated = {}
    with ExitStack() as stack:
        for name in real:
            stack.enter_context(HostLock(name, "a real robot"))
        for namespace in ("a", "b"):
            monkeypatch.setenv(NAMESPACE, namespace)
            simulated[namespace] = [host_lock.namespaced(f"driver/{kind}/{mark}x") for kind in ("fake", "lo")]
            for name in simulated[namespace]:
                stack.enter_context(HostLock(name, "a simulated robot"))
        for namespace in ("a", "b"):
            monkeypatch.setenv(NAMESPACE, namespace)
            assert {name for name in host_lock.held() if mark in name} == {*real, *simulated[namespace]}
        everything = {*real, *simulated["a"], *simulated["b"]}
        monkeypatch.setenv(NAMESPACE, "")
        assert {name for name in host_lock.held() if mark in name} == everything, "the owner's shell reaches all"
        monkeypatch.setenv(NAMESPACE, "a")
        assert {name for name in host_lock.held_anywhere() if mark in name} == everything


def test_within_a_namespace_a_lock_is_held_once() -> None:
    name = host_lock.namespaced(f"driver/fake/{uuid4().hex}")
    assert name.endswith("@" + os.environ[NAMESPACE])
    with HostLock(name, "the robot"), pytest.raises(RobotBusy, match="the robot is already held"):
        HostLock(name, "the robot")


@pytest.mark.parametrize("namespace", ["a@b", "a/b", "a b", "x" * 41])
def test_a_namespace_that_is_not_a_word_is_refused(namespace: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(NAMESPACE, namespace)
    with pytest.raises(ConfigError, match="valid: at most 40 letters"):
        host_lock.namespaced("driver/fake/rex")
