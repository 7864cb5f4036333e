"""One robot waits for another: two agents read the same post, and no other process coordinates them."""

from __future__ import annotations

from itertools import pairwise

import pytest

from agentrob.model import AccountKind, Post, Role, StatusCard
from tests.agent.joint.joint_scene import JointScene

THEN = "@quadruped walk forward 0.3 m, then @humanoid wave"
LONG = "@quadruped walk forward 4 m, then @humanoid wave"
TOGETHER = "@quadruped walk forward 4 m. Meanwhile @humanoid walk forward 4 m. Then both of you wave."


def state(post: Post) -> str:
    assert post.card is not None
    return post.card.state


async def test_law_18_a_part_begins_when_the_one_before_it_is_done_and_one_reply_sums_up(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post(THEN)
        waiting = await scene.shows(post, 2, "queued")
        first, second = await scene.ends(post, 1), await scene.ends(post, 2)
        summary = await scene.summary(post)
    assert "Waits until `quadruped` (part 1) is done, at most 1 minute" in waiting.raw
    assert waiting.card is not None
    assert (waiting.card.post, waiting.card.content_hash) == (post.id, post.content_hash)
    assert (state(first), state(second)) == ("done", "done")
    assert "Part 2 of 2." in second.raw
    done_at = next(e.at for e in scene.world.events if e.post and e.post.id == first.id and e.post.card == first.card)
    states = [(e.at, state(e.post)) for e in scene.world.events if e.post and e.post.id == second.id]
    assert [name for _, name in states] == ["seen", "queued", "running", "done"]
    assert states[2][0] > done_at
    assert summary.author.name == "quadruped"
    assert summary.raw.startswith("2 of 2 done:")
    assert "2. `humanoid` is done: `wave`" in summary.raw


async def test_parts_that_follow_both_wait_for_both(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post("@quadruped 前进0.3米。@humanoid 左转30度。然后你们俩都挥手。")
        ends = [await scene.ends(post, number) for number in (1, 2, 3, 4)]
        summary = await scene.summary(post)
    assert [state(end) for end in ends] == ["done"] * 4
    assert "第 3 部分，共 4 部分。" in ends[2].raw
    assert summary.raw.startswith("4 个部分完成了 4 个")


async def test_a_part_after_one_that_was_refused_is_cancelled_with_the_reason(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post("@quadruped walk forward 9 m, then @humanoid wave")
        end, summary = await scene.ends(post, 2), await scene.summary(post)
    assert state(end) == "cancelled"
    assert "I did not begin, because `quadruped` (part 1) was refused." in end.raw
    assert summary.raw.startswith("0 of 2 done:")


async def test_a_robot_that_does_not_answer_ends_the_wait(scene: JointScene) -> None:
    scene.world.clock_offset_s = -90.0  # older than the first part may take, and still fresh
    async with scene.agents("humanoid"):
        post = await scene.post(THEN)
        scene.world.clock_offset_s = 0.0
        end = await scene.ends(post, 2)
    assert state(end) == "cancelled"
    assert "because `quadruped` (part 1) did not answer in time" in end.raw


@pytest.mark.parametrize("how", ["@quadruped stop", "stop", "the button", "elsewhere"])
async def test_law_13_one_stop_stops_all_parts(scene: JointScene, how: str) -> None:
    async with scene.agents():
        post = await scene.post(TOGETHER)
        await scene.shows(post, 1, "running")
        await scene.shows(post, 2, "running")
        await scene.shows(post, 3, "queued")
        bob = scene.world.sign_in("bob")
        if how == "the button":
            await bob.press_stop("quadruped")
        elif how == "elsewhere":
            await bob.create_topic("robots", "Another topic", "@quadruped stop", key="stop")
        else:
            await bob.reply(post.topic_id, how, key="stop")
        ends = [await scene.ends(post, number) for number in (1, 2, 3, 4)]
        summary = await scene.summary(post)
    assert [state(end) for end in ends] == ["stopped", "stopped", "cancelled", "cancelled"]
    assert summary.raw.startswith("0 of 4 done:")


async def test_law_13_a_stop_at_one_robots_machine_stops_all_parts(scene: JointScene) -> None:
    async with scene.agents() as (quadruped, _):
        post = await scene.post(TOGETHER)
        await scene.shows(post, 1, "running")
        await scene.shows(post, 2, "running")
        await quadruped.driver.stop("a person at the robot")
        ends = [await scene.ends(post, number) for number in (1, 2, 3, 4)]
    assert [state(end) for end in ends] == ["stopped", "stopped", "cancelled", "cancelled"]


async def test_law_4_an_edit_cancels_the_parts_that_wait(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post(LONG)
        await scene.shows(post, 2, "queued")
        await scene.world.sign_in("alice").edit(post.id, "@quadruped walk forward 4 m, then @humanoid sit")
        end = await scene.ends(post, 2)
    assert state(end) == "cancelled"
    assert "was edited" in end.raw


async def test_laws_2_and_4_rights_are_asked_again_after_the_wait(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post(LONG)
        await scene.shows(post, 2, "queued")
        await scene.shows(post, 1, "running")
        scene.world.set_role("alice", Role.MEMBER)
        end = await scene.ends(post, 2)
        assert state(await scene.ends(post, 1)) == "done"
    assert state(end) == "refused"


async def test_law_1_only_the_robots_own_card_for_this_post_and_text_releases_a_wait(scene: JointScene) -> None:
    imp = scene.world.sign_in("imp", kind=AccountKind.ROBOT_AGENT)
    quadruped = scene.world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    async with scene.agents("humanoid"):
        earlier = await scene.post(THEN)
        post = await scene.post(THEN, topic=earlier.topic_id)
        await scene.shows(post, 2, "queued")
        facts = {"part": 1, "parts": 2, "post": post.id, "content_hash": post.content_hash}
        forged = (
            (imp, StatusCard("imp", "done", **facts)),  # type: ignore[arg-type]
            (imp, StatusCard("quadruped", "done", **facts)),  # type: ignore[arg-type]
            (scene.world.sign_in("bob"), StatusCard("quadruped", "done", **facts)),  # type: ignore[arg-type]
            (quadruped, StatusCard("quadruped", "done", **{**facts, "content_hash": "0" * 64})),  # type: ignore[arg-type]
            (quadruped, StatusCard("quadruped", "done", **{**facts, "part": 2})),  # type: ignore[arg-type]
            (quadruped, StatusCard("quadruped", "done")),
            (quadruped, StatusCard("quadruped", "done", **{**facts, "post": earlier.id})),  # type: ignore[arg-type]
        )
        for number, (forum, card) in enumerate(forged):
            await forum.reply(post.topic_id, "done", key=f"forged {number}", reply_to=post.id, card=card)
        assert state(await scene.ends(earlier, 2)) == "done"  # the last one was true of the earlier post
        waiting = scene.part(post, 2)
        assert waiting is not None
        assert state(waiting) == "queued"
        true = StatusCard("quadruped", "done", **facts)  # type: ignore[arg-type]
        await quadruped.reply(post.topic_id, "done", key="true", reply_to=post.id, card=true)
        assert state(await scene.ends(post, 2)) == "done"


async def test_law_5_what_was_released_too_long_ago_does_not_begin(scene: JointScene) -> None:
    quadruped = scene.world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    async with scene.agents("humanoid"):
        post = await scene.post("@quadruped walk forward 5 m slowly, then @humanoid wave")
        await scene.shows(post, 2, "queued")
    facts = {"part": 1, "parts": 2, "post": post.id, "content_hash": post.content_hash}
    card = StatusCard("quadruped", "done", **facts)  # type: ignore[arg-type]
    await quadruped.reply(post.topic_id, "done", key="true", reply_to=post.id, card=card)
    scene.world.clock_offset_s = 125.0
    async with scene.agents("humanoid"):
        assert state(await scene.ends(post, 2)) == "expired"


@pytest.mark.parametrize("world", [{"live": False, "fastest_poll_s": 0.2}, {"max_edits": 3}, {"max_edits": 1}])
async def test_it_works_on_a_forum_that_is_polled_and_where_edits_are_few(
    scene: JointScene, world: dict[str, float]
) -> None:
    for name, value in world.items():
        setattr(scene.world, name, value)
    async with scene.agents():
        post = await scene.post(THEN)
        await scene.summary(post)
        finals = {p.author.name: p for p in scene.replies(post) if p.card is not None and p.card.is_final}
    assert {name: state(p) for name, p in finals.items()} == {"quadruped": "done", "humanoid": "done"}
    assert len(scene.summaries(post)) == 1


async def test_what_is_not_understood_is_asked_by_every_robot_and_nobody_moves(scene: JointScene) -> None:
    scene.world.sign_in("carol")
    posts = {
        "@quadruped walk 1 m, then @humanoid fly to the moon": "I did not understand the part of `humanoid`",
        "@quadruped walk 1 m, then @carol wave": "`carol` is not a robot",
        "@quadruped walk 1 m when @humanoid is done. @humanoid wave when @quadruped is done.": "in a circle",
    }
    async with scene.agents():
        for text, why in posts.items():
            post = await scene.post(text)
            asked = await scene.until(
                lambda post=post: [p for p in scene.replies(post) if p.card and p.card.state == "asks_back"]
            )
            assert why in asked[0].raw, asked[0].raw
            assert "carol" in text or "`@quadruped walk forward 1 m, then @humanoid wave`" in asked[0].raw
            assert not scene.summaries(post)


async def test_two_parts_of_one_robot_are_two_commands(scene: JointScene) -> None:
    async with scene.agents():
        post = await scene.post("@quadruped wave, then @humanoid wave, then @quadruped walk forward 0.3 m")
        ends = [await scene.ends(post, number) for number in (1, 2, 3)]
        await scene.summary(post)
    assert [state(end) for end in ends] == ["done"] * 3
    assert ends[0].id != ends[2].id
    times = [end.edited_at for end in ends]
    assert all(a is not None and b is not None and a < b for a, b in pairwise(times))
