"""Search, latest posts, notifications and feeds: they list the right posts and never hidden ones."""

from __future__ import annotations

import threading
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed

import pytest
from sqlalchemy import text

from agentrob.board.admin.moderation import erase_content
from agentrob.board.content.store import MAX_SEARCHES
from agentrob.board.db.database import open_engine
from agentrob.board.db.fulltext import create_index, drop_index, expression, indexed
from agentrob.board.db.records import StoredPost
from agentrob.board.search import search
from agentrob.board.search.search import terms
from agentrob.model import Page, Role
from tests.board.running_board import LIMIT_S, RunningBoard
from tests.board.web.forum_site import Site, running_site

ATOM = "{http://www.w3.org/2005/Atom}"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        yield site


def topic(site: Site, title: str, body: str, board: str = "talk", by: str = "alice") -> tuple[str, str]:
    made = site.api(by).post("/topics", json={"board_id": board, "title": title, "body": body}).json()
    return made["topic"]["id"], made["post"]["id"]


def found(site: Site, query: str, by: str = "bob") -> list[str]:
    page = site.browser(by).client.get("/search", params={"q": query}).text
    return [part.split('"')[0] for part in page.split('class="row-title" href="/p/')[1:]]


# -------------------------------------------------------------------- search
def test_chinese_of_one_two_and_more_characters_is_found(site: Site) -> None:
    _, post = topic(site, "记录", "机器人向前走了两米，然后挥手。")
    for query in ("手", "机器", "前走", "两米", "向前走了两米", "机器人", "记录", "两米 挥手"):
        assert post in found(site, query), query
    for query in ("器机", "前米", "两米机器", '"手 挥"', "鲸"):
        assert post not in found(site, query), query


def test_chinese_mixed_with_letters_and_digits_is_found(site: Site) -> None:
    _, post = topic(site, "n", "请让go2机器狗前进2米然后转90度，再后退3米。")
    for query in ("前进2米", "go2机", "go2机器狗", "前进2米然后转90", "转90度", "后退3米", "进2", "退3米。", '"2米然"'):
        assert post in found(site, query), query
    for query in ("前进3米", "前2米", "go2狗", "2然", "90米", "前进2米后"):
        assert post not in found(site, query), query


def test_search_ignores_case_accents_and_word_endings(site: Site) -> None:
    _, post = topic(site, "Zebra crossing", "The café's robot WALKED past 13 tulips at 2.5 m")
    for query in ("zebra", "Cafe", "walks", "tulip", "zebra tulips", '"past 13"', "2.5", "ｗａｌｋｅｄ"):
        assert post in found(site, query), query
    assert post not in found(site, "zebra giraffe")
    assert post not in found(site, '"13 past"')


@pytest.mark.parametrize(
    "query", ['"', "AND", "NEAR(", "a* OR b", "words:x", "^x", "-", "'; DROP TABLE posts", "😀", "*" * 199]
)
def test_an_invalid_query_is_answered_with_a_page(site: Site, query: str) -> None:
    assert site.browser("bob").client.get("/search", params={"q": query}).status_code == 200


def test_phrases_are_found_anywhere_in_a_post(site: Site) -> None:
    _, post = topic(site, "Long", " ".join(f"word{n} 第{n}次前进" for n in range(2000)) + " the very last words")
    for query in ('"very last words"', '"word1998 第1998次"', "1999次前进", f"last {'word1997'}"):
        assert post in found(site, query), query
    for query in ('"words very last"', '"word1998 第1997次"', "前进次", f"last {'x' * 150}"):
        assert post not in found(site, query), query


def test_very_long_words_are_indexed_and_found(site: Site) -> None:
    long, overflow_px = "abcdefghij" * 18, "x" * 5000
    _, post = topic(site, "n", f"see {long} and {overflow_px} here")
    for query in (long, f'"see {long} and"', "here"):
        assert post in found(site, query), query


def test_the_index_follows_edits_and_removals(site: Site) -> None:
    _, post = topic(site, "Heron", "an ostrich")
    site.api("alice").patch(f"/posts/{post}", json={"body": "a pelican"}).raise_for_status()
    assert found(site, "ostrich") == []
    assert found(site, "pelican") == found(site, "heron") == [post]
    site.api("alice").delete(f"/posts/{post}").raise_for_status()
    assert found(site, "pelican") == []


def test_results_are_newest_first_and_paging_continues_where_the_last_page_ended(site: Site) -> None:
    posts = [topic(site, "n", f"quokka number {n}")[1] for n in range(23)]
    browser = site.browser("bob")
    assert found(site, "quokka") == posts[:2:-1]
    page = browser.get("/search?q=quokka").text
    older = page.split('rel="next" href="')[1].split('"')[0].replace("&amp;", "&")
    rest = browser.get(older).text
    assert [p.split('"')[0] for p in rest.split('class="row-title" href="/p/')[1:]] == posts[2::-1]


