"""The demo as a process: it starts only once, gives a clear reason otherwise, and leaves no process behind."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import httpx2
import pytest

from agentrob.demo.visitor import LIMIT_S
from agentrob.process import host_lock
from tests import in_process
from tests.demo.running import AGENTROB, RUNNING, START_S, RunningDemo, end_leftovers, start_demo
from tests.tolerances import about_deg, about_m

pytestmark = pytest.mark.sim


def descendants(pid: int) -> set[int]:
    """Return all descendants of a process."""
    found = set()
    for task in Path(f"/proc/{pid}/task").iterdir():
        for child in (task / "children").read_text().split():
            found |= {int(child)} | descendants(int(child))
    return found


def abstract_sockets() -> dict[str, str]:
    """Return inode and name of each host lock on this machine."""
    lines = [line.split(maxsplit=7) for line in Path("/proc/net/unix").read_text().splitlines()[1:]]
    start = "@" + host_lock.PREFIX
    return {line[6]: line[7].removeprefix(start) for line in lines if len(line) == 8 and line[7].startswith(start)}


def locks_of(processes: set[int]) -> dict[str, str]:
    """Return inode and name of each host lock that these processes hold."""
    files = [file for pid in processes for file in Path(f"/proc/{pid}/fd").iterdir()]
    open_now = {str(file.readlink()) for file in files if file.is_symlink()}
    return {inode: name for inode, name in abstract_sockets().items() if f"socket:[{inode}]" in open_now}


def ledger_of(data: Path, robot: str) -> list[dict[str, Any]]:
    """Return the simulated world's own record of what a robot did."""
    events = map(json.loads, (data / "world.jsonl").read_text().splitlines())
    return [event for event in events if event["robot"] == robot]


def true_motions(data: Path, robot: str) -> list[tuple[float, float]]:
    """Return the true distance and rotation of each motion, in metres and degrees."""
    ways, start = [], None
    for event in ledger_of(data, robot):
        if event["event"] == "move_begin" and start is None:
            start = event["pose"]
        elif event["event"] == "stop_move" and start is not None:
            pose = event["pose"]
            metres = math.hypot(pose["x_m"] - start["x_m"], pose["y_m"] - start["y_m"])
            ways.append((metres, (pose["yaw_deg"] - start["yaw_deg"] + 180) % 360 - 180))
            start = None
    return ways


#: The data folder of a demo, and the result of `agentrob demo --post` there.
Posted = tuple[Path, subprocess.CompletedProcess[str]]
SENTENCE = "@quadruped walk forward 1 metre, turn left, wave and take a photo"


@pytest.fixture(scope="module")
def first_demo(tmp_path_factory: pytest.TempPathFactory) -> Posted:
    data = tmp_path_factory.mktemp("demos") / "demo"  # where the commands of a user with this data folder look
    command = [AGENTROB, "demo", "--post", SENTENCE, "--json", "--data", str(data)]
    return data, subprocess.run(command, capture_output=True, text=True, timeout=START_S + LIMIT_S, check=False)


@pytest.fixture(scope="module")
def demo(first_demo: Posted) -> Iterator[RunningDemo]:
    """Start another demo with this data folder, after accounts and robots were changed."""
    data, before = first_demo[0], len(RUNNING)
    for change in (
        ("board", "account", "add", "olga", "--role", "operator"),
        ("board", "account", "change", "visitor", "--role", "member", "--suspend"),
        ("board", "account", "change", "humanoid", "--suspend"),
        ("board", "robot", "change", "quadruped", "--owner", "olga"),
    ):
        changed = board(data, *change)
        assert changed.returncode == 0, changed.stderr
    yield start_demo(data)
    end_leftovers(before)


def board(data: Path, *words: str) -> in_process.Said:
    return in_process.agentrob(data.parent, *words, "--config", str(data / "agentrob.toml"))


def test_one_post_is_executed_and_reported_as_json(first_demo: Posted) -> None:
    data, done = first_demo
    assert done.returncode == 0, done.stdout + done.stderr
    told = json.loads(done.stdout.splitlines()[-1])
    assert told["status"] == "done"
    assert [s["op"] for s in told["steps"]] == ["move", "turn", "hello", "get_front_image"]
    assert all(s["outcome"] == "done" for s in told["steps"])
    move, turn = told["steps"][:2]
    assert move["asked"]["distance_m"] == 1.0
    assert move["measured"]["distance_m"] == about_m(1.0)
    assert turn["asked"]["degrees"] == 90
    assert turn["measured"]["degrees"] == about_deg(90)
    ways = true_motions(data, "go2")
    assert ways[0][0] == pytest.approx(1.0, abs=0.05), "by the simulator's truth, which nothing that drives may read"
    assert ways[1][1] == pytest.approx(90, abs=4)
    assert {"seen", "first_motion", "done"} <= set(told["timings_ms"])
    assert 0 < told["timings_ms"]["seen"] < told["timings_ms"]["first_motion"] < told["timings_ms"]["done"]
    assert told["topic_url"].startswith("http://127.0.0.1:")
    assert "1.0" in told["reply_markdown"] or "1 m" in told["reply_markdown"]
    assert [Path(p).read_bytes()[:2] for p in told["images"]].count(b"\xff\xd8") >= 1


