"""Laws 5 and 6 after a loss of data: a board or a journal restored from yesterday, a deleted journal, a second start,
and another version of the application. The motions are counted by a robot's body that is never killed."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Any

import pytest

from tests.kill.kill_backup import Backup
from tests.kill.kill_house import LONG_WALK, WALK, Asked, House, check
from tests.kill.kill_process import wait_for

THINKING, JOURNAL = "agentrob.agent.understanding.understand:", "agentrob.agent.store.journal:Journal."
#: Where an agent is killed with a command that waits, and with one that walks.
SCREENED = {"target": THINKING + "judge", "when": "after"}
CLAIMED = {"target": JOURNAL + "set_status_post", "when": "after"}
WALKING = {"target": "agentrob.agent.execution.execute:Run._must_end", "when": "before", "nth": 5}
ENDED = {"target": JOURNAL + "_end", "when": "after"}
ORDERS = (SCREENED, CLAIMED, WALKING, ENDED)


def slow(*values: Any, id: str) -> Any:
    return pytest.param(*values, id=id, marks=pytest.mark.slow)


def fast(*values: Any, id: str) -> Any:
    return pytest.param(*values, id=id)


def done(house: House, text: str = WALK) -> Asked:
    """Run a command from its post to its end."""
    asked = house.ask(text)
    assert check(house, asked) == "done"
    return asked


def killed_at(house: House, point: dict[str, Any]) -> Asked:
    """Kill the agent while it processes a command."""
    house.arm("agent", point)
    asked = house.ask(WALK)
    house.died("agent")
    house.posted(asked)
    wait_for("the robot stands", lambda: not house.moves(asked.began), 60.0)
    return asked


def serves_as_ever(house: House) -> None:
    """Check that a new command is done once and answered once."""
    done(house)


# -------------------------------------------------------------------- the board of yesterday
def say(house: House, body: str) -> dict[str, Any]:
    topic = {"board_id": "robots", "title": "t", "body": body}
    answer = house._insist("POST", "/topics", json=topic, headers={"Idempotency-Key": secrets.token_hex(8)})
    return dict(answer["post"])


def newest(house: House) -> int:
    return int(house._insist("GET", "/changes")["now"]["id"].split("-")[0])


def era(house: House) -> str:
    """The prefix of the posts that the journal set aside last, because their forum was replaced; empty before that."""
    found = house.in_journal("SELECT max(post) FROM claim WHERE post LIKE 'before-%'")
    return "-".join(found[0].split("-")[:2]) + "-" if found and found[0] else ""


def board_of_yesterday(house: House, backup: Backup, more_until: int) -> Asked | None:
    """Restore the board, and post until it has more events than before: talk, with a command in the middle."""
    house.running["board"].kill()
    backup.put_back()
    house.start("board")
    early = house.ask(WALK) if more_until else None
    if early:
        house.posted(early)
    while newest(house) <= more_until:
        say(house, "nothing that a robot should do")
    return early


@pytest.mark.parametrize(
    ("agent", "more"),
    [
        slow("frozen", False, id="the agent runs on, fewer events than before"),
        fast("frozen", True, id="the agent runs on, more events than before"),
        slow("killed", False, id="the agent is started anew, fewer events than before"),
        slow("killed", True, id="the agent is started anew, more events than before"),
    ],
)
def test_laws_5_and_6_the_board_of_yesterday_moves_nothing_and_what_is_new_is_done_once(
    house: House, tmp_path: Path, agent: str, more: bool
) -> None:
    done(house)
    backup = Backup(house.board_path, tmp_path / "board")
    undone = done(house)
    last = newest(house)
    before = era(house)
    if agent == "frozen":
        house.running["agent"].freeze()
    else:
        house.running["agent"].kill()
    at = len(house.ledger())
    early = board_of_yesterday(house, backup, last if more else 0)
    if agent == "frozen":
        house.running["agent"].thaw()
    else:
        house.start("agent")
    wait_for("the agent notices that it is another forum", lambda: era(house) != before, 60.0)
    fresh = house.ask(WALK)
    assert check(house, fresh) == "done"
    assert house.motions(at) == 1, "only what was asked of the robot since then moved it"
    if early is not None:
        assert [p["card"]["state"] for p in house.answers(early)] == ["expired"]
        assert early.post is not None
        assert early.post["id"] == house.posted(undone)["id"], "else this test would not see that ids are mixed up"


@pytest.mark.slow
@pytest.mark.parametrize("point", [SCREENED, CLAIMED, WALKING], ids=["screened", "claimed", "walking"])
@pytest.mark.parametrize("more", [False, True], ids=["fewer events", "more events"])
def test_laws_5_and_6_what_only_the_journal_knows_since_the_board_was_put_back_does_no_harm(
    house: House, tmp_path: Path, point: dict[str, Any], more: bool
) -> None:
    done(house)
    backup = Backup(house.board_path, tmp_path / "board")
    open_one = killed_at(house, point)
    moved, before = house.motions(open_one.began), era(house)
    last = newest(house)
    early = board_of_yesterday(house, backup, last if more else 0)
    house.start("agent")
    wait_for("the agent notices that it is another forum", lambda: era(house) != before, 60.0)
    ended = house.in_journal("SELECT final FROM claim WHERE post = :a", era(house) + str(house.posted(open_one)["id"]))
    assert ended == ("cancelled",), "what was open on the other forum is closed with it"
    # An open claim of this id belongs to the earlier post, whose number was reused.
    unended = "SELECT 1 FROM claim WHERE final IS NULL AND post = :a"
    assert early or not house.in_journal(unended, house.posted(open_one)["id"])
    wait_for("the early post is answered", lambda: not house.in_journal(unended, house.posted(open_one)["id"]), 60.0)
    fresh = house.ask(WALK)
    assert check(house, fresh) == "done"
    assert house.motions(open_one.began) == moved + 1
    if early is not None:
        assert [p["card"]["state"] for p in house.answers(early)] in ([], ["expired"])


# -------------------------------------------------------------------- the journal
@pytest.mark.parametrize(
    ("point", "state", "motions"),
    [
        # A first start moves nothing that was posted before it.
        slow(SCREENED, "expired", 0, id="it waits"),
        slow(CLAIMED, "interrupted", 0, id="it is claimed on the forum"),
        slow(WALKING, "interrupted", 1, id="it walks"),
        slow(None, "done", 1, id="it is done"),
    ],
)
def test_law_6_a_deleted_journal_moves_nothing_again_and_each_command_gets_one_final_reply(
    house: House, point: dict[str, Any] | None, state: str, motions: int
) -> None:
    if point is not None:
        asked = killed_at(house, point)
    else:
        asked = done(house)
        house.running["agent"].kill()
    house.journal_store.delete()
    house.start("agent")
    assert check(house, asked) == state
    assert house.motions(asked.began) == motions
    serves_as_ever(house)
    assert len(house.answers(asked)) == 1
    assert house.motions(asked.began) == motions + 1


@pytest.mark.parametrize(
    ("point", "state", "motions"),
    [
        # Unknown to the journal and to the forum, it is a fresh post like any other.
        slow(SCREENED, "done", 1, id="it waits"),
        slow(CLAIMED, "interrupted", 0, id="it is claimed on the forum"),
        slow(WALKING, "interrupted", 1, id="it walks"),
        fast(None, "done", 1, id="it is done"),
    ],
)
def test_law_6_the_journal_of_yesterday_moves_nothing_again_and_each_command_gets_one_final_reply(
    house: House, point: dict[str, Any] | None, state: str, motions: int
) -> None:
    done(house)
    backup = house.journal_store.copy()
    if point is not None:
        asked = killed_at(house, point)
    else:
        asked = done(house)
        house.running["agent"].kill()
    house.journal_store.put_back(backup)
    house.start("agent")
    assert check(house, asked) == state
    assert house.motions(asked.began) == motions
    serves_as_ever(house)
    assert len(house.answers(asked)) == 1


@pytest.mark.slow
def test_law_6_a_journal_copied_while_a_command_waited_does_not_do_it_again(house: House) -> None:
    asked = killed_at(house, CLAIMED)
    backup = house.journal_store.copy()
    house.start("agent")
    assert check(house, asked) == "done"
    house.running["agent"].kill()
    house.journal_store.put_back(backup)
    house.start("agent")
    assert check(house, asked) == "done"
    assert house.motions(asked.began) == 1
    serves_as_ever(house)


# -------------------------------------------------------------------- a second start
@pytest.mark.parametrize(("kind", "said"), [slow("agent", "already runs", id="agent"), slow("driver", "", id="driver")])
def test_laws_6_and_11_a_second_start_is_refused_in_one_line_and_the_first_is_not_disturbed(
    house: House, kind: str, said: str
) -> None:
    asked = house.ask(f"{LONG_WALK} slowly")
    wait_for("the robot walks", lambda: house.moves(asked.began), 60.0)
    second = house.second(kind)
    assert house.moves(asked.began), "the first was disturbed, or the second came too late to disturb it"
    assert second.returncode != 0
    assert second.stdout == ""
    assert second.stderr.count("\n") == 1, second.stderr
    assert said in second.stderr
    assert house.final(asked)["card"]["state"] == "done"
    assert house.motions(asked.began) == 1
    assert house.walked_m(asked.began) == pytest.approx(3.0, abs=0.1)
    serves_as_ever(house)


# -------------------------------------------------------------------- an upgrade
@pytest.mark.parametrize(
    ("point", "state", "motions"),
    [
        slow(SCREENED, "done", 1, id="it waits"),
        slow(CLAIMED, "done", 1, id="it is claimed on the forum"),
        slow(WALKING, "interrupted", 1, id="it walks"),
        slow(ENDED, "done", 1, id="it has walked"),
    ],
)
def test_law_6_another_version_ends_what_the_one_before_it_left_open_and_tells_it_once(
    house: House, point: dict[str, Any], state: str, motions: int
) -> None:
    asked = killed_at(house, point)
    tomorrow, later = (f"another-{secrets.token_hex(4)}" for _ in range(2))
    for version in (tomorrow, later):
        house.start("agent", KILL_VERSION=version)
        assert check(house, asked) == state
        assert house.motions(asked.began) == motions
        if version == tomorrow:
            assert_worked_as(house, version)
            house.running["agent"].kill()
    serves_as_ever(house)
    assert_worked_as(house, later)
    assert len(house.answers(asked)) == 1


def assert_worked_as(house: House, version: str) -> None:
    """Otherwise the journal would see the same version, and this test would prove nothing."""
    assert house.in_journal("SELECT 1 FROM meta WHERE key = 'version' AND value = :a", version)
