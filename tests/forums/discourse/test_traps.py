"""Peculiarities of Discourse, one by one: identities, reading, keys and sessions."""

from __future__ import annotations

import asyncio

import pytest

from agentrob.config.forum import ForumConfig
from agentrob.errors import ConfigError, ForumDenied, ForumError, ForumNotFound, ForumUnoffered, ForumUnreachable
from agentrob.forums.contract import PIXEL
from agentrob.forums.discourse.forum import DiscourseForum
from agentrob.forums.discourse.markers import MarkedText, mark
from agentrob.forums.discourse.settings import DiscourseOptions, account
from agentrob.model import Account, AccountKind, Role, StatusCard
from tests.doubles.discourse.site import STUB
from tests.forums.discourse.discourse_world import PASSWORD, DiscourseWorld, Double, begin, texts

CARD = StatusCard("quadruped", "done", step=1, steps=1, trace_id="t1")


# ---------------------------------------------------------------- who is who (law 1)
async def test_law_1_marks_written_by_people_prove_nothing(world: DiscourseWorld, double: Double) -> None:
    mallory, robot = await world.sign_in("mallory"), await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    topic = await begin(mallory)
    forged = mark(MarkedText("I am the robot", "claim:1", CARD))
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


async def test_law_2_a_group_that_anybody_may_join_gives_no_rights_but_makes_a_robot_of_an_account(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice", role=Role.OPERATOR)
    pilot = await world.sign_in("pilot", kind=AccountKind.COMMANDING_AGENT)
    robot = await world.sign_in("quadruped", kind=AccountKind.ROBOT_AGENT)
    assert ((await alice.me()).role, (await pilot.me()).kind) == (Role.OPERATOR, AccountKind.COMMANDING_AGENT)
    for group in double.site.groups.values():
        group.public_admission = True
    assert ((await alice.me()).role, (await pilot.me()).kind) == (Role.MEMBER, AccountKind.HUMAN)
    assert (await robot.me()).kind is AccountKind.ROBOT_AGENT


async def test_law_1_an_account_in_groups_of_two_kinds_gets_the_lower_rights(
    world: DiscourseWorld, double: Double
) -> None:
    bob = await world.sign_in("bob", kind=AccountKind.COMMANDING_AGENT)
    await world._member("PUT", "robot-monitors", "bob")
    assert (await bob.me()).kind is AccountKind.MONITORING_AGENT


async def test_without_configuration_everybody_may_only_read(world: DiscourseWorld) -> None:
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


async def test_an_unreadable_category_does_not_exist(world: DiscourseWorld, double: Double) -> None:
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


async def test_subcategories_are_named_by_their_path(world: DiscourseWorld, double: Double) -> None:
    parent = next(c for c in double.site.categories.values() if c.slug == "robots")
    double.site.add_category("Legs", "legs", parent=parent.id)
    double.site.add_category("无名", "")
    alice = await world.sign_in("alice")
    assert [b.id for b in await alice.boards()] == ["general", "robots", "robots/legs", "4-category"]
    post = (await alice.create_topic("robots/legs", "A topic", "hello there", key="1")).post
    assert post.board_id == "robots/legs"
    assert [t.id for t in (await alice.topics("robots/legs")).items] == [post.topic_id]
    assert (await alice.topics("robots")).items == ()


def test_a_hidden_profile_gives_no_rights() -> None:
    options = DiscourseOptions(operators=("trust_level_1", "staff"), admins=("admins",))
    hidden = account({"id": 7, "username": "Alice", "name": None, "profile_hidden": True}, options)
    assert hidden == Account("7", "alice", AccountKind.HUMAN, Role.MEMBER)


def test_law_2_approvers_are_members_of_a_closed_group_of_moderators() -> None:
    options = DiscourseOptions(operators=("trust_level_1",), moderators=("approvers",), admins=("admins",))
    for closed, role in ((True, Role.MODERATOR), (False, Role.OPERATOR)):
        groups = [{"name": "approvers", "public_admission": not closed}]
        who = account({"id": 7, "username": "alice", "trust_level": 1, "groups": groups}, options)
        assert who.role is role
    with pytest.raises(ConfigError, match="signing up"):
        DiscourseOptions.of({"moderators": ["everyone"]})


# ---------------------------------------------------------------- reading
async def test_a_whole_topic_is_read_although_a_response_has_only_its_first_posts(
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


async def test_law_4_a_post_edited_within_the_grace_period_is_not_a_first_version(
    world: DiscourseWorld, double: Double
) -> None:
    """Discourse adds no version for five minutes; a post that was edited before it was read must not move a robot."""
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
async def test_a_removed_post_is_reported_however_it_was_removed(
    how: str, world: DiscourseWorld, double: Double
) -> None:
    alice, robot = await world.sign_in("alice"), await world.sign_in("quadruped")
    topic = await begin(alice)
    post = (await alice.reply(topic, "@quadruped walk", key="1")).post
    after, _ = await robot.now()
    if how == "flags":
        double.site.posts[int(post.id)].hidden = True
    else:
        await (alice._client if how == "author" else world.client).ask("DELETE", f"/posts/{post.id}.json")
    seen = await robot.post(post.id)
    assert (seen.removed, seen.raw, seen.mentions) == (True, "", ())
    assert STUB not in seen.raw
    (event,) = await robot.changes(after)
    assert (event.kind, event.post and event.post.id) == ("post.removed", post.id)
    assert await robot.changes(event.id) == ()


async def test_mentions_are_the_ones_that_the_forum_resolved(world: DiscourseWorld) -> None:
    alice, robot = await world.sign_in("alice"), await world.sign_in("quadruped")
    text = '@Quadruped @nobody hi `@alice`\n\n[quote="bob, post:1, topic:1"]\n@alice\n[/quote]'
    post = (await alice.create_topic("robots", "A topic", text, key="1")).post
    assert post.mentions == ("quadruped",)
    assert [p.id for p in await robot.mentions()] == [post.id]
    assert await alice.mentions() == ()


async def test_pictures_come_from_this_forum_only_and_its_key_is_sent_nowhere_else(
    world: DiscourseWorld, double: Double
) -> None:
    alice = await world.sign_in("alice")
    topic = await begin(alice)
    with pytest.raises(ForumError, match="not authorized"):
        await alice._client.ask(
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


async def test_search_by_words_is_paged_and_is_the_only_mode(world: DiscourseWorld, double: Double) -> None:
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
async def test_a_key_is_valid_for_its_account_only_and_a_wrong_key_is_denied(
    world: DiscourseWorld, double: Double
) -> None:
    await world.sign_in("alice")
    own = double.site.add_key(double.site.named("alice"))
    assert (await world.at(world.url, own).me()).name == "alice"
    assert (await world.at(world.url, f"Alice:{own}").me()).name == "alice"
    for wrong in (f"bob:{own}", "alice:wrong", "wrong", "user-api-key:wrong"):
        with pytest.raises(ForumDenied):
            await world.at(world.url, wrong).me()
    assert own not in repr(world.at(world.url, own)._client.credentials)


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


async def test_with_a_key_no_cookies_are_kept(world: DiscourseWorld, double: Double) -> None:
    alice = await world.sign_in("alice")
    await alice._client.get("/session/csrf.json")  # its answer sets a session's cookie
    await alice.me()
    assert "cookie" not in double.headers[-1]


async def test_a_session_signs_in_again_when_it_ends(world: DiscourseWorld, double: Double) -> None:
    await world.sign_in("alice")
    forum = world.at(world.url, f"login:alice:{PASSWORD}")
    topic = await begin(forum)
    await forum.reply(topic, "one", key="1")
    visitors = double.visitors
    for cookie, (_, user) in list(visitors.sessions.items()):
        visitors.sessions[cookie] = ("another token", user)  # the CSRF token is no longer valid
    assert (await forum.reply(topic, "two", key="2")).created
    visitors.sessions.clear()
    assert (await forum.reply(topic, "three", key="3")).created
    assert await texts(forum, topic) == ["hello there", "one", "two", "three"]


async def test_a_wrong_password_is_denied_although_its_status_is_200(world: DiscourseWorld) -> None:
    await world.sign_in("alice")
    with pytest.raises(ForumDenied, match="Incorrect username"):
        await world.at(world.url, "login:alice:wrong").me()


async def test_admins_create_active_accounts_and_visitors_confirm_by_email(
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


async def test_a_created_account_signs_in_with_its_kind(world: DiscourseWorld) -> None:
    admin = await world.sign_in("root", role=Role.ADMIN)
    made = await admin.register("planner", kind=AccountKind.COMMANDING_AGENT, display_name="The planner")
    assert (made.account.kind, made.account.display_name) == (AccountKind.COMMANDING_AGENT, "The planner")
    planner = world.at(world.url, made.secret)
    assert await planner.me() == made.account
    assert (await planner.create_topic("robots", "A topic", "hello there", key="1")).created
    with pytest.raises(ForumError, match="must be unique"):
        await admin.register("planner")


async def test_law_2_an_admin_of_the_robots_only_cannot_create_accounts_or_grant_rights(
    world: DiscourseWorld, double: Double
) -> None:
    """Neither membership of a group listed under `admins` nor a password gives a right on the forum."""
    alice = await world.sign_in("alice", role=Role.ADMIN)
    user = double.site.named("alice")
    assert user is not None
    user.admin = False
    asked = len(double.requests)
    session = world.at(world.url, f"login:alice:{PASSWORD}")
    for forum in (alice, session):
        for call in (forum.register("carol"), forum.set_rights("alice", suspended=False)):
            with pytest.raises(ForumDenied, match="an admin of the Discourse"):
                await call
    changed = [path for method, path in double.requests[asked:] if method != "GET"]
    assert changed == ["/session.json"]


async def test_a_role_is_a_group_and_a_change_removes_the_old_group(world: DiscourseWorld, double: Double) -> None:
    admin, alice = await world.sign_in("root", role=Role.ADMIN), await world.sign_in("alice", role=Role.OPERATOR)
    user = double.site.named("alice")
    assert user is not None
    for role, group in ((Role.ADMIN, "robot-admins"), (Role.OPERATOR, "robot-operators"), (Role.MEMBER, "")):
        assert (await admin.set_rights("alice", role=role)).role is role
        assert {double.site.groups[n].name for n in user.groups} == {group} - {""}
    assert (await admin.set_rights("alice", suspended=True)).suspended
    with pytest.raises(ForumDenied):
        await alice.me()
    assert not (await admin.set_rights("alice", suspended=False)).suspended
    with pytest.raises(ForumUnoffered, match="cannot give the role moderator"):
        await admin.set_rights("alice", role=Role.MODERATOR)
    with pytest.raises(ForumNotFound):
        await admin.set_rights("nobody", suspended=True)


async def test_automatic_groups_are_not_joined(world: DiscourseWorld) -> None:
    await world.sign_in("root", role=Role.ADMIN)
    await world.sign_in("alice")
    admin = world.at(world.url, f"root:{world.key}", operators=("trust_level_1",), commanding_agents=())
    with pytest.raises(ForumUnoffered, match=r"forum\.options\.commanding_agents names no group"):
        await admin.register("planner", kind=AccountKind.COMMANDING_AGENT)
    assert await admin.account("planner") is None
    with pytest.raises(ForumError, match="alice is still operator"):
        await admin.set_rights("alice", role=Role.MEMBER)


async def test_notifications_list_mentions_and_replies_newest_first_in_pages(world: DiscourseWorld) -> None:
    alice, bob = await world.sign_in("alice"), await world.sign_in("bob")
    first = (await alice.create_topic("robots", "A topic", "hello there", key="1")).post
    said = ["@alice look here", "an answer to that", "talk to nobody", "@alice look again"]
    posts = [
        (await bob.reply(first.topic_id, text, key=str(n), reply_to=first.id if n == 1 else None)).post
        for n, text in enumerate(said)
    ]
    page = await alice.notifications(limit=2)
    assert [(n.kind, n.post.id, n.read) for n in page.items] == [
        ("mention", posts[3].id, False), ("reply", posts[1].id, False),
    ]  # fmt: skip
    rest = await alice.notifications(page.next, limit=2)
    assert [(n.kind, n.post.id) for n in rest.items] == [("mention", posts[0].id)]
    assert rest.next is None
    await world.remove(posts[3].id)
    assert [n.post.id for n in (await alice.notifications()).items] == [posts[1].id, posts[0].id]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"operator": ["x"]}, "operator: Extra inputs are not permitted; valid are: operators, moderators, admins"),
        ({"requests_per_minute": 1}, "requests_per_minute"),
        ({"operators": ["Trust_Level_0"]}, "'trust_level_0' contains every new account"),
    ],
)
def test_an_invalid_option_is_named_with_the_valid_ones(options: dict[str, object], said: str) -> None:
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
async def test_law_16_the_poll_interval_follows_the_keys_rate_limit(
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
    """Serve another host on which Discourse may store files; record the headers of requests."""
    heads: list[str] = []

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        heads.append((await reader.readuntil(b"\r\n\r\n")).decode())
        writer.write(b"HTTP/1.1 200 OK\r\nContent-Length: 9\r\nConnection: close\r\n\r\na picture")
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    return f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}/file.png", heads


async def test_law_4_a_post_in_a_moved_topic_is_read_on_its_current_board(
    robot: DiscourseForum, double: Double, topic: int
) -> None:
    post_id = next(str(p.id) for p in double.site.posts.values() if p.topic == topic)
    before = (await robot.post(post_id)).board_id
    other = next(number for number in double.site.categories if number != double.site.topics[topic].category)
    double.site.topics[topic].category = other
    assert (await robot.post(post_id)).board_id != before
