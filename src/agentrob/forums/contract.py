"""The contract of every forum, as tests: inherit `ForumContract`, give it a `world`, and run pytest.

    class TestMyForum(ForumContract):
        @pytest.fixture
        async def world(self): yield MyWorld(...)

A forum that has no event stream, or limits edits, says so (`live`, `max_edits`) and is held to what it says.
"""

from __future__ import annotations

import asyncio
import contextlib
from datetime import UTC, datetime, timedelta
from typing import Any, Protocol

import pytest

from agentrob.errors import ForumDenied, ForumNotFound, ForumUnoffered, ForumUnreachable
from agentrob.forums.protocol import Event, Forum, KeyedEdits, Notifications, Permissions, Registrar, Searcher
from agentrob.language.rendered_text import text_in
from agentrob.language.visible_text import OMITTED, mentions
from agentrob.model import AccountKind, EventKind, Post, Role, StatusCard

#: Ends what hangs, also on a busy machine.
LIMIT_S = 60.0
#: The smallest PNG that decoders accept: one grey pixel.
PIXEL = bytes.fromhex(
    "89504e470d0a1a0a0000000d49484452000000010000000108000000003a7e9b550000000a49444154789c636800000082008177cd72b6"
    "0000000049454e44ae426082"
)
#: Two grey pixels side by side.
SPOT = bytes.fromhex(
    "89504e470d0a1a0a0000000d4948445200000002000000010800000000d14920560000000b4944415478da6368680000018301018b9155"
    "f20000000049454e44ae426082"
)


class World(Protocol):
    """A running forum with the board `robots`, and what its moderators can do."""

    async def sign_in(self, name: str, *, kind: AccountKind = ..., role: Role = ...) -> Forum:
        """A forum signed in as this account, which is made when it is not there."""
        ...

    async def suspend(self, name: str) -> None: ...

    async def remove(self, post_id: str) -> None: ...

    async def unreachable(self) -> Forum:
        """A forum that cannot be reached."""
        ...


async def _topic(forum: Forum, body: str = "hello", key: str = "k") -> Post:
    return (await forum.create_topic("robots", "A topic", body, key=key)).post


async def _size(forum: Forum, url: str) -> tuple[int, int]:
    """Width and height of a picture, as its PNG says."""
    png = await forum.download(url)
    assert png.startswith(b"\x89PNG")
    return int.from_bytes(png[16:20]), int.from_bytes(png[20:24])


async def _collect(forum: Forum, after: str, until: int) -> list[Event]:
    """The first `until` events after `after`, heartbeats left out; fails after `LIMIT_S`."""
    found: list[Event] = []
    async with asyncio.timeout(LIMIT_S):
        async for event in forum.stream(after, 0.25):
            if event.kind is not EventKind.HEARTBEAT:
                found.append(event)
            if len(found) >= until:
                break
    return found


