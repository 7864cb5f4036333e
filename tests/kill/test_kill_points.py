"""Law 6 at every point: agent, driver and board die by SIGKILL at each point between a post and its reply.

A point is before or after a function of the product. The process that reaches it dies at once and is restarted. The
command must then have exactly one final reply and at most one motion, by the ledger of a robot's body that is never
killed. A point that is never reached fails.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from tests.kill.kill_process import wait_for
from tests.kill.kill_scene import DRIVER_AWAY, DRIVER_DIED, LONG_WALK, PHOTO, WALK, KillScene, check

#: A recording is added to a reply later. It could reach the point that the next test has armed.
RECORDING = "none"
#: The requested distance, and what a velocity that is held for a second and then coasts can add to it.
MOST_M = 0.3 + 0.6
#: A robot stands still this long after its agent's death: the lease's second, and the time to come to rest.
STILL_S = 1.5
#: Its driver commands it to rest within this time: the lease's second, and the interval of the lease checks.
REST_COMMANDED_S = 1.2

DONE = frozenset({"done"})
INTERRUPTED = frozenset({"interrupted"})


@dataclass(frozen=True)
class Point:
    """Which process dies where, what was posted, and the allowed final states."""

    name: str
    kind: str
    target: str
    when: str
    ends: frozenset[str]
    motions: int | None = None
    nth: int = 1
    containing: str = ""
    text: str = WALK

    @property
    def order(self) -> dict[str, Any]:
        return {"target": self.target, "when": self.when, "nth": self.nth, "containing": self.containing}


def agent(name: str, target: str, when: str, ends: frozenset[str], motions: int | None = None, **more: Any) -> Point:
    return Point(f"agent, {name}", "agent", "agentrob." + target, when, ends, motions, **more)


def driver(
    name: str, target: str, when: str, motions: int | None = None, ends: frozenset[str] = DRIVER_DIED, **more: Any
) -> Point:
    return Point(f"driver, {name}", "driver", target, when, ends, motions, **more)


def board(name: str, target: str, when: str, ends: frozenset[str] = DONE, **more: Any) -> Point:
    return Point(f"board, {name}", "board", "agentrob.board." + target, when, ends, **more)


AGENT, UNDERSTAND, MOTION = "agent.agent:", "agent.understanding.understand:", "agent.motion:"
STATUS = "agent.reporting.status_post:StatusPost."
JOURNAL, CLIENT = "agent.store.journal:Journal.", "robots.driver.client:DriverClient."
FORUM = "forums.agentrob.forum:BoardForum."
#: Nothing has moved yet, so everything is done after the restart, once.
BEFORE_MOTION = [
    agent("post not heard yet", AGENT + "RobotAgent._handle_event", "before", DONE, 1, containing="post.created"),
    agent("post heard", AGENT + "RobotAgent._handle_event", "after", DONE, 1, containing="post.created"),
    agent("post perceived", AGENT + "triage", "after", DONE, 1),
    agent("not claimed in the journal yet", JOURNAL + "claim", "before", DONE, 1),
    agent("claimed in the journal", JOURNAL + "claim", "after", DONE, 1),
    agent("taken, cursor saved", JOURNAL + "put_all", "after", DONE, 1, containing="cursor"),
    agent("to be planned", UNDERSTAND + "extract", "before", DONE, 1),
    agent("planned", UNDERSTAND + "extract", "after", DONE, 1),
    agent("to be screened", UNDERSTAND + "judge", "before", DONE, 1),
    agent("screened", UNDERSTAND + "judge", "after", DONE, 1),
    agent("thought kept", JOURNAL + "assess", "after", DONE, 1),
    agent("not claimed on the forum yet", FORUM + "reply", "before", DONE, 1, containing="claim:"),
    agent("claimed on the forum", FORUM + "reply", "after", DONE, 1, containing="claim:"),
    agent("claim noted in the journal", JOURNAL + "set_status_post", "after", DONE, 1),
    agent("first in line", "agent.queue.queue:CommandQueue.turn", "after", DONE, 1),
    agent("attempt not committed yet", JOURNAL + "_begin", "before", DONE, 1),
]
#: Begun, and not known to be finished: never repeated, however far it moved.
BEGUN = [
    agent("attempt committed", JOURNAL + "_begin", "after", INTERRUPTED, 0),
    agent("allowed again", MOTION + "permission", "after", INTERRUPTED, 0),
    agent("lease taken", CLIENT + "_call", "after", INTERRUPTED, 0, containing="'POST', '/lease'"),
    agent("step shown", STATUS + "show", "after", INTERRUPTED, 0, containing="state=<CommandState.RUNNING"),
    agent("step about to be sent", CLIENT + "step", "before", INTERRUPTED, 0),
    agent("status to be updated", FORUM + "edit", "before", INTERRUPTED, containing="state=<CommandState.RUNNING"),
    agent("status updated", FORUM + "edit", "after", INTERRUPTED, containing="state=<CommandState.RUNNING"),
    agent("walking", "agent.execution.execute:Run._must_end", "before", INTERRUPTED, 1, nth=5),
    agent("step's result there", CLIENT + "step", "after", INTERRUPTED, 1),
    agent("photo there", CLIENT + "step", "after", INTERRUPTED, 1, nth=2, text=PHOTO),
    agent("pictures kept", "agent.store.records:Records.keep_pictures", "after", INTERRUPTED, 1, text=PHOTO),
    agent("motion's end not committed yet", JOURNAL + "_end", "before", INTERRUPTED, 1),
]
#: The end is on disk and is written as it was.
ENDED = [
    agent("motion's end committed", JOURNAL + "_end", "after", DONE, 1),
    agent("record written", "agent.store.records:Records.write", "after", DONE, 1),
    agent("pictures to be uploaded", FORUM + "_upload", "before", DONE, 1, containing="xff", text=PHOTO),
    agent("pictures uploaded", FORUM + "_upload", "after", DONE, 1, containing="xff", text=PHOTO),
    agent("final reply to be sent", FORUM + "edit_once", "before", DONE, 1, containing="state=<CommandState.DONE"),
    agent("final reply sent", FORUM + "edit_once", "after", DONE, 1, containing="state=<CommandState.DONE"),
    agent("journal not closed yet", JOURNAL + "finish", "before", DONE, 1),
    agent("journal closed", JOURNAL + "finish", "after", DONE, 1),
]
DRIVER = [
    driver("lease asked for", "agentrob.robots.driver.driver:Driver.take", "before", 0, DRIVER_AWAY),
    driver("lease given", "agentrob.robots.driver.driver:Driver.take", "after", 0, DRIVER_AWAY),
    driver("lease renewed", "agentrob.robots.driver.lease:Leases.renew", "after", nth=3),
    driver("step asked for", "agentrob.robots.driver.driver:Driver.step", "before", 0),
    driver("step begun", "tests.kill.kill_robot:RemoteBodyRobot.step", "before", 0),
    driver("first velocity commanded", "tests.kill.kill_robot:RemoteBodyRobot.command", "after", 1),
    driver("walking", "tests.kill.kill_robot:RemoteBodyRobot.command", "before", 1, nth=8),
    driver("to rest", "tests.kill.kill_robot:RemoteBodyRobot.rest", "before", 1),
    driver("at rest", "tests.kill.kill_robot:RemoteBodyRobot.rest", "after", 1),
    driver("step measured", "tests.kill.kill_robot:RemoteBodyRobot.step", "after", 1),
    driver("result to be sent", "agentrob.robots.driver.driver:Driver.step", "after", 1),
]
#: While the board is down nobody could stop the robot, so a motion may be interrupted, or not begin. It cannot be
#: verified either whether the command still holds, which cancels it before any motion (see `check`).
AWAY = frozenset({"done", "interrupted", "cancelled"})
BOARD = [
    board("command to be written", "content.writes:create_topic", "before"),
    board("command in the transaction", "content.writes:create_topic", "after"),
    board("command committed, not published", "db.writer:Writer._answer", "before"),
    board("command being published", "events.hub:Hub._deliver", "before"),
    board("command published", "events.hub:Hub._deliver", "after"),
    board("claim to be written", "content.writes:reply", "before", AWAY, containing="claim:"),
    board("claim in the transaction", "content.writes:reply", "after", AWAY, containing="claim:"),
    board("claim committed, not answered", "db.writer:Writer._answer", "before", AWAY, nth=2),
    board("claim answered", "db.writer:Writer._answer", "after", AWAY, nth=2),
    board("status in the transaction", "content.writes:edit", "after", AWAY, containing="'running'"),
    board("picture kept", "content.images:keep", "after", text=PHOTO),
    board("picture registered", "content.writes:add_image", "after", text=PHOTO),
    board("final reply to be written", "content.writes:edit", "before", containing="'done'"),
    board("final reply in the transaction", "content.writes:edit", "after", containing="'done'"),
]
IN_A_STOP = [
    ("agentrob.robots.driver.driver:Driver.stop", "before"),
    ("agentrob.robots.safety.guard:Guard.stop", "before"),
    ("tests.kill.kill_robot:RemoteBodyRobot.stop", "after"),
    ("agentrob.robots.driver.driver:Driver.stop", "after"),
]
POINTS = [*BEFORE_MOTION, *BEGUN, *ENDED, *DRIVER, *BOARD]
#: Run by default: one kill of each kind of process.
FAST = {"agent, walking", "driver, walking", "board, claim committed, not answered"}
assert {p.name for p in POINTS} >= FAST
assert len({p.name for p in POINTS}) == len(POINTS)


def case(point: Point) -> Any:
    return pytest.param(point, id=point.name, marks=() if point.name in FAST else pytest.mark.slow)


@pytest.mark.parametrize("point", [case(point) for point in POINTS])
def test_law_6_killed_at(point: Point, scene: KillScene) -> None:
    scene.arm(point.kind, point.order)
    command = scene.ask(point.text)
    killed_s = scene.wait_for_kill(point.kind)
    scene.start(point.kind)
    state = check(scene, command)
    scene.release()
    assert state in point.ends, scene.answers(command)[0]["raw"]
    if point.motions is not None:
        assert scene.motions(command.began) == point.motions
    assert scene.walked_m(command.began) < MOST_M
    if point.kind == "agent" and state == "interrupted":
        assert (scene.at_rest_since(command.began) or 0.0) - killed_s < STILL_S


@pytest.mark.slow
@pytest.mark.parametrize("nth", [3, 11, 23])
def test_law_11_the_agent_is_killed_on_a_long_walk_and_the_robot_stands_within_1_5_s(
    scene: KillScene, nth: int
) -> None:
    scene.arm("agent", {"target": "agentrob.agent.execution.execute:Run._must_end", "when": "before", "nth": nth})
    command = scene.ask(LONG_WALK)
    killed_s = scene.wait_for_kill("agent")
    scene.start("agent")
    assert check(scene, command) == "interrupted"
    assert scene.motions(command.began) == 1
    at_rest_s = scene.at_rest_since(command.began)
    assert at_rest_s is not None
    rest_commanded_s = scene.rest_commanded_after(command.began, killed_s) - killed_s
    print(f"told to rest after {rest_commanded_s:.3f} s, at rest after {at_rest_s - killed_s:.3f} s")  # noqa: T201
    assert 0.0 < rest_commanded_s < REST_COMMANDED_S
    assert at_rest_s - killed_s < STILL_S
    assert scene.walked_m(command.began) < 2.5, "it did not walk to the end"


@pytest.mark.slow
@pytest.mark.parametrize(("target", "when"), IN_A_STOP)
def test_law_14_a_driver_killed_in_a_stop_leaves_a_robot_that_stands_and_never_goes_on(
    scene: KillScene, target: str, when: str
) -> None:
    scene.arm("driver", {"target": target, "when": when})
    command = scene.ask(LONG_WALK)
    wait_for("the robot walks", lambda: scene.moves(command.began), 60.0)
    scene.stop(command)
    killed_s = scene.wait_for_kill("driver")
    scene.start("driver")
    final = scene.final(command)
    scene.release()
    assert final["card"]["state"] in {"stopped"} | DRIVER_DIED, "or nobody could confirm that it came to rest"
    assert scene.motions(command.began) == 1
    at_rest_s = scene.at_rest_since(command.began)
    assert at_rest_s is not None
    assert at_rest_s - killed_s < STILL_S
    assert len(scene.final_versions(final)) == 1
