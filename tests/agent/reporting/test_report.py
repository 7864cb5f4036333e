"""The text of replies: requested beside measured values, in both languages, and untrusted words stay quoted."""

from __future__ import annotations

import string
from dataclasses import replace
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.media.image_store import Link
from agentrob.agent.media.pictures import Picture
from agentrob.agent.reporting import report as words
from agentrob.language.messages import en, zh
from agentrob.language.messages.catalog import say
from agentrob.language.messages.done_text import done_text
from agentrob.language.visible_text import mentions, visible_text
from agentrob.model import (
    Account,
    ActionClass,
    ActionResult,
    Choice,
    Command,
    CommandState,
    Decision,
    Direction,
    Number,
    Op,
    Operation,
    Option,
    Outcome,
    Plan,
    Pose,
    Primitive,
    Report,
    RobotState,
    StopResult,
    Unit,
    Verdict,
)
from agentrob.robots.safety.ranges import SAMPLES, SIDES, RangeMonitor

COMMAND = Command("7", "t", "h", Account("2", "alice"), "quadruped", "@quadruped …", "en", datetime.now(UTC), "abc123")
WALK = Primitive(Op.MOVE, Direction.FORWARD, distance_m=2.0)
TURN = Primitive(Op.TURN, Direction.LEFT, degrees=90.0)
PHOTO = Primitive(Op.GET_FRONT_IMAGE)
PLAN = Plan((WALK, TURN, PHOTO), ("`turn left` had no angle: taken as 90°.",))
DONE = (
    ActionResult(WALK, Outcome.DONE, {"distance_m": 1.98}),
    ActionResult(TURN, Outcome.DONE, {"degrees": 89.2}),
    ActionResult(PHOTO, Outcome.DONE, image=b"jpeg"),
)


def report(status: str, **more: object) -> Report:
    return replace(Report(COMMAND, CommandState(status), plan=PLAN), **more)


def test_law_18_what_was_asked_stands_beside_what_was_measured() -> None:
    pictures = [Picture("step", b"", 3), Picture("path", b""), Picture("recording", b"")]
    done = report("done", results=DONE, timings_ms={"seen": 42, "first_motion": 130, "done": 9100})
    reply_text = words.final(done, pictures)
    assert "| 1 | walk forward 2 m | 1.98 m | done |" in reply_text
    assert "| 2 | turn left 90° | 89.2° | done |" in reply_text
    assert "| 3 | take a photo | – | done |" in reply_text
    assert "taken as 90°" in reply_text
    assert "Pictures: photo of step 3, the path measured, a recording." in reply_text
    assert "seen after 0.04 s · first motion after 0.13 s · done after 9.1 s · trace `abc123`" in reply_text


def test_law_18_unknown_is_said_as_unknown_and_too_little_is_a_failure() -> None:
    little = ActionResult(WALK, Outcome.FAILED, {"distance_m": 0.4}, reason="obstacle", message="Something is near.")
    unknown = ActionResult(TURN, Outcome.UNKNOWN, reason="unreachable")
    reply_text = words.final(report("failed", results=(little, unknown, ActionResult(PHOTO, Outcome.SKIPPED))))
    assert "**Failed** at step 1." in reply_text
    assert "| 1 | walk forward 2 m | 0.40 m | failed |" in reply_text
    assert "| 2 | turn left 90° | unknown | unknown |" in reply_text
    assert "| 3 | take a photo | – | not begun |" in reply_text
    assert "Something is near." in reply_text


def test_a_chinese_report_says_everything_in_chinese() -> None:
    command = replace(COMMAND, language="zh")
    result = replace(DONE[0], outcome=Outcome.STOPPED, reason="obstacle", message="Something is near.")
    reply_text = words.final(
        report("failed", command=command, results=(result, replace(DONE[1], outcome=Outcome.SKIPPED)))
    )
    assert "向前走 2 米" in reply_text
    assert "有障碍物离得太近" in reply_text
    assert not any(word in reply_text for word in ("Failed", "Step", "Something"))