def test_the_visitor_owns_the_demo(first_demo: Posted) -> None:
    data = first_demo[0]
    assert "visitor\thuman\tadmin\n" in board(data, "board", "account", "list").stdout
    for robot in ("quadruped", "humanoid"):
        assert "owner: visitor\n" in board(data, "board", "robot", "show", robot).stdout


def test_a_restart_works_after_changes_of_accounts_and_robots(demo: RunningDemo) -> None:
    accounts = board(demo.data, "board", "account", "list").stdout
    assert "visitor\thuman\tadmin\n" in accounts
    assert "suspended" not in accounts
    owned = board(demo.data, "board", "robot", "show", "quadruped").stdout
    assert "owner: olga\n" in owned, "an owner whom somebody chose stays"
    with httpx2.Client(timeout=60) as browser:
        page = browser.get(demo.link)
        assert browser.post(demo.link, data={"csrf": form_token(page.text)}).status_code == 303
        assert browser.get(demo.url + "/admin/accounts").status_code == 200


def test_a_second_demo_with_the_same_data_is_refused_in_one_line(demo: RunningDemo) -> None:
    second = subprocess.run(
        [AGENTROB, "demo", "--port", "0", "--data", str(demo.data)],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert second.returncode == 1
    assert f"a demo already runs at {demo.url}" in second.stderr.splitlines()[-1]
    assert "Traceback" not in second.stderr


def test_a_taken_port_is_one_clear_line(tmp_path: Path) -> None:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        s.listen()
        port = s.getsockname()[1]
        refused = subprocess.run(
            [AGENTROB, "demo", "--port", str(port), "--data", str(tmp_path / "data")],
            capture_output=True,
            text=True,
            timeout=100,
            check=False,
        )
    assert refused.returncode == 1
    assert f"port {port} is in use; choose another with --port" in refused.stderr.splitlines()[-1]


def test_a_new_link_can_be_printed_and_works_once(demo: RunningDemo) -> None:
    printed = demo.agentrob("demo", "link", "--data", str(demo.data))
    assert printed.returncode == 0, printed.stderr
    link = printed.stdout.strip()
    assert link.startswith(demo.url + "/enter/")
    with httpx2.Client(timeout=60) as browser, httpx2.Client(timeout=60) as thief:
        for _ in range(2):  # a prefetch does not use it up
            page = browser.get(link)
            assert page.status_code == 200
        assert browser.post(link, data={"csrf": form_token(page.text)}).status_code == 303
        assert "visitor" in browser.get(demo.url).text
        stolen = thief.post(link, data={"csrf": form_token(thief.get(demo.url + "/sign-in").text)})
        assert stolen.status_code == 404


def test_the_doctor_finds_the_robots_of_a_running_demo(demo: RunningDemo) -> None:
    found = demo.agentrob("doctor", "quadruped", "--json")
    assert found.returncode == 0, found.stdout + found.stderr
    told = json.loads(found.stdout)
    assert (told["robot"], told["model"]) == ("quadruped", "go2")
    assert "its driver holds it" in told["findings"][1]["found"]
    whole = demo.agentrob("doctor", "--json")
    assert whole.returncode == 0, whole.stdout + whole.stderr
    told = json.loads(whole.stdout)
    assert {one["check"]: one["status"] for one in told["findings"]}.items() >= {
        "database": "ok",
        "forum": "ok",
    }.items()
    assert [one["robot"] for one in told["robots"]] == ["quadruped", "humanoid"]
    for one in told["robots"]:
        assert {"account": "ok", "agent": "ok"}.items() <= {f["check"]: f["status"] for f in one["findings"]}.items()


def form_token(page: str) -> str:
    found = re.search(r'name="csrf" value="([^"]+)"', page)
    assert found
    return found[1]


@pytest.mark.slow
def test_a_killed_demo_leaves_no_process_and_no_link(tmp_path: Path) -> None:
    demo = start_demo(tmp_path / "data")
    children = descendants(demo.process.pid)
    demo.process.kill()
    demo.process.wait(60)
    deadline = time.monotonic() + 60
    while left := [c for c in children if alive(c)]:
        assert time.monotonic() < deadline, left
    link = demo.agentrob("demo", "link", "--data", str(demo.data))
    assert link.returncode == 1
    assert "no demo is running" in link.stderr
    again = start_demo(tmp_path / "data")
    os.killpg(again.process.pid, signal.SIGINT)
    assert again.process.wait(60) == 0


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_without_a_demo_the_link_command_says_how_to_start_one(tmp_path: Path) -> None:
    done = subprocess.run(
        [AGENTROB, "demo", "link", "--data", str(tmp_path)], capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 1
    assert "start one with: agentrob demo" in done.stderr


def post_once(data: Path, sentence: str) -> dict[str, Any]:
    done = subprocess.run(
        [AGENTROB, "demo", "--post", sentence, "--json", "--data", str(data)],
        capture_output=True,
        text=True,
        timeout=110,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    told: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return told


@pytest.mark.slow
def test_the_humanoid_walks_turns_and_waves(tmp_path: Path) -> None:
    told = post_once(tmp_path / "data", "@humanoid walk forward 1 metre, turn left, wave")
    assert told["status"] == "done"
    assert [s["op"] for s in told["steps"]] == ["move", "turn", "hello"]
    assert told["steps"][0]["measured"]["distance_m"] == about_m(1.0)
    assert told["steps"][1]["measured"]["degrees"] == about_deg(90)
    did = ledger_of(tmp_path / "data", "g1")
    begun = next(e["pose"] for e in did if e["event"] == "move_begin")
    waved = next(e["pose"] for e in did if e.get("action") == "high wave")
    metres = math.hypot(waved["x_m"] - begun["x_m"], waved["y_m"] - begun["y_m"])
    assert metres == pytest.approx(1.0, abs=0.09), "the move's tolerance and the turn's"
    assert (waved["yaw_deg"] - begun["yaw_deg"]) % 360 == pytest.approx(90, abs=8)
    other = {e["event"] for e in ledger_of(tmp_path / "data", "go2")}
    assert not other & {"move_begin", "action_begin"}, "the other robot did nothing"


@pytest.mark.slow
def test_a_post_that_mentions_both_robots_makes_each_do_its_own_part(tmp_path: Path) -> None:
    told = post_once(tmp_path / "data", "@quadruped turn left 45 degrees. @humanoid wave.")
    assert told["status"] == "done"
    ops = {name: [s["op"] for s in answer["steps"]] for name, answer in told["robots"].items()}
    assert ops == {"quadruped": ["turn"], "humanoid": ["hello"]}
    assert all(answer["reply_markdown"] for answer in told["robots"].values())
    go2, g1 = (ledger_of(tmp_path / "data", robot) for robot in ("go2", "g1"))
    assert [e["action"] for e in g1 if e["event"] == "action_begin"] == ["high wave"]
    assert not [e for e in g1 if e["event"] == "move_begin"]
    assert [e for e in go2 if e["event"] == "move_begin"]
    assert not [e for e in go2 if e["event"] == "action_begin"]


@pytest.mark.slow
def test_a_question_back_ends_with_exit_code_one(tmp_path: Path) -> None:
    done = subprocess.run(
        [AGENTROB, "demo", "--post", "@quadruped walk forward", "--json", "--data", str(tmp_path / "data")],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 1
    assert json.loads(done.stdout.splitlines()[-1])["status"] == "asks_back"


def test_ctrl_c_ends_everything_within_three_seconds_and_leaves_no_process_lock_or_port(demo: RunningDemo) -> None:
    """This is the last test of the file, because it ends the demo that the others use."""
    children = descendants(demo.process.pid)
    assert len(children) >= 5, "the forum, the world, a driver for each robot, and a worker"
    locks = locks_of({demo.process.pid, *children})
    kinds = sorted(name.split("/")[0] for name in locks.values())
    assert kinds == ["board", "domain", "domain", "driver", "driver", "world", "world"]
    port = urlsplit(demo.url).port
    began = time.monotonic()
    os.killpg(demo.process.pid, signal.SIGINT)  # to the whole process group, like a terminal
    assert demo.process.wait(60) == 0
    assert time.monotonic() - began < 3.0
    assert not [c for c in children if Path(f"/proc/{c}").exists()]
    assert not locks.keys() & abstract_sockets().keys()
    with socket.socket() as s:
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        s.bind(("127.0.0.1", port))
    assert (demo.data / "agentrob.toml").exists(), "the data folder is kept"
    assert str(demo.data) in "".join(demo.said), "and named"
