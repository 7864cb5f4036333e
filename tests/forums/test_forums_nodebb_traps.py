"""What is peculiar about NodeBB, each against what a real one answered: sign-in, tokens, limits, the queue, rights."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import pytest
from nodebb_world import NodeBBWorld

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumNotFound, ForumUnreachable
from agentrob.forums.contract import PIXEL
from agentrob.forums.forum import EventKind
from agentrob.forums.nodebb import NodeBBForum
from agentrob.forums.nodebb_socket import Push
from agentrob.forums.nodebb_wire import NodeBBWire
from agentrob.model import AccountKind, Post, Role

PASSWORD = "a password of a test"


async def _topic(forum: NodeBBForum, title: str = "A topic") -> Post:
    return (await forum.create_topic("robots", title, "hello there", key="topic")).post


async def _texts(forum: NodeBBForum, topic_id: str) -> list[str]:
    return [p.raw for p in (await forum.posts(topic_id)).items]


def _replies(nodebb: NodeBBWorld, name: str, post: Post) -> int:
    """How often an account asked to write a reply in the post's topic."""
    return nodebb.server.asked.count((name, f"POST /api/v3/topics/{post.topic_id}"))


# ---------------------------------------------------------------------- signing in
async def test_programs_that_nodebb_takes_for_spiders_get_no_csrf_token(nodebb: NodeBBWorld) -> None:
    forum = nodebb.at(nodebb.url, "login:alice:whatever")
    forum._wire._http.headers["User-Agent"] = "python-requests/2.32"
    with pytest.raises(ForumError, match="spider"):
        await forum.me()


async def test_a_wrong_password_is_denied_and_not_tried_again_at_once(nodebb: NodeBBWorld) -> None:
    await nodebb.sign_in("alice")
    forum = nodebb.at(nodebb.url, "login:alice:not her password")
    for _ in range(8):
        with pytest.raises(ForumDenied, match="invalid login"):
            await forum.me()
    tried = nodebb.server.asked.count(("guest alice", "POST /login"))
    assert tried == 1, "NodeBB locks an account after five"


