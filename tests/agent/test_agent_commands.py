"""A post comes in, the robot moves, a reply goes out."""

from __future__ import annotations

import json
from pathlib import Path

from agent_scene import Driver, Scene, make_scene


async def test_a_command_is_done_and_reported_with_what_was_measured(scene: Scene) -> None:
    async with scene.agent():
        post = await scene.post("alice", "@quadruped walk forward 1 metre, turn left 90 degrees and take a photo")
        reply = await scene.final(post)
    assert reply.card is not None
    assert reply.card.state == "done"
    assert "| 1 | walk forward 1 m |" in reply.raw
    assert len(scene.replies(post)) == 1
    assert len(reply.images) == 2
    record = json.loads((scene.folder / "agents/quadruped/records" / f"{post.id}.json").read_text())
    assert [s["op"] for s in record["steps"]] == ["move", "turn", "get_front_image"]
    assert abs(record["steps"][0]["measured"]["distance_m"] - 1.0) < 0.05


async def test_it_answers_to_other_names_that_its_owner_configured(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, mentions=("@Rex",))
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", "@rex turn left 45 degrees"))
    assert reply.card is not None
    assert reply.card.state == "done"
