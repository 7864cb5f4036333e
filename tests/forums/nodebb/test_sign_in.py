"""Signing in to NodeBB, against recordings of a real one: sessions, tokens, new accounts, and rights by groups."""

from __future__ import annotations

import asyncio

import pytest

from agentrob.errors import ForumDenied, ForumError
from agentrob.forums.contract import PIXEL
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.model import AccountKind, EventKind, Role
from tests.forums.nodebb.nodebb_world import PASSWORD, NodeBBWorld, begin, replies, texts


# ---------------------------------------------------------------------- signing in
async def test_programs_that_nodebb_takes_for_spiders_get_no_csrf_token(nodebb: NodeBBWorld) -> None:
    forum = nodebb.at(nodebb.url, "login:alice:whatever")
    forum._client._http.headers["User-Agent"] = "python-requests/2.32"
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
    post = await begin(alice)
    alice._client.csrf = "lapsed"
    assert (await alice.reply(post.topic_id, "after all", key="1")).created
    assert await texts(alice, post.topic_id) == ["hello there", "after all"]
    assert replies(nodebb, "alice", post) == 2, "refused once for want of a token, then taken"


async def test_a_lapsed_session_is_begun_anew_when_writing_and_while_listening(nodebb: NodeBBWorld) -> None:
    alice, bob = await nodebb.sign_in("alice"), await nodebb.sign_in("bob")
    post = await begin(alice)
    after, _ = await bob.now()
    alice._client.cookie = bob._client.cookie = "express.sid=s%3Agone.forever"
    assert (await alice.me()).name == "alice"
    alice._client.cookie = "express.sid=s%3Agone.forever"
    assert (await alice.reply(post.topic_id, "still me", key="1")).post.author.name == "alice"
    async with asyncio.timeout(60):
        async for event in bob.stream(after, 0.25):
            if event.kind is EventKind.POST_CREATED:
                assert event.post is not None
                assert event.post.raw == "still me"
                break
    assert (await bob.me()).name == "bob"


async def test_another_identity_is_taken_on_at_run_time(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    await nodebb.sign_in("bob")
    post = await begin(alice)
    assert (await alice.switch(nodebb.secrets["bob"])).name == "bob"
    reply = await alice.reply(post.topic_id, "bob says this", key="topic")
    assert (reply.created, reply.post.author.name) == (True, "bob"), "keys are each account's own"
    assert (await alice.post(post.id)).key is None


# ---------------------------------------------------------------------- tokens
async def test_a_bearer_token_reads_and_writes_any_number_of_times_and_keeps_no_cookies(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    for n in range(6):
        assert (await bearer.reply(post.topic_id, f"reply {n}", key=f"r{n}")).created
    assert len(await texts(bearer, post.topic_id)) == 7
    assert (await bearer.me()).name == "alice"


async def test_a_bearer_token_uploads_no_pictures_and_says_so(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    with pytest.raises(ForumError, match="login:name:password"):
        await bearer.reply(post.topic_id, "look", key="1", images=(PIXEL,))
    assert (await bearer.reply(post.topic_id, "no picture", key="1")).created


async def test_a_bearer_token_hears_posts_by_asking(nodebb: NodeBBWorld) -> None:
    alice = await nodebb.sign_in("alice")
    post = await begin(alice)
    bearer = nodebb.at(nodebb.url, await nodebb.token(nodebb.uids["alice"]))
    after, _ = await bearer.now()
    await alice.reply(post.topic_id, "do you hear me?", key="1")
    async with asyncio.timeout(60):
        async for event in bearer.stream(after, 0.25):
            if event.post is not None:
                assert event.post.raw == "do you hear me?"
                break


async def test_a_void_token_is_denied_and_does_not_listen_on_as_a_guest(nodebb: NodeBBWorld) -> None:
    bob = await nodebb.sign_in("bob")
    after, _ = await bob.now()
    bearer = nodebb.at(nodebb.url, "00000000-0000-4000-8000-000000000000")
    with pytest.raises(ForumDenied):
        await asyncio.wait_for(anext(bearer.stream(after, 0.25)), 60)


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
    await nodebb.client.send("PUT", "/groups/robot-operators", {"private": 0})
    open_to_all = (await alice.me()).role
    await nodebb.client.send("PUT", "/groups/robot-operators", {"private": 1})
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
