"""A command end to end: a post comes in, the robot moves, a reply goes out."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import pytest

from agentrob.agent.media.poses import PoseSampler
from tests.agent.agent_scene import Driver, Scene, held_by, make_scene
from tests.tolerances import about_m

DRAWS = True


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
    assert record["steps"][0]["measured"]["distance_m"] == about_m(1.0)


async def test_it_answers_to_other_names_that_its_owner_configured(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, mentions=("@Rex",))
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", "@rex turn left 45 degrees"))
    assert reply.card is not None
    assert reply.card.state == "done"


async def test_never_mind_takes_back_what_its_author_asked_for_and_has_not_begun(scene: Scene) -> None:
    scene.person("carol")
    async with scene.agent() as agent:
        async with held_by("somebody at the console", scene.driver):
            running = await scene.post("alice", "@quadruped turn left 20 degrees")
            await scene.until(lambda: agent.queue.moving)
            mine = [await scene.post("alice", f"@quadruped turn left {angle} degrees") for angle in (30, 40)]
            hers = await scene.post("carol", "@quadruped turn right 30 degrees")
            took = await scene.post("alice", "@quadruped never mind")
            ends = [await scene.final(post) for post in mine]
            answer = await scene.final(took)
        others = [await scene.final(post) for post in (running, hers)]
    assert [end.card.state for end in ends] == ["cancelled", "cancelled"]
    assert all("took it back" in end.raw for end in ends)
    assert "Cancelled: 2 of your commands" in answer.raw
    assert others[1].card.state == "done"
    assert others[0].card.state != "cancelled"


async def test_law_18_never_mind_does_not_take_back_a_command_whose_motion_has_ended(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    ended, go_on = asyncio.Event(), asyncio.Event()

    async def written(_: PoseSampler) -> None:  # as on a slow disk, which delays the report
        ended.set()
        await go_on.wait()

    monkeypatch.setattr(PoseSampler, "written", written)
    async with scene.agent():
        done = await scene.post("alice", "@quadruped turn left 20 degrees")
        await asyncio.wait_for(ended.wait(), 60)
        answer = await scene.final(await scene.post("alice", "@quadruped never mind"))
        go_on.set()
        report = await scene.final(done)
    assert "nothing of yours waiting" in answer.raw
    assert report.card.state == "done"


async def test_never_mind_with_a_new_command_replaces_the_old_one(scene: Scene) -> None:
    async with scene.agent() as agent:
        async with held_by("somebody at the console", scene.driver):
            await scene.post("alice", "@quadruped turn left 20 degrees")
            await scene.until(lambda: agent.queue.moving)
            old = await scene.post("alice", "@quadruped turn left 30 degrees")
            await scene.state(old, "queued")
            new = await scene.post("alice", "@quadruped never mind, turn right 50 degrees")
            assert (await scene.final(old)).card.state == "cancelled"
        assert (await scene.final(new)).card.state == "done"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("@quadruped never mind", "nothing of yours waiting"),
        ("@quadruped what do you see?", "Without a vision model"),
        ("@quadruped 你看到了什么？", "没有视觉模型"),
    ],
)
async def test_what_is_no_command_and_wants_an_answer_gets_one(scene: Scene, text: str, said: str) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("bob", text))
    assert reply.card.state == "answered"
    assert said in reply.raw


async def test_who_may_have_a_photo_is_shown_what_the_robot_sees(scene: Scene) -> None:
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", "@quadruped what do you see?"))
    assert reply.card.state == "done", reply.raw
    assert "take a photo" in reply.raw
    assert "I cannot say what I see; the photo shows it." in reply.raw


async def test_a_step_whose_length_is_configured_is_walked(driver: Driver, tmp_path: Path) -> None:
    scene = make_scene(driver, tmp_path, step_length_m=0.4)
    async with scene.agent():
        reply = await scene.final(await scene.post("alice", "@quadruped walk forward two steps"))
    assert reply.card.state == "done"
    assert "walk forward 0.8 m" in reply.raw


async def test_again_and_the_way_back_are_read_from_what_was_done_in_the_thread(scene: Scene) -> None:
    async with scene.agent():
        first = await scene.post("alice", "@quadruped walk forward 1 metre, turn left 90 degrees")
        await scene.final(first)
        for text, rows in (
            ("@quadruped again, but slower", ["walk forward 1 m at 0.2", "turn left 90"]),
            ("@quadruped and now back", ["turn right 90", "walk backward 1 m"]),
        ):
            reply = await scene.final(await scene.post("alice", text, first.topic_id))
            assert reply.card.state == "done", reply.raw
            assert all(row in reply.raw for row in rows), reply.raw
        elsewhere = await scene.final(await scene.post("alice", "@quadruped again"))
    assert elsewhere.card.state == "asks_back"
