"""The command line without a simulated world: forum, fake robot and agent, each in its own process."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import httpx2
import pytest

from agentrob.process.child import Child, terminate_all
from agentrob.process.host_lock import namespaced
from agentrob.wiring import plan as planning
from tests import forked_process, in_process

AGENTROB = str(Path(sys.executable).with_name("agentrob"))
LIMIT_S = 60.0
DOMAIN = int(os.environ["AGENTROB_TEST_DOMAIN"])
CONFIG = """
data = "{data}"
[board]
listen = "127.0.0.1:{port}"
[forum]
url = "http://127.0.0.1:{port}"
[robots.rex]
model = "fake"
domain = {domain}
simulated = true
home_on_start = true
options = {{ time_scale = 50 }}
"""


def agentrob(folder: Path, *args: str, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [AGENTROB, *args],
        cwd=folder,
        env={**os.environ, **env},
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )


@dataclass
class Lab:
    """A folder with an `agentrob.toml`, a running board and driver, and clients of the board."""

    folder: Path
    url: str
    runtime: str
    robot_token: str
    operator: httpx2.Client

    @property
    def env(self) -> dict[str, str]:
        """The environment of an agent in this lab."""
        return {"AGENTROB_TOKEN": self.robot_token, "AGENTROB_RUNTIME": self.runtime}

    def post(self, text: str) -> str:
        topic = self.operator.post("/topics", json={"board_id": "robots", "title": text[:60], "body": text})
        assert topic.status_code == 201, topic.text
        return str(topic.json()["topic"]["id"])

    def answers(self, topic: str) -> list[dict[str, object]]:
        posts = self.operator.get(f"/topics/{topic}/posts").json()["items"]
        return [p for p in posts if p["author"]["name"] == "rex"]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    folder = tmp_path_factory.mktemp("lab")
    runtime = tmp_path_factory.mktemp("r")
    (folder / "agentrob.toml").write_text(CONFIG.format(data=folder / "data", port=0, domain=DOMAIN))
    config = str(folder / "agentrob.toml")
    board = Child("board", ["board", "serve", "--config", config], folder / "board.log")
    url = board.wait_ready()["url"]
    (folder / "agentrob.toml").write_text(
        CONFIG.format(data=folder / "data", port=url.rsplit(":", 1)[1], domain=DOMAIN)
    )
    driver = Child("driver", ["driver", "--config", config], folder / "driver.log", {"AGENTROB_RUNTIME": str(runtime)})
    driver.wait_ready()
    robot = agentrob(folder, "board", "account", "add", "rex", "--kind", "robot_agent")
    assert robot.returncode == 0, robot.stderr
    person = in_process.agentrob(folder, "board", "account", "add", "ann", "--role", "operator")
    assert person.stdout.startswith(url + "/enter/"), person.stderr
    token = in_process.agentrob(folder, "board", "account", "token", "ann").stdout.strip()
    with httpx2.Client(base_url=url + "/api/v1", headers={"Authorization": f"Bearer {token}"}, timeout=60) as operator:
        yield Lab(folder, url, str(runtime), robot.stdout.strip(), operator)
    terminate_all([driver, board])


def test_a_single_run_answers_the_waiting_posts_and_ends(lab: Lab) -> None:
    # The first run sets the watermark; older posts are never carried out.
    first = forked_process.agentrob(lab.folder, "agent", "once", **lab.env)
    assert first.returncode == 0, first.stderr
    topic = lab.post("@rex walk forward 1 m and take a photo")
    done = agentrob(lab.folder, "agent", "once", **lab.env)
    assert done.returncode == 0, done.stderr
    (answer,) = lab.answers(topic)
    assert answer["card"]["state"] == "done"  # type: ignore[index]
    again = forked_process.agentrob(lab.folder, "agent", "once", **lab.env)
    assert again.returncode == 0
    assert len(lab.answers(topic)) == 1


def test_an_agent_without_its_token_says_which_variable_it_needs(lab: Lab) -> None:
    done = in_process.agentrob(lab.folder, "agent", "run", AGENTROB_TOKEN="")
    assert done.returncode == 1
    assert "AGENTROB_TOKEN must hold the agent's forum token" in done.stderr


def test_stop_reaches_every_driver_without_a_configuration(lab: Lab, tmp_path: Path) -> None:
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken/agentrob.toml").write_text("[robots.rex\n")
    lock = namespaced(f"driver/fake/{DOMAIN}/rex")
    for type_in, folder, args in (
        (agentrob, tmp_path, ["stop"]),
        (forked_process.agentrob, tmp_path, ["stop", "--all"]),
        (forked_process.agentrob, tmp_path, ["stop", "nobody"]),
        (forked_process.agentrob, tmp_path / "broken", ["stop", "rex"]),
    ):
        done = type_in(folder, *args)
        assert f"{lock}: zero velocity commanded after" in done.stdout, args


def test_stop_names_one_robot_of_the_configuration(lab: Lab) -> None:
    one = in_process.agentrob(lab.folder, "stop", "rex")
    assert one.returncode == 0, one.stdout + one.stderr
    assert one.stdout.startswith("rex: zero velocity commanded after")


def test_a_credential_is_never_issued_for_another_account(lab: Lab) -> None:
    taken = in_process.agentrob(lab.folder, "board", "account", "add", "ann", "--kind", "robot_agent")
    assert taken.returncode == 1
    assert taken.stdout == ""
    assert "is there already, as human with the role operator" in taken.stderr


def test_an_account_can_be_changed_and_suspended_and_its_tokens_revoked(lab: Lab) -> None:
    token = in_process.agentrob(
        lab.folder, "board", "account", "add", "eve", "--kind", "commanding_agent"
    ).stdout.strip()
    with httpx2.Client(base_url=lab.url + "/api/v1", headers={"Authorization": f"Bearer {token}"}, timeout=60) as eve:
        assert eve.get("/boards").status_code == 200
        changed = in_process.agentrob(
            lab.folder, "board", "account", "change", "eve", "--role", "operator", "--suspend"
        )
        assert changed.stdout == "eve: commanding_agent, operator, suspended\n"
        assert eve.get("/boards").status_code == 403
        assert in_process.agentrob(lab.folder, "board", "account", "change", "eve", "--unsuspend").returncode == 0
        assert eve.get("/boards").status_code == 200
        assert (
            in_process.agentrob(lab.folder, "board", "account", "revoke", "eve").stdout
            == "1 tokens of eve are revoked\n"
        )
        assert eve.get("/boards").status_code == 401


def test_a_second_driver_and_a_second_board_are_refused_in_one_line(lab: Lab) -> None:
    for command, says in (
        (["driver", "rex"], ""),
        (["board", "serve"], "; set board.listen to another port, or end what listens there\n"),
    ):
        done = forked_process.agentrob(lab.folder, *command, AGENTROB_RUNTIME=lab.runtime)
        assert done.returncode == 1
        assert "Traceback" not in done.stderr
        assert done.stderr.endswith(says)
        assert done.stderr.count("\n") <= 2


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["driver", "max"], "robot 'max' is not configured"),
        (["drive", "dragon", "fly"], "installed robots: fake, g1, go2"),
        (["sim", "--domain", "go2"], "is not ROBOT=DOMAIN"),
        (["drive", "go2", "walk forward"], ""),
        (["demo", "--port", "70000"], "less than or equal to 65535"),
        (["board", "migrate", "--to", "0000"], "there is no revision '0000'; 0009_access_version, 0008_simulated"),
    ],
)
def test_invalid_arguments_are_answered_with_the_valid_ones(tmp_path: Path, args: list[str], says: str) -> None:
    done = in_process.agentrob(tmp_path, *args)
    assert done.returncode != 0
    assert says in done.stderr


def test_plan_shows_the_steps_and_moves_nothing(tmp_path: Path) -> None:
    done = in_process.agentrob(tmp_path, "plan", "walk forward 2 m, turn left and take a photo", "--json")
    told = json.loads(done.stdout)
    assert told["intent"] == "command"
    assert [s["op"] for s in told["plan"]] == ["move", "turn", "get_front_image"]
    assert told["verdict"]["decision"] == "allow"
    refused = in_process.agentrob(tmp_path, "plan", "walk forward 30 m", "--json")
    assert json.loads(refused.stdout)["verdict"]["decision"] == "refuse"


def test_plan_reads_the_part_of_the_first_mentioned_robot() -> None:
    told = planning.plan_text("@quadruped walk 1 m @humanoid wave", "go2")
    assert (told["intent"], [step["op"] for step in told["plan"]]) == ("command", ["move"])


@pytest.mark.parametrize(
    ("text", "steps", "runs"),
    [
        ("in 10 minutes wave", ["hello"], 1),
        ("every weekday at 9:00 walk 1 m and wave", ["move", "hello"], 30),
        ("每个工作日九点挥手", ["hello"], 30),
    ],
)
def test_plan_says_that_a_text_with_a_time_is_a_schedule(
    tmp_path: Path, text: str, steps: list[str], runs: int
) -> None:
    told = json.loads(in_process.agentrob(tmp_path, "plan", text, "--json").stdout)
    assert [step["op"] for step in told["plan"]] == steps
    assert (told["schedule"]["runs"], len(told["schedule"]["next_runs"])) == (runs, min(runs, 3))
    assert told["verdict"]["decision"] == "allow"
    shown = in_process.agentrob(tmp_path, "plan", text).stdout
    assert "a schedule: it would not run now, but on " in shown
    assert told["schedule"]["next_runs"][-1].split()[1] in shown
    assert "(UTC)" in shown


@pytest.mark.parametrize(
    ("text", "question"), [("tomorrow wave", "not the time"), ("every 31st wave", "when"), ("明天挥手", "几点")]
)
def test_plan_asks_about_a_time_that_is_not_understood(text: str, question: str) -> None:
    told = planning.plan_text(text, "go2")
    assert (told["intent"], told["plan"]) == ("ask_back", [])
    assert question in told["question"]
    assert "schedule" not in told


def test_plan_does_not_compile_harm_rules_for_a_plain_command() -> None:
    """Compiling all of them would take most of a second."""
    code = (
        "import sys\nsys.argv = ['agentrob', 'plan', 'walk forward 2 m']\n"
        "from agentrob.screening.text import patterns\n"
        "made = []\nreal = patterns.compiled\n"
        "def counted(groups, phrases, **how):\n    made.extend(phrases)\n    return real(groups, phrases, **how)\n"
        "patterns.compiled = counted\nfrom agentrob.cli.main import main\n"
        "try:\n    main()\nexcept SystemExit:\n    pass\nprint(len(made))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=LIMIT_S, check=True)
    assert "move direction=forward" in done.stdout
    assert int(done.stdout.splitlines()[-1]) < 10


def test_help_is_fast_because_imports_are_lazy(tmp_path: Path) -> None:
    heavy = ("mujoco", "numpy", "sqlalchemy", "matplotlib", "cyclonedds", "fastapi", "httpx2")
    code = (
        "import sys\nsys.argv = ['agentrob', '--help']\nfrom agentrob.cli.main import main\n"
        f"try:\n    main()\nexcept SystemExit:\n    pass\nprint([m for m in {heavy!r} if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=LIMIT_S, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_an_agent_that_serves_ends_on_sigterm(lab: Lab) -> None:
    config = str(lab.folder / "agentrob.toml")
    agent = Child("agent", ["agent", "run", "--config", config], lab.folder / "agent.log", lab.env)
    assert agent.wait_ready()["robot"] == "rex"
    topic = lab.post("@rex wave")
    deadline = time.monotonic() + LIMIT_S
    while not any(a["card"]["state"] == "done" for a in lab.answers(topic)):  # type: ignore[index]
        assert time.monotonic() < deadline, "no answer"
        with lab.operator.stream("GET", "/events", params={"heartbeat": 0.25}) as events:
            next(events.iter_lines())
    agent.process.send_signal(signal.SIGTERM)
    assert agent.process.wait(60) == 0
