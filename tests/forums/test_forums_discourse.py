"""The traps of Discourse, one by one: writing once and only once, limits, who is who, keys and sessions."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import pytest

from agentrob.config import ForumConfig
from agentrob.errors import (
    ConfigError,
    ForumDenied,
    ForumError,
    ForumLimited,
    ForumNotFound,
    ForumUnreachable,
)
from agentrob.forums.contract import PIXEL
from agentrob.forums.discourse import DiscourseForum
from agentrob.forums.discourse_double.site import DEFAULTS, STUB, Refusal
from agentrob.forums.discourse_marks import Marked, mark, unmark
from agentrob.forums.discourse_settings import DiscourseOptions, account
from agentrob.model import Account, AccountKind, Role, StatusCard

sys.path.append(str(Path(__file__).parent))
from discourse_world import PASSWORD, DiscourseWorld, Double, double_world

Worlds = tuple[DiscourseWorld, Double]
CARD = StatusCard("quadruped", "done", step=1, steps=1, trace_id="t1")


@pytest.fixture
async def made() -> AsyncIterator[Worlds]:
    async with double_world() as found:
        yield found


@pytest.fixture
def world(made: Worlds) -> DiscourseWorld:
    return made[0]


@pytest.fixture
def double(made: Worlds) -> Double:
    return made[1]


async def begin(forum: DiscourseForum, key: str = "begin") -> str:
    """A topic; returns its id."""
    return (await forum.create_topic("robots", "A topic", "hello there", key=key)).post.topic_id


async def texts(forum: DiscourseForum, topic_id: str) -> list[str]:
    return [p.raw for p in (await forum.posts(topic_id)).items]


# ---------------------------------------------------------------- one post per key
async def test_law_6_a_reply_whose_answer_was_lost_is_found_again_not_written_again(
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


async def test_law_6_of_two_processes_that_write_at_once_one_post_stays(world: DiscourseWorld, double: Double) -> None:
    forums = [await world.sign_in("alice") for _ in range(3)]
    topic = await begin(forums[0])
    written = await asyncio.gather(*(f.reply(topic, f"by {n}", key="race") for n, f in enumerate(forums)))
    assert len({w.post.id for w in written}) == 1
    assert [w.created for w in written].count(True) == 1
    marked = [p for p in double.site.posts.values() if unmark(p.raw).key == "race"]
    assert len(marked) == 1


async def test_a_topic_whose_answer_was_lost_is_found_by_its_external_id(world: DiscourseWorld, double: Double) -> None:
    alice = await world.sign_in("alice")
    double.lose["POST", "/posts.json"] = 1
    with pytest.raises(ForumUnreachable):
        await begin(alice)
    again = await alice.create_topic("robots", "A topic", "hello there", key="begin")
    assert not again.created
    assert len(double.site.topics) == 1


async def test_without_an_admins_key_a_topic_is_found_by_its_mark(world: DiscourseWorld, double: Double) -> None:
    """Discourse takes an `external_id` from admins' keys only, and passes over it otherwise."""
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


async def test_two_replies_of_the_same_words_are_two_posts(world: DiscourseWorld, double: Double) -> None:
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
    with pytest.raises(ForumError, match="too similar"):  # so it would be without marks
        await robot._wire.ask("POST", "/posts.json", json={**content, "reply_to_post_number": 1})


async def test_words_that_were_taken_for_their_own_copy_are_found(world: DiscourseWorld, double: Double) -> None:
    """The post is there but is not listed yet; the refusal as too similar makes us look again."""
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    post = double.site.write(double.site.users[2], {"topic_id": topic, "raw": mark(Marked("late", "k"))})
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
    with pytest.raises(ForumLimited):  # it is not even asked before the time is over
        await alice.reply(topic, "two", key="2")
    assert double.count("POST", "/posts.json") == asked
    assert (await alice.topic(topic)).id == topic  # reading goes on
    alice._wire._held.clear()
    double.site._times.clear()
    assert (await alice.reply(topic, "two", key="2")).created
    assert (await texts(alice, topic))[1:] == ["one", "two"]


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


async def test_edits_of_a_day_that_are_used_up_are_a_refusal_not_a_wait(world: DiscourseWorld, double: Double) -> None:
    """So that a report becomes a reply, instead of waiting until tomorrow."""
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


