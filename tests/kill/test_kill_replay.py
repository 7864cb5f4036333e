"""An agent that dies between a motion and its report: the report after its restart has the command's replay."""

from __future__ import annotations

from typing import Any

import pytest

from tests.kill.kill_process import wait_for
from tests.kill.kill_scene import ROBOT, KillScene, check

#: The agent dies before (or after) this function; the robot walked 0.3 m.
JOURNAL, FORUM = "agentrob.agent.store.journal:Journal.", "agentrob.forums.agentrob.forum:BoardForum."
END, REPORT = "the motion's end is committed", "the report is posted, its replay not"
POINTS = {
    END: {"target": JOURNAL + "_end", "when": "after"},
    REPORT: {"target": FORUM + "publish_replay", "when": "before"},
}


def replay_of(scene: KillScene, post_id: str) -> dict[str, Any]:
    """Wait for the replay, which follows the report."""

    def find() -> dict[str, Any]:
        answer = scene.http.get(f"/commands/{post_id}/replay", params={"robot": ROBOT})
        return dict(answer.json()) if answer.is_success else {}

    return dict(wait_for("the replay", find, 60.0))


@pytest.mark.parametrize("point", [END, pytest.param(REPORT, marks=pytest.mark.slow)])
def test_the_replay_survives_the_agent(point: str, scene: KillScene) -> None:
    scene.arm("agent", {"nth": 1, "containing": "", **POINTS[point]})
    command = scene.ask("walk forward 0.3 metres")
    scene.wait_for_kill("agent")
    scene.start("agent")
    assert check(scene, command) == "done"
    scene.release()
    data = replay_of(scene, scene.posted(command)["id"])
    walked_m = abs(sum(data["pose"][0][1:])) / 1000
    assert walked_m == pytest.approx(scene.walked_m(command.began), abs=0.1)
    assert [words for _, words in data["steps"]] == ["walk forward 0.3 m"]
    folder = scene.folder / "agents" / ROBOT / "poses"
    wait_for("its file is deleted", lambda: not list(folder.glob("*.jsonl")), 60.0)
