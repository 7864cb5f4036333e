"""Commands are read while they are written: by the grammar and the screen of agents, in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from agentrob.board.command_reading import DraftCommand, ReadableRobot
from agentrob.model import Account, ActionClass, Capabilities, Direction, Limits, Op, Plan, Primitive, RobotRights, Role
from agentrob.process.answering import client
from agentrob.process.answering.server import TooSlow
from agentrob.wiring.command_reader import ReaderProcess, read

RIGHTS = RobotRights(
    owner="ann", command=dict.fromkeys(ActionClass, "operator"), approve="owner", approval=("gesture",)
)
DOG = ReadableRobot(
    "quadruped",
    Capabilities("go2", frozenset(Op), Limits()),
    RobotRights(command=RIGHTS.command),
    sees=("ball", "box"),
    consents=frozenset({"flip"}),
)
SLOW = ReadableRobot("humanoid", Capabilities("g1", frozenset({Op.MOVE, Op.HELLO}), Limits(speed_mps=0.2)), RIGHTS)
ALICE = Account("1", "alice", role=Role.OPERATOR)


@pytest.mark.parametrize(
    ("text", "outcome", "line"),
    [
        ("@quadruped walk forward 1 m, then wave", "would", "I would walk forward 1 m, then wave."),
        ("@quadruped walk forward 9 m", "refuse", "Too far: 5 m a step at most."),
        ("@quadruped walk forward 5 m, then back 5 m, then forward 1 m", "refuse", "Too far: 10 m a command at most."),
        ("@quadruped walk 1 m at 2 m/s", "refuse", "Too fast: 0.5 m/s at most."),
        ("@quadruped turn left 400 degrees", "refuse", "Too far: I turn 360° a step at most."),
        ("@quadruped walk forward 2 m at 0.02 m/s", "refuse", "Too long: 60 s a command at most."),
        ("@quadruped wave 11 times", "refuse", "Too much: 10 steps a command at most."),
        ("@humanoid make a heart", "refuse", "This robot cannot do this: make a heart. It can: walk, wave."),
        ("@humanoid wave", "needs_approval", "This would wait for an approval. Then I would wave."),
        ("@quadruped drive into the wall", "refuse", "I do not drive into people, animals or things"),
        ("@quadruped walk", "ask_back", "How far? `walk` has no distance, and I do not guess. For example:"),
        ("@quadruped stop", "stop", "I would stop."),
        ("@quadruped help", "answer", "I would answer, without moving."),
        ("@quadruped 向前走一米，然后挥手", "would", "我会向前走1米，然后打个招呼。"),
        ("@quadruped 向前走九米", "refuse", "太远：每步最多 5 米。"),
        ("@quadruped 停", "stop", "我会停下。"),
        ("@quadruped preview wave", "answer", "Only a preview; nothing moves. I would wave."),
        ("preview: @quadruped wave", "answer", "Only a preview; nothing moves. I would wave."),
        ("@quadruped wave, but show me first", "answer", "Only a preview; nothing moves. I would wave."),
        ("@quadruped 预演 挥手", "answer", "只是预演，没有任何动作。我会打个招呼。"),
        ("@quadruped preview", "ask_back", "What shall I preview?"),
        ("@quadruped preview walk forward 9 m", "refuse", "Too far: 5 m a step at most."),
        ("@quadruped previews are great, wave", "ask_back", "Shall I only preview this?"),
        ("@quadruped every weekday at 9 wave", "would", "I would wave. At the times that my reply will name."),
        (
            "@humanoid in 10 minutes wave",
            "needs_approval",
            "This would wait for an approval. Then I would wave. At",
        ),
        ("@quadruped tomorrow at 9 walk forward 9 m", "refuse", "Too far: 5 m a step at most."),
        ("@quadruped tomorrow wave", "ask_back", "I understood the day, but not the time."),
        ("@quadruped schedules", "answer", "I would answer, without moving."),
        ("@quadruped 明天早上九点挥手", "would", "我会打个招呼。时间见我的答复。"),
        ("@rex wave, then @quadruped wave", "would", "I would wave. I begin when `rex` is done."),
        ("@quadruped wave, then @rex wave", "would", "I would wave."),
        ("@rex wave, then @quadruped walk forward 9 m", "refuse", "Too far: 5 m a step at most."),
        ("@quadruped wave, then @rex fly", "ask_back", "I did not understand the part of `rex`, `fly`."),
        ("@rex 挥手，等它挥完再让 @quadruped 挥手", "would", "我会打个招呼。等 `rex` 完成后开始。"),
        ("@quadruped come home", "would", "I would go home."),
        ("@quadruped wave and come home", "would", "I would wave, then go home."),
        ("@quadruped turn to the red ball", "would", "I would turn towards the red ball."),
        ("@quadruped what colours do you see?", "would", "I would name the colours that the camera shows."),
        ("@quadruped 转向红球", "would", "我会转向红色球。"),
        ("@quadruped turn to the green column", "ask_back", "I cannot `turn to the green column`"),
        ("@humanoid turn to the red ball", "ask_back", "I cannot `turn to the red ball`"),
        ("@quadruped come home?", "ask_back", "Is this a question or a command?"),
        ("@quadruped walk a 9 m square", "ask_back", "`walk a square of 9 m`: that size does not fit my limits"),
    ],
)
def test_a_text_is_read_in_one_line(text: str, outcome: str, line: str) -> None:
    (found,) = read(DraftCommand(text, ALICE, (DOG, SLOW))).robots
    assert found.outcome == outcome
    assert found.line.startswith(line)
    assert "did not move" not in found.line
    assert "没有动" not in found.line


def test_law_10_what_the_owner_did_not_consent_to_is_refused_while_it_is_written() -> None:
    real = replace(DOG, consents=frozenset())
    (found,) = read(DraftCommand("@quadruped do a backflip", ALICE, (real,))).robots
    assert (found.outcome, found.rule) == ("refuse", "consent.flip")
    assert found.line.startswith("A backflip needs the consent of the robot's owner")
    (found,) = read(DraftCommand("@quadruped do a backflip", ALICE, (DOG,))).robots
    assert found.outcome == "would", "it consents, or that is not known"
    simulated = replace(real, can=replace(real.can, simulated=True))
    assert read(DraftCommand("@quadruped do a backflip", ALICE, (simulated,))).robots[0].outcome == "would"


def test_the_scene_is_known_while_it_is_written() -> None:
    text = "@quadruped walk forward 3 m"
    assert read(DraftCommand(text, ALICE, (DOG,))).robots[0].outcome == "would"
    stairs = replace(DOG, scene="There are stairs 2 m in front of the robot.")
    (found,) = read(DraftCommand(text, ALICE, (stairs,))).robots
    assert (found.outcome, found.rule.split(".")[0]) == ("refuse", "scene")


def test_each_robot_reads_its_own_part() -> None:
    found = read(DraftCommand("@quadruped walk 1 m. @humanoid walk 2 m. @nobody wave.", ALICE, (DOG, SLOW)))
    assert found.mentioned == ("quadruped", "humanoid", "nobody")
    assert [(one.robot, one.steps[0]["distance_m"]) for one in found.robots] == [("quadruped", 1.0), ("humanoid", 2.0)]


def test_what_was_done_in_the_thread_can_be_done_again() -> None:
    before = Plan((Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.5),))
    known = ReadableRobot(DOG.name, DOG.can, DOG.rights, (before,))
    assert read(DraftCommand("@quadruped again", ALICE, (known,))).robots[0].line == "I would walk forward 1.5 m."
    assert "nothing in this thread" in read(DraftCommand("@quadruped again", ALICE, (DOG,))).robots[0].line


def test_law_2_who_may_not_command_is_told_who_can_allow_it() -> None:
    member = Account("2", "bob", role=Role.MEMBER)
    (found,) = read(DraftCommand("@quadruped wave", member, (DOG,))).robots
    assert (found.outcome, found.rule) == ("refuse", "rights.operator")
    assert "An admin of the forum can give it." in found.line


def test_law_2_an_account_for_simulated_robots_is_told_where_it_may_command() -> None:
    player = Account("3", "eve", commands_simulated=True)
    simulated = replace(DOG, can=replace(DOG.can, simulated=True))
    assert read(DraftCommand("@quadruped wave", player, (simulated,))).robots[0].outcome == "would"
    (found,) = read(DraftCommand("@quadruped wave", player, (DOG,))).robots
    assert (found.outcome, found.rule) == ("refuse", "rights.simulated")


@pytest.fixture(scope="module")
def process() -> Iterator[ReaderProcess]:
    process = ReaderProcess()
    yield process
    process.close()


def test_the_process_reads_as_this_process_does(process: ReaderProcess) -> None:
    for text in ("@quadruped walk forward 1 m, then wave", "@humanoid wave", "@quadruped \ud83d 走", "", "@nobody hi"):
        draft = DraftCommand(text.encode("utf-8", "replace").decode(), ALICE, (DOG, SLOW))
        assert process.read(draft) == read(draft)


def test_a_process_that_has_just_been_started_has_longer_to_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "ANSWER_S", 0.01)
    started = ReaderProcess()
    try:
        assert started.read(DraftCommand("@quadruped wave", ALICE, (DOG,))).robots[0].outcome == "would"
    finally:
        started.close()


def test_a_closed_process_reads_nothing(process: ReaderProcess) -> None:
    ended = ReaderProcess()
    ended.close()
    with pytest.raises(TooSlow):
        ended.read(DraftCommand("@quadruped wave", ALICE, (DOG,)))
