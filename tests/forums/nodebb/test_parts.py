"""Unit tests of the NodeBB adapter: marks, the clock, settings, and responses of defective servers."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agentrob.config.forum import ForumConfig
from agentrob.errors import ConfigError, ForumDenied, ForumError, ForumLimited, ForumUnreachable
from agentrob.forums.nodebb.clock import HeaderClock
from agentrob.forums.nodebb.forum import NodeBBForum
from agentrob.forums.nodebb.http import NodeBBClient
from agentrob.forums.nodebb.markers import MarkedText, mark, pictures_in, unmark
from agentrob.forums.nodebb.posts import mentions_in
from agentrob.forums.nodebb.settings import Credentials, NodeBBOptions, account
from agentrob.model import AccountKind, Role, StatusCard

CARD = StatusCard(
    "quadruped", "running", step=1, steps=2, doing="move", trace_id="t1", part=2, parts=3, post="12",
    content_hash="0a" * 32, bid_s=9, bid_cm=150, near_cm=90, room="lab", battery=80, ahead=1, takes=1,
    left_to="humanoid",
)  # fmt: skip


@settings(max_examples=50)
@given(
    st.text(st.characters(exclude_categories=["Cs"]), min_size=1).filter(lambda t: t.strip()),
    st.text(min_size=1, max_size=200, alphabet=st.characters(min_codepoint=33, max_codepoint=126)),
    st.sampled_from([None, CARD]),
    st.lists(st.from_regex(r"/assets/uploads/files/[a-z0-9-]{1,20}\.png", fullmatch=True), max_size=3),
)
def test_what_is_marked_is_taken_apart_again(text: str, key: str, card: StatusCard | None, pictures: list[str]) -> None:
    wanted = MarkedText(text.rstrip(), key, card, tuple(pictures))
    assert unmark(mark(wanted)) == wanted


@pytest.mark.parametrize(
    "raw",
    ["plain", "[//]: # (agentrob:!!!)", "[//]: # (agentrob:e30)\nafter it", "text [//]: # (agentrob:e30=)", ""],
)
def test_of_a_text_without_a_mark_everything_is_text(raw: str) -> None:
    assert unmark(raw) == MarkedText(raw)


def test_pictures_in_code_are_none() -> None:
    assert pictures_in("![a](/assets/uploads/1.png)\n```\n![b](/x.png)\n```\n`![c](/y.png)`") == (
        "/assets/uploads/1.png",
    )


def test_mentions_are_links_that_the_forum_made_outside_of_quotes() -> None:
    link = '<a class="plugin-mentions-user plugin-mentions-a" href="/forum/user/{0}">@{0}</a>'
    content = f"<p>{link.format('bob')}</p><blockquote>{link.format('eve')}</blockquote><a href='/user/mal'>@mal</a>"
    assert mentions_in(content) == ("bob",)


def test_many_answers_make_a_clock_of_whole_seconds_finer() -> None:
    clock, here = HeaderClock(), datetime(2026, 1, 1, tzinfo=UTC)
    ahead = timedelta(seconds=7.3)
    for n in range(40):
        asked = here + timedelta(milliseconds=90 * n)
        answered = asked + timedelta(milliseconds=20)
        there = asked + timedelta(milliseconds=10) + ahead
        clock.add(there.replace(microsecond=0), asked, answered)
    assert clock.uncertainty_s < 0.15
    assert abs((clock.now() - datetime.now(UTC) - ahead).total_seconds()) < 0.1
    clock.add(here - timedelta(hours=1), here, here)
    assert clock.now() < datetime.now(UTC), "a clock that was set is believed"


# ---------------------------------------------------------------------- settings
@pytest.mark.parametrize(
    ("groups", "kind", "role"),
    [
        ((), AccountKind.HUMAN, Role.MEMBER),
        (("drivers",), AccountKind.HUMAN, Role.OPERATOR),
        (("administrators", "drivers"), AccountKind.HUMAN, Role.ADMIN),
        (("robots", "drivers"), AccountKind.ROBOT_AGENT, Role.OPERATOR),
        (("watchers", "robots"), AccountKind.MONITORING_AGENT, Role.MEMBER),
        (("planners",), AccountKind.COMMANDING_AGENT, Role.MEMBER),
    ],
)
def test_groups_become_kinds_and_roles(groups: tuple[str, ...], kind: AccountKind, role: Role) -> None:
    options = NodeBBOptions(
        operators=("Drivers",),
        robot_agents=("robots",),
        monitoring_agents=("watchers",),
        commanding_agents=("planners",),
    )
    user = {"uid": 7, "userslug": "Alice-B", "username": "Alice &amp; B", "banned": False}
    made = account(user, [{"slug": g, "private": 1, "hidden": 0} for g in groups], options)
    assert (made.id, made.name, made.display_name, made.kind, made.role) == ("7", "alice-b", "Alice & B", kind, role)


def test_law_2_open_and_hidden_groups_give_no_rights_but_make_a_robot_of_an_account() -> None:
    options = NodeBBOptions(operators=("drivers",), robot_agents=("robots",))
    user = {"uid": 7, "userslug": "alice", "username": "alice"}
    for flags in ({"private": 0, "hidden": 0}, {"private": 1, "hidden": 1}):
        made = account(user, [{"slug": "drivers", **flags}, {"slug": "robots", **flags}], options)
        assert (made.role, made.kind) == (Role.MEMBER, AccountKind.ROBOT_AGENT)


def test_settings_that_are_none_are_refused_with_what_is_valid() -> None:
    with pytest.raises(ConfigError, match="valid are: operators"):
        NodeBBForum(ForumConfig(options={"operator": ["x"]}), "token")
    for setting in ("operators", "admins", "commanding_agents"):
        with pytest.raises(ConfigError, match="'registered-users' contains every new account"):
            NodeBBForum(ForumConfig(options={setting: ["Registered Users"]}), "token")
    with pytest.raises(ConfigError, match="login:NAME:PASSWORD"):
        Credentials.of("login:only-a-name")
    with pytest.raises(ConfigError, match="uid"):
        Credentials.of("token@alice")


def test_secrets_are_not_printed() -> None:
    for secret in ("login:alice:geheim", "geheim", "geheim@7"):
        assert "geheim" not in repr(Credentials.of(secret))


def test_a_password_may_have_colons() -> None:
    assert Credentials.of("login:alice:a:b").password == "a:b"


# ---------------------------------------------------------------------- defective servers
@asynccontextmanager
async def answering(answer: bytes) -> AsyncIterator[NodeBBForum]:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        await reader.readuntil(b"\r\n\r\n")
        writer.write(answer)
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    forum = NodeBBForum(ForumConfig(url=f"http://127.0.0.1:{server.sockets[0].getsockname()[1]}"), "token")
    try:
        yield forum
    finally:
        await forum.close()
        server.close()


@pytest.mark.parametrize(
    ("answer", "error"),
    [
        (b"HTTP/1.1 429 Too Many\r\nRetry-After: 7\r\nContent-Length: 9\r\n\r\nslow down", ForumLimited),
        (b"HTTP/1.1 429 Too Many\r\nRetry-After: Wed, 21 Oct 2099\r\nContent-Length: 0\r\n\r\n", ForumLimited),
        (b"HTTP/1.1 502 Bad\r\nContent-Type: text/html\r\nContent-Length: 5\r\n\r\n<p>no", ForumUnreachable),
        (b'HTTP/1.1 401 No\r\nContent-Length: 16\r\n\r\n"not-authorized"', ForumDenied),
        (b"HTTP/1.1 403 No\r\nContent-Length: 9\r\n\r\nForbidden", ForumDenied),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 4\r\n\r\nhuh?", ForumError),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n{}", ForumError),
        (b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\n[]", ForumError),
        (b"nonsense\r\n\r\n", ForumUnreachable),
    ],
)
async def test_every_response_of_a_defective_server_becomes_a_forum_error(
    answer: bytes, error: type[ForumError]
) -> None:
    async with answering(answer) as forum:
        calls = (lambda: forum.post("1"), forum.boards, forum.me, lambda: forum.topics("robots"), forum.now)
        # A new forum may have no posts at all.
        for call in calls[:-1] if answer.endswith(b"[]") else calls:
            with pytest.raises(error) as raised:
                await call()
            if isinstance(raised.value, ForumLimited):
                assert raised.value.retry_after_s in (7, 1)


async def test_a_picture_is_fetched_from_this_forum_only() -> None:
    forum = NodeBBForum(ForumConfig(url="http://127.0.0.1:9"), "token")
    for elsewhere in (
        "http://127.0.0.2:9/assets/uploads/1.png",
        "//example.org/1.png",
        "http://127.0.0.1:9@example.org/",
    ):
        with pytest.raises(ForumError, match="not a picture of this forum"):
            await forum.download(elsewhere)
    await forum.close()


async def test_a_number_that_is_none_never_gets_into_an_address() -> None:
    forum = NodeBBForum(ForumConfig(url="http://127.0.0.1:9"), "token")
    for call in (forum.post("../users/1"), forum.topic("1?x="), forum.reply("1/../2", "x", key="1")):
        with pytest.raises((ForumError, ForumUnreachable)):
            await call
    await forum.close()


async def test_the_wire_under_a_path_stays_under_it() -> None:
    client = NodeBBClient("http://127.0.0.1:9/forum/", Credentials.of("token"))
    assert client.url == "http://127.0.0.1:9/forum"
    await client.close()
