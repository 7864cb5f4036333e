"""Rights and notifications on NodeBB, against recordings of a real one."""

from __future__ import annotations

import pytest

from agentrob.errors import ForumDenied, ForumError, ForumNotFound, ForumUnoffered
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.protocol import Notification
from agentrob.model import AccountKind, Role
from tests.forums.nodebb.nodebb_world import NodeBBWorld, begin
from tests.waiting import until


# ---------------------------------------------------------------------- moderators
async def test_moderators_come_from_groups_also_from_nodebbs_own(nodebb: NodeBBWorld) -> None:
    bob = await nodebb.sign_in("bob")
    carol = await nodebb.sign_in("carol", role=Role.MODERATOR)
    await nodebb.sign_in("dave")
    await nodebb.client.send("PUT", f"/groups/global-moderators/membership/{nodebb.uids['dave']}")
    dave = await bob.account("dave")
    assert dave is not None
    assert ((await carol.me()).role, dave.role) == (Role.MODERATOR, Role.MODERATOR)


async def test_law_2_a_group_of_moderators_that_anybody_may_join_approves_nothing(nodebb: NodeBBWorld) -> None:
    carol = await nodebb.sign_in("carol", role=Role.MODERATOR)
    await nodebb.client.send("PUT", "/groups/robot-moderators", {"private": 0})
    open_to_all = (await carol.me()).role
    await nodebb.client.send("PUT", "/groups/robot-moderators", {"private": 1})
    assert (open_to_all, (await carol.me()).role) == (Role.MEMBER, Role.MODERATOR)


# ---------------------------------------------------------------------- changing rights
async def test_an_admin_gives_and_takes_each_role_and_nobody_keeps_the_one_before(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    for role in (Role.OPERATOR, Role.MODERATOR, Role.ADMIN, Role.MODERATOR, Role.MEMBER):
        assert (await nodebb.admin.set_rights("alice", role=role)).role is role
        assert (await alice.me()).role is role
    groups = (await nodebb.client.get("/api/user/alice/groups"))["groups"]
    assert not {g["slug"] for g in groups} & {"robot-operators", "robot-moderators", "administrators"}


async def test_who_is_suspended_is_let_in_again_also_when_he_was_muted(nodebb: NodeBBWorld) -> None:
    await nodebb.sign_in("alice", role=Role.OPERATOR)
    changed = await nodebb.admin.set_rights("alice", suspended=True)
    assert (changed.role, changed.suspended) == (Role.OPERATOR, True)
    assert not (await nodebb.admin.set_rights("alice", suspended=False)).suspended
    await nodebb.client.send("PUT", f"/users/{nodebb.uids['alice']}/mute", {"reason": "a test"})
    muted = await nodebb.admin.account("alice")
    assert muted is not None
    assert muted.suspended
    assert not (await nodebb.admin.set_rights("alice", suspended=False)).suspended


async def test_rights_that_cannot_be_given_are_said_so(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice", role=Role.MODERATOR)
    for refused in (alice.set_rights("admin", suspended=True), alice.set_rights("alice", role=Role.ADMIN)):
        with pytest.raises(ForumDenied, match="administrators"):
            await refused
    with pytest.raises(ForumNotFound):
        await nodebb.admin.set_rights("nobody-at-all", role=Role.OPERATOR)
    plain = NodeBBForum(nodebb.settings.model_copy(update={"options": {}}), nodebb.secrets["admin"])
    nodebb.forums.append(plain)
    for role in (Role.OPERATOR, Role.MODERATOR):
        with pytest.raises(ForumUnoffered, match=role):
            await plain.set_rights("alice", role=role)
    with pytest.raises(ForumUnoffered, match="robot_agents"):
        await plain.register("rover", kind=AccountKind.ROBOT_AGENT)
    assert (await alice.me()).role is Role.MODERATOR


async def test_law_2_a_right_by_a_group_that_is_open_is_not_said_to_be_given(nodebb: NodeBBWorld) -> None:
    await nodebb.sign_in("alice")
    await nodebb.client.send("PUT", "/groups/robot-operators", {"private": 0})
    with pytest.raises(ForumError, match="open to anybody"):
        await nodebb.admin.set_rights("alice", role=Role.OPERATOR)
    await nodebb.client.send("PUT", "/groups/robot-operators", {"private": 1})


# ---------------------------------------------------------------------- notifications
async def wait_for_notifications(forum: NodeBBForum, number: int) -> tuple[Notification, ...]:
    """Wait for this many notifications; NodeBB creates them a moment after the post."""
    return (await until(forum.notifications, lambda found: len(found.items) >= number)).items


async def test_a_reply_is_a_notice_one_that_mentions_is_one_only_page_by_page(
    nodebb: NodeBBWorld,
) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    first, other = await begin(alice), await begin(bob, "Another")
    mention = (await bob.reply(other.topic_id, "@alice look at this", key="1")).post
    await wait_for_notifications(alice, 1)
    both = (await bob.reply(first.topic_id, "@alice look here", key="2")).post
    await wait_for_notifications(alice, 2)
    reply = (await bob.reply(first.topic_id, "and here", key="3", reply_to=first.id)).post
    wanted = [("reply", reply.id), ("mention", both.id), ("mention", mention.id)]
    assert [(n.kind, n.post.id) for n in await wait_for_notifications(alice, 3)] == wanted
    one = await alice.notifications(limit=1)
    rest = await alice.notifications(one.next, limit=2)
    assert [(n.kind, n.post.id) for n in (*one.items, *rest.items)] == wanted
    assert not any(n.read for n in one.items)
    await nodebb.remove(both.id)
    assert [n.post.id for n in (await alice.notifications()).items] == [reply.id, mention.id]


async def test_a_notice_of_what_may_not_be_read_any_more_hides_no_other(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    room = (await nodebb.client.send("POST", "/categories", {"name": "Back room"}))["cid"]
    topic = (await alice.create_topic(str(room), "A topic", "hello there", key="1")).post
    first = await begin(alice)
    await bob.reply(topic.topic_id, "@alice in the back room", key="1")
    seen = (await bob.reply(first.topic_id, "@alice here", key="2")).post
    await wait_for_notifications(alice, 2)
    for privilege in ("groups:find", "groups:read", "groups:topics:read"):
        for group in ("registered-users", "guests"):
            await nodebb.client.send("DELETE", f"/categories/{room}/privileges/{privilege}", {"member": group})
    left = (await alice.notifications()).items
    await nodebb.client.send("DELETE", f"/categories/{room}")
    assert [n.post.id for n in left] == [seen.id]
