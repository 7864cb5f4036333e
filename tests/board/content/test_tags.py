"""Tags of topics, and unread posts of each account, over the API and the pages: rights, limits and migrations."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import httpx2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sqlalchemy import func, select, text

from agentrob.board.admin import local_admin
from agentrob.board.admin.moderation import erase_content
from agentrob.board.content import tags, unread
from agentrob.board.db import schema as db
from agentrob.board.db.database import migrate, open_engine
from agentrob.board.web import posts as pages_posts
from agentrob.board.web import topics
from agentrob.errors import BoardError
from tests.board.auth.test_rights import admin_api, client_with_role, new_board, topic_on
from tests.board.running_board import RunningBoard, running_board
from tests.waiting import wait_for

ATOM = "{http://www.w3.org/2005/Atom}"


@cache
def api_client(board: RunningBoard, name: str) -> httpx2.Client:
    """Return a cached API client, because creating one takes longer than most requests."""
    return board.client(name)


def topic(board: RunningBoard, by: str = "op", where: str = "talk", **fields: Any) -> dict[str, Any]:
    new = {"board_id": where, "title": "A topic", "body": "words"} | fields
    answer = api_client(board, by).post("/topics", json=new)
    assert answer.status_code == 201, answer.text
    made: dict[str, Any] = answer.json()["topic"]
    return made


def reply(board: RunningBoard, made: dict[str, Any], by: str = "op", body: str = "more") -> str:
    answer = api_client(board, by).post(f"/topics/{made['id']}/posts", json={"body": body})
    return str(answer.json()["post"]["id"])


def listed_topics(page: str) -> list[str]:
    """Return the ids of the topics that a page lists."""
    return re.findall(r'class="row-title" href="/t/(\d+)"', page)


# -------------------------------------------------------------------- tags
@pytest.mark.parametrize(
    ("words", "made"),
    [
        (["#Red Ball!", "red ball", "RED-BALL"], ("red-ball",)),
        (["机器人", " Ｇｏ２ "], ("机器人", "go2")),
        (["<script>", "\u202eevil", "'; DROP", "--", ""], ("script", "evil", "drop")),
    ],
)
def test_tags_are_normalised(words: list[str], made: tuple[str, ...]) -> None:
    assert tags.checked(words) == made


@given(st.text(max_size=60))
def test_normalising_a_tag_is_idempotent_and_leaves_letters_digits_and_hyphens(word: str) -> None:
    tag = tags.plain(word)
    assert tags.plain(tag) == tag
    assert len(tag) <= tags.LENGTH
    assert not re.search(r"[\s<>&\"'/?#%@,;\x00-\x1f\x7f\u200e\u200f\u202a-\u202e]", tag)


@pytest.mark.parametrize(
    ("words", "code"), [(["a", "b", "c", "d", "e", "f"], "too_many_tags"), (["x" * 25], "bad_tag")]
)
def test_too_many_and_too_long_tags_are_refused(words: list[str], code: str) -> None:
    with pytest.raises(BoardError) as caught:
        tags.checked(words)
    assert (caught.value.status, caught.value.code) == (422, code)


def test_a_topic_shows_its_tags_on_every_page(board: RunningBoard) -> None:
    made = topic(board, tags=["Mapping", "red ball"], body="a wombat")
    other = topic(board, tags=["mapping"], body="a wombat too")
    assert made["tags"] == ["mapping", "red-ball"]
    op = board.client("op")
    assert op.get(f"/topics/{made['id']}").json()["tags"] == ["mapping", "red-ball"]
    on_board = op.get("/boards/talk/topics", params={"tag": "Red Ball"}).json()["items"]
    assert [t["id"] for t in on_board] == [made["id"]]
    listed = {t["tag"]: t["topics"] for t in op.get("/tags").json()["items"]}
    assert (listed["mapping"], listed["red-ball"]) == (2, 1)
    found = op.get("/search", params={"q": "wombat", "tag": "red-ball"}).json()["items"]
    assert [p["topic_id"] for p in found] == [made["id"]]
    assert len(op.get("/search", params={"q": "wombat", "tag": "mapping"}).json()["items"]) == 2
    assert op.get("/search", params={"q": "wombat", "tag": "none such"}).json()["items"] == []
    browser = board.browser("op")
    for path in ("/", "/b/talk", f"/t/{made['id']}", "/tags"):
        assert 'href="/tags/red-ball"' in browser.get(path).text, path
    assert listed_topics(browser.get("/tags/mapping").text) == [other["id"], made["id"]]
    page = browser.get("/search", params={"q": "wombat", "tag": "red ball", "board": "talk"}).text
    assert (page.count('class="row-title"'), 'value="red-ball"' in page) == (1, True)
    assert browser.get("/search", params={"q": "wombat", "board": "robots"}).text.count('class="row-title"') == 0


def test_a_tag_has_a_feed_and_feed_entries_list_tags(board: RunningBoard) -> None:
    made = topic(board, title="Fed", tags=["fed 喂"])
    newest = reply(board, made, "member", "the newest")
    topic(board, title="Not fed")
    answer = board.browser("member").get("/tags/fed-喂/feed.atom")
    assert answer.headers["content-type"].startswith("application/atom+xml")
    entries = list(ET.fromstring(answer.content).iter(f"{ATOM}entry"))
    assert [e.findtext(f"{ATOM}title") for e in entries] == ["Fed", "Fed"]
    assert (entries[0].findtext(f"{ATOM}id") or "").endswith(f"/p/{newest}")
    site = ET.fromstring(board.browser("member").get("/feed.atom").content)
    terms = {e.findtext(f"{ATOM}title"): [c.get("term") for c in e.iter(f"{ATOM}category")] for e in site}
    assert (terms["Fed"], terms["Not fed"]) == (["fed-喂"], [])


def test_only_the_author_and_moderators_may_tag_a_topic(board: RunningBoard) -> None:
    made = topic(board, "member", tags=["before"])
    path = f"/topics/{made['id']}/tags"
    assert board.client("member").put(path, json={"tags": ["mine"]}).json()["tags"] == ["mine"]
    refused = client_with_role(board, "operator").put(path, json={"tags": ["theirs"]})
    assert refused.status_code == 403
    changed = admin_api(board).put(path, json={"tags": ["Moderated", "moderated"]})
    assert changed.json()["tags"] == ["moderated"]
    log = admin_api(board).get("/admin/audit", params={"target": f"topic:{made['id']}"}).json()["items"]
    assert [(e["action"], e["detail"]["tags"]) for e in log] == [("topic.tags", ["moderated"])]
    admin_api(board).post(f"/topics/{made['id']}/lock", json={"locked": True}).raise_for_status()
    assert board.client("member").put(path, json={"tags": []}).json()["code"] == "locked"
    assert admin_api(board).put(path, json={"tags": []}).json()["tags"] == []
    assert board.client("member").put("/topics/999999/tags", json={"tags": []}).status_code == 404
    assert board.client("member").put(path, json={"tags": ["x"] * 6}).status_code == 422


def test_tags_of_unreadable_topics_are_not_listed(board: RunningBoard) -> None:
    where = new_board(board, "closed-tags", read_role="admin", post_role="admin")
    made = topic(board, "admin", where, tags=["hush"])
    member, browser = board.client("member"), board.browser("member")
    assert "hush" not in member.get("/tags").text
    assert "hush" not in browser.get("/tags").text
    assert listed_topics(browser.get("/tags/hush").text) == []
    assert "<entry>" not in browser.get("/tags/hush/feed.atom").text
    assert member.put(f"/topics/{made['id']}/tags", json={"tags": []}).status_code == 404
    assert listed_topics(board.browser("admin").get("/tags/hush").text) == [made["id"]]


def csrf(browser: httpx2.Client, path: str) -> str:
    found = re.search(r'name="csrf" value="([^"]*)"', browser.get(path).text)
    assert found
    return found[1]


def test_the_form_keeps_invalid_tags_for_correction(board: RunningBoard) -> None:
    browser = board.browser("member")
    form = {"csrf": csrf(browser, "/b/talk/new"), "title": "By form", "body": "x", "tags": "One, 二、three，One"}
    made = browser.post("/b/talk/new", data=form).headers["location"].removeprefix("/t/")
    assert board.client("op").get(f"/topics/{made}").json()["tags"] == ["one", "three", "二"]
    wrong = browser.post("/b/talk/new", data=form | {"tags": "a,b,c,d,e,f"})
    assert wrong.status_code == 422
    assert "at most 5 tags" in wrong.text
    assert 'value="a,b,c,d,e,f"' in wrong.text
    path = f"/t/{made}/tags"
    assert browser.post(path, data={"csrf": form["csrf"], "tags": "x" * 30}).status_code == 422
    assert browser.post(path, data={"csrf": "no", "tags": "y"}).status_code == 403
    assert browser.post(path, data={"csrf": form["csrf"], "tags": ""}).headers["location"] == f"/t/{made}"
    assert board.client("op").get(f"/topics/{made}").json()["tags"] == []
    assert board.browser("op").get(path).status_code == 403
    assert "/tags" in browser.get(f"/t/{made}").text
    assert browser.get("/tags/Other%20Case").headers["location"] == "/tags/other-case"
    assert browser.get("/tags/!!!").status_code == 404


def test_erasing_an_account_deletes_the_tags_of_its_topics(board: RunningBoard) -> None:
    board.add("leaver")
    topic(board, "leaver", tags=["private-matter"])
    board.run(erase_content(board.services, "admin", "leaver"))
    assert "private-matter" not in board.client("op").get("/tags").text


def test_erasing_an_account_deletes_its_read_positions(board: RunningBoard) -> None:
    board.add("forgetful")
    made = topic(board)
    board.client("forgetful").put(f"/topics/{made['id']}/read", json={}).raise_for_status()
    reads = select(func.count()).select_from(db.topic_reads).join(db.accounts).where(db.accounts.c.name == "forgetful")
    with local_admin.writing(board.settings) as connection:
        assert connection.execute(reads).scalar_one() == 1
    board.run(erase_content(board.services, "admin", "forgetful"))
    with local_admin.writing(board.settings) as connection:
        assert connection.execute(reads).scalar_one() == 0


# -------------------------------------------------------------------- unread posts
def badges(page: str) -> dict[str, tuple[str, str]]:
    """Return for each topic the text of its badge and the post to which it links."""
    rows = re.findall(r'class="row-title" href="/t/(\d+)".*?</li>', page, re.DOTALL)
    parts = page.split('class="row-title" href="/t/')[1:]
    found = {n: re.search(r'class="count" href="/p/(\d+)">([^<]*)', part) for n, part in zip(rows, parts, strict=True)}
    return {n: (m[2], m[1]) for n, m in found.items() if m}


def test_posts_of_others_are_unread_until_shown(board: RunningBoard) -> None:
    old = topic(board)
    board.add("reader")
    browser = board.browser("reader")
    assert badges(browser.get("/").text) == {}, "what was there before counts as read"
    made = topic(board, title="New to the reader")
    first = reply(board, old, "member")
    reply(board, old, "op")
    reply(board, old, "reader", "their own is not new to them")
    seen = badges(browser.get("/b/talk").text)
    assert (seen[old["id"]], seen[made["id"]][0]) == (("2 new", first), "1 new")
    assert listed_topics(browser.get("/unread").text) == [old["id"], made["id"]]
    page = browser.get(f"/t/{old['id']}").text
    assert f'<strong>2 new</strong> for you: <a href="#post-{first}">' in page
    assert "for you" not in browser.get(f"/t/{old['id']}").text
    assert listed_topics(browser.get("/unread").text) == [made["id"]]
    reply(board, old, "op")
    assert badges(browser.get("/").text)[old["id"]][0] == "1 new"
    assert badges(board.browser("op").get("/b/talk").text).keys() != badges(browser.get("/b/talk").text).keys()


def test_a_long_topic_is_unread_from_the_read_position_on(board: RunningBoard, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(topics, "POSTS", 4)
    monkeypatch.setattr(pages_posts, "POSTS", 4)
    board.add("slow-reader")
    made = topic(board)
    posts = [reply(board, made, body=str(n)) for n in range(6)]
    browser = board.browser("slow-reader")
    browser.get(f"/t/{made['id']}")  # the first 4
    assert badges(browser.get("/").text)[made["id"]] == ("3 new", posts[3])
    page = browser.get(f"/t/{made['id']}").text
    assert f'<a href="/p/{posts[3]}">first unread' in page
    there = browser.get(f"/p/{posts[3]}").headers["location"]
    browser.get(there.partition("#")[0])
    assert made["id"] not in badges(browser.get("/").text)


def test_live_posts_count_as_read_and_removed_ones_are_never_unread(board: RunningBoard) -> None:
    board.add("watcher")
    made, browser = topic(board), board.browser("watcher")
    browser.get(f"/t/{made['id']}")
    post = reply(board, made)
    assert badges(browser.get("/").text)[made["id"]] == ("1 new", post)
    assert browser.get(f"/p/{post}/fragment").status_code == 200
    assert made["id"] in badges(browser.get("/").text), "a page that does not show it at its end"
    browser.get(f"/p/{post}/fragment", params={"seen": "1"})
    assert made["id"] not in badges(browser.get("/").text)
    gone = reply(board, made)
    board.client("op").delete(f"/posts/{gone}").raise_for_status()
    assert made["id"] not in badges(browser.get("/").text)


def test_mark_all_as_read_never_moves_read_positions_back(board: RunningBoard) -> None:
    board.add("busy")
    made, browser = topic(board), board.browser("busy")
    page = browser.get("/unread").text
    up_to = re.search(r'name="up_to" value="(\d+)"', page)
    assert up_to
    form = {"csrf": csrf(browser, "/unread"), "up_to": up_to[1]}
    assert browser.post("/unread/all-read", data=form | {"csrf": "x"}).status_code == 403
    later = reply(board, made)
    assert browser.post("/unread/all-read", data=form).headers["location"] == "/unread"
    assert badges(browser.get("/unread").text) == {made["id"]: ("1 new", later)}, "what came after the page was made"
    browser.post("/unread/all-read", data=form | {"up_to": "0"})
    assert len(badges(browser.get("/unread").text)) == 1
    browser.post("/unread/all-read", data=form | {"up_to": "9" * 18})
    assert listed_topics(browser.get("/unread").text) == []
    reply(board, made)
    assert len(badges(browser.get("/unread").text)) == 1, "a number of the future hides nothing"


def test_unread_posts_on_an_unreadable_board_are_not_listed(board: RunningBoard) -> None:
    where = new_board(board, "closed-news", read_role="admin", post_role="admin")
    board.add("outsider")
    topic_on(board, where, "hushed")
    page = board.browser("outsider").get("/unread").text
    assert listed_topics(page) == []
    assert board.client().get("/../unread").status_code in (303, 401, 404)


def stored_positions(board: RunningBoard) -> int:
    engine = open_engine(board.settings, writes=False)
    with engine.connect() as connection:
        found = connection.execute(select(func.count()).select_from(db.topic_reads)).scalar_one()
    engine.dispose()
    return int(found)


@pytest.fixture
def no_periodic_writes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Disable the periodic writing of read positions."""
    monkeypatch.setattr(unread, "WRITE_EVERY_S", 3600.0)


