"""Whether a post is for this robot (laws 1, 3, 5 and 13), tested without a forum."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.intake.triage import Addressing, Route, language_of, triage
from agentrob.language.visible_text import OMITTED, mentions, visible_text
from agentrob.model import Account, AccountKind, Post, Role

NOW = datetime(2026, 1, 1, 12, 0, tzinfo=UTC)
ME = Account("1", "quadruped", AccountKind.ROBOT_AGENT)
ALICE = Account("2", "alice", role=Role.OPERATOR)
EARS = Addressing(
    ME, {"quadruped", "dog"}, ("robots",), NOW - timedelta(days=1), NOW, 120.0, {"running"}, robots={"humanoid"}
)


def post(text: str, author: Account = ALICE, topic: str = "t", age_s: float = 1.0, board: str = "robots") -> Post:
    """A post as the board delivers it, where all mentioned names but @dog have accounts."""
    linked = tuple(name for name in mentions(visible_text(text)) if name != "dog")
    return Post("7", topic, board, author, text, NOW - timedelta(seconds=age_s), mentions=linked)


@pytest.mark.parametrize(
    ("text", "route"),
    [
        ("@quadruped walk forward 1 m", Route.READ),
        ("@Quadruped walk forward 1 m", Route.READ),
        ("@dog walk forward 1 m", Route.READ),
        ("走两步 @quadruped", Route.READ),
        ("walk forward 1 m", Route.NOTHING),
        ("@quadrupeds walk", Route.NOTHING),
        ("@humanoid walk", Route.NOTHING),
        ("`@quadruped walk`", Route.NOTHING),
        ("> @quadruped walk", Route.NOTHING),
        ("# @quadruped walk", Route.NOTHING),
        ("[@quadruped](http://x) ![@quadruped walk](y)", Route.NOTHING),
        ("![@quadruped walk](y)", Route.NOTHING),
        ("@quаdruped walk (a Cyrillic а)", Route.NOTHING),
        ("@quadruped stop", Route.STOP),
        ("@quadruped, please stop!", Route.STOP),
        ("@quadruped 停", Route.STOP),
        ("@quadruped emergency stop", Route.HALT),
        ("@quadruped walk 2 m and stop", Route.READ),
        ("@quadruped don't stop", Route.READ),
        ("@quadruped 停车场在哪里", Route.READ),
        ("stop", Route.NOTHING),
        ("@humanoid stop", Route.NOTHING),
    ],
)
def test_what_a_post_is_for_me(text: str, route: Route) -> None:
    assert triage(post(text), EARS).route is route


@pytest.mark.parametrize(
    ("text", "route"),
    [
        ("stop", Route.STOP),
        ("停！", Route.STOP),
        ("@humanoid stop", Route.NOTHING),
        ("@carol stop!", Route.STOP),  # an account that is not known to be a robot may be a person
        ("@nobody-at-all stop", Route.STOP),
        ("ok", Route.NOTHING),
    ],
)
def test_law_13_a_bare_stop_counts_in_the_thread_of_a_running_command(text: str, route: Route) -> None:
    assert triage(post(text, topic="running"), EARS).route is route


@pytest.mark.parametrize("text", ["@quadruped walk forward 1 m", "@quadruped stop"])
@pytest.mark.parametrize(
    "author",
    [
        ME,
        replace(ALICE, kind=AccountKind.ROBOT_AGENT),
        replace(ALICE, kind=AccountKind.MONITORING_AGENT),
        replace(ALICE, suspended=True),
    ],
)
def test_law_1_some_are_never_obeyed(author: Account, text: str) -> None:
    assert triage(post(text, author), EARS).route is Route.NOTHING


def test_law_1_a_commanding_agent_is_read_as_a_human_is() -> None:
    author = replace(ALICE, kind=AccountKind.COMMANDING_AGENT)
    assert triage(post("@quadruped wave", author), EARS).route is Route.READ


@pytest.mark.parametrize(("age_s", "route"), [(119.9, Route.READ), (120.1, Route.STALE), (86_401, Route.STALE)])
def test_law_5_old_posts_are_stale(age_s: float, route: Route) -> None:
    assert triage(post("@quadruped wave", age_s=age_s), EARS).route is route


def test_law_5_what_is_older_than_the_first_start_is_stale() -> None:
    ears = replace(EARS, watermark_at=NOW - timedelta(seconds=1))
    assert triage(post("@quadruped wave", age_s=1.0), ears).route is Route.STALE
    assert triage(post("@quadruped wave", age_s=0.9), ears).route is Route.READ


def test_law_4_of_an_edited_post_only_a_stop_counts() -> None:
    assert triage(post("@quadruped walk forward 1 m"), EARS, edited=True).route is Route.NOTHING
    assert triage(post("@quadruped stop"), EARS, edited=True).route is Route.STOP


def test_a_removed_post_is_nothing_and_another_board_only_stops() -> None:
    assert triage(replace(post("@quadruped stop"), removed=True), EARS).route is Route.NOTHING
    assert triage(post("@quadruped wave", board="offtopic"), EARS).route is Route.NOTHING
    assert triage(post("@quadruped stop", board="offtopic"), EARS).route is Route.STOP


@given(st.text(max_size=300), st.booleans())
def test_any_text_is_something_and_without_my_name_never_a_command(text: str, edited: bool) -> None:
    heard = triage(post(text), EARS, edited)
    if "quadruped" not in heard.text.lower() and "dog" not in heard.text.lower():
        assert heard.route is Route.NOTHING
    assert not (edited and heard.route in (Route.READ, Route.STALE))


@pytest.mark.parametrize(
    ("text", "language"),
    [
        ("@quadruped walk", "en"),
        ("@quadruped 走一米", "zh"),
        ("@quadruped go to 北京 and wave there", "en"),
        ("", "en"),
    ],
)
def test_the_language_of_a_post(text: str, language: str) -> None:
    assert language_of(text) == language


BUSY = replace(EARS, commands={"9"})


@pytest.mark.parametrize(
    ("text", "topic", "route"),
    [
        ("stop right there", "running", Route.STOP),
        ("@bob careful!", "running", Route.STOP),
        ("@carol it hits the table, stop it", "running", Route.STOP),
        ("@carol @humanoid wait", "running", Route.NOTHING),
        ("@humanoid wait", "running", Route.NOTHING),
        ("why did it stop?", "running", Route.NOTHING),
        ("stop right there", "elsewhere", Route.NOTHING),
        ("@quadruped that's enough", "elsewhere", Route.STOP),
        ("@quadruped wait for me at the door", "elsewhere", Route.STOP),
        ("@quadruped walk 1 m and stop", "elsewhere", Route.READ),
        ("@quadruped approve", "running", Route.APPROVE),
    ],
)
def test_law_13_while_a_command_moves_in_doubt_it_stops(text: str, topic: str, route: Route) -> None:
    heard = triage(post(text, topic=topic), BUSY)
    assert heard.route is route
    assert heard.taken_as_stop == (route is Route.STOP)


@pytest.mark.parametrize(
    "text", ["@quadruped wait for me at the door", "@quadruped why did it stop?", "@quadruped careful"]
)
def test_law_13_at_rest_only_the_narrow_rule_holds(text: str) -> None:
    assert triage(post(text), replace(EARS, running_topics=())).route is Route.READ


@pytest.mark.parametrize(
    ("text", "running", "route"),
    [
        ("@quadruped don't move, just take a photo", (), Route.READ),
        ("@quadruped don't move, just take a photo", ("running",), Route.STOP),
        ("@quadruped don't move", (), Route.STOP),
        ("@quadruped don't move, walk 1 m", (), Route.STOP),
        ("@quadruped stop, take a photo", (), Route.STOP),
    ],
)
def test_law_13_a_photo_without_motion_is_read_at_rest_only(text: str, running: tuple[str, ...], route: Route) -> None:
    assert triage(post(text), replace(EARS, running_topics=running)).route is route


@pytest.mark.parametrize(
    ("text", "topic", "running", "route"),
    [
        ("cancel", "timed", (), Route.CANCEL),
        ("@quadruped cancel the schedule", "timed", (), Route.CANCEL),
        ("@quadruped cancel the schedule", "timed", ("running",), Route.CANCEL),
        ("@quadruped 取消日程", "timed", ("running",), Route.CANCEL),
        ("cancel this schedule please", "timed", ("running",), Route.CANCEL),
        ("@quadruped cancel", "timed", ("running",), Route.STOP),
        ("@quadruped 取消", "timed", ("running",), Route.STOP),
        ("@quadruped cancel the run", "timed", ("running",), Route.STOP),
        ("@quadruped stop, cancel the schedule", "timed", ("running",), Route.STOP),
        ("@quadruped cancel the schedule", "timed", ("running", "timed"), Route.STOP),
        ("@quadruped cancel the schedule", "elsewhere", ("running",), Route.STOP),
        ("@humanoid cancel the schedule", "timed", ("running",), Route.NOTHING),
    ],
)
def test_law_13_only_words_that_name_a_schedule_end_it_while_another_thread_moves_the_robot(
    text: str, topic: str, running: tuple[str, ...], route: Route
) -> None:
    heard = triage(post(text, topic=topic), replace(EARS, running_topics=running, schedule_topics={"timed"}))
    assert heard.route is route


@pytest.mark.parametrize(
    ("text", "topic", "route"),
    [
        ("keep on", "ended", Route.RENEW),
        ("Yes, keep on!", "ended", Route.RENEW),
        ("please continue the schedule", "ended", Route.RENEW),
        ("@quadruped renew it", "ended", Route.RENEW),
        ("继续", "ended", Route.RENEW),
        ("好的，继续吧", "ended", Route.RENEW),
        ("keep on", "elsewhere", Route.NOTHING),
        ("@quadruped keep on", "elsewhere", Route.READ),
        ("@humanoid keep on", "ended", Route.NOTHING),
        ("don't keep on", "ended", Route.NOTHING),
        ("keep on walking", "ended", Route.NOTHING),
        ("we could continue tomorrow", "ended", Route.NOTHING),
        ("stop, don't continue", "ended", Route.NOTHING),
        ("@quadruped stop", "ended", Route.STOP),
    ],
)
def test_a_reply_that_only_renews_is_one_only_where_a_schedule_had_its_last_run(
    text: str, topic: str, route: Route
) -> None:
    heard = triage(post(text, topic=topic), replace(EARS, renewable_topics={"ended"}))
    assert heard.route is route
    edited = triage(post(text, topic=topic), replace(EARS, renewable_topics={"ended"}), edited=True)
    assert edited.route is not Route.RENEW


@pytest.mark.parametrize(("age_s", "fresh"), [(1.0, True), (121.0, False)])
def test_law_5_an_old_renewal_is_not_fresh(age_s: float, fresh: bool) -> None:
    heard = triage(post("keep on", topic="ended", age_s=age_s), replace(EARS, renewable_topics={"ended"}))
    assert (heard.route, heard.fresh) == (Route.RENEW, fresh)


def test_law_13_a_command_under_way_does_not_stop_itself_but_an_edit_of_it_may() -> None:
    command = replace(post("@quadruped wait for the door, then walk", topic="running"), id="9")
    assert triage(command, BUSY).route is Route.READ
    assert triage(command, BUSY, edited=True).route is Route.STOP


def test_law_3_a_name_that_the_page_does_not_link_commands_nothing_and_may_stop() -> None:
    """Zero-width characters in a name: another forum shows it, but does not treat it as a mention."""
    unlinked = replace(post("@quad\u200bruped walk forward 1 m"), mentions=())
    assert triage(unlinked, EARS).route is Route.NOTHING
    assert triage(replace(unlinked, mentions=("quadruped",)), EARS).route is Route.READ
    assert triage(replace(post("@quad\u200bruped stop"), mentions=()), EARS).route is Route.STOP
    assert triage(post("@quadruped- stop"), EARS).route is Route.STOP
    assert triage(post("@quadruped- walk forward 1 m"), EARS).route is Route.NOTHING
    # The page links it where the agent does not read it, for example in a heading.
    assert triage(replace(post("# @quadruped\n\nstop"), mentions=("quadruped",)), EARS).route is Route.STOP
    assert triage(replace(post("# @quadruped\n\nwalk forward"), mentions=("quadruped",)), EARS).route is Route.NOTHING


def test_law_3_a_post_whose_rendering_differs_leaves_a_mark_approves_nothing_and_stops() -> None:
    def heard(text: str) -> tuple[Route, bool]:
        found = triage(replace(post(text), rendering_differs=True), EARS)
        return found.route, OMITTED in found.text

    assert heard("@quadruped walk forward 1 m") == (Route.READ, True)
    assert heard("@quadruped approve") == (Route.READ, True)
    assert heard("@quadruped stop") == (Route.STOP, True)
