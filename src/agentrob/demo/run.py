"""Run the demo: start and end the forum, the simulated world, and the robots' drivers and agents on this machine."""

from __future__ import annotations

import asyncio
import contextlib
import fcntl
import json
import os
import shutil
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO

from agentrob import plugins
from agentrob.config import load as configuration
from agentrob.config.board import BoardConfig
from agentrob.config.forum import ForumConfig
from agentrob.config.load import Config
from agentrob.config.minds import MindConfig
from agentrob.config.robots import RatesConfig, RobotConfig
from agentrob.demo import terminal
from agentrob.demo.errors import DemoError
from agentrob.demo.ports import choose_port
from agentrob.errors import ConfigError
from agentrob.model import AccountKind, CommandState, Role
from agentrob.process.child import Child, ChildError, terminate_all
from agentrob.process.signals import delayed_signals, sigterm_interrupts
from agentrob.sim.domains import PrivateDomain
from agentrob.wiring.running_demo import demo_folder, running_demo

#: Handle of each robot, and its kind.
ROBOTS = {"quadruped": "go2", "humanoid": "g1"}
VISITOR = "visitor"
#: A simulated robot is this near to where its odometry says, after some tens of metres.
ROOM_ERROR_M = 0.1
SENTENCES = (
    "@quadruped walk forward 1 metre, turn left, wave and take a photo",
    "@humanoid walk forward 1 metre, turn left, wave",
    "@quadruped wave. @humanoid make a heart.",
)


@dataclass(frozen=True, slots=True)
class DemoSettings:
    """The demo's options. `port` None takes 8088 or, if that is in use, any free port; 0 takes any free port; `data` is
    the data folder, which is kept; with `post` the demo posts this text, waits for the answer and ends; with `browser`
    it opens a browser where there is one.

    `more` are kinds of additional robots; each is named after its kind. `mind` reads the posts: an
    installed one such as `rules`, or one of `./agentrob.toml` or of the data folder's `agentrob.toml`; None uses the
    mind of the previous start.
    """

    data: Path
    port: int | None = None
    post: str | None = None
    as_json: bool = False
    world: str = "room"
    more: Sequence[str] = ()
    mind: str | None = None
    browser: bool = True

    @property
    def robots(self) -> dict[str, str]:
        """The handle and kind of each robot."""
        return ROBOTS | {kind: kind for kind in self.more if kind not in ROBOTS.values()}


