"""Shared by every process: configuration, host locks, child processes."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from agentrob.config import load
from agentrob.errors import ConfigError, RobotBusy
from agentrob.process import host_lock
from agentrob.process.child import Child, ChildError, terminate_all
from tests.host_numbers import dds_number

LIMIT_S = 60.0


def test_an_unknown_setting_is_refused_with_what_is_valid() -> None:
    with pytest.raises(ConfigError, match=r"robots\.rex\.colour is not a setting; valid here: .*domain"):
        load.parse({"robots": {"rex": {"colour": "red"}}})


def test_a_wrong_value_names_its_place_and_what_was_found() -> None:
    with pytest.raises(ConfigError, match=r"robots\.rex\.domain.*999"):
        load.parse({"robots": {"rex": {"domain": 999}}})


def test_an_unknown_robot_lists_the_configured_ones() -> None:
    with pytest.raises(ConfigError, match="'max' is not configured; configured robots: rex"):
        load.parse({"robots": {"rex": {}}}).robot("max")


def test_broken_toml_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "agentrob.toml"
    path.write_text("[board\n")
    with pytest.raises(ConfigError, match="not valid TOML"):
        load.load(path)


def test_a_host_lock_is_exclusive_visible_and_released() -> None:
    name = f"test/{os.getpid()}"
    with host_lock.HostLock(name, "the test"):
        assert name in host_lock.held("test/")
        with pytest.raises(RobotBusy, match="the test is already held"):
            host_lock.HostLock(name, "the test")
    assert name not in host_lock.held("test/")
    host_lock.HostLock(name, "the test").close()


def test_a_host_lock_is_released_while_a_thread_accepts_on_it() -> None:
    name = f"test/waits-{os.getpid()}"
    lock = host_lock.HostLock(name, "x")
    ended: list[OSError] = []

    def wait() -> None:
        try:
            lock.socket.accept()
        except OSError as e:
            ended.append(e)

    def waits() -> bool:
        """Return whether the thread is blocked in a system call on this socket."""
        called = Path(f"/proc/self/task/{waiting.native_id}/syscall").read_text().split()
        return len(called) > 1 and called[1] == hex(lock.socket.fileno())

    waiting = threading.Thread(target=wait, daemon=True)
    waiting.start()
    end_s = time.monotonic() + LIMIT_S
    while not waits():
        assert time.monotonic() < end_s
    lock.close()
    waiting.join(LIMIT_S)
    assert ended, "it waits for callers of a lock that is closed"
    host_lock.HostLock(name, "x").close()


def test_a_host_lock_dies_with_its_process() -> None:
    name = f"test/dies-{os.getpid()}"
    code = "from agentrob.process.host_lock import HostLock\n"
    code += f"l = HostLock({name!r}, 'x'); print('held', flush=True); input()"
    holder = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    assert name in host_lock.held("test/")
    holder.kill()
    holder.wait()
    host_lock.HostLock(name, "x").close()


def test_a_failed_child_is_reported_with_its_last_output(tmp_path: Path) -> None:
    child = Child("driver", ["driver", "nobody"], tmp_path / "driver.log")
    with pytest.raises(ChildError, match="robot 'nobody' is not configured"):
        child.wait_ready(LIMIT_S)
    terminate_all([child])


def test_a_child_that_serves_several_robots_is_ready_when_each_of_them_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    second = tmp_path / "second"
    os.mkfifo(second)
    program = tmp_path / "program"  # prints one ready line, and the next one when it is told to
    program.write_text(f'#!/bin/sh\necho \'{{"ready": true, "robot": "ann"}}\'\ncat {second}\nexec sleep 1000\n')
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    child = Child("worker", [], tmp_path / "worker.log", ready_lines=2)
    try:
        with pytest.raises(ChildError, match="worker was not ready after 0 s"):
            child.wait_ready(0.2)
        second.write_text('{"ready": true, "robot": "bob"}\n')
        assert child.wait_ready(LIMIT_S) == {"ready": True, "robot": "ann"}
    finally:
        terminate_all([child])


def test_children_end_when_their_parent_is_killed(tmp_path: Path) -> None:
    code = (
        "from pathlib import Path; from agentrob.process.child import Child\n"
        f"c = Child('sim', ['sim', '--domain', 'go2={181 + dds_number()}'], Path('log')); c.wait_ready(60)\n"
        "print(c.process.pid, flush=True); input()"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert parent.stdout is not None
    pid = int(parent.stdout.readline())
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    deadline = time.monotonic() + LIMIT_S
    while Path(f"/proc/{pid}/stat").exists() and "Z" not in Path(f"/proc/{pid}/stat").read_text().split()[2]:
        assert time.monotonic() < deadline, "the child outlived its parent"
        os.sched_yield()