class ForumContract:
    """Inherit this; every method is a test."""

    async def test_a_topic_is_read_back_by_everybody_as_it_was_written(self, world: World) -> None:
        alice, bob = await world.sign_in("alice", role=Role.OPERATOR), await world.sign_in("bob")
        text = "@bob **walk** 走 1 m\n\n> quoted\n"
        written = await alice.create_topic("robots", "A title", text, key="1")
        post = await bob.post(written.post.id)
        assert written.created
        assert (post.raw.strip(), post.author.name, post.author.role) == (text.strip(), "alice", Role.OPERATOR)
        assert (post.board_id, post.version, post.removed) == ("robots", 1, False)
        assert "bob" in post.mentions
        assert abs(post.created_at - datetime.now(UTC)) < timedelta(seconds=30)
        assert (await bob.topic(post.topic_id)).title == "A title"
        assert post.topic_id in [t.id for t in (await bob.topics("robots")).items]

    async def test_boards_are_listed(self, world: World) -> None:
        assert "robots" in [b.id for b in await (await world.sign_in("alice")).boards()]

    async def test_replies_come_oldest_first_page_by_page(self, world: World) -> None:
        alice = await world.sign_in("alice")
        first = await _topic(alice)
        for n in range(4):
            await alice.reply(first.topic_id, f"reply {n}", key=f"r{n}", reply_to=first.id)
        seen: list[str] = []
        page = await alice.posts(first.topic_id, limit=2)
        seen += [p.raw.strip() for p in page.items]
        while page.next:
            page = await alice.posts(first.topic_id, page.next, limit=2)
            seen += [p.raw.strip() for p in page.items]
        assert seen == ["hello", "reply 0", "reply 1", "reply 2", "reply 3"]

    async def test_a_reply_says_what_it_replies_to(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        first = await _topic(alice)
        reply = (await bob.reply(first.topic_id, "to the first", key="1", reply_to=first.id)).post
        answer = (await alice.reply(first.topic_id, "to the reply", key="2", reply_to=reply.id)).post
        plain = (await alice.reply(first.topic_id, "to nobody", key="3")).post
        assert (reply.reply_to, answer.reply_to) == (first.id, reply.id)
        read = [await bob.post(p.id) for p in (first, reply, answer, plain)]
        assert [p.reply_to for p in read] == [None, first.id, reply.id, None]
        assert [p.reply_to for p in (await bob.posts(first.topic_id)).items] == [None, first.id, reply.id, None]

    async def test_long_threads_and_boards_are_read_whole_whatever_the_page(self, world: World) -> None:
        alice = await world.sign_in("alice")
        topics = [(await alice.create_topic("robots", f"Title {n}", "hello", key=f"t{n}")).post for n in range(3)]
        long = topics[0].topic_id
        for n in range(22):
            await alice.reply(long, f"reply {n}", key=f"r{n}")
        wanted = ["hello", *(f"reply {n}" for n in range(22))]
        for limit in (9, 20, 50):
            pages = [await alice.posts(long, limit=limit)]
            while pages[-1].next:
                pages.append(await alice.posts(long, pages[-1].next, limit=limit))
            assert [p.raw.strip() for page in pages for p in page.items] == wanted
            assert all(len(page.items) == limit for page in pages[:-1])
        listed = await alice.topics("robots", limit=2)
        ids = [t.id for t in (*listed.items, *(await alice.topics("robots", listed.next, limit=2)).items)]
        assert ids[:3] == [long, topics[2].topic_id, topics[1].topic_id]

    async def test_pictures_stand_below_the_text_in_their_order_and_stay(self, world: World) -> None:
        robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
        alice = await world.sign_in("alice")
        first = await _topic(alice)
        reply = (await robot.reply(first.topic_id, "look at *this*", key="1", images=(PIXEL, SPOT))).post
        assert reply.raw.strip() == "look at *this*"
        seen = await alice.post(reply.id)
        assert seen.images == reply.images
        assert [await _size(alice, url) for url in seen.images] == [(1, 1), (2, 1)]
        again = await robot.reply(first.topic_id, "look at *this*", key="1", images=(PIXEL, SPOT))
        assert (again.created, again.post.images) == (False, reply.images)
        if robot.max_edits == 0:
            return
        edited = await robot.edit(reply.id, "look again")
        assert (edited.raw.strip(), edited.images) == ("look again", reply.images)
        if robot.max_edits != 1:
            more = await robot.edit(reply.id, "and again", images=(PIXEL,))
            assert (more.images[:2], len(more.images)) == (reply.images, 3)

    async def test_the_same_key_twice_is_one_post_and_other_accounts_keys_are_their_own(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        first = await alice.create_topic("robots", "A title", "one", key="same")
        again = await alice.create_topic("robots", "A title", "two", key="same")
        assert (first.created, again.created) == (True, False)
        assert again.post.id == first.post.id
        reply = await alice.reply(first.post.topic_id, "three", key="reply")
        assert not (await alice.reply(first.post.topic_id, "four", key="reply")).created
        assert (await bob.reply(first.post.topic_id, "five", key="reply")).created
        found = await alice.find("reply")
        assert found is not None
        assert (found.id, found.key) == (reply.post.id, "reply")
        assert await bob.find("same") is None
        assert (await bob.post(reply.post.id)).key is None

    async def test_a_key_used_at_the_same_time_makes_one_post(self, world: World) -> None:
        alice = await world.sign_in("alice")
        first = await _topic(alice)
        replies = await asyncio.gather(*(alice.reply(first.topic_id, "once", key="race") for _ in range(5)))
        assert [r.created for r in replies].count(True) == 1
        assert len({r.post.id for r in replies}) == 1

    async def test_an_edit_replaces_the_text_and_counts_the_version(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        post = await _topic(alice)
        if alice.max_edits == 0:
            return
        edited = await alice.edit(post.id, "changed")
        assert (edited.raw.strip(), edited.version) == ("changed", 2)
        assert edited.edited_at is not None
        assert edited.content_hash != post.content_hash
        with pytest.raises(ForumDenied):
            await bob.edit(post.id, "mine now")

    async def test_edits_are_limited_to_what_the_forum_says(self, world: World) -> None:
        alice = await world.sign_in("alice")
        post = await _topic(alice)
        for n in range(alice.max_edits if alice.max_edits is not None else 6):
            await alice.edit(post.id, f"edit {n}")
        if alice.max_edits is not None:
            with pytest.raises(ForumDenied):
                await alice.edit(post.id, "one too many")

    async def test_a_status_card_and_pictures_travel_with_the_post(self, world: World) -> None:
        robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
        alice = await world.sign_in("alice")
        first = await _topic(alice)
        card = StatusCard("quadruped", "running", step=1, steps=2, doing="move", trace_id="t1")
        post = (await robot.reply(first.topic_id, "on my way", key="s", reply_to=first.id, card=card)).post
        assert post.card == card
        if robot.max_edits == 0:
            return
        done = StatusCard("quadruped", "done", step=2, steps=2, trace_id="t1")
        edited = await robot.edit(post.id, "done", images=(PIXEL,), card=done)
        assert edited.card == done
        assert len(edited.images) == 1
        assert (await alice.post(post.id)).images == edited.images
        assert (await alice.download(edited.images[0])).startswith(b"\x89PNG")

    async def test_law_1_a_card_that_names_another_robot_is_no_card(self, world: World) -> None:
        robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
        alice = await world.sign_in("alice")
        first = await _topic(alice)
        forged = StatusCard("humanoid", "done", trace_id="t1")
        try:
            reply = (await robot.reply(first.topic_id, "done", key="s", reply_to=first.id, card=forged)).post
        except ForumDenied:
            return  # the forum itself refuses it
        assert (reply.raw.strip(), reply.card) == ("done", None)
        assert (await alice.post(reply.id)).card is None

    async def test_law_3_what_counts_of_a_post_is_what_its_page_shows(self, world: World) -> None:
        """A robot is called where its name is read and linked; a mark says that something is not as it reads."""
        await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
        alice = await world.sign_in("alice")
        hidden = "`@quadruped` walk\n\n> @quadruped walk\n\n[@quadruped](https://example.org) walk"
        first = await _topic(alice, hidden)
        bodies = (
            "@quadruped walk **1** m",
            "@quadruped- walk 1 m",
            "@quad**rup**ed walk 1 m",
            "@quadruped turn left \u202e09\u202c degrees",
        )
        posts = [first]
        for n, body in enumerate(bodies):
            posts.append((await alice.reply(first.topic_id, body, key=f"r{n}", reply_to=first.id)).post)
        texts = [text_in(post) for post in posts]
        called = ["quadruped" in mentions(t) and "quadruped" in p.mentions for t, p in zip(texts, posts, strict=True)]
        assert called == [False, True, False, False, True]
        assert [OMITTED in text for text in texts] == [True, False, False, True, True]
        assert "walk 1 m" in texts[1]

    async def test_what_is_not_there_is_said_so(self, world: World) -> None:
        alice = await world.sign_in("alice")
        for missing in (alice.post("999999"), alice.topic("999999"), alice.posts("999999"), alice.topics("no-board")):
            with pytest.raises(ForumNotFound):
                await missing
        with pytest.raises(ForumNotFound):
            await alice.reply("999999", "hello?", key="1")
        assert await alice.account("nobody") is None
        assert await alice.find("never-used") is None

    async def test_accounts_are_shown_as_they_are_now(self, world: World) -> None:
        alice = await world.sign_in("alice", role=Role.OPERATOR)
        bob = await world.sign_in("bob")
        me, seen = await alice.me(), await bob.account("alice")
        assert seen is not None
        assert (me.name, me.kind, me.role, me.suspended) == ("alice", AccountKind.HUMAN, Role.OPERATOR, False)
        assert seen.id == me.id
        post = await _topic(alice)
        await world.suspend("alice")
        now = await bob.account("alice")
        assert now is not None
        assert now.suspended
        assert (await bob.post(post.id)).author.suspended
        with pytest.raises(ForumDenied):
            await alice.reply(post.topic_id, "still here?", key="2")

    async def test_a_removed_post_says_so(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        post = await _topic(alice)
        after, _ = await bob.now()
        await world.remove(post.id)
        assert (await bob.post(post.id)).removed
        (event,) = await bob.changes(after)
        assert event.kind is EventKind.POST_REMOVED
        assert event.post is not None
        assert (event.post.id, event.post.removed) == (post.id, True)

    async def test_changes_come_once_and_in_order_after_the_watermark(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        before = await _topic(alice, "before", "0")
        after, at = await bob.now()
        assert abs(at - datetime.now(UTC)) < timedelta(seconds=30)
        post = (await alice.reply(before.topic_id, "one", key="1")).post
        second = (await alice.reply(before.topic_id, "two", key="2")).post
        events = await bob.changes(after)
        assert [(e.kind, e.post and e.post.id) for e in events] == [
            (EventKind.POST_CREATED, post.id),
            (EventKind.POST_CREATED, second.id),
        ]
        assert [e.post and e.post.id for e in await bob.changes(events[0].id)] == [second.id]
        assert await bob.changes(events[-1].id) == ()
        assert len(await bob.changes(after, limit=1)) == 1

    async def test_a_watermark_of_another_forum_is_not_found(self, world: World) -> None:
        bob = await world.sign_in("bob")
        await _topic(bob)
        with pytest.raises(ForumNotFound):
            await bob.changes("999999")
        if bob.live:
            with pytest.raises(ForumNotFound):
                await _collect(bob, "999999", 1)

    async def test_the_stream_brings_new_and_edited_posts_and_resumes_after_an_id(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        if not bob.live:
            return
        post = await _topic(alice)
        after, _ = await bob.now()
        listening = asyncio.create_task(_collect(bob, after, 2))
        await alice.reply(post.topic_id, "reply", key="1")
        if alice.max_edits == 0:
            await alice.reply(post.topic_id, "another", key="2")
        else:
            await alice.edit(post.id, "edited")
        first, second = await listening
        assert first.kind is EventKind.POST_CREATED
        assert first.post is not None
        assert first.post.raw.strip() == "reply"
        assert second.kind in (EventKind.POST_EDITED, EventKind.POST_CREATED)
        assert [e.id for e in await _collect(bob, first.id, 1)] == [second.id]

    async def test_a_quiet_stream_beats(self, world: World) -> None:
        bob = await world.sign_in("bob")
        if not bob.live:
            return
        after, _ = await bob.now()
        async with asyncio.timeout(LIMIT_S):
            async for event in bob.stream(after, 0.25):
                assert event.kind is EventKind.HEARTBEAT
                assert event.id == ""
                break

    # ---------------------------------------------------------------- what not every forum has
    async def test_a_search_finds_posts_by_their_words_newest_first_or_is_said_not_to_be_offered(
        self, world: World
    ) -> None:
        alice = await world.sign_in("alice")
        first = await _topic(alice, "a purple elephant")
        second = (await alice.reply(first.topic_id, "another elephant, purple too", key="2")).post
        await alice.reply(first.topic_id, "a grey elephant", key="3")
        if not isinstance(alice, Searcher):
            return
        try:
            found = await alice.search("purple elephant", limit=1)
        except ForumUnoffered:
            return
        assert [p.id for p in found.items] == [second.id]
        rest = await alice.search("purple elephant", cursor=found.next, limit=1)
        assert [p.id for p in rest.items] == [first.id]
        if rest.next is not None:  # the forum was used before
            older = [p.id for p in (await alice.search("purple elephant", cursor=rest.next, limit=1)).items]
            assert older
            assert not {first.id, second.id} & set(older)
        assert (await alice.search("unicorn")).items == ()

    async def test_notices_name_mentions_and_replies_or_are_said_not_to_be_offered(self, world: World) -> None:
        alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
        first = await _topic(alice, "hello")
        mention = (await bob.reply(first.topic_id, "@alice look", key="1")).post
        if not isinstance(alice, Notifications):
            return
        try:
            found = await alice.notifications()
            async with asyncio.timeout(LIMIT_S):
                while mention.id not in [n.post.id for n in found.items]:
                    await asyncio.sleep(0.1)  # some forums make them a moment after the post
                    found = await alice.notifications()
        except ForumUnoffered:
            return
        assert [n.kind for n in found.items if n.post.id == mention.id] == ["mention"]
        assert isinstance(bob, Notifications)
        assert [n for n in (await bob.notifications()).items if n.post.topic_id == first.topic_id] == []

    async def test_accounts_and_rights_are_for_admins_or_are_said_not_to_be_offered(self, world: World) -> None:
        alice, admin = await world.sign_in("alice"), await world.sign_in("admin", role=Role.ADMIN)
        newcomer = getattr(world, "newcomer", "planner")  # a name that nobody has
        if isinstance(alice, Registrar) and isinstance(admin, Registrar):
            with pytest.raises((ForumDenied, ForumUnoffered)):
                await alice.register("carol")
            with contextlib.suppress(ForumUnoffered):
                made = await admin.register(newcomer, kind=AccountKind.COMMANDING_AGENT)
                assert (made.account.name, made.account.role) == (newcomer, Role.MEMBER)
                assert made.secret
        if isinstance(alice, Permissions) and isinstance(admin, Permissions):
            with pytest.raises((ForumDenied, ForumUnoffered)):
                await alice.set_rights("alice", role=Role.OPERATOR)
            with contextlib.suppress(ForumUnoffered):
                changed = await admin.set_rights("alice", role=Role.OPERATOR, suspended=True)
                assert (changed.role, changed.suspended) == (Role.OPERATOR, True)

    async def test_an_unreachable_forum_is_said_so(self, world: World) -> None:
        nowhere = await world.unreachable()
        calls: list[Any] = [nowhere.now(), nowhere.me(), nowhere.post("1"), nowhere.reply("1", "x", key="1")]
        for call in calls:
            with pytest.raises(ForumUnreachable):
                await call
        with pytest.raises(ForumUnreachable):
            async for _ in nowhere.stream("0", 0.25):
                pass
        await nowhere.close()


class KeyedEditsContract:
    """The further contract of a forum with `KeyedEdits`; needs the `world` of `ForumContract`."""

    async def test_an_edit_under_a_key_is_made_once(self, world: World) -> None:
        robot, bob = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT), await world.sign_in("bob")
        first = await _topic(bob)
        assert isinstance(robot, KeyedEdits)
        if robot.max_edits is not None:
            return
        post, other = [(await robot.reply(first.topic_id, "seen", key=key)).post for key in ("1", "2")]
        edited = await robot.edit_once(post.id, "the end", key="end", images=(PIXEL,))
        await robot.edit_once(post.id, "the end", key="end", images=(PIXEL,))
        again = await robot.post(post.id)
        assert (again.raw.strip(), again.version, again.images) == ("the end", 2, edited.images)
        assert (await robot.edit_once(post.id, "measured", key="measured")).raw.strip() == "measured"
        assert (await robot.edit_once(other.id, "the end", key="end")).version == 2  # keys are those of a post
        assert isinstance(bob, KeyedEdits)
        with pytest.raises(ForumDenied):
            await bob.edit_once(post.id, "mine now", key="end")