def test_posts_on_unreadable_boards_are_not_in_search_notifications_or_feeds(site: Site) -> None:
    staff = {"id": "staff", "name": "Staff", "read_role": "operator", "post_role": "operator"}
    made = site.admin_api().post("/admin/boards", json=staff)
    assert made.status_code < 300, made.text
    _, post = topic(site, "Secret narwhal", "@bob a narwhal", board="staff")
    assert post in found(site, "narwhal", by="alice")
    bob = site.browser("bob")
    assert found(site, "narwhal") == []
    for words, here in (("narwhal", "staff"), ("narwhal", "nowhere"), ("narwhal", "talk")):
        answer = site.api("bob").get("/search", params={"q": words, "board_id": here})
        assert (answer.status_code, answer.json()["items"]) == (200, []), here
    for path in ("/latest", "/notifications", "/feed.atom", "/u/alice"):
        assert "narwhal" not in bob.get(path).text, path
    assert bob.get("/b/staff/feed.atom").status_code == 404
    assert bob.get(f"/c/{post}").status_code == 404
    assert bob.client.get("/notifications/count").text.strip() == "Notifications"


def test_erased_posts_leave_nothing_in_the_index(site: Site) -> None:
    site.board.add("carol")
    _, post = topic(site, "Axolotl", "an axolotl", by="carol")
    site.board.run(erase_content(site.board.services, "root", "carol"))
    assert found(site, "axolotl", by="root") == []
    engine = open_engine(site.settings, writes=False)
    with engine.connect() as connection:
        column = "rowid" if engine.dialect.name == "sqlite" else "post_id"
        left = connection.execute(text(f"SELECT count(*) FROM post_words WHERE {column} = :id"), {"id": int(post)})
        assert left.scalar_one() == 0
    engine.dispose()