async def test_a_lapsed_csrf_token_is_made_anew_and_the_write_is_done_once(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    alice._wire.csrf = "lapsed"
    assert (await alice.reply(post.topic_id, "after all", key="1")).created
    assert await _texts(alice, post.topic_id) == ["hello there", "after all"]
    assert _replies(nodebb, "alice", post) == 2, "refused once for want of a token, then taken"


async def test_a_lapsed_session_is_begun_anew_when_writing_and_while_listening(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await _topic(alice)
    after, _ = await bob.now()
    alice._wire.cookie = bob._wire.cookie = "express.sid=s%3Agone.forever"
    assert (await alice.me()).name == "alice"
    alice._wire.cookie = "express.sid=s%3Agone.forever"
    assert (await alice.reply(post.topic_id, "still me", key="1")).post.author.name == "alice"
    async with asyncio.timeout(10):
        async for event in bob.stream(after, 0.25):
            if event.kind is EventKind.POST_CREATED:
                assert event.post is not None
                assert event.post.raw == "still me"
                break
    assert (await bob.me()).name == "bob"


async def test_another_identity_is_taken_on_at_run_time(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    await nodebb.sign_in("bob")
    post = await _topic(alice)
    assert (await alice.switch(nodebb.secrets["bob"])).name == "bob"
    reply = await alice.reply(post.topic_id, "bob says this", key="topic")
    assert (reply.created, reply.post.author.name) == (True, "bob"), "keys are each account's own"
    assert (await alice.post(post.id)).key is None


# ---------------------------------------------------------------------- tokens
async def test_a_bearer_token_reads_and_writes_any_number_of_times_and_keeps_no_cookies(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    for n in range(6):
        assert (await bearer.reply(post.topic_id, f"reply {n}", key=f"r{n}")).created
    assert len(await _texts(bearer, post.topic_id)) == 7
    assert (await bearer.me()).name == "alice"


async def test_a_bearer_token_uploads_no_pictures_and_says_so(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    with pytest.raises(ForumError, match="login:name:password"):
        await bearer.reply(post.topic_id, "look", key="1", images=(PIXEL,))
    assert (await bearer.reply(post.topic_id, "no picture", key="1")).created


async def test_a_bearer_token_hears_posts_by_asking(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    after, _ = await bearer.now()
    await alice.reply(post.topic_id, "do you hear me?", key="1")
    async with asyncio.timeout(10):
        async for event in bearer.stream(after, 0.25):
            if event.post is not None:
                assert event.post.raw == "do you hear me?"
                break


async def test_a_void_token_is_denied_and_does_not_listen_on_as_a_guest(nodebb: NodeBBWorld) -> None:
    bob = await nodebb.sign_in("bob")
    after, _ = await bob.now()
    bearer = nodebb.at(nodebb.url, "00000000-0000-4000-8000-000000000000")
    with pytest.raises(ForumDenied):
        await asyncio.wait_for(anext(bearer.stream(after, 0.25)), 10)


async def test_a_master_token_needs_the_number_of_an_account(nodebb: NodeBBWorld) -> None:
    await nodebb.sign_in("alice")
    token = await nodebb.token("0", nodebb.password)
    with pytest.raises(ForumDenied, match="TOKEN@UID"):
        await nodebb.at(nodebb.url, token).post("1")
    with pytest.raises(ForumDenied, match="TOKEN@UID"):
        await nodebb.at(nodebb.url, token).boards()
    assert (await nodebb.at(nodebb.url, f"{token}@{nodebb.uids['alice']}").me()).name == "alice"


# ---------------------------------------------------------------------- making accounts
async def test_a_taken_name_makes_no_second_account_of_another_name(nodebb: NodeBBWorld) -> None:
    await nodebb.sign_in("alice")
    with pytest.raises(ForumError, match="taken"):
        await nodebb.admin.add_account("alice")
    assert await nodebb.admin.account("alice-0") is None


async def test_the_public_form_makes_an_account_that_only_looks_and_stops(nodebb: NodeBBWorld) -> None:
    await nodebb.forget("newcomer")
    made = await NodeBBForum.sign_up(nodebb.settings, "newcomer", PASSWORD, "newcomer@example.org")
    me = await made.me()
    assert (me.name, me.kind, me.role) == ("newcomer", AccountKind.HUMAN, Role.MEMBER)
    with pytest.raises(ForumDenied, match="signing up was refused"):
        await NodeBBForum.sign_up(nodebb.settings, "newcomer", PASSWORD, "newcomer2@example.org")
    await made.close()


async def test_law_2_a_group_that_anybody_may_join_gives_no_rights(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice", role=Role.OPERATOR)
    assert (await alice.me()).role is Role.OPERATOR
    await nodebb.wire.send("PUT", "/groups/robot-operators", {"private": 0})
    open_to_all = (await alice.me()).role
    await nodebb.wire.send("PUT", "/groups/robot-operators", {"private": 1})
    assert open_to_all is Role.MEMBER
    assert (await alice.me()).role is Role.OPERATOR


async def test_law_2_where_private_groups_are_switched_off_no_group_gives_rights(nodebb: NodeBBWorld) -> None:
    alice, root = await nodebb.sign_in("alice", role=Role.OPERATOR), await nodebb.sign_in("root", role=Role.ADMIN)
    await nodebb.set("allowPrivateGroups", 0)
    bob = await nodebb.sign_in("bob")
    seen, admin = await bob.account("alice"), await root.me()
    await nodebb.set("allowPrivateGroups", 1)
    assert seen is not None
    assert seen.role is Role.MEMBER, "anybody could have joined robot-operators"
    assert admin.role is Role.ADMIN, "nobody joins the administrators"
    assert (await alice.me()).role is Role.OPERATOR


async def test_kinds_of_accounts_come_from_groups(nodebb: NodeBBWorld) -> None:
    for kind in (AccountKind.MONITORING_AGENT, AccountKind.COMMANDING_AGENT):
        name = f"a-{kind.value.split('_')[0]}"
        assert (await (await nodebb.sign_in(name, kind=kind)).me()).kind is kind


# ---------------------------------------------------------------------- limits
async def test_a_new_member_who_posts_again_at_once_is_told_when(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    for setting, seconds in (("newbiePostDelay", 120), ("postDelay", 10), ("initialPostDelay", 30)):
        await nodebb.set(setting, seconds)
        with pytest.raises(ForumLimited) as told:
            await alice.reply(post.topic_id, "too fast", key="1")
        assert told.value.retry_after_s == seconds
        await nodebb.set(setting, 0)
    assert (await alice.reply(post.topic_id, "in time", key="1")).created
    assert await _texts(alice, post.topic_id) == ["hello there", "in time"]


async def test_a_reply_in_the_queue_is_waited_for_and_not_written_again(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    await nodebb.set("postQueue", 1)
    for _ in range(3):
        with pytest.raises(ForumLimited, match="moderator"):
            await alice.reply(post.topic_id, "to be looked at", key="1")
    other = nodebb.at(nodebb.url, nodebb.secrets["alice"])
    with pytest.raises(ForumLimited, match="moderator"):
        await other.reply(post.topic_id, "to be looked at", key="1")
    assert _replies(nodebb, "alice", post) == 1, "written once, waited for since"
    await nodebb.set("postQueue", 0)
    waiting = (await nodebb.wire.get("/api/post-queue"))["posts"]
    ours = [q["id"] for q in waiting if str(q["data"].get("tid")) == post.topic_id]
    assert len(ours) == 1
    await nodebb.wire.send("POST", f"/posts/queue/{ours[0]}")
    accepted = await alice.reply(post.topic_id, "to be looked at", key="1")
    assert (accepted.created, accepted.post.raw) == (False, "to be looked at")
    assert await _texts(alice, post.topic_id) == ["hello there", "to be looked at"]


async def test_posts_of_one_account_go_one_after_the_other(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    written = await asyncio.gather(*(alice.reply(post.topic_id, f"at once {n}", key=f"k{n}") for n in range(4)))
    assert all(w.created for w in written), "NodeBB refuses two at a time"
    assert nodebb.server.most_at_once == 1


async def test_another_program_of_the_same_account_that_posts_just_now_is_a_wait(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    others = [nodebb.at(nodebb.url, nodebb.secrets["alice"]) for _ in range(3)]
    for other in others:
        await other.me()

    waits: list[float] = []

    async def insist(forum: NodeBBForum) -> bool:
        while True:
            try:
                return (await forum.reply(post.topic_id, "once", key="same")).created
            except ForumLimited as e:
                waits.append(e.retry_after_s)
                await asyncio.sleep(e.retry_after_s)

    created = await asyncio.gather(*(insist(forum) for forum in others))
    assert created.count(True) == 1
    assert all(wait < 1 for wait in waits)
    assert (await _texts(alice, post.topic_id)).count("once") == 1


async def test_short_words_are_long_enough(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    assert (await alice.reply(post.topic_id, "ok", key="1")).post.raw == "ok"
    with pytest.raises(ForumError, match=r"title"):
        await alice.create_topic("robots", "x" * 300, "hello there", key="2")


async def test_a_muted_or_banned_account_is_denied_and_shown_as_suspended(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await _topic(alice)
    await nodebb.wire.send("PUT", f"/users/{nodebb.uids['alice']}/mute", {"reason": "a test"})
    with pytest.raises(ForumDenied, match="muted"):
        await alice.reply(post.topic_id, "words", key="1")
    assert (await bob.post(post.id)).author.suspended


# ---------------------------------------------------------------------- once per key
async def test_a_lost_answer_costs_nothing_and_doubles_nothing(
    nodebb: NodeBBWorld, monkeypatch: pytest.MonkeyPatch
) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    send = NodeBBWire.send

    async def lost(self: NodeBBWire, method: str, path: str, body: Mapping[str, Any] | None = None) -> dict[str, Any]:
        await send(self, method, path, body)
        raise ForumUnreachable("the answer was lost")

    with monkeypatch.context() as patch:
        patch.setattr(NodeBBWire, "send", lost)
        with pytest.raises(ForumUnreachable):
            await alice.reply(post.topic_id, "once", key="1", reply_to=post.id)
    again = await nodebb.at(nodebb.url, nodebb.secrets["alice"]).reply(post.topic_id, "once", key="1", reply_to=post.id)
    assert not again.created
    assert _replies(nodebb, "alice", post) == 1
    assert await _texts(alice, post.topic_id) == ["hello there", "once"]


async def test_law_6_a_claim_is_found_by_who_has_lost_his_memory_also_when_it_was_removed(nodebb: NodeBBWorld) -> None:
    robot = await nodebb.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    key = f"claim:{post.id}"
    claim = (await robot.reply(post.topic_id, "mine", key=key, reply_to=post.id)).post
    await nodebb.remove(claim.id)
    fresh = nodebb.at(nodebb.url, nodebb.secrets["quadruped"])
    again = await fresh.reply(post.topic_id, "mine", key=key, reply_to=post.id)
    assert (again.created, again.post.id, again.post.removed) == (False, claim.id, True)


async def test_law_1_a_mark_that_somebody_copies_is_nobody_elses_key_or_card(nodebb: NodeBBWorld) -> None:
    robot = await nodebb.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice)
    status = (await robot.reply(post.topic_id, "mine", key="claim:1")).post
    raw = (await alice._wire.get_v3(f"/posts/{status.id}"))["content"]
    await alice._wire.send("POST", f"/topics/{post.topic_id}", {"content": raw})
    await alice._wire.send("POST", f"/topics/{post.topic_id}", {"content": _forged_card()})
    fresh = nodebb.at(nodebb.url, nodebb.secrets["quadruped"])
    read = (await fresh.posts(post.topic_id)).items
    assert [p.key for p in read] == [None, "claim:1", None, None]
    assert [p.card for p in read] == [None, None, None, None]


def _forged_card() -> str:
    from agentrob.forums.nodebb_marks import Marked, mark
    from agentrob.model import StatusCard

    return mark(Marked("believe me", "claim:1", StatusCard("quadruped", "done")))


# ---------------------------------------------------------------------- reading
async def test_names_and_titles_are_not_shown_in_html(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await _topic(alice, "Tom & Jerry's <walk>")
    assert (await alice.topic(post.topic_id)).title == "Tom & Jerry's <walk>"
    assert "Tom & Jerry's <walk>" in [t.title for t in (await alice.topics("robots")).items]
    assert "Comments & Feedback" in [b.name for b in await alice.boards()]


async def test_mentions_are_accounts_outside_of_code_and_quotes_and_are_noticed(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    await nodebb.sign_in("quadruped")
    text = "@bob look, @nobody-at-all\n\n> @quadruped said\n\n`@quadruped` code"
    post = (await alice.create_topic("robots", "A topic", text, key="1")).post
    assert post.mentions == ("bob",)
    async with asyncio.timeout(10):
        while post.id not in [p.id for p in await bob.mentions()]:  # noqa: ASYNC110 - it has no event of its own
            await asyncio.sleep(0.2)


async def test_words_are_found_by_the_search_plugin(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = (await alice.create_topic("robots", "A topic", "the zebrafinch sings", key="1")).post
    found = await alice.search("zebrafinch", board_id="robots")
    assert post.id in [p.id for p in found.items]
    assert all("zebrafinch" in p.raw for p in found.items)


async def test_a_person_who_left_commands_nothing_any_more(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice", role=Role.OPERATOR), await nodebb.sign_in("bob")
    post = await _topic(alice)
    await nodebb.forget("alice")
    author = (await bob.post(post.id)).author
    assert (author.role, author.suspended) == (Role.MEMBER, True)
    assert await bob.account("alice") is None


# ---------------------------------------------------------------------- events
async def test_a_restart_hears_what_was_written_and_edited_meanwhile(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    first = await _topic(alice)
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
    post = await _topic(bob)
    after, _ = await bob.now()
    pid, written_ms, *rest = after.split(".")
    assert pid == post.id
    other = nodebb.at(nodebb.url, nodebb.secrets["bob"])
    for forged in (".".join((pid, str(int(written_ms) - 1000), *rest)), ".".join(("999999", written_ms, *rest)), "x"):
        with pytest.raises(ForumNotFound):
            await other.changes(forged)


async def test_the_socket_needs_the_session_and_says_at_once_that_something_happened(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await _topic(alice)
    await bob.me()
    async with asyncio.timeout(10), Push(bob._wire) as push:
        await push.connected.wait()
        await push.wait(1)  # it says so once when it is there
        await alice.reply(post.topic_id, "listen", key="1")
        assert await push.wait(5)
