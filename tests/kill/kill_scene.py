"""A board, a driver and an agent as processes that may be killed one by one, with a robot that outlives them."""

from __future__ import annotations

import json
import secrets
import shutil
import sqlite3
import tempfile
import threading
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import httpx2

from agentrob.config.board import BoardConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.journal import JournalConfig
from agentrob.config.load import Config
from agentrob.config.robots import FenceConfig, RatesConfig, RecordingConfig, RobotConfig
from agentrob.language.messages.catalog import say
from agentrob.model import AccountKind, Role
from agentrob.model.lifecycle import FINAL_STATES
from agentrob.wiring import app
from tests.agent.store.journal_store import JournalStore
from tests.forked_process import ForkedProcess
from tests.host_numbers import free_port
from tests.in_process import Said
from tests.kill import kill_body
from tests.kill.kill_process import KillableProcess, agentrob, wait_for

View = Literal["auto", "none"]
ROBOT, PERSON = "quadruped", "visitor"
WALK, LONG_WALK, PHOTO = "walk forward 0.3 metres", "walk forward 3 metres", "walk forward 0.3 metres, take a photo"
#: Final states of a command whose driver was killed before it got a step: nothing moved.
DRIVER_AWAY = frozenset({"failed"})
#: Final states of a command whose driver was killed during a step: the agent knows that the result is unknown.
DRIVER_DIED = frozenset({"interrupted"})
#: Agents, drivers and boards restart within seconds; an agent waits longest, for a board, because of its backoff.
END_S = 90.0
#: How a question for an approval begins.
WAITS = say("agent.waits", "en")
ENTRY = "[agentrob.robots]\nfar = tests.kill.kill_robot:RemoteBodyRobot\n"


@dataclass
class PostedCommand:
    """One command in progress: who posted it, the ledger, and the start time."""

    text: str
    began: int
    key: str = field(default_factory=lambda: secrets.token_hex(8))
    post: dict[str, Any] | None = None
    thread: threading.Thread | None = None


