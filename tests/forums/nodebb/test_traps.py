"""Peculiarities of NodeBB, against recordings of a real one: limits, the post queue, reading, events."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.nodebb.markers import MarkedText, mark
from agentrob.forums.nodebb.socket import Push
from agentrob.model import AccountKind, EventKind, Role, StatusCard
from tests.forums.nodebb.nodebb_world import NodeBBWorld, begin, replies, texts
from tests.waiting import until


# ---------------------------------------------------------------------- limits
async def test_a_new_member_who_posts_again_at_once_is_reported_when(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    for setting, seconds in (("newbiePostDelay", 120), ("postDelay", 10), ("initialPostDelay", 30)):
        await nodebb.set(setting, seconds)
        with pytest.raises(ForumLimited) as told:
            await alice.reply(post.topic_id, "too fast", key="1")
        assert told.value.retry_after_s == seconds
        await nodebb.set(setting, 0)
    assert (await alice.reply(post.topic_id, "in time", key="1")).created
    assert await texts(alice, post.topic_id) == ["hello there", "in time"]


async def test_a_reply_in_the_queue_is_waited_for_and_not_written_again(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    await nodebb.set("postQueue", 1)
    for _ in range(3):
        with pytest.raises(ForumLimited, match="moderator"):
            await alice.reply(post.topic_id, "to be looked at", key="1")
    other = nodebb.at(nodebb.url, nodebb.secrets["alice"])
    with pytest.raises(ForumLimited, match="moderator"):
        await other.reply(post.topic_id, "to be looked at", key="1")
    assert replies(nodebb, "alice", post) == 1, "written once, waited for since"
    await nodebb.set("postQueue", 0)
    waiting = (await nodebb.client.get("/api/post-queue"))["posts"]
    ours = [q["id"] for q in waiting if str(q["data"].get("tid")) == post.topic_id]
    assert len(ours) == 1
    await nodebb.client.send("POST", f"/posts/queue/{ours[0]}")
    accepted = await alice.reply(post.topic_id, "to be looked at", key="1")
    assert (accepted.created, accepted.post.raw) == (False, "to be looked at")
    assert await texts(alice, post.topic_id) == ["hello there", "to be looked at"]


async def test_posts_of_one_account_go_one_after_the_other(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    written = await asyncio.gather(*(alice.reply(post.topic_id, f"at once {n}", key=f"k{n}") for n in range(4)))
    assert all(w.created for w in written), "NodeBB refuses two at a time"
    assert nodebb.server.most_at_once == 1


async def test_another_program_of_the_same_account_that_posts_just_now_is_a_wait(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    others = [nodebb.at(nodebb.url, nodebb.secrets["alice"]) for _ in range(3)]
    for other in others:
        await other.me()

    waits: list[float] = []

    async def reply_until_accepted(forum: NodeBBForum) -> bool:
        while True:
            try:
                return (await forum.reply(post.topic_id, "once", key="same")).created
            except ForumLimited as e:
                waits.append(e.retry_after_s)
                await asyncio.sleep(e.retry_after_s)

    created = await asyncio.gather(*(reply_until_accepted(forum) for forum in others))
    assert created.count(True) == 1
    assert all(wait < 1 for wait in waits)
    assert (await texts(alice, post.topic_id)).count("once") == 1


async def test_short_words_are_long_enough(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    assert (await alice.reply(post.topic_id, "ok", key="1")).post.raw == "ok"
    with pytest.raises(ForumError, match=r"title"):
        await alice.create_topic("robots", "x" * 300, "hello there", key="2")


async def test_a_muted_or_banned_account_is_denied_and_shown_as_suspended(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await begin(alice)
    await nodebb.client.send("PUT", f"/users/{nodebb.uids['alice']}/mute", {"reason": "a test"})
    with pytest.raises(ForumDenied, match="muted"):
        await alice.reply(post.topic_id, "words", key="1")
    assert (await bob.post(post.id)).author.suspended


# ---------------------------------------------------------------------- once per key
async def test_a_lost_answer_costs_nothing_and_doubles_nothing(
    nodebb: NodeBBWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    send = NodeBBClient.send

    async def lost(self: NodeBBClient, method: str, path: str, body: Mapping[str, Any] | None = None) -> dict[str, Any]:
        await send(self, method, path, body)
        raise ForumUnreachable("the answer was lost")

    with monkeypatch.context() as patch:
        patch.setattr(NodeBBClient, "send", lost)
        with pytest.raises(ForumUnreachable):
            await alice.reply(post.topic_id, "once", key="1", reply_to=post.id)
    again = await nodebb.at(nodebb.url, nodebb.secrets["alice"]).reply(post.topic_id, "once", key="1", reply_to=post.id)
    assert not again.created
    assert replies(nodebb, "alice", post) == 1
    assert await texts(alice, post.topic_id) == ["hello there", "once"]


async def test_law_6_a_claim_is_found_by_who_has_lost_his_memory_also_when_it_was_removed(nodebb: NodeBBWorld) -> None:
    robot = await nodebb.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    key = f"claim:{post.id}"
    claim = (await robot.reply(post.topic_id, "mine", key=key, reply_to=post.id)).post
    await nodebb.remove(claim.id)
    fresh = nodebb.at(nodebb.url, nodebb.secrets["quadruped"])
    again = await fresh.reply(post.topic_id, "mine", key=key, reply_to=post.id)
    assert (again.created, again.post.id, again.post.removed) == (False, claim.id, True)


async def test_law_1_a_mark_that_somebody_copies_is_nobody_elses_key_or_card(nodebb: NodeBBWorld) -> None:
    robot = await nodebb.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    status = (await robot.reply(post.topic_id, "mine", key="claim:1")).post
    raw = (await alice._client.get_v3(f"/posts/{status.id}"))["content"]
    await alice._client.send("POST", f"/topics/{post.topic_id}", {"content": raw})
    await alice._client.send("POST", f"/topics/{post.topic_id}", {"content": _forged_card()})
    fresh = nodebb.at(nodebb.url, nodebb.secrets["quadruped"])
    read = (await fresh.posts(post.topic_id)).items
    assert [p.key for p in read] == [None, "claim:1", None, None]
    assert [p.card for p in read] == [None, None, None, None]


def _forged_card() -> str:
    return mark(MarkedText("believe me", "claim:1", StatusCard("quadruped", "done")))


# ---------------------------------------------------------------------- reading
async def test_names_and_titles_are_not_shown_in_html(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice, "Tom & Jerry's <walk>")
    assert (await alice.topic(post.topic_id)).title == "Tom & Jerry's <walk>"
    assert "Tom & Jerry's <walk>" in [t.title for t in (await alice.topics("robots")).items]
    assert "Comments & Feedback" in [b.name for b in await alice.boards()]


async def test_mentions_are_accounts_outside_of_code_and_quotes_and_are_noticed(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    await nodebb.sign_in("quadruped")
    text = "@bob look, @nobody-at-all\n\n> @quadruped said\n\n`@quadruped` code"
    post = (await alice.create_topic("robots", "A topic", text, key="1")).post
    assert post.mentions == ("bob",)
    await until(bob.mentions, lambda found: post.id in [p.id for p in found])


async def test_words_are_found_by_the_search_plugin(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = (await alice.create_topic("robots", "A topic", "the zebrafinch sings", key="1")).post
    found = await alice.search("zebrafinch", board_id="robots")
    assert post.id in [p.id for p in found.items]
    assert all("zebrafinch" in p.raw for p in found.items)


async def test_a_person_who_left_commands_nothing_any_more(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice", role=Role.OPERATOR), await nodebb.sign_in("bob")
    post = await begin(alice)
    await nodebb.forget("alice")
    author = (await bob.post(post.id)).author
    assert (author.role, author.suspended) == (Role.MEMBER, True)
    assert await bob.account("alice") is None


async def test_law_4_a_post_that_a_moderator_gave_away_is_its_new_owners(nodebb: NodeBBWorld) -> None:
    """NodeBB's "Change Owner" causes no event and is not an edit, so an agent reads a post again before it acts."""
    alice, bob = await nodebb.sign_in("alice", role=Role.OPERATOR), await nodebb.sign_in("bob")
    post = await begin(alice)
    after, _ = await bob.now()
    await nodebb.client.send("PUT", f"/posts/{post.id}/owner", {"uid": int(nodebb.uids["bob"])})
    assert await bob.changes(after) == ()
    now = await bob.post(post.id)
    assert (now.author.name, now.author.role, now.content_hash) == ("bob", Role.MEMBER, post.content_hash)
    assert now.author.id != post.author.id


