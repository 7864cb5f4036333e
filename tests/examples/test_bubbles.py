"""An operation that AgentRob has never heard of works from the post to the report, in both languages, from its
declaration alone."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pydantic import TypeAdapter

from agentrob.board.command_reading import DraftCommand, ReadableRobot
from agentrob.board.robots.abilities import abilities_of, capabilities_of
from agentrob.errors import ConfigError
from agentrob.language.messages.help import help_text
from agentrob.minds.llm.prompt import system_prompt
from agentrob.minds.visual_loop.tools import step_of, tools_of
from agentrob.model import Account, ActionClass, Capabilities, Mandate, Plan, RobotRights, Role
from agentrob.model.operations.data import as_data
from agentrob.model.plans import step_of as step_from
from agentrob.wiring.app import capabilities_of as described
from agentrob.wiring.command_reader import read
from tests.agent.agent_scene import ROBOT, Driver, Scene, make_scene, robot_settings
from tests.in_process import agentrob

ROOT = Path(__file__).parents[2]
FILE = ROOT / "examples/bubbles/agentrob_bubbles.py"


def plug_in(folder: Path, source: str) -> None:
    """Install the example in a folder of its own, as pip does, with this source."""
    (folder / "agentrob_bubbles.py").write_text(source, encoding="utf-8")
    facts = folder / "agentrob_bubbles-0.1.0.dist-info"
    facts.mkdir()
    (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: agentrob-bubbles\nVersion: 0.1.0\n")
    (facts / "entry_points.txt").write_text("[agentrob.robots]\nbubbles = agentrob_bubbles:BubbleRobot\n")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("bubbles")
    plug_in(folder, FILE.read_text(encoding="utf-8"))
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(folder)
        yield folder
    sys.modules.pop("agentrob_bubbles", None)


@pytest.fixture(scope="module")
def driver(installed: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driver]:
    driver = Driver(tmp_path_factory.mktemp("driver"), robot_settings(model="bubbles", options={"time_scale": 1}))
    yield driver
    driver.end()


@pytest.fixture
def scene(driver: Driver, tmp_path: Path) -> Scene:
    return make_scene(driver, tmp_path, model="bubbles")


@pytest.fixture
def can(installed: Path) -> Capabilities:
    return described("bubbles")


# ---------------------------------------------------------------------- one file
def test_nothing_outside_its_own_file_knows_the_operation() -> None:
    assert [path for path in (ROOT / "src").rglob("*.py") if "blow_bubbles" in path.read_text(encoding="utf-8")] == []


def test_the_guide_shows_the_example_as_it_is() -> None:
    guide = (ROOT / "docs/robots/add-a-robot.md").read_text(encoding="utf-8")
    (shown,) = [block for block in re.findall(r"```python\n(.*?)```", guide, re.DOTALL) if "BLOW_BUBBLES" in block]
    assert shown in FILE.read_text(encoding="utf-8")
    assert len(shown.splitlines()) <= 12


# ---------------------------------------------------------------------- from the post to the report
@pytest.mark.parametrize(
    ("post", "step", "did"),
    [
        ("blow bubbles for 2 seconds", "blow bubbles for 2 seconds", "blew bubbles (2."),
        ("please blow 2 seconds of bubbles", "blow bubbles for 2 seconds", "blew bubbles (2."),
        ("make bubbles", "blow bubbles for 3 seconds", "blew bubbles (3."),
        ("吹2秒泡泡", "吹泡泡 2 秒", "吹了泡泡（2."),
        ("请吹泡泡两秒", "吹泡泡 2 秒", "吹了泡泡（2."),
    ],
)
async def test_a_post_is_carried_out_and_reported_with_what_was_measured(
    scene: Scene, post: str, step: str, did: str
) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} {post}"))
    assert reply.card is not None
    assert reply.card.state == "done", reply.raw
    assert did in reply.raw
    row = next(line for line in reply.raw.splitlines() if line.startswith("| 1 |"))
    assert f"| {step} |" in row
    assert re.search(r"\| [23]\.\d s \|", row)


async def test_it_stands_among_other_steps_and_is_repeated(scene: Scene) -> None:
    async with scene.agent():
        asked = await scene.post("alice", f"@{ROBOT} walk 0.5 m, blow bubbles for 1 s twice and then turn left")
        reply = await scene.final(asked)
        assert reply.card is not None
        assert (reply.card.state, reply.card.steps) == ("done", 4), reply.raw
        again = await scene.final(await scene.post("alice", f"@{ROBOT} again", topic=asked.topic_id))
    assert "blew bubbles" in again.raw


@pytest.mark.parametrize(
    ("post", "state", "said"),
    [
        ("blow bubbles for 30 seconds", "refused", "30 s is beyond what “blow bubbles” allows: 1 to 10 s."),
        ("吹泡泡30秒", "refused", "30 秒超出了“吹泡泡”允许的范围：1 到 10 秒。"),
        ("blow bubbles for 3 metres", "asks_back", "What shall I do with"),
        ("blow bubbles for 2 seconds and sing a song", "asks_back", "I cannot do that"),
    ],
)
async def test_what_it_does_not_allow_is_refused_or_asked_about(scene: Scene, post: str, state: str, said: str) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", f"@{ROBOT} {post}"))
    assert reply.card is not None
    assert reply.card.state == state, reply.raw
    assert said in reply.raw


async def test_a_stop_ends_it(scene: Scene) -> None:
    async with scene.agent():
        asked = await scene.post("alice", f"@{ROBOT} blow bubbles for 10 seconds, 5 times")
        await scene.state(asked, "running")
        await scene.post("bob", "stop", topic=asked.topic_id)
        reply = await scene.final(asked)
    assert reply.card is not None
    assert reply.card.state == "stopped", reply.raw


async def test_a_member_may_not_command_it(scene: Scene) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("bob", f"@{ROBOT} blow bubbles"))
    assert reply.card is not None
    assert reply.card.state == "refused"


@pytest.mark.slow  # the contract test runs in real time
def test_it_keeps_the_contract_of_every_robot(installed: Path) -> None:
    path = os.pathsep.join(filter(None, (os.environ.get("PYTHONPATH", ""), str(installed))))
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", ROOT / "examples/bubbles"],
        env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout


# ---------------------------------------------------------------------- what else follows from the declaration
def test_help_and_the_page_name_it(can: Capabilities) -> None:
    assert "- `@robbie blow bubbles for 3 seconds`" in help_text(can, "robbie", "en")
    assert "- `@robbie 吹泡泡 3 秒`" in help_text(can, "robbie", "zh")
    card = {"model": can.model, "ops": sorted(can.ops), "operations": [as_data(one) for one in can.declared]}
    assert ("blow bubbles", "@robbie blow bubbles for 3 seconds") in abilities_of("robbie", capabilities_of(card))


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("@robbie blow bubbles for 4 seconds", "I would blow bubbles for 4 seconds."),
        ("@robbie again", "I would blow bubbles for 2 seconds."),
        ("@robbie 吹泡泡30秒", "30 秒超出了“吹泡泡”允许的范围：1 到 10 秒。"),
    ],
)
def test_a_post_is_read_while_it_is_written(can: Capabilities, text: str, line: str) -> None:
    done = (Plan((can.bound(step_from({"op": "blow_bubbles", "seconds": 2.0})),)),)
    robot = ReadableRobot("robbie", can, RobotRights(command=dict.fromkeys(ActionClass, "operator")), done)
    draft = DraftCommand(text, Account("1", "alice", role=Role.OPERATOR), (robot,))
    drafts = TypeAdapter(DraftCommand)  # as it goes to the process that reads
    (reading,) = read(drafts.validate_json(drafts.dump_json(draft))).robots
    assert reading.line == line


def test_a_model_has_it_as_an_action_and_as_a_tool(can: Capabilities) -> None:
    assert "blow_bubbles" in system_prompt(can)
    mandate = Mandate({"blow_bubbles": 1}, steps=1)
    tool, _ = tools_of(mandate, can)
    assert tool.name == "act_blow_bubbles"
    step, _ = step_of(tool.name, tool.arguments.model_validate({"seconds": 2}), mandate, can)
    assert step.asked() == {"seconds": 2.0}
    with pytest.raises(ValueError, match="less than or equal to 10"):
        tool.arguments.model_validate({"seconds": 20})


def test_its_words_are_refused_at_start_where_they_mean_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "installed"
    folder.mkdir()
    plug_in(folder, FILE.read_text(encoding="utf-8").replace("blow bubbles|make bubbles", "stop the show"))
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "agentrob_bubbles", raising=False)
    with pytest.raises(ConfigError, match="the operation 'blow_bubbles' is asked for by “stop the show”, which stops"):
        described("bubbles")
    done = agentrob(tmp_path, "drive", "bubbles", "wave", AGENTROB_DATA=str(tmp_path / "data"))
    assert done.returncode == 1
    assert "which stops robots; choose other words" in done.stderr.splitlines()[-1]