class KillScene:
    """All processes on loopback, in one folder. `kinds` are the processes that may be killed: board, driver, agent.
    `recording` is the view of the robot's recordings."""

    kinds: tuple[str, ...] = ("board", "driver", "agent")

    def __init__(self, folder: Path, database: str = "", recording: View = "auto") -> None:
        self.folder, self.recording = folder, recording
        self.journal_store = JournalStore(folder, ROBOT, database)
        self.runtime = Path(tempfile.mkdtemp(prefix="agentrob-kill-"))  # socket paths must be short
        self.ledger_path = folder / "ledger.jsonl"
        self.running: dict[str, KillableProcess] = {}
        self.tokens: dict[str, str] = {}
        self._install_robot()
        self.world = self.start_world()
        port = free_port()
        self.url = f"http://127.0.0.1:{port}"
        self.config = Config(
            data=str(folder),
            board=BoardConfig(listen=f"127.0.0.1:{port}", base_url=self.url),
            forum=ForumConfig(url=self.url),
            journal=JournalConfig(database=database),
            robots={ROBOT: self.robot()},
        )
        self.config_path = folder / "agentrob.toml"
        self.config.write(self.config_path)
        app.board_account(self.config, ROBOT, AccountKind.ROBOT_AGENT, Role.MEMBER)
        app.board_account(self.config, PERSON, AccountKind.HUMAN, Role.OPERATOR)
        self.tokens = {name: app.board_token(self.config, name) for name in (ROBOT, PERSON)}
        headers = {"Authorization": f"Bearer {self.tokens[PERSON]}"}
        self.http = httpx2.Client(base_url=self.url + "/api/v1", headers=headers, timeout=5.0)
        for kind in self.kinds:
            self.start(kind)

    def _install_robot(self) -> None:
        """Return the folder where a third party's robot is installed."""
        info = self.folder / "plugins" / "far_robot-1.dist-info"
        info.mkdir(parents=True)
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: far-robot\nVersion: 1\n")
        (info / "entry_points.txt").write_text(ENTRY)

    # ------------------------------------------------------------ the robot
    def start_world(self) -> KillableProcess:
        args = str(self.runtime / "body"), str(self.ledger_path)
        return KillableProcess(kill_body.main, *args, log=self.folder / "world.log").ready()

    def robot(self) -> RobotConfig:
        fence = FenceConfig(x_min_m=-900, x_max_m=900, y_min_m=-900, y_max_m=900)
        options = {"body": str(self.runtime / "body")}
        rates = RatesConfig(commands_per_hour=0, cooldown_s=0, waiting=0)  # hundreds of commands by one account
        return RobotConfig(
            rates=rates,
            model="far",
            simulated=True,
            home_on_start=True,
            fence=fence,
            recording=RecordingConfig(view=self.recording),
            options=options,
        )

    def ledger(self, since: int = 0) -> list[dict[str, Any]]:
        if not self.ledger_path.exists():
            return []
        return [json.loads(line) for line in self.ledger_path.read_text().splitlines()[since:]]

    def moves(self, since: int) -> bool:
        return self.at_rest_since(since) is None

    def at_rest_since(self, since: int) -> float | None:
        """Return when it last came to rest (CLOCK_MONOTONIC); 0 if it has not moved, None while it moves."""
        changes = [line for line in self.ledger(since) if line["event"] in ("moves", "rests")]
        if not changes:
            return 0.0
        return float(changes[-1]["at_s"]) if changes[-1]["event"] == "rests" else None

    def motions(self, since: int) -> int:
        """Return how many steps a driver began."""
        return sum(line["event"] == "step" for line in self.ledger(since))

    def rest_commanded_after(self, since: int, after_s: float) -> float:
        """Return when a driver first commanded it to rest after this time (CLOCK_MONOTONIC)."""
        commanded_s = [
            line["at_s"] for line in self.ledger(since) if line["event"] == "rest_commanded" and line["at_s"] > after_s
        ]
        return float(commanded_s[0])

    def walked_m(self, since: int) -> float:
        before = self.ledger()[:since]
        lines = self.ledger(since)
        start_m = before[-1]["walked_m"] if before else 0.0
        return float(lines[-1]["walked_m"] - start_m) if lines else 0.0

    # ------------------------------------------------------------ processes that may be killed
    def start(self, kind: str, **env: str) -> None:
        self.begin(kind, **env).ready()

    def begin(self, kind: str, **env: str) -> KillableProcess:
        """Start a process without waiting until it is ready."""
        process = KillableProcess(
            agentrob, *self.arguments(kind), log=self.folder / f"{kind}.log", env=self.env() | env
        )
        self.running[kind] = process
        return process

    def arguments(self, kind: str) -> tuple[tuple[str, ...], Path]:
        """Return the arguments for `agentrob` and the folder where its robots are installed."""
        arguments = {"board": ("board", "serve"), "driver": ("driver", ROBOT), "agent": ("agent", "run", ROBOT)}[kind]
        return (*arguments, "--config", str(self.config_path)), self.folder / "plugins"

    def env(self) -> dict[str, str]:
        return {
            "AGENTROB_DATA": str(self.folder),
            "AGENTROB_RUNTIME": str(self.runtime),
            "AGENTROB_TOKEN": self.tokens[ROBOT],
        }

    def second(self, kind: str, limit_s: float = 60.0) -> Said:
        """Start a second process of a running kind, and wait until it ends."""
        process = ForkedProcess(agentrob, *self.arguments(kind), env=self.env())
        said, errors = process.communicate(limit_s)
        assert process.returncode is not None
        return Said(process.returncode, said, errors)

    def arm(self, kind: str, point: Mapping[str, Any]) -> None:
        self.running[kind].arm(point)

    def wait_for_kill(self, kind: str, limit_s: float = 60.0) -> float:
        return self.running[kind].wait_for_kill(limit_s)

    def release(self) -> None:
        """Release the robot as an owner would: a driver that restarts while the robot still moves halts it (law 12)."""
        transport = httpx2.HTTPTransport(uds=str(self.runtime / "agentrob" / f"{ROBOT}.sock"))
        with httpx2.Client(transport=transport, base_url="http://driver", timeout=60.0) as driver:
            if driver.get("/state").json()["halted"]:
                assert driver.post("/release", json={"by": PERSON}).is_success

    def close(self) -> None:
        self.http.close()
        for process in (*reversed(self.running.values()), self.world):
            process.end()
        shutil.rmtree(self.runtime, ignore_errors=True)

    # ------------------------------------------------------------ posts and replies
    def ask(self, text: str) -> PostedCommand:
        """Post a command; repeat it under the same key while the forum does not answer, as a person would."""
        command = PostedCommand(f"@{ROBOT} {text}", len(self.ledger()))
        topic = {"board_id": "robots", "title": text, "body": command.text}
        command.thread = threading.Thread(target=self._post, args=(command, "/topics", topic), daemon=True)
        command.thread.start()
        return command

    def _post(self, command: PostedCommand, path: str, body: dict[str, Any]) -> None:
        answer = self._request("POST", path, json=body, headers={"Idempotency-Key": command.key})
        command.post = answer["post"]

    def _request(self, method: str, path: str, **more: Any) -> Any:
        """Wait until the board answers; it may be down for a while."""

        def attempt() -> list[Any]:
            try:
                answer = self.http.request(method, path, **more)
            except httpx2.TransportError:
                return []
            if answer.status_code == 503:
                return []
            assert answer.is_success, answer.text
            return [answer.json()]

        return wait_for(f"{method} {path}", attempt, 60.0)[0]

    def stop(self, command: PostedCommand) -> None:
        """Post "stop" in the thread of a command."""
        path = f"/topics/{self.posted(command)['topic_id']}/posts"
        key = {"Idempotency-Key": secrets.token_hex(8)}
        self._request("POST", path, json={"body": f"@{ROBOT} stop"}, headers=key)

    def posted(self, command: PostedCommand) -> dict[str, Any]:
        return dict(wait_for("the command is posted", lambda: command.post, 60.0))

    def answers(self, command: PostedCommand) -> list[dict[str, Any]]:
        """Return the robot's replies to the command, oldest first."""
        post = self.posted(command)
        found = self._request("GET", f"/topics/{post['topic_id']}/posts")["items"]
        return [p for p in found if p["author"]["name"] == ROBOT and p["reply_to"] == post["id"]]

    def final(self, command: PostedCommand) -> dict[str, Any]:
        """Return the final reply once it is posted, the agent's journal has closed the command, and the robot
        stands."""

        def find_finals() -> list[dict[str, Any]]:
            return [p for p in self.answers(command) if p["card"] and p["card"]["state"] in FINAL_STATES]

        wait_for(f"a final reply to {command.text!r}", find_finals, END_S)
        wait_for("the journal is closed over the command", lambda: self.journal(command), 60.0)
        wait_for("the robot stands", lambda: not self.moves(command.began), 60.0)
        finals = find_finals()
        assert len(finals) == 1, finals
        return finals[0]

    def journal(self, command: PostedCommand) -> str:
        """Return the command's final state in the agent's journal, or an empty string while it is open."""
        found = self.in_journal("SELECT final FROM claim WHERE post = :a", self.posted(command)["id"])
        return str(found[0] or "") if found else ""

    @property
    def board_path(self) -> Path:
        path = app.board_settings(self.config).database_path
        assert path is not None
        return path

    def in_journal(self, query: str, *values: str) -> Any:
        """Return the first row of a query on the agent's journal, with `:a`, `:b` for the values."""
        found = self.journal_store.rows(query, **dict(zip("ab", values, strict=False)))
        return tuple(found[0]) if found else None

    def final_versions(self, post: dict[str, Any]) -> list[str]:
        """Return the versions of the status post that contain an end, which unlike a status has paragraphs.

        A question for an approval, with its preview, is no end. A version that only adds a late recording does not
        count again.
        """
        with closing(sqlite3.connect(f"file:{self.board_path}?mode=ro", uri=True, timeout=10.0)) as db:
            older = db.execute(
                "SELECT raw FROM post_versions WHERE post_id = ? ORDER BY version", (int(post["id"]),)
            ).fetchall()
        versions = (*(row[0] for row in older), post["raw"])
        ends = [raw for raw in versions if "\n\n" in raw and not raw.startswith(WAITS)]
        late = len(ends) > 1 and "a recording" in ends[-1] and "a recording" not in ends[-2]
        return ends[: len(ends) - late]


def check(scene: KillScene, command: PostedCommand) -> str:
    """Check what must hold after any death: one final reply, one motion at most, nothing written twice.

    Return the final state.
    """
    final = scene.final(command)
    state = str(final["card"]["state"])
    assert len(scene.answers(command)) == 1, "a claim, status or final post is there twice"
    ends = scene.final_versions(final)
    assert len(ends) == 1, "the end was reported twice:\n" + "\n---\n".join(ends)
    assert scene.motions(command.began) <= 1, "the motion was begun again"
    assert len(final["images"]) == len({image["id"] for image in final["images"]}) <= 3  # photo, path, recording
    if state == "done":
        assert scene.motions(command.began) == 1
        assert abs(scene.walked_m(command.began) - 0.3) < 0.05, "done, and not what was asked"
    if state == "cancelled":
        assert scene.motions(command.began) == 0, "cancelled, and yet it moved"
    return state