class Demo:
    """A running demo, as a context manager. `url` and `children` are set after `start`."""

    def __init__(self, settings: DemoSettings, says: Callable[[str], None] = lambda _: None) -> None:
        """`says` is called with the name of what is being started."""
        self.settings, self.says = settings, says
        self.data = settings.data
        self.robots = settings.robots
        self.children: list[Child] = []
        self._domains: dict[str, PrivateDomain] = {}
        self._lock: IO[str] | None = None
        self.url = ""
        self.tokens: dict[str, str] = {}
        self.runtime: Path | None = None
        self.room_url = self.camera = ""

    def __enter__(self) -> Demo:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with _ignoring_signals():
            terminate_all(self.children)
            for domain in self._domains.values():
                domain.close()
            if self.runtime:
                shutil.rmtree(self.runtime, ignore_errors=True)
            if self._lock:
                (self.data / "demo.json").unlink(missing_ok=True)
                self._lock.close()

    # ------------------------------------------------------------------ start
    def start(self) -> None:
        """Start everything; return when posts are answered. Raises `DemoError` or `ChildError`."""
        self._check_robots()
        self._hold_data()
        try:
            self._minds()
            self._start()
        except OSError as e:
            raise DemoError(f"cannot use the data folder {self.data}: {e}") from None

    def _start(self) -> None:
        # A private folder for sockets avoids conflicts with another demo, or with a driver of the same name.
        self.runtime = Path(tempfile.mkdtemp(prefix="agentrob-demo-"))
        port = choose_port(self.settings.port)
        self.url = f"http://127.0.0.1:{port}"
        self.says("starting the room, and setting up the forum")
        world = self._start_world()
        config = self._write_config(port, room_url="")
        self._bootstrap(config)
        board = self._child("board", "board", "serve", "--config", str(config))
        simulators = self._start_simulators()
        self.says("building the room and its robots")
        room = world.wait_ready()
        self.room_url, self.camera = room["http"], room["camera"]
        for simulator in simulators:
            simulator.wait_ready()
        config = self._write_config(port, self.room_url)
        self.says("starting the robots' drivers and agents")
        drivers = [self._child(f"driver-{name}", "driver", name, "--config", str(config)) for name in self.robots]
        board.wait_ready()
        agents = self._start_agents(list(self.robots), config)
        for driver in drivers:
            self.says(f"waiting for {driver.name.replace('-', ' of @')}")
            driver.wait_ready()
        self.says("waiting for the agents")
        for child in agents:
            child.wait_ready()
        facts = {"pid": os.getpid(), "url": self.url, "room": self.room_url, "runtime": str(self.runtime)}
        (self.data / "demo.json").write_text(json.dumps(facts))

    def _check_robots(self) -> None:
        """Raise `ConfigError` if a robot is not installed or cannot be loaded, `SimError` if it cannot be simulated."""
        from agentrob.wiring import app

        for kind in self.robots.values():
            app.capabilities_of(kind)
            app.simulated_robot(kind, 0, self.settings.world)

    def _start_world(self) -> Child:
        """Start the world. Robots outside the world get a domain too, because their drivers lock it."""
        for name in self.robots:
            self._domains[name] = PrivateDomain()
        args = ["sim", "--ledger", str(self.data / "world.jsonl"), "--world", self.settings.world]
        for name, model in ROBOTS.items():
            args += ["--domain", f"{model}={self._domains[name].number}"]
        return self._child("world", *args)

    def _start_simulators(self) -> list[Child]:
        """Start the simulations that packages of robots bring along."""
        from agentrob.wiring.simulators import has_simulator

        return [
            self._child(f"simulator-{name}", "simulator", model, "--domain", str(self._domains[name].number))
            for name, model in self.robots.items()
            if has_simulator(model)
        ]

    def _start_agents(self, robots: Sequence[str], config_path: Path) -> list[Child]:
        """Start a worker that runs the agents of these robots."""
        from agentrob.wiring import app

        config = app.load(config_path)
        tokens = {app.token_variable(config, robot): self.tokens[robot] for robot in robots}
        words = ("agent", "run", *robots, "--config", str(config_path))
        return [self._child("worker", *words, env=tokens, ready_lines=len(robots))]

    def _child(self, name: str, *args: str, env: dict[str, str] | None = None, ready_lines: int = 1) -> Child:
        own = {"AGENTROB_DATA": str(self.data), "AGENTROB_RUNTIME": str(self.runtime), **(env or {})}
        with delayed_signals():
            child = Child(name, args, self.data / "log" / f"{name}.log", own, ready_lines)
            self.children.append(child)
        return child

    def _hold_data(self) -> None:
        try:
            self.data.mkdir(parents=True, exist_ok=True, mode=0o700)
            self._lock = (self.data / "demo.lock").open("w")
        except OSError as e:
            raise DemoError(f"cannot use the data folder {self.data}: {e.strerror}") from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._lock.close()
            self._lock = None
            url = (running_demo(self.data) or {}).get("url", "")
            raise DemoError(
                f"a demo already runs{' at ' + url if url else ''} with the data folder {self.data}; "
                "end it, or choose another folder with --data"
            ) from None

    def _write_config(self, port: int, room_url: str) -> Path:
        from agentrob.wiring import app

        minds, mind = self._minds()
        # the visitor owns the robots and the forum, and has no rate limit
        own = {"owner": VISITOR, "rates": RatesConfig(commands_per_hour=0), "mind": mind}
        robots = {
            name: app.simulated_robot(model, self._domains[name].number, self.settings.world).model_copy(update=own)
            for name, model in self.robots.items()
        }
        robots = {name: _in_one_room(robot) if app.in_world(robot.model) else robot for name, robot in robots.items()}
        robots |= {  # the room's camera sees only robots in the world
            name: _in_room(robot, room_url) for name, robot in robots.items() if room_url and app.in_world(robot.model)
        }
        config = Config(
            data=str(self.data),
            board=BoardConfig(listen=f"127.0.0.1:{port}", base_url=self.url),
            forum=ForumConfig(url=self.url),
            robots=robots,
            minds=minds,
        )
        path = self.data / "agentrob.toml"
        config.write(path, "Written by `agentrob demo` at each start, which keeps only [minds]; edit a copy.")
        return path

    def _minds(self) -> tuple[dict[str, MindConfig], str]:
        """The configured models, and the mind that reads posts. Raises `ConfigError` if it is unknown or cannot be
        loaded."""
        path = self.data / "agentrob.toml"
        previous = self._previous_config(path)
        minds = previous.minds | configuration.load().minds
        last = next((robot.mind for robot in previous.robots.values()), "rules")
        known = [*plugins.names("minds"), *sorted(minds)]
        mind = self.settings.mind or (last if last in known else "rules")
        if mind not in known:
            valid = ", ".join(known)
            raise ConfigError(f"unknown mind {mind!r}; valid: {valid}; add [minds.NAME] to ./agentrob.toml or {path}")
        if mind not in minds and mind != "rules":
            plugins.find("minds", mind)  # else the agents would try again and again to load one that cannot be loaded
        return minds, mind

    def _previous_config(self, path: Path) -> Config:
        """The configuration of the previous start. An invalid file is renamed, so that the demo starts anyway."""
        if not path.exists():
            return Config()
        try:
            return configuration.load(path)
        except ConfigError as e:
            aside = path.with_suffix(".toml.broken")
            path.replace(aside)
            print(f"AgentRob demo: {e}; renamed the file to {aside}", file=sys.stderr)
            return Config()

    def _bootstrap(self, config_path: Path) -> None:
        from agentrob.wiring import app

        config = app.load(config_path)
        app.own_board_account(config, VISITOR, AccountKind.HUMAN, Role.ADMIN, "Visitor")
        for name in self.robots:
            app.own_board_account(config, name, AccountKind.ROBOT_AGENT, Role.MEMBER, name.capitalize())
            app.own_board_robot(config, name, VISITOR)
        for name in (*self.robots, VISITOR):
            app.revoke_board_tokens(config, name, "demo")
            self.tokens[name] = app.board_token(config, name, "demo")

    # ------------------------------------------------------------------ while it runs
    def link(self) -> str:
        """A one-time link that signs the visitor in."""
        from agentrob.wiring import app

        return app.board_link(app.load(self.data / "agentrob.toml"), VISITOR)

    def watch(self) -> None:
        """Block until a child ends; then raise `ChildError`."""
        while True:
            self.check()
            time.sleep(0.5)

    def check(self) -> None:
        """Raise `ChildError` if a child has ended."""
        for child in self.children:
            if not child.alive:
                raise ChildError(f"{child.name} has ended: {child.last_line()} (log: {child.log})")