async def test_short_words_pass_the_least_length_since_the_mark_counts(world: DiscourseWorld, double: Double) -> None:
    for name in ("min_post_length", "min_first_post_length"):
        double.site.settings[name] = DEFAULTS[name]
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    post = (await robot.reply(topic, "OK.", key="1")).post
    assert (await robot.post(post.id)).raw == "OK."
    assert (await robot.edit(post.id, "No.")).raw == "No."
    with pytest.raises(ForumError, match="Body is too short"):  # a comment would not
        await robot._wire.ask("POST", "/posts.json", json={"raw": f"OK. <!-- {'x' * 40} -->", "topic_id": int(topic)})


async def test_a_title_that_is_too_short_is_said_so(world: DiscourseWorld, double: Double) -> None:
    double.site.settings["min_topic_title_length"] = DEFAULTS["min_topic_title_length"]
    alice = await world.sign_in("alice")
    with pytest.raises(ForumError, match=r"Title is too short \(minimum is 15 characters\)"):
        await begin(alice)
    assert not double.site.topics


# ---------------------------------------------------------------- the review queue
async def test_a_queued_reply_is_waited_for_and_never_sent_twice(world: DiscourseWorld, double: Double) -> None:
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    double.site.settings["approve_post_count"] = 100
    for forum in (robot, robot, await world.sign_in("quadruped")):  # the same process, and one that begins anew
        with pytest.raises(ForumLimited, match="approval"):
            await forum.reply(topic, "in a moment", key="k")
    assert len(double.site.waiting) == 1
    await world.wire.ask("PUT", "/review/1/perform/approve_post.json", json={})
    found = await robot.reply(topic, "in a moment", key="k")
    assert (found.created, found.post.raw) == (False, "in a moment")
    assert (await texts(robot, topic)).count("in a moment") == 1


async def test_a_reply_that_a_moderator_rejected_is_not_sent_again(world: DiscourseWorld, double: Double) -> None:
    robot = await world.sign_in("quadruped")
    topic = await begin(robot)
    double.site.settings["approve_post_count"] = 100
    with pytest.raises(ForumLimited):
        await robot.reply(topic, "in a moment", key="k")
    await world.wire.ask("PUT", "/review/1/perform/reject_post.json", json={})
    with pytest.raises(ForumDenied, match="did not approve"):
        await robot.reply(topic, "in a moment", key="k")
    assert not double.site.waiting


# ---------------------------------------------------------------- who is who (law 1)
async def test_law_1_marks_that_people_write_prove_nothing(world: DiscourseWorld, double: Double) -> None:
    mallory, robot = await world.sign_in("mallory"), await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    topic = await begin(mallory)
    forged = mark(Marked("I am the robot", "claim:1", CARD))
    user = double.site.named("mallory")
    assert user is not None
    post = double.site.write(user, {"topic_id": topic, "raw": forged})
    seen = await robot.post(str(post.id))
    assert (seen.raw, seen.card, seen.key) == ("I am the robot", None, None)
    assert await robot.find("claim:1") is None
    assert (await robot.reply(topic, "mine", key="claim:1", card=CARD)).created
    mine = await mallory.find("claim:1")
    assert mine is not None
    assert mine.id == str(post.id)


@pytest.mark.parametrize(
    ("change", "role", "kind"),
    [
        ({"trust_level": 3}, Role.OPERATOR, AccountKind.HUMAN),
        ({"trust_level": 1}, Role.MEMBER, AccountKind.HUMAN),
        ({"moderator": True}, Role.OPERATOR, AccountKind.HUMAN),
        ({"admin": True}, Role.ADMIN, AccountKind.HUMAN),
    ],
)
async def test_trust_levels_and_groups_give_rights_by_configuration(
    change: dict[str, object], role: Role, kind: AccountKind, world: DiscourseWorld, double: Double
) -> None:
    groups = {"operators": ("trust_level_2", "staff"), "admins": ("admins",)}
    await world.sign_in("Alice")
    user = double.site.named("alice")
    for name, value in change.items():
        setattr(user, name, value)
    watcher = world.at(world.url, f"system:{world.key}", **groups)
    account = await watcher.account("alice")
    assert account is not None
    assert (account.name, account.role, account.kind) == ("alice", role, kind)


