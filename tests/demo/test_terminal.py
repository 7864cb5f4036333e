"""The demo's output on a terminal, its port, and when it opens a browser."""

from __future__ import annotations

import contextlib
import os
import re
import signal
import socket
import sqlite3
import time
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.demo import ports, terminal
from agentrob.demo.errors import DemoError
from agentrob.demo.run import Demo, DemoSettings
from agentrob.process.child import Child
from agentrob.process.listen import is_free
from tests.demo.running import AGENTROB, START_S
from tests.terminal import Terminal

OLDER_FORUM = Path(__file__).parents[1] / "wiring/older_files/board.sql"


# ------------------------------------------------------------------ the port
def test_the_usual_port_is_taken_if_it_is_free_and_any_other_one_if_not(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = ports.free_port()
    monkeypatch.setattr(ports, "PORT", usual)
    assert ports.choose_port(None) == usual
    with socket.socket() as other:
        other.bind(("127.0.0.1", usual))
        other.listen()
        chosen = ports.choose_port(None)
        assert chosen not in (0, usual)
        assert is_free(ports.HOST, chosen)
        with pytest.raises(DemoError, match=f"port {usual} is in use"):
            ports.choose_port(usual)
    assert ports.choose_port(usual) == usual


# ------------------------------------------------------------------ the browser
@pytest.mark.parametrize(
    ("environment", "at_terminal", "opens"),
    [
        ({"DISPLAY": ":0"}, True, True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True, True),
        ({"BROWSER": "firefox"}, True, True),
        ({}, True, False),
        ({"DISPLAY": ""}, True, False),
        ({"DISPLAY": ":0"}, False, False),
        ({"DISPLAY": ":0", "CI": "true"}, True, False),
        ({"DISPLAY": "localhost:10", "SSH_CONNECTION": "10.0.0.2 1 10.0.0.3 22"}, True, False),
    ],
)
def test_a_browser_is_opened_only_for_a_person_who_sees_it(
    environment: dict[str, str], at_terminal: bool, opens: bool
) -> None:
    assert terminal.has_browser(environment, terminal=at_terminal) is opens


def test_a_missing_gl_library_is_said_with_what_gives_one() -> None:
    told = terminal.welcome("http://x/enter/1", ["@quadruped wave"], "/data", ["pictures come from a simple camera"])
    assert "  Note   pictures come from a simple camera\n" in told
    assert "Note" not in terminal.welcome("http://x/enter/1", ["@quadruped wave"], "/data")


# ------------------------------------------------------------------ the whole demo at a terminal
@pytest.mark.sim
def test_it_shows_its_progress_opens_a_browser_on_older_data_and_ends_by_ctrl_c(tmp_path: Path) -> None:
    data, opened = tmp_path / "data", tmp_path / "opened"
    (data / "board").mkdir(parents=True)
    with sqlite3.connect(data / "board/board.sqlite3") as database:  # a forum of version 0.1.0
        database.executescript(OLDER_FORUM.read_text(encoding="utf-8"))
    database.close()
    browser = tmp_path / "browser"
    browser.write_text(f'#!/bin/sh\necho "$1" > {opened}.part && mv {opened}.part {opened}\n')
    browser.chmod(0o755)
    here = {key: value for key, value in os.environ.items() if key != "CI" and not key.startswith("SSH_")}
    command = (AGENTROB, "demo", "--port", "0", "--data", str(data))
    demo = Terminal(
        *command, **{**here, "BROWSER": str(browser), "TERM": "xterm", "COLUMNS": "200", "MUJOCO_GL": "off"}
    )
    demo.read_until("Ctrl-C", START_S)
    assert "building the room and its robots" in demo.said
    assert "starting the robots' drivers and agents" in demo.said
    assert "pictures come from a simple camera" in demo.said, "there is no OpenGL"
    printed = re.search(r"http://\S+/enter/\S+", demo.said)
    assert printed is not None
    deadline = time.monotonic() + 30
    while not opened.exists():
        assert time.monotonic() < deadline, "no browser was opened"
        time.sleep(0.05)
    link = opened.read_text().strip()
    assert link != printed[0], "the printed link still works after the browser has used its own"
    for one in (link, printed[0]):
        assert httpx2.get(one, timeout=60).status_code == 200
    demo.press(b"\x03")
    demo.read_until("ending", 30)
    assert demo.wait() == 0


def processes_of(data: Path) -> list[str]:
    """Return the command lines of all processes of the demo with this data folder."""
    mark = f"AGENTROB_DATA={data}".encode()
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):  # it has ended, or is another user's
            if mark in (process / "environ").read_bytes().split(b"\0"):
                found.append((process / "cmdline").read_text().replace("\0", " "))
    return found


@pytest.mark.sim
def test_ctrl_c_while_it_starts_ends_everything_and_it_starts_again(tmp_path: Path) -> None:
    data = tmp_path / "data"
    command = (AGENTROB, "demo", "--port", "0", "--no-browser", "--data", str(data))
    for step in (
        "setting up the forum",
        "building the room and its robots",
        "waiting for driver",
        "waiting for the agents",
    ):
        demo = Terminal(*command, **{**os.environ, "TERM": "xterm", "COLUMNS": "200"})
        demo.read_until(step, START_S)
        assert processes_of(data) or step == "setting up the forum"
        demo.press(b"\x03")
        demo.read_until("AgentRob demo: ending", 30)
        assert demo.wait() == 0
        assert "Traceback" not in demo.said
        assert "Ctrl-C" not in demo.said, "it had started already"
        assert processes_of(data) == []


@pytest.mark.sim
def test_ctrl_c_while_a_process_is_started_ends_it_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Interrupted(Child):
        def __init__(self, *args: Any) -> None:
            super().__init__(*args)
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr("agentrob.demo.run.Child", Interrupted)
    demo = Demo(DemoSettings(tmp_path / "data", port=0))
    with pytest.raises(KeyboardInterrupt), demo:
        demo.start()
    assert [(child.name, child.alive) for child in demo.children] == [("world", False)]
