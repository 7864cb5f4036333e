"""Robots in several rooms: home shows one of the rooms and links the others, a thread shows the room of its robots."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from agentrob.model import AccountKind
from tests.board.web.forum_site import CARD, Site, running_site

ROOMS = {"quadruped": "lab", "humanoid": "lab", "arm": "@arm"}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        for name, room in ROOMS.items():
            if name != "quadruped":
                site.board.add(name, kind=AccountKind.ROBOT_AGENT)
            card = CARD | {"boards": ["robots"], "map": {"room": room, "size_m": [4, 4], "pose": [0, 0, 0]}}
            site.api(name).put(f"/robots/{name}", json={"card": card}).raise_for_status()
        yield site


def shown(page: str) -> list[str]:
    """The rooms whose maps a page shows, as the robots in them."""
    return re.findall(r'data-live="[^"]*robots=([^"&]*)"', page)


@pytest.mark.parametrize(
    ("path", "rooms", "current"),
    [
        ("/", ["humanoid,quadruped"], "humanoid, quadruped"),
        ("/?room=%40arm", ["arm"], "arm"),
        ("/?room=lab", ["humanoid,quadruped"], "humanoid, quadruped"),
        ("/?room=nowhere", ["humanoid,quadruped"], "humanoid, quadruped"),
    ],
)
def test_home_shows_one_room_and_links_the_others(site: Site, path: str, rooms: list[str], current: str) -> None:
    page = site.browser("bob").get(path).text
    assert shown(page) == rooms
    links = re.search(r'<nav class="room-links".*?</nav>', page, re.DOTALL)
    assert links
    assert re.findall(r'href="([^"]*)"', links[0]) == ["/?room=lab", "/?room=%40arm"]
    assert re.findall(r'aria-current="true">([^<]*)<', links[0]) == [current]


def test_a_thread_shows_the_room_of_the_robots_that_it_names(site: Site) -> None:
    alice = site.api("alice")
    for body, room in (("@arm wave", "arm"), ("@humanoid wave", "humanoid,quadruped"), ("Hello", "humanoid,quadruped")):
        topic = alice.post("/topics", json={"board_id": "robots", "title": "A topic", "body": body}).json()["topic"]
        assert shown(site.browser("bob").get(f"/t/{topic['id']}").text) == [room]
