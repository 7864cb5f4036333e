"""A configuration, a forum, an agent's files and a driver's lock that version 0.1.0 wrote work with this version.

`older_files/` is the folder of a forum as in docs/forum/own-forum.md, with a fake robot, written by the version before
the modules moved into packages; its databases are dumps by `sqlite3 FILE .dump`. The agent was killed during a walk
(post 11), while two commands were waiting (12 and 15). `agent/` is what an agent of 0.1.0 kept of another command, and
`ada.halt` how its driver noted an emergency stop; `every_setting.toml` has every setting of 0.1.0.
"""

from __future__ import annotations

import shutil
import sqlite3
import time
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.config import load as configuration
from agentrob.model.lifecycle import FINAL_STATES
from agentrob.robots.safety.lock import Halt
from agentrob.wiring import app
from tests.forked_process import ForkedCommand, end_all
from tests.in_process import agentrob

FILES = Path(__file__).parent / "older_files"
DONE, KILLED, WAITING = "9", "11", ("12", "15")


@dataclass
class OlderForum:
    """Today's three processes, started on the older files."""

    folder: Path
    http: httpx2.Client
    agent_log: Path

    def states(self) -> dict[str, str]:
        """Return the state of each command on the forum, by its post."""
        found = {}
        for topic in self.get("/boards/robots/topics")["items"]:
            posts = self.get(f"/topics/{topic['id']}/posts")["items"]
            found |= {post["reply_to"] or posts[0]["id"]: post["card"]["state"] for post in posts if post["card"]}
        return found

    def get(self, path: str) -> dict[str, Any]:
        found: dict[str, Any] = self.http.get(f"/api/v1{path}").raise_for_status().json()
        return found

    def motions(self) -> dict[str, str]:
        with sqlite3.connect(self.folder / "data/agents/rex/journal.sqlite") as journal:
            return dict(journal.execute("SELECT post, state FROM motion").fetchall())


def restore(dump: Path, to: Path) -> None:
    to.parent.mkdir(parents=True)
    with sqlite3.connect(to) as database:
        database.executescript(dump.read_text(encoding="utf-8"))
    database.close()


def token_of(folder: Path, name: str) -> str:
    done = agentrob(folder, "board", "account", "token", name)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.fixture(scope="module")
def older(tmp_path_factory: pytest.TempPathFactory) -> Iterator[OlderForum]:
    folder = tmp_path_factory.mktemp("older")
    restore(FILES / "board.sql", folder / "data/board/board.sqlite3")
    restore(FILES / "journal.sql", folder / "data/agents/rex/journal.sqlite")
    shutil.copytree(FILES / "agent", folder / "data/agents/rex", dirs_exist_ok=True)
    config = folder / "agentrob.toml"
    text = (FILES / "agentrob.toml").read_text().replace('data = "./data"', f'data = "{folder / "data"}"')
    config.write_text(text.replace("127.0.0.1:8199", "127.0.0.1:0"))
    env = {"AGENTROB_RUNTIME": str(folder / "run")}
    processes = [ForkedCommand(folder, "board", "serve", log=folder / "board.log", **env)]
    try:
        url = processes[0].ready["url"]
        config.write_text(text.replace("http://127.0.0.1:8199", url))
        tokens = {name: token_of(folder, name) for name in ("chief", "rex")}
        env["AGENTROB_TOKEN"] = tokens["rex"]
        for name, words in (("driver", ("driver", "rex")), ("agent", ("agent", "run", "rex"))):
            processes.append(ForkedCommand(folder, *words, log=folder / f"{name}.log", **env))
            assert processes[-1].ready
        with httpx2.Client(base_url=url, headers={"Authorization": f"Bearer {tokens['chief']}"}) as http:
            yield OlderForum(folder, http, folder / "agent.log")
    finally:
        end_all(processes)


def settled(older: OlderForum) -> dict[str, str]:
    """Wait until no command is in progress; return the states."""
    deadline = time.monotonic() + 60
    while (states := older.states()) and not set(states.values()) <= FINAL_STATES:
        assert time.monotonic() < deadline, f"{states}; the agent's last line: {older.agent_log.read_text()[-500:]}"
        time.sleep(0.1)
    return states


def test_law_6_motions_of_the_older_version_are_not_repeated(older: OlderForum) -> None:
    states = settled(older)
    assert states[DONE] == "done"
    assert states[KILLED] == "interrupted", "its motion had begun, and its end is not known"
    assert {states[post] for post in WAITING} == {"expired"}, "too old to begin now"
    motions = older.motions()
    assert (motions[DONE], motions[KILLED]) == ("ended", "begun")
    assert not [post for post in WAITING if motions.get(post) in ("begun", "ended")]


def test_posts_accounts_and_search_of_the_older_forum_work(older: OlderForum) -> None:
    titles = {topic["title"] for topic in older.get("/boards/robots/topics")["items"]}
    assert {"A first walk", "Refused", "Cut short", "Waits"} <= titles
    assert older.get("/search?q=crutches")["items"] == []
    assert older.get("/search?q=child")["items"], "the index of words came with the database"
    assert older.get("/accounts/ann")["role"] == "member"
    assert older.get("/admin/robots/rex")["owner"] == "chief"


def test_every_setting_of_the_older_version_is_accepted_and_means_the_same() -> None:
    file = FILES / "every_setting.toml"
    config = configuration.load(file)
    now = config.model_dump(mode="json")
    assert differences(tomllib.loads(file.read_text()), now) == []


def differences(older: dict[str, Any], now: dict[str, Any], where: str = "") -> list[str]:
    """Return the settings that have another value now."""
    found = []
    for key, value in older.items():
        if isinstance(value, dict):
            found += differences(value, now[key], f"{where}{key}.")
        elif now[key] != value:
            found.append(f"{where}{key}: {value!r} is {now[key]!r}")
    return found


def test_records_and_recordings_of_the_older_agent_are_kept_and_read(older: OlderForum) -> None:
    settled(older)
    record = app.read_record(older.folder / "data", "rex", "1")
    assert [step["outcome"] for step in record["steps"]] == ["done"] * 3
    assert record["timings_ms"]["done"] > record["timings_ms"]["first_motion"]
    recordings = older.folder / "data/agents/rex/recordings"
    assert (recordings / "1.jsonl").read_bytes() == (FILES / "agent/recordings/1.jsonl").read_bytes()


def test_law_17_a_robot_that_the_older_driver_locked_stays_locked() -> None:
    halt = Halt(FILES / "ada.halt")
    assert halt.lock is not None
    assert (halt.lock.by, halt.lock.why) == ("olga", "smoke from the left hip")


def test_a_new_command_is_executed(older: OlderForum) -> None:
    content = {"board_id": "robots", "title": "Today", "body": "@rex walk forward 0.3 metres"}
    topic = older.http.post("/api/v1/topics", json=content).raise_for_status().json()["topic"]["id"]
    deadline = time.monotonic() + 60
    while not [p for p in older.get(f"/topics/{topic}/posts")["items"] if p["card"] and p["card"]["state"] == "done"]:
        assert time.monotonic() < deadline, older.get(f"/topics/{topic}/posts")["items"][-1]
        time.sleep(0.1)