def test_reading_writes_nothing_at_once_and_positions_survive_a_restart(
    no_periodic_writes: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with running_board(tmp_path) as board:
        board.add("silent")
        browser, known = board.browser("silent"), board.services
        made = [topic(board) for _ in range(4)]
        jobs, do = list[str](), known.store.do

        async def counted(job: Any) -> Any:
            jobs.append(job.__qualname__)
            return await do(job)

        monkeypatch.setattr(known.store, "do", counted)
        for one in made[:3] * 3:
            assert browser.get(f"/t/{one['id']}").status_code == 200
        assert (jobs, stored_positions(board)) == ([], 0)
        board.run(known.marks.write(known.store))
        board.run(known.marks.write(known.store))
        assert (len(jobs), stored_positions(board)) == (1, 3)
        browser.get(f"/t/{made[3]['id']}")
    with running_board(tmp_path) as board:
        assert listed_topics(board.browser("silent").get("/unread").text) == [], "the last one was written at the end"


def test_read_positions_that_cannot_be_written_are_retried(
    no_periodic_writes: None, fresh_board: Callable[..., RunningBoard], monkeypatch: pytest.MonkeyPatch
) -> None:
    board = fresh_board()
    board.add("patient")
    browser, known = board.browser("patient"), board.services
    browser.get(f"/t/{topic(board)['id']}")

    async def refused(_: Any) -> None:
        raise BoardError(503, "busy", "the database is busy")

    with monkeypatch.context() as patch:
        patch.setattr(known.store, "do", refused)
        board.run(known.marks.write(known.store))
    assert stored_positions(board) == 0
    board.run(known.marks.write(known.store))
    assert stored_positions(board) == 1


def test_read_positions_are_written_periodically(
    fresh_board: Callable[..., RunningBoard], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(unread, "WRITE_EVERY_S", 0.02)
    board = fresh_board()
    board.add("early")
    board.browser("early").get(f"/t/{topic(board)['id']}")
    wait_for(lambda: stored_positions(board) == 1)


# -------------------------------------------------------------------- the database
def test_posts_from_before_the_migration_count_as_read(tmp_path: Path) -> None:
    with running_board(tmp_path) as board:
        made = topic(board, tags=["kept-not"])
    with local_admin.writing(board.settings) as connection:
        connection.execute(text("UPDATE accounts SET read_up_to = 0"))
    migrate(board.settings, "0003_pages")
    migrate(board.settings)
    with local_admin.writing(board.settings) as connection:
        assert connection.execute(text("SELECT min(read_up_to) FROM accounts")).scalar_one() == 1
        assert connection.execute(text("SELECT count(*) FROM topic_tags")).scalar_one() == 0
    with running_board(tmp_path, database=board.settings.database) as again:
        assert again.client("op").get(f"/topics/{made['id']}").json()["tags"] == []
