"""A post that addresses no robot, or one that is offline, gets one line of help, in the preview and after posting."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.board.web.forum_site import CARD, Site, running_site


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("reach")) as made:
        card = {**CARD, "boards": ["robots"]}
        made.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
        yield made


def hint_on(page: str) -> str:
    """Return the line of help on a page, or an empty string."""
    found = re.search(r'<p class="(?:note|reading)"[^>]*dir="auto">(.*?)</p>', page)
    return found[1].replace("&#39;", "'") if found else ""


LINES = {
    "@quadrupd walk forward 1 metre": "There is no account @quadrupd. Did you mean @quadruped?",
    "@zebra walk forward 1 metre": "There is no account @zebra. Robots here: @quadruped.",
    "wave": "No robot is mentioned, so none answers. Mention one, for example: @quadruped wave",
    "quadruped walk forward 1 metre": "No robot is mentioned, so none answers.",
    "quadruped, are you there?": "No robot is mentioned, so none answers.",
    "向前走一米": "No robot is mentioned, so none answers.",
    "@quadruped walk forward 1 metre": "",
    "@alice look at this": "",
    "What a nice robot.": "",
    "stop": "",
}


@pytest.mark.parametrize(("text", "line"), LINES.items())
def test_the_author_is_told_before_posting_and_after(site: Site, text: str, line: str) -> None:
    alice = site.browser("alice")
    shown = alice.send("/b/robots/new", title="A try", body=text, do="preview")
    assert hint_on(shown.text).startswith(line)
    assert bool(hint_on(shown.text)) is bool(line)
    posted = alice.send("/b/robots/new", title="A try", body=text)
    assert hint_on(posted.text).startswith(line)
    assert bool(hint_on(posted.text)) is bool(line)
    assert hint_on(site.browser("bob").get(posted.url.path).text) == "", "only its author is told"


def test_a_board_without_robots_says_so_on_the_page_and_in_the_preview(site: Site) -> None:
    alice = site.browser("alice")
    assert "No robot acts on this board." in alice.get("/b/talk/new").text
    assert "No robot acts on this board." not in alice.get("/b/robots/new").text
    shown = alice.send("/b/talk/new", title="A try", body="@quadruped walk forward 1 metre", do="preview")
    assert hint_on(shown.text) == "@quadruped does not act on this board (talk): it acts on robots."
    shown = alice.send("/b/talk/new", title="A try", body="walk forward 1 metre", do="preview")
    assert hint_on(shown.text) == "No robot acts on this board."


def test_the_author_is_told_when_the_agent_is_offline(tmp_path: Path) -> None:
    with running_site(tmp_path) as site:
        shown = site.browser("alice").send("/b/robots/new", title="A try", body="@quadruped wave", do="preview")
        assert hint_on(shown.text).startswith("@quadruped is not connected now, so it does not answer.")


def test_the_examples_of_a_board_are_what_its_robot_can_do(tmp_path: Path) -> None:
    with running_site(tmp_path) as site:
        card = {**CARD, "boards": ["robots"], "ops": ["photo", "hello"], "move_directions": []}
        site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
        alice = site.browser("alice")
        for path in ("/b/robots", "/b/robots/new"):
            page = alice.get(path).text
            assert "<code>@quadruped wave</code>" in page
            assert "walk forward" not in page
