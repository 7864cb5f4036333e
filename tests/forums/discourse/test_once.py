"""Writes to a Discourse happen once, within its limits, its review queue and its minimum lengths."""

from __future__ import annotations

import asyncio

import pytest

from agentrob.errors import ForumDenied, ForumError, ForumLimited, ForumUnreachable
from agentrob.forums.discourse.markers import MarkedText, mark, unmark
from tests.doubles.discourse.site import DEFAULTS, Refusal
from tests.forums.discourse.discourse_world import DiscourseWorld, Double, begin, texts


# ---------------------------------------------------------------- one post per key
async def test_law_6_a_reply_whose_response_was_lost_is_found_and_not_written_again(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    double.lose["POST", "/posts.json"] = 1
    with pytest.raises(ForumUnreachable):
        await alice.reply(topic, "once", key="k")
    again = await alice.reply(topic, "once", key="k")
    assert not again.created
    assert (await texts(alice, topic)).count("once") == 1


async def test_law_6_another_process_of_the_same_account_finds_the_reply(world: DiscourseWorld) -> None:
    first, second = await world.sign_in("alice"), await world.sign_in("alice")
    topic = await begin(first)
    written = await first.reply(topic, "one", key="k", card=None)
    found = await second.reply(topic, "two", key="k")
    assert (found.created, found.post.id, found.post.key) == (False, written.post.id, "k")
    again = await second.create_topic("robots", "Another", "hello again", key="begin")
    assert (again.created, again.post.topic_id) == (False, topic)


async def test_law_6_concurrent_writes_of_two_processes_leave_one_post(world: DiscourseWorld, double: Double) -> None:
    forums = [await world.sign_in("alice") for _ in range(3)]
    topic = await begin(forums[0])
    written = await asyncio.gather(*(f.reply(topic, f"by {n}", key="race") for n, f in enumerate(forums)))
    assert len({w.post.id for w in written}) == 1
    assert [w.created for w in written].count(True) == 1
    marked = [p for p in double.site.posts.values() if unmark(p.raw).key == "race"]
    assert len(marked) == 1


async def test_a_topic_whose_response_was_lost_is_found_by_its_external_id(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    double.lose["POST", "/posts.json"] = 1
    with pytest.raises(ForumUnreachable):
        await begin(alice)
    again = await alice.create_topic("robots", "A topic", "hello there", key="begin")
    assert not again.created
    assert len(double.site.topics) == 1


async def test_without_an_admins_key_a_topic_is_found_by_its_mark(world: DiscourseWorld, double: Double) -> None:
    """Discourse accepts an `external_id` from admins' keys only, and ignores it otherwise."""
    await world.sign_in("alice")
    user = double.site.named("alice")
    assert user is not None
    double.site.user_keys["secret"] = user.id
    mine, other = world.at(world.url, "user-api-key:secret"), world.at(world.url, "user-api-key:secret")
    topic = await begin(mine)
    assert double.site.topics[int(topic)].external_id is None
    assert (await mine.me()).name == "alice"
    again = await other.create_topic("robots", "A topic", "hello there", key="begin")
    assert (again.created, again.post.topic_id) == (False, topic)


async def test_two_replies_with_the_same_text_are_two_posts(world: DiscourseWorld, double: Double) -> None:
    """Discourse answers the same content from an API key with the same post for 120 s, and refuses what is too
    similar for five minutes."""
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    first = await robot.reply(topic, "Done.", key="1")
    second = await robot.reply(topic, "Done.", key="2")
    assert (second.created, second.post.id != first.post.id) == (True, True)
    assert (await texts(robot, topic))[1:] == ["Done.", "Done."]
    raw = next(p.raw for p in double.site.posts.values() if str(p.id) == first.post.id)
    content = {"raw": raw, "topic_id": int(topic)}
    with pytest.raises(ForumError, match="too similar"):  # without marks Discourse would do so
        await robot._client.ask("POST", "/posts.json", json={**content, "reply_to_post_number": 1})


async def test_a_post_refused_as_its_own_duplicate_is_found(world: DiscourseWorld, double: Double) -> None:
    """The post exists but is not listed yet; the error "too similar" triggers another look-up."""
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    post = double.site.write(double.site.users[2], {"topic_id": topic, "raw": mark(MarkedText("late", "k"))})
    double.site.topics[int(topic)].posts.remove(post.id)
    check = double.site._check

    def refuse(*_: object) -> None:
        double.site.topics[int(topic)].posts.append(post.id)
        double.site._check = check  # type: ignore[method-assign]
        raise Refusal(422, "Body is too similar to what you recently posted")

    double.site._check = refuse  # type: ignore[method-assign]
    found = await robot.reply(topic, "late", key="k")
    assert (found.created, found.post.id) == (False, str(post.id))


# ---------------------------------------------------------------- limits
async def test_a_second_reply_within_five_seconds_is_limited_and_then_written_once(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    double.site.settings["rate_limit_create_post"] = DEFAULTS["rate_limit_create_post"]
    await alice.reply(topic, "one", key="1")
    with pytest.raises(ForumLimited) as limited:
        await alice.reply(topic, "two", key="2")
    assert 3 < limited.value.retry_after_s <= 5
    asked = double.count("POST", "/posts.json")
    with pytest.raises(ForumLimited):  # no request is sent before the time is over
        await alice.reply(topic, "two", key="2")
    assert double.count("POST", "/posts.json") == asked
    assert (await alice.topic(topic)).id == topic  # reading continues
    alice._client._held.clear()
    double.site._times.clear()
    assert (await alice.reply(topic, "two", key="2")).created
    assert (await texts(alice, topic))[1:] == ["one", "two"]


async def test_a_second_topic_within_fifteen_seconds_is_limited_and_then_written_once(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    double.site.settings["rate_limit_create_topic"] = DEFAULTS["rate_limit_create_topic"]
    await begin(alice, "1")
    for _ in range(2):
        with pytest.raises(ForumLimited) as limited:
            await begin(alice, "2")
        assert 13 < limited.value.retry_after_s <= 15
    alice._client._held.clear()
    double.site._times.clear()
    assert await begin(alice, "2") == await begin(alice, "2")
    assert len(double.site.topics) == 2


@pytest.mark.parametrize(
    ("setting", "count", "token"),
    [
        ("max_reqs_per_ip_per_10_seconds", 3, "alice:{key}"),  # answered in plain text
        ("max_admin_api_reqs_per_minute", 3, "alice:{key}"),
        ("max_user_api_reqs_per_minute", 3, "user-api-key:secret"),
    ],
)
async def test_the_limits_of_address_and_key_are_waited_for(
    setting: str, count: int, token: str, world: DiscourseWorld, double: Double
) -> None:
    await world.sign_in("alice")
    double.site.user_keys["secret"] = 2
    double.site._times.clear()
    double.site.settings[setting] = count
    forum = world.at(world.url, token.format(key=double.site.add_key()))
    for _ in range(count):
        await forum.boards()
    with pytest.raises(ForumLimited) as limited:
        await forum.boards()
    assert 1 <= limited.value.retry_after_s <= 60
    asked = len(double.requests)
    with pytest.raises(ForumLimited):
        await forum.reply("1", "hello", key="1")
    assert len(double.requests) == asked


async def test_the_daily_limit_of_edits_is_an_error_and_not_a_wait(world: DiscourseWorld, double: Double) -> None:
    """The report is posted as a reply instead of waiting until tomorrow."""
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    post = (await robot.reply(topic, "running", key="1")).post
    double.site.settings["max_edits_per_day"] = 1
    await robot.edit(post.id, "still running")
    with pytest.raises(ForumDenied, match="no more edits"):
        await robot.edit(post.id, "done")
    assert (await robot.reply(topic, "done", key="2")).created


async def test_slow_mode_is_waited_for(world: DiscourseWorld, double: Double) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    double.site.topics[int(topic)].slow_mode_seconds = 300
    with pytest.raises(ForumLimited, match="slow mode") as limited:
        await alice.reply(topic, "two", key="2")
    assert limited.value.retry_after_s == 300


async def test_short_texts_pass_the_minimum_length_because_the_mark_counts(
    world: DiscourseWorld, double: Double
) -> None:
    for name in ("min_post_length", "min_first_post_length"):
        double.site.settings[name] = DEFAULTS[name]
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    post = (await robot.reply(topic, "OK.", key="1")).post
    assert (await robot.post(post.id)).raw == "OK."
    assert (await robot.edit(post.id, "No.")).raw == "No."
    with pytest.raises(ForumError, match="Body is too short"):  # a comment would not
        await robot._client.ask("POST", "/posts.json", json={"raw": f"OK. <!-- {'x' * 40} -->", "topic_id": int(topic)})


async def test_a_title_that_is_too_short_is_reported(world: DiscourseWorld, double: Double) -> None:
    double.site.settings["min_topic_title_length"] = DEFAULTS["min_topic_title_length"]
    alice = await world.sign_in("alice")
    with pytest.raises(ForumError, match=r"Title is too short \(minimum is 15 characters\)"):
        await begin(alice)
    assert not double.site.topics


# ---------------------------------------------------------------- the review queue
async def test_a_queued_reply_is_awaited_and_never_sent_twice(world: DiscourseWorld, double: Double) -> None:
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    double.site.settings["approve_post_count"] = 100
    for forum in (robot, robot, await world.sign_in("quadruped")):  # the same process, and a new one
        with pytest.raises(ForumLimited, match="approval"):
            await forum.reply(topic, "in a moment", key="k")
    assert len(double.site.waiting) == 1
    await world.client.ask("PUT", "/review/1/perform/approve_post.json", json={})
    found = await robot.reply(topic, "in a moment", key="k")
    assert (found.created, found.post.raw) == (False, "in a moment")
    assert (await texts(robot, topic)).count("in a moment") == 1


async def test_a_rejected_reply_is_not_sent_again(world: DiscourseWorld, double: Double) -> None:
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    double.site.settings["approve_post_count"] = 100
    with pytest.raises(ForumLimited):
        await robot.reply(topic, "in a moment", key="k")
    await world.client.ask("PUT", "/review/1/perform/reject_post.json", json={})
    with pytest.raises(ForumDenied, match="did not approve"):
        await robot.reply(topic, "in a moment", key="k")
    assert not double.site.waiting