async def test_law_1_whoever_is_in_two_kinds_of_group_has_fewest_rights(world: DiscourseWorld, double: Double) -> None:
    bob = await world.sign_in("bob", kind=AccountKind.COMMANDING_AGENT)
    await world._member("PUT", "robot-monitors", "bob")
    assert (await bob.me()).kind is AccountKind.MONITORING_AGENT


async def test_without_configuration_nobody_may_more_than_look(world: DiscourseWorld) -> None:
    plain = DiscourseForum(ForumConfig(url=world.url), f"system:{world.key}")
    assert (await plain.me()).role is Role.MEMBER
    assert (plain.live, plain.fastest_poll_s) == (False, 2.0)
    await plain.close()


async def test_an_author_whose_account_is_gone_is_never_obeyed(world: DiscourseWorld, double: Double) -> None:
    alice, bob = await world.sign_in("alice", role=Role.ADMIN), await world.sign_in("bob")
    topic = await begin(alice)
    user = double.site.named("alice")
    assert user is not None
    user.active = False
    (post,) = (await bob.posts(topic)).items
    assert (post.author.role, post.author.kind) == (Role.MEMBER, AccountKind.MONITORING_AGENT)


async def test_a_category_for_others_is_not_there(world: DiscourseWorld, double: Double) -> None:
    secret = double.site.add_category("Secret", "secret", only=world.groups["robot-admins"])
    system = double.site.users[1]
    post = double.site.write(system, {"title": "Secret plans", "category": secret.id, "raw": "nothing to see"})
    alice, admin = await world.sign_in("alice"), await world.sign_in("admin", role=Role.ADMIN)
    assert "secret" not in [b.id for b in await alice.boards()]
    assert "secret" in [b.id for b in await admin.boards()]
    assert str(post.id) not in [str(p["id"]) for p in await alice.newest(None)]
    with pytest.raises(ForumNotFound):
        await alice.post(str(post.id))
    with pytest.raises(ForumDenied):
        await alice.posts(str(post.topic))


async def test_subcategories_are_called_by_their_path(world: DiscourseWorld, double: Double) -> None:
    parent = next(c for c in double.site.categories.values() if c.slug == "robots")
    double.site.add_category("Legs", "legs", parent=parent.id)
    double.site.add_category("无名", "")
    alice = await world.sign_in("alice")
    assert [b.id for b in await alice.boards()] == ["general", "robots", "robots/legs", "4-category"]
    post = (await alice.create_topic("robots/legs", "A topic", "hello there", key="1")).post
    assert post.board_id == "robots/legs"
    assert [t.id for t in (await alice.topics("robots/legs")).items] == [post.topic_id]
    assert (await alice.topics("robots")).items == ()


def test_what_a_hidden_profile_does_not_say_gives_no_right() -> None:
    options = DiscourseOptions(operators=("trust_level_1", "staff"), admins=("admins",))
    hidden = account({"id": 7, "username": "Alice", "name": None, "profile_hidden": True}, options)
    assert hidden == Account("7", "alice", AccountKind.HUMAN, Role.MEMBER)