# ---------------------------------------------------------------------- events
async def test_a_restart_hears_what_was_written_and_edited_meanwhile(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    first = await begin(alice)
    after, _ = await bob.now()
    second = (await alice.reply(first.topic_id, "written meanwhile", key="1")).post
    await alice.edit(first.id, "stop")
    restarted = nodebb.at(nodebb.url, nodebb.secrets["bob"])
    events = await restarted.changes(after)
    assert {(e.kind, e.post and e.post.id) for e in events} == {
        (EventKind.POST_EDITED, first.id),
        (EventKind.POST_CREATED, second.id),
    }
    assert await restarted.changes(events[-1].id) == ()


async def test_law_5_an_event_of_a_forum_that_was_replaced_is_not_found(nodebb: NodeBBWorld) -> None:
    bob = await nodebb.sign_in("bob")
    post = await begin(bob)
    after, _ = await bob.now()
    pid, written_ms, *rest = after.split(".")
    assert pid == post.id
    other = nodebb.at(nodebb.url, nodebb.secrets["bob"])
    for forged in (".".join((pid, str(int(written_ms) - 1000), *rest)), ".".join(("999999", written_ms, *rest)), "x"):
        with pytest.raises(ForumNotFound):
            await other.changes(forged)


async def test_the_socket_needs_the_session_and_says_at_once_that_something_happened(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await begin(alice)
    await bob.me()
    async with asyncio.timeout(60), Push(bob._client) as push:
        await push.connected.wait()
        await push.wait(1)  # it says so once when it is there
        await alice.reply(post.topic_id, "listen", key="1")
        assert await push.wait(60)
