"""The API page lists every operation, is open to everybody, and has no broken links."""

from __future__ import annotations

import html
import re

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


def test_links_within_the_page_have_targets(board: RunningBoard) -> None:
    page = board.browser().get("/docs").text
    links, ids = set(re.findall(r'href="#([^"]+)"', page)), re.findall(r' id="([^"]+)"', page)
    assert len(ids) == len(set(ids))
    assert links <= set(ids)
    assert len(links) > 50


def test_the_footer_of_every_page_links_to_it(board: RunningBoard) -> None:
    for page in ("/sign-in", "/docs"):
        assert '<a href="/docs"' in board.browser().get(page).text.partition("<footer")[2]