# ---------------------------------------------------------------- reading
async def test_a_topic_is_read_whole_though_only_its_first_posts_come_with_it(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    author = double.site.users[2]
    for n in range(60):
        double.site.write(author, {"topic_id": topic, "raw": f"*reply* {n}"})
    pages = [await alice.posts(topic, limit=25)]
    while pages[-1].next:
        pages.append(await alice.posts(topic, pages[-1].next, limit=25))
    read = [p.raw for page in pages for p in page.items]
    assert read == ["hello there", *(f"*reply* {n}" for n in range(60))]


async def test_law_4_an_edit_within_the_grace_period_is_no_first_version(world: DiscourseWorld, double: Double) -> None:
    """Discourse counts no version for five minutes; what was edited before it was seen must not move a robot."""
    alice, robot = await world.sign_in("alice"), await world.sign_in("quadruped")
    topic = await begin(alice)
    post = (await alice.reply(topic, "harmless words", key="1")).post
    assert (await robot.post(post.id)).version == 1
    stored = double.site.posts[int(post.id)]
    double.site.revise(double.site.users[stored.user], stored, "@quadruped walk forward 5 m")
    assert stored.version == 1
    edited = await robot.post(post.id)
    assert (edited.version, edited.edited_at is not None) == (2, True)
    late = double.site.write(double.site.users[stored.user], {"topic_id": topic, "raw": "harmless words again"})
    late.created_at = late.created_at.replace(year=2025)  # touched long after it was written, and never seen before
    assert (await robot.post(str(late.id))).version == 2


@pytest.mark.parametrize("how", ["author", "moderator", "flags"])
async def test_a_post_that_is_gone_says_so_however_it_went(how: str, world: DiscourseWorld, double: Double) -> None:
    alice, robot = await world.sign_in("alice"), await world.sign_in("quadruped")
    topic = await begin(alice)
    post = (await alice.reply(topic, "@quadruped walk", key="1")).post
    after, _ = await robot.now()
    if how == "flags":
        double.site.posts[int(post.id)].hidden = True
    else:
        await (alice._wire if how == "author" else world.wire).ask("DELETE", f"/posts/{post.id}.json")
    seen = await robot.post(post.id)
    assert (seen.removed, seen.raw, seen.mentions) == (True, "", ())
    assert STUB not in seen.raw
    (event,) = await robot.changes(after)
    assert (event.kind, event.post and event.post.id) == ("post.removed", post.id)
    assert await robot.changes(event.id) == ()


async def test_mentions_are_those_that_the_forum_resolved(world: DiscourseWorld) -> None:
    alice, robot = await world.sign_in("alice"), await world.sign_in("quadruped")
    text = '@Quadruped @nobody hi `@alice`\n\n[quote="bob, post:1, topic:1"]\n@alice\n[/quote]'
    post = (await alice.create_topic("robots", "A topic", text, key="1")).post
    assert post.mentions == ("quadruped",)
    assert [p.id for p in await robot.mentions()] == [post.id]
    assert await alice.mentions() == ()


async def test_pictures_come_from_this_forum_and_its_key_goes_nowhere_else(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    with pytest.raises(ForumError, match="not authorized"):
        await alice._wire.ask(
            "POST",
            "/uploads.json",
            data={"upload_type": "composer"},
            files={"file": ("1.tiff", b"II*\0", "image/tiff")},
        )
    written = await alice.reply(topic, "look", key="1", images=(PIXEL, PIXEL))
    assert (len(written.post.images), written.post.raw) == (2, "look")
    elsewhere, headers = await _elsewhere()
    double.site.moved[written.post.images[0].rpartition("/")[2]] = elsewhere
    assert await alice.download(written.post.images[0]) == b"a picture"
    assert "api-key" not in headers[0].lower()
    with pytest.raises(ForumError, match="not a picture of this forum"):
        await alice.download("http://127.0.0.2:1/uploads/default/original/1X/a.png")


async def test_posts_are_found_by_their_words_page_by_page_and_by_words_only(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    ids = [
        str(double.site.write(double.site.users[2], {"topic_id": topic, "raw": f"a purple *elephant* {n}"}).id)
        for n in range(55)
    ]
    double.site.write(double.site.users[2], {"title": "Elsewhere", "raw": "purple as well"})
    pages = [await alice.search("purple", board_id="robots", limit=20)]
    while pages[-1].next:
        pages.append(await alice.search("purple", board_id="robots", cursor=pages[-1].next, limit=20))
    assert [p.id for page in pages for p in page.items] == ids[::-1]
    assert pages[0].items[0].raw == "a purple *elephant* 54"
    assert (await alice.search("unicorn")).items == ()
    asked = double.count("GET", "/search.json")
    assert (await alice.search("in:messages @alice #general -x")).items == ()
    assert double.count("GET", "/search.json") == asked
    with pytest.raises(ForumNotFound):
        await alice.search("purple", board_id="no-board")


# ---------------------------------------------------------------- keys and sessions
async def test_a_key_is_for_its_account_only_and_a_wrong_one_is_denied(world: DiscourseWorld, double: Double) -> None:
    await world.sign_in("alice")
    own = double.site.add_key(double.site.named("alice"))
    assert (await world.at(world.url, own).me()).name == "alice"
    assert (await world.at(world.url, f"Alice:{own}").me()).name == "alice"
    for wrong in (f"bob:{own}", "alice:wrong", "wrong", "user-api-key:wrong"):
        with pytest.raises(ForumDenied):
            await world.at(world.url, wrong).me()
    assert own not in repr(world.at(world.url, own)._wire.credentials)


async def test_identity_is_switched_at_run_time_by_a_key_for_all_users(world: DiscourseWorld, double: Double) -> None:
    forum = await world.sign_in("alice")
    topic = await begin(forum)
    await world.sign_in("bob")
    await forum.reply(topic, "by alice", key="k")
    assert (await forum.switch("bob")).name == "bob"
    written = await forum.reply(topic, "by bob", key="k")
    assert (written.created, written.post.author.name) == (True, "bob")
    with pytest.raises(ForumDenied):
        await forum.switch("nobody-there")
    assert (await forum.me()).name == "bob"


async def test_no_cookie_is_kept_with_a_key(world: DiscourseWorld, double: Double) -> None:
    alice = await world.sign_in("alice")
    await alice._wire.get("/session/csrf.json")  # its answer sets a session's cookie
    await alice.me()
    assert "cookie" not in double.headers[-1]


async def test_a_session_signs_in_writes_and_is_begun_anew_when_it_ends(world: DiscourseWorld, double: Double) -> None:
    await world.sign_in("alice")
    forum = world.at(world.url, f"login:alice:{PASSWORD}")
    topic = await begin(forum)
    await forum.reply(topic, "one", key="1")
    visitors = double.visitors
    for cookie, (_, user) in list(visitors.sessions.items()):
        visitors.sessions[cookie] = ("another token", user)  # the CSRF token is no longer good
    assert (await forum.reply(topic, "two", key="2")).created
    visitors.sessions.clear()
    assert (await forum.reply(topic, "three", key="3")).created
    assert await texts(forum, topic) == ["hello there", "one", "two", "three"]


async def test_a_wrong_password_is_denied_though_it_is_answered_with_200(world: DiscourseWorld) -> None:
    await world.sign_in("alice")
    with pytest.raises(ForumDenied, match="Incorrect username"):
        await world.at(world.url, "login:alice:wrong").me()


async def test_accounts_are_made_by_admins_at_once_and_by_visitors_with_an_e_mail(
    world: DiscourseWorld, double: Double
) -> None:
    admin = world.at(world.url, f"system:{world.key}")
    made = await admin.create_account("carol", "carol@example.com", PASSWORD)
    assert made is not None
    assert (made.name, made.role) == ("carol", Role.MEMBER)
    with pytest.raises(ForumError, match="must be unique"):  # answered with 200
        await admin.create_account("carol", "other@example.com", PASSWORD)
    visitor = world.at(world.url, f"login:carol:{PASSWORD}")
    assert await visitor.create_account("dave", "dave@example.com", PASSWORD) is None
    assert double.site.named("dave") is not None


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"operator": ["x"]}, "operator: Extra inputs are not permitted; valid are: operators, admins"),
        ({"requests_per_minute": 1}, "requests_per_minute"),
    ],
)
def test_a_wrong_option_is_named_with_those_that_are_valid(options: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        DiscourseForum(ForumConfig(url="http://127.0.0.1:9", options=options), "x:y")


@pytest.mark.parametrize(
    ("token", "per_minute", "live", "poll_s"),
    [
        ("alice:key", None, False, 2.0),
        ("user-api-key:key", None, False, 6.0),
        ("alice:key", 240, True, 0.5),
        ("alice:key", 120, False, 1.0),
    ],
)
async def test_law_16_how_fast_it_listens_is_what_the_key_allows(
    token: str, per_minute: int | None, live: bool, poll_s: float
) -> None:
    options = {} if per_minute is None else {"requests_per_minute": per_minute}
    forum = DiscourseForum(ForumConfig(url="http://127.0.0.1:9", options=options), token)
    assert (forum.live, forum.fastest_poll_s) == (live, poll_s)
    if not live:
        with pytest.raises(ForumUnreachable):
            await anext(forum.stream("0"))
    await forum.close()


async def _elsewhere() -> tuple[str, list[str]]:
    """Where a Discourse may keep its files; what is asked there with which headers."""
    heads: list[str] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        heads.append((await reader.readuntil(b"\r\n\r\n")).decode())
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 9\r\nConnection: close\r\n\r\na picture")
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    return f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/file.png", heads