def _in_one_room(robot: RobotConfig) -> RobotConfig:
    """The settings of a robot in the world, which shares its room with the others: it starts where its map says."""
    return robot.model_copy(update={"room": robot.map.room, "room_error_m": ROOM_ERROR_M})


def _in_room(robot: RobotConfig, room_url: str) -> RobotConfig:
    """The settings of a robot in the world, with the addresses of the room's HTTP server."""
    shown = robot.map.model_copy(update={"geometry": f"{room_url}/geometry/{robot.model}"})
    recording = robot.recording.model_copy(update={"camera": f"{room_url}/film/{robot.model}.jpg"})
    room = {
        "room_camera": f"{room_url}/overview.jpg", "room_reset": f"{room_url}/reset", "map": shown,
        "recording": recording,
    }  # fmt: skip
    return robot.model_copy(update=room)


def config_for(robot: str | None, path: Path | None) -> Config:
    """The configuration of this robot: the file, or that of the running demo if the file does not name the robot.

    For the demo's configuration it also sets AGENTROB_RUNTIME to the demo's socket folder, so that this process finds
    the demo's drivers.
    """
    config = configuration.load(path)
    if path is not None or robot in config.robots or (robot is None and config.robots):
        return config
    data = demo_folder(once=False)
    facts = running_demo(data)
    if facts is None:
        return config
    demo = configuration.load(data / "agentrob.toml")
    if robot is not None and robot not in demo.robots:
        return config
    os.environ["AGENTROB_RUNTIME"] = facts["runtime"]
    return demo


@contextlib.contextmanager
def _ignoring_signals() -> Iterator[None]:
    """Ignore signals during shutdown, which has a time limit."""
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    before = {number: signal.signal(number, signal.SIG_IGN) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def run(settings: DemoSettings) -> int:
    """The command `agentrob demo`; returns the exit code."""
    with sigterm_interrupts(), Demo(settings) as demo:
        try:
            if settings.post is not None:
                demo.start()
                return _post_once(demo, settings)
            with terminal.progress() as demo.says:
                demo.start()
            print(welcome(demo), flush=True)
            if settings.browser:
                terminal.open_browser(demo.link)
            demo.watch()
        except KeyboardInterrupt:
            print("\nAgentRob demo: ending", file=sys.stderr)
            return 0 if settings.post is None else 130
    return 0


def welcome(demo: Demo) -> str:
    from agentrob.language.messages.help import commands
    from agentrob.wiring import app

    others = {name: kind for name, kind in demo.robots.items() if name not in ROBOTS}
    more = [f"@{name} {commands(app.capabilities_of(kind), 'en')[0]}" for name, kind in others.items()]
    software = demo.camera == terminal.SOFTWARE_CAMERA
    notes = ["There is no OpenGL library, so the pictures come from a simple camera (libosmesa6 has one)"]
    return terminal.welcome(demo.link(), (*SENTENCES, *more), str(demo.data), notes if software else ())


def print_link(data: Path) -> None:
    """The command `agentrob demo link`."""
    facts = running_demo(data)
    if facts is None:
        raise DemoError(f"no demo is running with the data folder {data}; start one with: agentrob demo")
    print(Demo(DemoSettings(data)).link())


# ---------------------------------------------------------------------- one post, then end
def _post_once(demo: Demo, settings: DemoSettings) -> int:
    from agentrob.demo import visitor
    from agentrob.wiring import app

    assert settings.post is not None
    config = app.load(demo.data / "agentrob.toml")
    outcome = asyncio.run(visitor.ask(config, demo.tokens[VISITOR], settings.post, demo.check))
    if settings.as_json:
        print(json.dumps(outcome, ensure_ascii=False), flush=True)
    else:
        print(outcome["reply_markdown"] or outcome["error"])
    return 0 if outcome["status"] == CommandState.DONE else 1
