"""A configuration, a forum and an agent's journal that were written by an older version work with this one.

`older_files/` is the folder of a forum as in docs/own-forum.md, with a fake robot, written by the version before the
modules moved into packages; its databases are dumps by `sqlite3 FILE .dump`. The agent was killed during a walk (post
11), while two commands were waiting (12 and 15).
"""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.model.lifecycle import FINAL_STATES
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


def test_a_new_command_is_executed(older: OlderForum) -> None:
    content = {"board_id": "robots", "title": "Today", "body": "@rex walk forward 0.3 metres"}
    topic = older.http.post("/api/v1/topics", json=content).raise_for_status().json()["topic"]["id"]
    deadline = time.monotonic() + 60
    while not [p for p in older.get(f"/topics/{topic}/posts")["items"] if p["card"] and p["card"]["state"] == "done"]:
        assert time.monotonic() < deadline, older.get(f"/topics/{topic}/posts")["items"][-1]
        time.sleep(0.1)