@pytest.mark.parametrize(
    ("side", "english", "chinese"),
    [
        (Direction.FORWARD, "ahead", "前方 0.40 米"),
        (Direction.LEFT, "to the left", "左方 0.40 米"),
        (Direction.BACKWARD, "behind", "后方 0.40 米"),
        (Direction.RIGHT, "to the right", "右方 0.40 米"),
    ],
)
def test_law_18_an_obstacle_is_told_with_its_side_and_what_to_do_in_both_languages(
    side: Direction, english: str, chinese: str
) -> None:
    monitor, ranges = RangeMonitor(), [9.0, 9.0, 9.0, 9.0]
    ranges[SIDES[side]] = 0.4
    for n in range(SAMPLES):
        jittered = tuple(r + n * 1e-4 for r in ranges)
        monitor.update(n * 0.1, RobotState(0.0, Pose(0.0, 0.0, 0.0), ranges_m=jittered))
    sentence = monitor.obstacle(Primitive(Op.MOVE, side, distance_m=1.0), 0.5)
    assert sentence is not None
    failed = replace(DONE[0], outcome=Outcome.REFUSED, reason="obstacle", message=sentence)
    told = words.final(report("failed", results=(failed,)))
    assert f"Something is 0.40 m {english}; this step needs 0." in told
    assert "Clear the way" in told
    command = replace(COMMAND, language="zh")
    told = words.final(report("failed", command=command, results=(failed,)))
    assert f"{chinese}处有障碍物，这一步在那里需要 0." in told
    assert "请清出道路" in told


@pytest.mark.parametrize("language", ["en", "zh"])
@pytest.mark.parametrize(
    "status",
    ["done", "failed", "refused", "asks_back", "stopped", "interrupted", "cancelled", "expired", "answered"],
)
def test_every_status_has_its_words_in_both_languages(status: str, language: str) -> None:
    command = replace(COMMAND, language=language)
    verdict = Verdict(Decision.REFUSE, "limits.step_m", "Too far.")
    reply_text = words.final(report(status, command=command, verdict=verdict, message="alice"))
    assert "abc123" in reply_text
    assert reply_text.strip()
    assert words.short(report(status, command=command))


def test_a_refusal_names_its_rule() -> None:
    verdict = Verdict(Decision.REFUSE, "limits.step_m", "A step is at most 5 m.")
    reply_text = words.final(report("refused", verdict=verdict))
    assert "**Refused.**" in reply_text
    assert "A step is at most 5 m." in reply_text
    assert "Rule: `limits.step_m`." in reply_text


@given(st.text(max_size=400) | st.text(alphabet="@quadrped<>![]()`*\n ", max_size=400))
def test_law_3_sentences_made_of_people_s_words_mention_nobody_and_bring_no_markup(text: str) -> None:
    verdict = Verdict(Decision.REFUSE, "rule", f"I will not @quadruped {text}")
    for reply_text in (
        words.final(report("refused", verdict=verdict)),
        words.final(report("failed", message=f"@humanoid {text}")),
        words.final(report("asks_back", message=f"{text} @bob")),
        words.state_text(None, 0, "en", f"@bob {text}"),
    ):
        assert not set(mentions(visible_text(reply_text))) & {"quadruped", "humanoid", "bob"}
        assert "<" not in reply_text
        assert "![" not in reply_text


@pytest.mark.parametrize("language", ["en", "zh"])
def test_a_claim_of_another_agent_is_reported_as_interrupted_once(language: str) -> None:
    message = say("agent.interrupted.claim", language)
    reply_text = words.final(
        report("interrupted", message=message, plan=Plan(), command=replace(COMMAND, language=language))
    )
    assert reply_text.startswith(message)
    assert reply_text.count("**") == 2


def test_a_stop_says_what_it_did_and_plainly_when_it_was_not_confirmed() -> None:
    good = StopResult(87.4, True, True, 0.06)
    assert words.stop_reply(good, "en", 2, False) == (
        "**Stopped.** Zero velocity was commanded 87 ms after the stop; I came to rest 0.06 m further. "
        "Commands ended or cancelled: 2."
    )
    assert "did not confirm" in words.stop_reply(replace(good, confirmed=False), "en", 0, False)
    assert "could not reach" in words.stop_reply(None, "en", 0, True)
    assert "owner releases" in words.stop_reply(good, "en", 0, True)
    assert "Stops since then: 3" in words.stop_reply(good, "en", 0, False, 3)


def test_the_state_is_reported_with_what_is_unknown() -> None:
    reply_text = words.state_text(RobotState(0.1, mode="idle"), 2, "en")
    assert reply_text == "**idle**, battery unknown, home is not set, commands waiting or running: 2."


def test_every_sentence_has_the_same_places_in_both_languages() -> None:
    def places(text: str) -> set[str]:
        return {name for _, name, _, _ in string.Formatter().parse(text) if name}

    for key, english in en.PHRASES.items():
        chinese = zh.PHRASES[key]
        assert places(english) == places(chinese), key
        assert "UTC" not in english + chinese, "a reply says how long: who reads it is in another time zone"


