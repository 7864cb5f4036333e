"""The API page lists every operation, is open to everybody, and has no broken links."""

from __future__ import annotations

import html
import re

from agentrob.board.web.templating import inline_code
from tests.board.running_board import RunningBoard


def test_the_page_lists_every_operation_and_schema(board: RunningBoard) -> None:
    page = html.unescape(board.browser().get("/docs").raise_for_status().text)
    document = board.client().get("/openapi.json").json()
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            assert f"<code>{method.upper()} {path}</code>" in page
            assert f'id="{operation["operationId"]}"' in page
    for name in document["components"]["schemas"]:
        assert f'id="schema-{name}"' in page


def test_each_operation_has_a_readable_title_of_its_own(board: RunningBoard) -> None:
    page = board.browser().get("/docs").text
    titles = re.findall(r'<h3 id="[a-z_]+">([^<]*)</h3>', page)
    assert {"Search posts", "Stop robot", "Get own account", "Approve command"} <= set(titles)
    assert len(titles) == len(set(titles))
    assert all(re.fullmatch(r"[A-Z][a-z]+( [a-z]+)+", title) for title in titles)
    document = board.client().get("/openapi.json").json()
    operations = [one for methods in document["paths"].values() for one in methods.values()]
    assert [one["summary"] for one in operations] == [
        one["operationId"].replace("_", " ").capitalize() for one in operations
    ]
    shown = re.sub(r"<[^>]*>", " ", page)
    assert not any(one["operationId"] in shown for one in operations)


def test_words_between_backticks_are_shown_as_code(board: RunningBoard) -> None:
    page = board.browser().get("/docs").text
    assert "<code>up_to</code> as in the unread page; <code>board_id</code> for one board only." in page
    assert "<td>Query: <code>next</code> of the previous page" in page
    assert "`" not in page
    assert str(inline_code("a `<b>` & `c")) == "a <code>&lt;b&gt;</code> &amp; `c"


def test_each_paragraph_of_a_description_is_a_paragraph(board: RunningBoard) -> None:
    page = board.browser().get("/docs").text
    assert "words in double quotes must be adjacent.</p><p>By meaning: posts that say" in page


def test_links_within_the_page_have_targets(board: RunningBoard) -> None:
    page = board.browser().get("/docs").text
    links, ids = set(re.findall(r'href="#([^"]+)"', page)), re.findall(r' id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert links <= set(ids)
    assert len(links) > 50


def test_the_footer_of_every_page_links_to_it(board: RunningBoard) -> None:
    for page in ("/sign-in", "/docs"):
        assert '<a href="/docs"' in board.browser().get(page).text.partition("<footer")[2]
