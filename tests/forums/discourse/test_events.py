"""Events of a Discourse arrive once and in order, read from its lists of posts, also across restarts."""

from __future__ import annotations

from datetime import timedelta

import pytest

from agentrob.errors import ForumLimited, ForumNotFound
from agentrob.forums.discourse.forum import DiscourseForum
from tests.forums.discourse.discourse_world import (
    CREATED,
    EDITED,
    REMOVED,
    DiscourseWorld,
    Double,
    first,
    kinds_and_posts,
    write,
)


# ---------------------------------------------------------------- lists
async def test_more_posts_than_a_page_are_all_delivered(robot: DiscourseForum, double: Double, topic: int) -> None:
    after, _ = await robot.now()
    ids = [write(double.site, topic_id=topic, raw=f"post number {n}").id for n in range(130)]
    heard: list[str] = []
    while events := await robot.changes(after, 40):
        heard += [e.post.id for e in events if e.post]
        after = events[-1].id
    assert heard == [str(n) for n in ids]


async def test_a_post_that_appears_below_the_newest_is_delivered(
    robot: DiscourseForum, double: Double, topic: int
) -> None:
    """Ids are assigned in order, but posts that are written at the same time may appear out of order."""
    after, _ = await robot.now()
    reserved = double.site.reserve()
    later = write(double.site, topic_id=topic, raw="written first")
    events = await robot.changes(after)
    assert kinds_and_posts(events) == [(CREATED, str(later.id))]
    write(double.site, reserved, topic_id=topic, raw="@quadruped stop")
    assert kinds_and_posts(await robot.changes(events[-1].id)) == [(CREATED, str(reserved))]


async def test_an_edit_within_the_grace_period_is_delivered(robot: DiscourseForum, double: Double, topic: int) -> None:
    post = write(double.site, topic_id=topic, raw="@quadruped walk")
    after, _ = await robot.now()
    double.site.revise(double.site.users[1], post, "@quadruped stop")
    assert post.version == 1
    (event,) = await robot.changes(after)
    assert (event.kind, event.post and event.post.raw) == (EDITED, "@quadruped stop")
    assert event.post is not None
    assert event.post.version == 2
    assert await robot.changes(event.id) == ()


async def test_events_found_together_are_delivered_in_order(robot: DiscourseForum, double: Double, topic: int) -> None:
    """A reply comes before an edit of an older post, although the ids suggest the opposite order."""
    old = double.site.posts[1]
    after, _ = await robot.now()
    reply = write(double.site, topic_id=topic, raw="a reply to it")
    double.site.revise(double.site.users[1], old, "changed afterwards")
    old.updated_at = reply.created_at + timedelta(milliseconds=5)
    assert kinds_and_posts(await robot.changes(after)) == [(CREATED, str(reply.id)), (EDITED, str(old.id))]


async def test_a_restored_post_is_an_edit_not_a_new_post(robot: DiscourseForum, double: Double, topic: int) -> None:
    post = write(double.site, topic_id=topic, raw="@quadruped walk")
    after, _ = await robot.now()
    post.hidden = True
    (gone,) = await robot.changes(after)
    post.hidden = False
    (back,) = await robot.changes(gone.id)
    assert (gone.kind, back.kind) == (REMOVED, EDITED)


async def test_a_deleted_topic_removes_its_posts(robot: DiscourseForum, double: Double, topic: int) -> None:
    reply = write(double.site, topic_id=topic, raw="a reply to it")
    after, _ = await robot.now()
    double.site.delete(double.site.users[1], double.site.posts[double.site.topics[topic].posts[0]])
    assert sorted(kinds_and_posts(await robot.changes(after))) == [(REMOVED, "1"), (REMOVED, str(reply.id))]


async def test_posts_that_could_not_be_read_are_delivered_later(
    robot: DiscourseForum, double: Double, topic: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The author of the second of three posts cannot be loaded at first; no post is lost or delivered twice."""
    after, _ = await robot.now()
    users = [double.site.add_user(f"writer{n}") for n in range(3)]
    ids = [double.site.write(u, {"topic_id": topic, "raw": "some words here"}).id for u in users]
    ask, limited = robot.account, [True]

    async def account(name: str) -> object:
        if name == "writer1" and limited.pop() if limited else False:
            raise ForumLimited("too fast", 1.0)
        return await ask(name)

    monkeypatch.setattr(robot, "account", account)
    with pytest.raises(ForumLimited):
        await robot.changes(after)
    assert kinds_and_posts(await robot.changes(after)) == [(CREATED, str(n)) for n in ids]


# ---------------------------------------------------------------- after a restart
async def test_another_process_resumes_after_an_event(world: DiscourseWorld, double: Double, topic: int) -> None:
    before = await world.sign_in("quadruped")
    after, _ = await before.now()
    old = write(double.site, topic_id=topic, raw="heard before")
    (event,) = await before.changes(after)
    new = [write(double.site, topic_id=topic, raw=f"while it was away {n}") for n in range(3)]
    double.site.revise(double.site.users[1], old, "changed meanwhile")
    old.updated_at += timedelta(seconds=5)
    again = await world.sign_in("quadruped")
    events, cursor = [], event.id
    while found := await again.changes(cursor, 2):
        events += kinds_and_posts(found)
        cursor = found[-1].id
    assert events == [*((CREATED, str(p.id)) for p in new), (EDITED, str(old.id))]
    more = write(double.site, topic_id=topic, raw="and now")
    assert kinds_and_posts(await again.changes(cursor)) == [(CREATED, str(more.id))]


async def test_another_process_resumes_although_the_newest_post_is_gone(
    world: DiscourseWorld, double: Double, topic: int
) -> None:
    posts = [write(double.site, topic_id=topic, raw=f"some words {n}") for n in range(6)]
    after, _ = await (await world.sign_in("quadruped")).now()
    double.site.delete(double.site.users[1], posts[-1])
    assert await (await world.sign_in("quadruped")).changes(after) == ()


@pytest.mark.parametrize("posts", [0, 30])
async def test_law_6_a_restored_forum_does_not_know_the_event(
    posts: int, world: DiscourseWorld, double: Double, topic: int
) -> None:
    """The restored forum has fewer posts than before, or other posts under the same ids."""
    for n in range(8):
        write(double.site, topic_id=topic, raw=f"before {n}")
    after, _ = await (await world.sign_in("quadruped")).now()
    double.site.posts.clear()
    double.site.topics.clear()
    double.site._post_ids = 0
    old = write(double.site, title="A topic", category=2, raw="the first post")
    old.created_at -= timedelta(days=1)
    for n in range(posts):
        write(double.site, topic_id=old.topic, raw=f"after {n}").created_at += timedelta(seconds=n)
    forum = await world.sign_in("quadruped")
    with pytest.raises(ForumNotFound):
        await forum.changes(after)
    with pytest.raises(ForumNotFound):
        await first(forum.stream(after), CREATED)


@pytest.mark.parametrize("cursor", ["", "0", "1-2-3", "1-2-3-4-5-x", "9" * 40, "1-1-1-1-1-1"])
async def test_an_invalid_watermark_is_not_found(cursor: str, robot: DiscourseForum, topic: int) -> None:
    with pytest.raises(ForumNotFound):
        await robot.changes(cursor)


async def test_the_forums_clock_is_read_from_its_responses(robot: DiscourseForum, topic: int) -> None:
    _, at = await robot.now()
    said, _ = robot._client.clock_at or (None, 0.0)
    assert said is not None
    assert said.microsecond == 0
    assert timedelta() <= at - said < timedelta(seconds=5)