def test_a_report_begins_with_what_was_done_and_ends_with_details() -> None:
    pictures = [Picture("step", b"", 3), Picture("path", b"")]
    timings = {"seen": 42, "first_motion": 130, "done": 9100}
    done = words.final(report("done", results=DONE, timings_ms=timings), pictures, ["*`model`: 12 tokens*", "A hint."])
    assert done.startswith("**Done:** walked 1.98 m, turned left 89°, took a photo.\n\n| Step |")
    above, details = done.split("\n\n#### Details\n\n")
    assert "A hint." in above
    for small in ("seen after", "trace `", "Pictures: ", "12 tokens"):
        assert small in details
        assert small not in above
    command = replace(COMMAND, language="zh")
    chinese = words.final(report("done", command=command, results=DONE), pictures)
    assert chinese.startswith("**完成**：向前走了 1.98 米，左转了 89°，拍了照片。\n\n")
    assert "\n\n#### 详情\n\n" in chinese


def test_pictures_that_are_stored_elsewhere_are_linked_before_the_table() -> None:
    link = Link("https://pictures.example.org/a.jpg", datetime.now(UTC), 3600.0)
    reply_text = words.final(report("done", results=DONE), [Picture("step", b"", 3, link)])
    assert reply_text.index(link.url) < reply_text.index("| Step |")


def test_a_report_says_what_was_done_until_it_failed_and_what_to_do() -> None:
    near = "Something is 0.41 m to the left; this step needs 1.00 m there."
    little = ActionResult(WALK, Outcome.FAILED, {"distance_m": 0.4}, reason="obstacle", message=near)
    waved = ActionResult(Primitive(Op.HELLO), Outcome.DONE)
    first = words.final(report("failed", results=(waved, waved, little))).split("\n\n")[0]
    assert first == (
        f"**Failed** at step 3. {near} Clear the way, or ask for a shorter distance or another direction. "
        "Until then: waved 2 times, walked 0.40 m."
    )


def test_what_was_not_measured_or_not_done_is_not_said_to_be_done() -> None:
    lost = ActionResult(WALK, Outcome.INTERRUPTED, unmeasured="odometry_lost")
    cut = ActionResult(Primitive(Op.HELLO), Outcome.STOPPED)
    still = ActionResult(TURN, Outcome.STOPPED, {"degrees": 0.2})
    refused = ActionResult(WALK, Outcome.REFUSED, {"distance_m": 0.0}, reason="fence")
    assert done_text((lost, cut, still, refused), "en") == "walked forward by an unknown distance"
    assert done_text((cut, still, refused), "en") == ""


def test_a_declared_operation_is_told_with_the_arguments_that_its_words_name():
    place = Choice("place", (Option("kitchen", {"en": "kitchen|galley", "zh": "厨房"}),))
    seconds = Number("seconds", Unit.SECONDS, 1.0, 10.0, 3.0)
    go = Operation(
        "go_to_place", ActionClass.MOVE, {"en": "go to the {place}"}, (place, seconds),
        {"en": "went to the {place} in {seconds}", "zh": "到了{place}"}, travel_m=5.0,
    )  # fmt: skip
    step = Primitive("go_to_place", arguments=go.complete({"place": "kitchen"}), declared=go)
    done = ActionResult(step, Outcome.DONE)
    assert done_text((done,), "en") == "went to the kitchen in 3 s"
    assert done_text((done,), "zh") == "到了厨房"


def test_a_queued_command_says_behind_whom_and_about_how_long() -> None:
    assert words.queued("en", 2, "bob", 42.0) == (
        "Queued, place 2, behind the command of `bob`; my turn comes in about 40 seconds."
    )
    assert words.queued("zh", 1, "bob", 1.0) == "排队中，第 1 位，前面是 `bob` 的命令；大约 5 秒后轮到。"
    assert words.queued("en", 1, "bob") == "Queued, place 1, behind the command of `bob`."


def test_law_17_that_a_stop_was_not_confirmed_is_said_before_the_table() -> None:
    cut = ActionResult(WALK, Outcome.STOPPED, {"distance_m": 0.4})
    for confirmed in (False, True):
        stopped = report("stopped", message="alice", results=(cut,), stop=StopResult(80.0, confirmed, True, 0.05))
        reply_text = words.final(stopped)
        assert reply_text.startswith("**Stopped** by `alice`. Until then: walked 0.40 m.\n\n")
        figures = "Zero velocity was commanded" if confirmed else "**I commanded a stop, but the robot did not confirm"
        assert (reply_text.index(figures) < reply_text.index("| Step |")) is not confirmed
