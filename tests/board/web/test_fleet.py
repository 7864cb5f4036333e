"""The page of all robots, for operators and admins."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.board.web.forum_site import CARD, Site, running_site

FLEET_CARD = CARD | {"worker": "lab-<1>", "version": "0.2.0", "lag_ms": 31, "failures": {"failed": 2}, "queue": 0}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=False) as site:
        yield site


def test_it_shows_who_serves_a_robot_and_what_failed(site: Site) -> None:
    alice = site.browser("alice")
    assert "not served" in alice.get("/fleet").text
    site.api("quadruped").put("/robots/quadruped", json={"card": FLEET_CARD}).raise_for_status()
    page = alice.get("/fleet").text
    assert "not served" not in page
    assert "lab-&lt;1&gt;" in page
    assert "31&nbsp;ms" in page
    assert "2&nbsp;failed" in page
    assert "<html" not in alice.get("/fleet?part=table").text


def test_a_malformed_card_shows_as_unknown(site: Site) -> None:
    card = {"worker": 3, "failures": [1], "lag_ms": "fast", "queue": -1, "stop_at": "yesterday"}
    site.api("quadruped").put("/robots/quadruped", json={"card": card}).raise_for_status()
    assert site.browser("alice").get("/fleet").status_code == 200


def test_it_is_for_operators_and_admins_and_linked_for_them(site: Site) -> None:
    assert site.browser("bob").get("/fleet").status_code == 403
    assert 'href="/fleet"' not in site.browser("bob").get("/").text
    assert 'href="/fleet"' in site.browser("alice").get("/").text
    assert 'href="/fleet"' in site.browser("root").get("/admin/accounts").text
    assert site.browser().get("/fleet").url.path == "/sign-in"
