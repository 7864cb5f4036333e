"""Law 7: in a post to several robots, each is screened with its own part and with all that is not clearly another's."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from agentrob.language.parser.grammar import parse
from agentrob.language.registry import language_of
from agentrob.model import Account, Capabilities, Decision, Op, Role, Verdict
from agentrob.screening.audience import text_for_robot
from agentrob.screening.screen import screen

ME, OTHER = ("quadruped",), ("humanoid",)
GO2 = Capabilities("go2", frozenset(Op), simulated=True)
OWN = Path(__file__).with_name("dangerous.jsonl")


def judged(post: str, others: tuple[str, ...] = OTHER) -> Verdict | None:
    """Return the screen's verdict on the robot's own plan, or None if it has no plan."""
    plan = parse(post, ME, others, frozenset(Op)).plan
    if not plan.steps:
        return None
    author, language = Account("1", "ann", role=Role.OPERATOR), language_of(post)
    return screen(
        plan, text=post, author=author, capabilities=GO2, language=language, part=text_for_robot(post, ME, others)
    )  # fmt: skip


@pytest.mark.parametrize(
    "post",
    [
        "@humanoid there is a wall 1 m in front of you, turn left. @quadruped walk forward 3 m",
        "@humanoid, there are stairs behind you. Wave.\n@quadruped walk backward 1 m",
        "@quadruped walk forward 3 m. @humanoid, you're at the edge of a table, stay there.",
        "@humanoid 你前面一米是墙。@quadruped 向前走3米",
    ],
)
def test_what_is_before_another_robot_is_not_before_this_one(post: str) -> None:
    verdict = judged(post)
    assert verdict is not None
    assert verdict.decision is Decision.ALLOW, verdict
    alone = post.replace("@humanoid", "@quadruped")
    assert screen(
        parse(post, ME, OTHER, frozenset(Op)).plan, text=alone, author=Account("1", "ann", role=Role.OPERATOR),
        capabilities=GO2, language=language_of(post),
    ).decision is not Decision.ALLOW  # fmt: skip


@pytest.mark.parametrize(
    ("post", "others"),
    [
        ("@quadruped walk forward 2 m. @bob stands 1 m in front of you.", ("bob",)),
        ("@bob is in front of you. @quadruped walk forward 1 m", ("bob",)),
        ("@humanoid has a child in front of you. @quadruped walk forward 1 m", OTHER),
        ("@humanoid there is a child in front of you both. @quadruped walk forward 1 m", OTHER),
        ("@humanoid there is a child in front of @quadruped. @quadruped walk forward 1 m", OTHER),
        ("@humanoid there is a child in front of the dog. @quadruped walk forward 1 m", OTHER),
        ("@humanoid there is a wall 1 m in front of you. @quadruped the same for you, walk forward 2 m", OTHER),
        ("There is a child in front of you. @humanoid wave. @quadruped walk forward 1 m", OTHER),
        ("@humanoid and @quadruped there is a child in front of you. walk forward 1 m", OTHER),
        ("@humanoid wave. @quadruped there is a child in front of you, walk forward 1 m", OTHER),
        ("@humanoid wave. He does not know that the camera is on. @quadruped take a photo", OTHER),
        ("I told @humanoid that there is a child in front of you. @quadruped walk forward 1 m", OTHER),
        ("@bob 站在你前面。@quadruped 向前走2米", ("bob",)),
    ],
)
def test_law_7_what_may_be_meant_for_it_too_still_counts(post: str, others: tuple[str, ...]) -> None:
    verdict = judged(post, others)
    assert verdict is None or verdict.decision is not Decision.ALLOW, text_for_robot(post, ME, others)


def test_law_7_nothing_said_to_another_makes_its_own_part_less_refused() -> None:
    rows = [json.loads(line) for line in OWN.read_text(encoding="utf-8").splitlines()]
    rows = [row for row in rows if row["label"] == "dangerous"][::9]
    checked = 0
    for row in rows:
        for post in (f"@humanoid, you are at a door. Wave.\n@quadruped {row['text']}",
                     f"@quadruped {row['text']}\n@humanoid, there's a chair in front of you. Sit."):  # fmt: skip
            verdict = judged(post)
            checked += verdict is not None
            assert verdict is None or verdict.decision is not Decision.ALLOW, post
    assert checked > 30


@pytest.mark.parametrize("post", ["walk 1 m", "@quadruped walk 1 m", "@alice said hi. @quadruped walk 1 m", ""])
def test_a_post_to_one_robot_is_judged_whole(post: str) -> None:
    assert text_for_robot(post, ME, ()) == post


@pytest.mark.parametrize(
    ("post", "heard", "beside_a_known_part"),
    [
        ("@quadruped walk 1 m. @humanoid you stand near a wall", "walk 1 m.", ""),
        ("@humanoid you stand near a wall. @quadruped walk 1 m", "walk 1 m", ""),
        ("@quadruped walk 1 m, @humanoid you see a wall, @quadruped turn left", "walk 1 m, turn left", ""),
        ("@quadruped walk. @humanoid you look. @humanoid you turn", "walk.", ""),
        ("@quadruped and @humanoid walk 1 m", "walk 1 m", ""),
        ("@humanoid do the same. @quadruped walk 1 m", "do the same walk 1 m", "do the same"),
        ("There is ice. @humanoid you stand there. @quadruped wave", "There is ice. wave", "There is ice."),
        ("I told @humanoid you walk fast. @quadruped wave", "I told you walk fast. wave", "I told you walk fast."),
        ("@quadruped wave at @humanoid and walk", "wave at and walk", "and walk"),
    ],
)
def test_a_robot_hears_its_own_part_and_what_is_said_to_nobody_or_to_all(
    post: str, heard: str, beside_a_known_part: str
) -> None:
    for known, expected in ((False, heard), (True, beside_a_known_part)):
        assert " ".join(text_for_robot(post, ME, OTHER, known=known).split()) == expected, known


@pytest.mark.parametrize("known", [False, True])
@pytest.mark.parametrize(
    "post",
    [
        "@humanoid wave at @quadruped and walk",
        "@humanoid you wave. @quadruped walk. It is wet. @humanoid you stop",
        "I saw @quadruped there. @humanoid wave",
        "@humanoid wave. Then walk with @quadruped",
    ],
)
def test_law_7_where_it_is_unclear_who_is_told_a_robot_hears_the_whole_post(post: str, known: bool) -> None:
    assert text_for_robot(post, ME, OTHER, known=known) == post


def test_a_post_to_one_robot_says_nothing_beside_its_known_part() -> None:
    assert text_for_robot("@quadruped go to the red ball", ME, (), known=True) == ""
    assert text_for_robot("@humanoid wave", ME, OTHER) == "@humanoid wave"