def test_posts_from_before_the_migration_are_indexed(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    body = {"board_id": "talk", "title": "Okapi", "body": "两米"}
    board.client("op").post("/topics", json=body).raise_for_status()
    engine = open_engine(board.settings, writes=True)
    with engine.begin() as connection:
        drop_index(connection)
        create_index(connection)
    engine.dispose()
    browser = board.browser("op")
    for query in ("两米", "okapi"):
        assert "Okapi" in browser.get("/search", params={"q": query}).text
    assert "<mark>两米</mark>" in browser.get("/search", params={"q": "两米"}).text


@pytest.mark.sqlite
def test_a_slow_search_is_aborted_with_advice_on_the_page(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    topic(site, "Lemur", "a lemur")
    monkeypatch.setattr(search, "MOST_S", -1.0)
    monkeypatch.setattr(search, "STEPS", 1)
    answer = site.browser("bob").client.get("/search", params={"q": "lemur"})
    assert answer.status_code == 503
    assert "Add a rarer word" in answer.text
    assert 'value="lemur"' in answer.text
    refused = site.api("bob").get("/search", params={"q": "lemur"})
    assert (refused.status_code, refused.json()["code"]) == (503, "too_broad")
    monkeypatch.undo()
    assert found(site, "lemur")


def test_law_15_nothing_waits_for_a_search_above_all_no_stop(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, go_on = threading.Event(), threading.Event()

    def slow(*_: object) -> Page[StoredPost]:
        begun.set()
        assert go_on.wait(LIMIT_S)
        return Page(())

    monkeypatch.setattr(search, "find", slow)
    with ThreadPoolExecutor(MAX_SEARCHES + 1) as others:
        searching = [others.submit(site.api("bob").get, "/search", params={"q": "x"}) for _ in range(MAX_SEARCHES + 1)]
        assert begun.wait(LIMIT_S)
        assert site.api("bob").post("/robots/quadruped/stop").status_code < 300
        refused = next(as_completed(searching, LIMIT_S)).result()
        assert (refused.status_code, refused.json()["code"]) == (503, "overloaded")
        go_on.set()
        assert sorted(s.result(LIMIT_S).status_code for s in searching) == [200] * MAX_SEARCHES + [503]


def test_search_over_the_api_is_paged(site: Site) -> None:
    _, first = topic(site, "n", "an aardvark 土豚")
    _, second = topic(site, "n", "two aardvarks 土豚")
    bob = site.api("bob")
    page = bob.get("/search", params={"q": "aardvark 土豚", "limit": 1}).json()
    assert [p["id"] for p in page["items"]] == [second]
    page = bob.get("/search", params={"q": "aardvark 土豚", "limit": 1, "cursor": page["next"]}).json()
    assert ([p["id"] for p in page["items"]], page["next"]) == ([first], None)
    assert bob.get("/search", params={"q": "x" * 201}).status_code == 422
    assert site.board.client().get("/search", params={"q": "aardvark"}).status_code == 401


def test_every_character_of_a_chinese_run_can_be_found() -> None:
    words, chars = indexed("走路go走")
    assert (words.split(), chars.split()) == (["走路", "路", "go", "走"], ["走", "路"])
    assert expression(terms("路")) == 'chars : "路"'
    assert expression(terms("走路 go")) == 'words : "走路" AND words : "go"'
    assert expression(terms("走路2米")) == 'words : "走路 路 2 米" *'


# -------------------------------------------------------------------- notifications
def count(site: Site, name: str) -> str:
    return site.browser(name).get("/notifications/count").text


def test_mentions_replies_and_posts_in_own_topics_notify_once(site: Site) -> None:
    site.board.add("dora", role=Role.OPERATOR)
    site.board.add("emil")
    number, first = topic(site, "Mine", "hello", by="dora")
    emil = site.api("emil")
    emil.post(f"/topics/{number}/posts", json={"body": "in your topic"}).raise_for_status()
    emil.post(f"/topics/{number}/posts", json={"body": "an answer", "reply_to": first}).raise_for_status()
    emil.post(f"/topics/{number}/posts", json={"body": "@dora you", "reply_to": first}).raise_for_status()
    emil.post(f"/topics/{number}/posts", json={"body": "`@dora` as code"}).raise_for_status()
    page = site.browser("dora").get("/notifications").text
    assert page.count("mentions you") == 1
    assert page.count("replies to you") == 1
    assert page.count("is in your topic") == 2
    assert "4<span" in count(site, "dora")
    assert "new" not in count(site, "emil")


def test_seen_notifications_are_no_longer_counted(site: Site) -> None:
    site.board.add("fritz")
    number, _ = topic(site, "T", "@fritz look")
    visitor = site.browser("fritz")
    assert "1<span" in visitor.get("/notifications/count").text
    assert visitor.send("/notifications/seen", page="/notifications").status_code == 200
    assert visitor.get("/notifications/count").text.strip() == "Notifications"
    csrf = visitor.csrf(f"/t/{number}")
    visitor.client.post("/notifications/seen", data={"csrf": csrf, "up_to": "0"})
    assert visitor.get("/notifications/count").text.strip() == "Notifications"
    visitor.client.post("/notifications/seen", data={"csrf": csrf, "up_to": "9" * 18})
    site.api("alice").post(f"/topics/{number}/posts", json={"body": "@fritz again"}).raise_for_status()
    assert "1<span" in visitor.get("/notifications/count").text, "a number of the future hides nothing"


def test_marking_notifications_as_seen_requires_the_owners_csrf_token(site: Site) -> None:
    visitor = site.browser("alice")
    assert visitor.client.post("/notifications/seen", data={"up_to": "9"}).status_code == 403
    assert site.browser().client.get("/notifications").url.path == "/sign-in"


# -------------------------------------------------------------------- feeds
def test_feeds_of_site_board_topic_and_robot_are_atom(site: Site) -> None:
    number, post = topic(site, "Feed & <b>", "one **two** \x0b three", board="robots")
    site.api("quadruped").post(f"/topics/{number}/posts", json={"body": "robots answer"}).raise_for_status()
    browser = site.browser("bob").client
    for path in ("/feed.atom", "/b/robots/feed.atom", f"/t/{number}/feed.atom", "/robots/quadruped/feed.atom"):
        answer = browser.get(path)
        assert answer.headers["content-type"].startswith("application/atom+xml")
        feed = ET.fromstring(answer.content)
        titles = [entry.findtext(f"{ATOM}title") for entry in feed.iter(f"{ATOM}entry")]
        assert "Feed & <b>" in titles, path
        assert feed.findtext(f"{ATOM}updated")
    entries = {
        e.findtext(f"{ATOM}id"): e for e in ET.fromstring(browser.get("/feed.atom").content).iter(f"{ATOM}entry")
    }
    entry = entries[f"{site.base}/p/{post}"]
    assert "<strong>two</strong>" in (entry.findtext(f"{ATOM}content") or "")
    assert entry.find(f"{ATOM}author/{ATOM}name").text == "alice"  # type: ignore[union-attr]
    topic_feed = ET.fromstring(browser.get(f"/t/{number}/feed.atom").content)
    assert len(list(topic_feed.iter(f"{ATOM}entry"))) == 2


def test_a_feed_requires_a_token_or_session(site: Site) -> None:
    token = {"Authorization": f"Bearer {site.board.tokens['bob']}"}
    assert site.board.browser().get("/feed.atom", headers=token).status_code == 200
    assert site.board.browser().get("/feed.atom").status_code == 303


def test_latest_shows_posts_newest_first(site: Site) -> None:
    _, old = topic(site, "Older", "x")
    _, new = topic(site, "Newer", "y")
    page = site.browser("bob").get("/latest").text
    assert page.index(f'href="/p/{new}"') < page.index(f'href="/p/{old}"')
