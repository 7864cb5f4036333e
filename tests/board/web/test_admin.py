"""Administration, robot settings and moderation with plain forms, without scripts."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from agentrob.board.admin import local_admin
from agentrob.board.auth import rights
from tests.board.web.forum_site import CARD, PASSWORD, Site, running_site

SECRET = re.compile(r'<textarea id="secret"[^>]*>([^<]*)</textarea>')


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=False) as site:
        yield site


def kept(site: Site) -> rights.RobotSettings:
    return rights.settings_of(site.board.services.store.everything, "quadruped")


def test_an_account_is_created_and_gets_a_password(site: Site) -> None:
    root = site.browser("root")
    page = root.send("/admin/accounts", name="newbie", display_name="New B.", role="operator", kind="human")
    link = SECRET.search(page.text)
    assert link
    assert page.headers["cache-control"] == "no-store"
    newbie = site.browser()
    path = link[1].removeprefix(site.base)
    assert newbie.send(path, password=PASSWORD).url.path == "/"
    assert "newbie" in newbie.get("/").text
    assert root.get("/admin/accounts/newbie").text.count("selected") == 1
    root.send("/admin/accounts/newbie/change", "/admin/accounts/newbie", role="member", display_name="", suspended="on")
    found = local_admin.find_account(site.settings, "newbie")
    assert (found.role, found.suspended) == ("member", True)


def test_errors_are_shown_on_the_page_and_keep_the_input(site: Site) -> None:
    root = site.browser("root")
    page = root.send("/admin/accounts", name="quadrup3d", display_name="Tidy", role="member", kind="human")
    assert page.status_code == 422
    assert "looks like the robot @quadruped" in page.text
    assert 'value="Tidy"' in page.text
    page = root.send("/admin/robots/quadruped", closed="sometimes", camera_days="0", camera_role="guest")
    assert page.status_code == 422
    assert "is not a valid maintenance window" in page.text
    assert ">sometimes</textarea>" in page.text


def test_a_token_is_shown_once_and_can_be_revoked(site: Site) -> None:
    root, page = site.browser("root"), "/admin/accounts/alice"
    shown = root.send(f"{page}/token", page, label="sensor", write="on")
    secret = SECRET.search(shown.text)
    assert secret
    account = root.get(page).text
    assert secret[1] not in account
    assert "sensor" in account
    token_id = re.findall(r'name="token" value="([0-9a-f]{16})"', account)[0]
    csrf = root.csrf(page)
    root.client.post(f"{page}/revoke", data={"csrf": csrf, "token": token_id})
    assert f'value="{token_id}"' not in root.get(page).text


def test_an_account_that_was_made_for_a_link_sets_its_first_password_itself(site: Site) -> None:
    site.admin_api().post("/admin/accounts", json={"name": "guest"}).raise_for_status()
    guest = site.browser("guest")
    assert "Set a password" in guest.get("/u/guest").text
    assert 'name="old"' not in guest.get("/password").text
    short = guest.send("/password", password="short")
    assert (short.status_code, 'name="old"' in short.text) == (422, False)
    elsewhere = site.browser("guest")
    assert guest.send("/password", password=PASSWORD).url.path == "/"
    assert "Change password" in guest.get("/u/guest").text
    assert elsewhere.get("/password").url.path == "/sign-in", "other sessions have ended"
    assert site.browser().send("/sign-in", name="guest", password=PASSWORD).url.path == "/"
    assert 'name="old"' in guest.get("/password").text
    assert guest.send("/password", password="another password").status_code == 401, (
        "the old one is asked for from now on"
    )


def test_boards_and_invites(site: Site) -> None:
    root = site.browser("root")
    fields = {"name": "The lab", "description": "", "read_role": "operator", "post_role": "operator"}
    root.send("/admin/boards", id="lab", command_role="operator", **fields)
    assert "The lab" in site.browser("alice").get("/").text
    assert "The lab" not in site.browser("bob").get("/").text
    shown = root.send("/admin/invites", role="member", uses="1", days="3")
    link = SECRET.search(shown.text)
    assert link
    path = link[1].removeprefix(site.base)
    assert site.browser().send(path, name="invited", password=PASSWORD).url.path == "/"
    late = site.browser()
    assert "was used up" in late.send(path, name="late", password=PASSWORD).text


def test_an_invite_for_simulated_robots(site: Site) -> None:
    root = site.browser("root")
    assert 'name="commands_simulated" checked' in root.get("/admin/invites?simulated=1").text
    assert 'name="commands_simulated">' in root.get("/admin/invites").text
    assert 'href="/admin/invites?simulated=1"' in root.get("/").text
    shown = root.send("/admin/invites", role="member", uses="1", days="3", commands_simulated="on")
    assert "who may command simulated robots" in shown.text
    assert "member, operator of simulated robots" in root.get("/admin/invites").text
    link = SECRET.search(shown.text)
    assert link
    guest = site.browser()
    home = guest.send(link[1].removeprefix(site.base), name="player", password=PASSWORD)
    assert "Your account may command simulated robots" in home.text
    assert "can command simulated robots" in guest.get("/u/player").text
    account = site.api("root").get("/accounts/player").json()
    assert (account["role"], account["commands_simulated"]) == ("member", True)
    root.send("/admin/accounts/player/change", "/admin/accounts/player", role="member", display_name="")
    assert site.api("root").get("/accounts/player").json()["commands_simulated"] is False


def test_a_room_is_reset_by_an_account_for_simulated_robots_only_if_the_robot_is_simulated(site: Site) -> None:
    admin_api, robot = site.admin_api(), site.api("quadruped")
    made = {"name": "tester", "role": "member"}
    admin_api.post("/admin/accounts", json=made).raise_for_status()
    admin_api.patch("/admin/accounts/tester", json={"commands_simulated": True}).raise_for_status()
    token = admin_api.post("/admin/accounts/tester/tokens", json={}).json()["token"]
    for simulated, status in ((True, 200), (False, 403)):
        robot.put("/robots/quadruped", json={"card": CARD | {"simulated": simulated}}).raise_for_status()
        sent = site.api("root").post("/robots/quadruped/reset", headers={"Authorization": f"Bearer {token}"})
        assert sent.status_code == status, sent.text


def test_only_the_owner_may_change_a_robots_rights(site: Site) -> None:
    root, path = site.browser("root"), "/admin/robots/quadruped"
    fields = {f"command_{c}": "operator" for c in ("photo", "gesture", "move")} | {"command_risky": "nobody"}
    fields |= {"approve": "moderator", "release": "owner", "camera_role": "member", "camera_days": "7"}
    root.send(path, owner="@alice", closed="mon-fri 22:00-06:00", **fields)
    assert (kept(site).owner, kept(site).camera_days, kept(site).command["risky"]) == ("alice", 7, "nobody")
    owner = site.browser("alice")
    owner.send(path, owner="bob", closed="", **fields)
    assert (kept(site).owner, kept(site).closed) == ("alice", ()), "the owner gives it to nobody"
    assert site.browser("bob").get(path).status_code == 403


def test_hiding_showing_locking_and_moving_by_forms(site: Site) -> None:
    made = site.api("alice").post("/topics", json={"board_id": "talk", "title": "A topic", "body": "rude words"}).json()
    topic, post = made["topic"]["id"], made["post"]["id"]
    root, bob = site.browser("root"), site.browser("bob")
    root.send(f"/p/{post}/moderate", reason="rude")
    assert "rude words" not in bob.get(f"/t/{topic}").text
    assert "rude words" in root.get(f"/p/{post}/moderate").text
    assert bob.get(f"/p/{post}/moderate").status_code == 403
    root.send(f"/p/{post}/moderate")
    assert "rude words" in bob.get(f"/t/{topic}").text
    root.send(f"/t/{topic}/lock", f"/t/{topic}/moderate", reason="late")
    assert "This topic is locked" in bob.get(f"/t/{topic}").text
    root.send(f"/t/{topic}/move", f"/t/{topic}/moderate", board="robots")
    assert "A topic" in bob.get("/b/robots").text
    log = root.get("/admin/audit").text
    assert all(word in log for word in ("post.hide", "post.show", "topic.lock", "topic.move", "rude"))


def test_erasing_requires_typing_the_name(site: Site) -> None:
    site.board.add("gone")
    site.api("gone").post("/topics", json={"board_id": "talk", "title": "Soon gone", "body": "b"}).raise_for_status()
    root, page = site.browser("root"), "/admin/accounts/gone"
    assert root.send(f"{page}/erase", page, sure="").status_code == 422
    assert "Soon gone" in root.get("/").text
    root.send(f"{page}/erase", page, sure="gone")
    assert "Soon gone" not in root.get("/").text
