"""A robot on a real NodeBB, set up by configuration alone: a post comes in, the robot moves, a reply goes out.

Set AGENTROB_TEST_NODEBB_URL and AGENTROB_TEST_NODEBB_ADMIN as described in `test_contract_live.py`; without them no
test is collected.
"""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from agentrob.model import AccountKind, Role
from tests.forums.nodebb.nodebb_processes import (
    ROBOT,
    answer,
    final,
    replies_to,
    running_robot,
    running_robots,
    state,
)
from tests.forums.nodebb.nodebb_world import NodeBBWorld
from tests.waiting import until

URL = os.environ.get("AGENTROB_TEST_NODEBB_URL", "")
ADMIN = os.environ.get("AGENTROB_TEST_NODEBB_ADMIN", "")


@pytest.fixture
async def world() -> AsyncIterator[NodeBBWorld]:
    made = NodeBBWorld(URL, ADMIN)
    await made.prepare()
    await made.sign_in("alice", role=Role.OPERATOR)
    await made.sign_in("bob")
    await made.sign_in(ROBOT, kind=AccountKind.ROBOT_AGENT)
    yield made
    await made.prepare()
    await made.close()


if URL:

    @pytest.mark.slow
    async def test_posts_are_done_refused_and_stopped_on_nodebb_by_configuration_alone(
        world: NodeBBWorld, tmp_path: Path
    ) -> None:
        alice, bob = world.forums[0], world.forums[1]
        with running_robot(world, world.secrets[ROBOT], tmp_path):
            walk = await alice.create_topic("robots", "A walk", f"@{ROBOT} walk forward 1 m", key="walk")
            done = await final(world, walk.post)
            assert done.card is not None
            assert done.card.state == "done", done.raw
            assert "| walk forward 1 m |" in done.raw
            mere = await bob.reply(walk.post.topic_id, f"@{ROBOT} walk forward 1 m", key="mere")
            refused = await final(world, mere.post)
            assert refused.card is not None
            assert refused.card.state == "refused"
            look = await alice.create_topic("robots", "A picture", f"@{ROBOT} take a picture", key="look")
            seen = await final(world, look.post)
            assert seen.images, seen.raw
            assert await alice.download(seen.images[0])
            far = await alice.create_topic("robots", "Far", f"@{ROBOT} walk forward 5 m", key="far")
            await state(world, far.post, "running")
            await bob.reply(far.post.topic_id, "stop", key="stop")
            stopped = await final(world, far.post)
            assert stopped.card is not None
            assert stopped.card.state == "stopped", stopped.raw
            text = "\n\n".join(post.raw for post in (done, refused, seen, stopped))
            (tmp_path / "told.md").write_text(text, encoding="utf-8")

    @pytest.mark.slow
    async def test_two_robots_with_an_agent_each_do_one_joint_command_on_nodebb(
        world: NodeBBWorld, tmp_path: Path
    ) -> None:
        """Each agent knows of the other's part only what NodeBB tells it."""
        alice, other = world.forums[0], "humanoid"
        await world.sign_in(other, kind=AccountKind.ROBOT_AGENT)
        text = f"@{ROBOT} walk forward 1 m, then @{other} walk forward 0.5 m. Then one of you walk backward 0.5 m"
        with running_robots(world, {name: world.secrets[name] for name in (ROBOT, other)}, tmp_path):
            post = (await alice.create_topic("robots", "Together", text, key="together")).post
            found = await until(
                lambda: replies_to(world, post), lambda found: any(" of 3 done:" in p.raw for p in found), limit_s=180
            )
            summary = [p for p in found if " of 3 done:" in p.raw]
        assert summary[0].raw.startswith("3 of 3 done:"), summary[0].raw
        cards = [p.card for p in await replies_to(world, post) if p.card]
        assert sorted((c.part, c.state) for c in cards if c.state == "done") == [(1, "done"), (2, "done"), (3, "done")]
        takers = [c.robot for c in cards if c.takes]  # both, where a bid was not seen in time: the first one counts
        assert takers[0] == next(c.robot for c in cards if (c.part, c.state) == (3, "done"))
        assert [c.left_to for c in cards if c.left_to] == takers[:1]

    @pytest.mark.slow
    async def test_law_7_on_nodebb_what_needs_an_approval_is_done_with_a_moderators(
        world: NodeBBWorld, tmp_path: Path
    ) -> None:
        alice, bob = world.forums[0], world.forums[1]
        carol = await world.sign_in("carol", role=Role.MODERATOR)
        with running_robot(world, world.secrets[ROBOT], tmp_path):
            wave = (await alice.create_topic("robots", "A wave", f"@{ROBOT} wave", key="wave")).post
            await state(world, wave, "waiting")
            for name, forum in (("alice", alice), ("bob", bob)):
                no = (await forum.reply(wave.topic_id, f"@{ROBOT} approve", key=f"by {name}")).post
                assert "approve" in (await answer(world, no)).raw
            await state(world, wave, "waiting")
            await carol.reply(wave.topic_id, f"@{ROBOT} approve", key="by carol")
            done = await final(world, wave)
            assert done.card is not None
            assert (done.card.state, "Approved by `carol`" in done.raw) == ("done", True), done.raw

    @pytest.mark.slow
    async def test_law_6_within_nodebbs_own_limits_each_command_is_answered_once(
        world: NodeBBWorld, tmp_path: Path
    ) -> None:
        """A new NodeBB queues posts, requires 120 s between a newcomer's posts and 10 s between anybody's.

        The robot's group is exempt from the first two, as docs/forum/nodebb.md asks; administrators are exempt from all
        three.
        """
        root = await world.sign_in("root", role=Role.ADMIN)
        await world.own_limits()
        with running_robot(world, world.secrets[ROBOT], tmp_path):
            posts = [
                (await root.create_topic("robots", f"A walk {n}", f"@{ROBOT} walk forward 1 m", key=f"walk{n}")).post
                for n in range(2)
            ]
            for post in posts:
                done = await final(world, post, 90)
                assert done.card is not None
                assert done.card.state == "done", done.raw
        for post in posts:
            text = [p for p in (await root.posts(post.topic_id)).items if p.author.name == ROBOT]
            assert len(text) == 1

    @pytest.mark.slow
    async def test_law_6_on_nodebb_a_claim_that_the_journal_does_not_know_moves_nothing(
        world: NodeBBWorld, tmp_path: Path
    ) -> None:
        alice = world.forums[0]
        robot = await world.sign_in(ROBOT)
        walk = await alice.create_topic("robots", "A walk", f"@{ROBOT} walk forward 1 m", key="walk")
        claim = await robot.reply(walk.post.topic_id, "claimed by another", key=f"claim:{walk.post.id}")
        await world.remove(claim.post.id)
        again = await robot.reply(walk.post.topic_id, "once more", key=f"claim:{walk.post.id}", reply_to=walk.post.id)
        fresh = await (await world.sign_in(ROBOT)).reply(walk.post.topic_id, "new", key=f"claim:{walk.post.id}")
        assert (again.created, fresh.created) == (False, False), "also a claim that a moderator removed stays one"
        assert again.post.id == fresh.post.id == claim.post.id
