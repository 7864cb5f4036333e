"""Laws 5 and 6 after a loss of data: a board or a journal restored from yesterday, a deleted journal, a second start,
and another version of the application. The motions are counted by a robot's body that is never killed."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Any

import pytest

from tests.kill.kill_backup import Backup
from tests.kill.kill_process import wait_for
from tests.kill.kill_scene import LONG_WALK, WALK, KillScene, PostedCommand, check

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


def run_to_end(scene: KillScene, text: str = WALK) -> PostedCommand:
    """Run a command from its post to its end."""
    command = scene.ask(text)
    assert check(scene, command) == "done"
    return command


def kill_agent_at(scene: KillScene, point: dict[str, Any]) -> PostedCommand:
    """Kill the agent while it processes a command."""
    scene.arm("agent", point)
    command = scene.ask(WALK)
    scene.wait_for_kill("agent")
    scene.posted(command)
    wait_for("the robot stands", lambda: not scene.moves(command.began), 60.0)
    return command


def check_that_it_serves(scene: KillScene) -> None:
    """Check that a new command is done once and answered once."""
    run_to_end(scene)


# -------------------------------------------------------------------- the board of yesterday
def create_post(scene: KillScene, body: str) -> dict[str, Any]:
    topic = {"board_id": "robots", "title": "t", "body": body}
    answer = scene._request("POST", "/topics", json=topic, headers={"Idempotency-Key": secrets.token_hex(8)})
    return dict(answer["post"])


def newest_event(scene: KillScene) -> int:
    return int(scene._request("GET", "/changes")["now"]["id"].split("-")[0])


def forum_prefix(scene: KillScene) -> str:
    """The prefix of the posts that the journal set aside last, because their forum was replaced; empty before that."""
    found = scene.in_journal("SELECT max(post) FROM claim WHERE post LIKE 'before-%'")
    return "-".join(found[0].split("-")[:2]) + "-" if found and found[0] else ""


def restore_older_board(scene: KillScene, backup: Backup, more_until: int) -> PostedCommand | None:
    """Restore the board, and post until it has more events than before: talk, with a command in the middle."""
    scene.running["board"].kill()
    backup.restore()
    scene.start("board")
    early = scene.ask(WALK) if more_until else None
    if early:
        scene.posted(early)
    while newest_event(scene) <= more_until:
        create_post(scene, "nothing that a robot should do")
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
    scene: KillScene, tmp_path: Path, agent: str, more: bool
) -> None:
    run_to_end(scene)
    backup = Backup(scene.board_path, tmp_path / "board")
    undone = run_to_end(scene)
    last = newest_event(scene)
    before = forum_prefix(scene)
    if agent == "frozen":
        scene.running["agent"].freeze()
    else:
        scene.running["agent"].kill()
    at = len(scene.ledger())
    early = restore_older_board(scene, backup, last if more else 0)
    if agent == "frozen":
        scene.running["agent"].thaw()
    else:
        scene.start("agent")
    wait_for("the agent notices that it is another forum", lambda: forum_prefix(scene) != before, 60.0)
    fresh = scene.ask(WALK)
    assert check(scene, fresh) == "done"
    assert scene.motions(at) == 1, "only what was asked of the robot since then moved it"
    if early is not None:
        assert [p["card"]["state"] for p in scene.answers(early)] == ["expired"]
        assert early.post is not None
        assert early.post["id"] == scene.posted(undone)["id"], "else this test would not see that ids are mixed up"


@pytest.mark.slow
@pytest.mark.parametrize("point", [SCREENED, CLAIMED, WALKING], ids=["screened", "claimed", "walking"])
@pytest.mark.parametrize("more", [False, True], ids=["fewer events", "more events"])
def test_laws_5_and_6_what_only_the_journal_knows_since_the_board_was_put_back_does_no_harm(
    scene: KillScene, tmp_path: Path, point: dict[str, Any], more: bool
) -> None:
    run_to_end(scene)
    backup = Backup(scene.board_path, tmp_path / "board")
    open_one = kill_agent_at(scene, point)
    moved, before = scene.motions(open_one.began), forum_prefix(scene)
    last = newest_event(scene)
    early = restore_older_board(scene, backup, last if more else 0)
    scene.start("agent")
    wait_for("the agent notices that it is another forum", lambda: forum_prefix(scene) != before, 60.0)
    ended = scene.in_journal(
        "SELECT final FROM claim WHERE post = :a", forum_prefix(scene) + str(scene.posted(open_one)["id"])
    )
    assert ended == ("cancelled",), "what was open on the other forum is closed with it"
    # An open claim of this id belongs to the earlier post, whose number was reused.
    unended = "SELECT 1 FROM claim WHERE final IS NULL AND post = :a"
    assert early or not scene.in_journal(unended, scene.posted(open_one)["id"])
    wait_for("the early post is answered", lambda: not scene.in_journal(unended, scene.posted(open_one)["id"]), 60.0)
    fresh = scene.ask(WALK)
    assert check(scene, fresh) == "done"
    assert scene.motions(open_one.began) == moved + 1
    if early is not None:
        assert [p["card"]["state"] for p in scene.answers(early)] in ([], ["expired"])


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
    scene: KillScene, point: dict[str, Any] | None, state: str, motions: int
) -> None:
    if point is not None:
        command = kill_agent_at(scene, point)
    else:
        command = run_to_end(scene)
        scene.running["agent"].kill()
    scene.journal_store.delete()
    scene.start("agent")
    assert check(scene, command) == state
    assert scene.motions(command.began) == motions
    check_that_it_serves(scene)
    assert len(scene.answers(command)) == 1
    assert scene.motions(command.began) == motions + 1


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
    scene: KillScene, point: dict[str, Any] | None, state: str, motions: int
) -> None:
    run_to_end(scene)
    backup = scene.journal_store.copy()
    if point is not None:
        command = kill_agent_at(scene, point)
    else:
        command = run_to_end(scene)
        scene.running["agent"].kill()
    scene.journal_store.restore(backup)
    scene.start("agent")
    assert check(scene, command) == state
    assert scene.motions(command.began) == motions
    check_that_it_serves(scene)
    assert len(scene.answers(command)) == 1


@pytest.mark.slow
def test_law_6_a_journal_copied_while_a_command_waited_does_not_do_it_again(scene: KillScene) -> None:
    command = kill_agent_at(scene, CLAIMED)
    backup = scene.journal_store.copy()
    scene.start("agent")
    assert check(scene, command) == "done"
    scene.running["agent"].kill()
    scene.journal_store.restore(backup)
    scene.start("agent")
    assert check(scene, command) == "done"
    assert scene.motions(command.began) == 1
    check_that_it_serves(scene)


# -------------------------------------------------------------------- a second start
@pytest.mark.parametrize(("kind", "said"), [slow("agent", "already runs", id="agent"), slow("driver", "", id="driver")])
def test_laws_6_and_11_a_second_start_is_refused_in_one_line_and_the_first_is_not_disturbed(
    scene: KillScene, kind: str, said: str
) -> None:
    command = scene.ask(f"{LONG_WALK} slowly")
    wait_for("the robot walks", lambda: scene.moves(command.began), 60.0)
    second = scene.second(kind)
    assert scene.moves(command.began), "the first was disturbed, or the second came too late to disturb it"
    assert second.returncode != 0
    assert second.stdout == ""
    assert second.stderr.count("\n") == 1, second.stderr
    assert said in second.stderr
    assert scene.final(command)["card"]["state"] == "done"
    assert scene.motions(command.began) == 1
    assert scene.walked_m(command.began) == pytest.approx(3.0, abs=0.1)
    check_that_it_serves(scene)


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
    scene: KillScene, point: dict[str, Any], state: str, motions: int
) -> None:
    command = kill_agent_at(scene, point)
    tomorrow, later = (f"another-{secrets.token_hex(4)}" for _ in range(2))
    for version in (tomorrow, later):
        scene.start("agent", KILL_VERSION=version)
        assert check(scene, command) == state
        assert scene.motions(command.began) == motions
        if version == tomorrow:
            assert_ran_version(scene, version)
            scene.running["agent"].kill()
    check_that_it_serves(scene)
    assert_ran_version(scene, later)
    assert len(scene.answers(command)) == 1


def assert_ran_version(scene: KillScene, version: str) -> None:
    """Otherwise the journal would see the same version, and this test would prove nothing."""
    assert scene.in_journal("SELECT 1 FROM meta WHERE key = 'version' AND value = :a", version)
