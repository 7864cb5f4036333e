"""Another site, a forged file or a crafted address cannot make a browser or this server do anything."""

from __future__ import annotations

import io
import re
import socket
import struct
import zlib
from collections.abc import Iterator
from typing import Any
from urllib.parse import quote

import httpx2
import pytest
from PIL import Image

from agentrob.board import access
from agentrob.board.admin import local_admin
from agentrob.board.auth import attempts
from agentrob.board.auth.attempts import PER_NAME
from agentrob.errors import BoardError
from tests.board.auth.test_rights import jpeg
from tests.board.web.forum_site import PASSWORD, Site, running_site

FORM = re.compile(r'<form[^>]*method="post"[^>]*action="([^"]*)"')


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True) as site:
        yield site


def everything(site: Site) -> list[tuple[str, str]]:
    """Return every form on every page that an admin sees, as the page and the form's action."""
    api = site.api("root")
    made = api.post("/topics", json={"board_id": "robots", "title": "t", "body": "b"}).json()
    topic, post = made["topic"]["id"], made["post"]["id"]
    invite = site.board.services.settings.base_url and "/invite/" + "x" * 43
    pages = ["/", "/b/robots", "/b/robots/new", f"/t/{topic}", f"/t/{topic}/moderate", f"/p/{post}/edit"]
    pages += [
        f"/p/{post}/remove",
        f"/p/{post}/moderate",
        "/robots",
        "/robots/quadruped",
        "/u/root",
        "/password",
        invite,
    ]
    pages += ["/password/" + "x" * 43, "/enter/" + "x" * 43]
    pages += [f"/admin/{page}" for page in ("accounts", "accounts/bob", "boards", "robots/quadruped", "invites")]
    browser = site.browser("root")
    found = [(page, action) for page in pages for action in set(FORM.findall(browser.get(page).text))]
    anybody = site.browser()
    return found + [
        (page, action) for page in ("/sign-in", "/sign-up") for action in FORM.findall(anybody.get(page).text)
    ]


def test_every_form_requires_a_csrf_token_and_the_same_origin(site: Site) -> None:
    forms = everything(site)
    assert len(forms) > 25
    browser, other = site.browser("root"), site.browser("bob")
    mine, theirs = browser.csrf("/u/root"), other.csrf("/u/bob")
    newest = site.api("root").get("/changes").json()["now"]["id"]
    rows = _audit_rows(site)
    for _, action in forms:
        for token in (None, "", theirs):
            sent = {"csrf": token} if token is not None else {}
            answer = browser.client.post(action, data=sent | {"body": "x", "title": "x"}, follow_redirects=False)
            assert answer.status_code == 403, (action, token, answer.status_code)
        for header in ({"Origin": "https://evil.example"}, {"Sec-Fetch-Site": "cross-site"}):
            answer = browser.client.post(action, data={"csrf": mine}, headers=header, follow_redirects=False)
            assert answer.status_code == 403, (action, header)
        token = {"Authorization": f"Bearer {site.board.tokens['root']}"}
        for csrf in ("", mine):
            assert httpx2.post(site.base + action, data={"csrf": csrf}, headers=token, timeout=60).status_code == 403, (
                action
            )
    assert site.api("root").get("/changes").json()["now"]["id"] == newest, "nothing happened"
    assert _audit_rows(site) == rows


def _audit_rows(site: Site) -> int:
    from agentrob.board.db import audit

    with local_admin.writing(site.settings) as connection:
        return len(connection.execute(audit.statement(None, 10_000)).all())


# -------------------------------------------------------------------- sessions
def test_signing_in_replaces_a_session_id_chosen_by_an_attacker(site: Site) -> None:
    chosen = "A" * 43
    browser, name = site.browser(), site.settings.cookie
    browser.client.cookies.set(name, chosen, domain="127.0.0.1")
    browser.send("/sign-in", name="bob", password=PASSWORD)
    assert browser.client.get("/api/v1/me").json()["name"] == "bob"
    assert chosen not in [c.value for c in browser.client.cookies.jar if c.path == "/"]
    thief = httpx2.Client(base_url=site.base, cookies={name: chosen}, timeout=60)
    assert thief.get("/api/v1/me").status_code == 401


def test_signing_out_invalidates_the_session_on_the_server(site: Site) -> None:
    browser, name = site.browser("bob"), site.settings.cookie
    (secret,) = {str(c.value) for c in browser.client.cookies.jar if c.name == name}
    browser.send("/sign-out", "/u/bob")
    assert httpx2.get(site.base + "/api/v1/me", cookies={name: secret}, timeout=60).status_code == 401


def test_password_guesses_are_limited_for_signed_in_accounts_too(site: Site) -> None:
    site.board.add("guessed", password=PASSWORD)
    browser = site.browser("guessed")
    with local_admin.writing(site.settings) as connection:
        for _ in range(PER_NAME - 1):
            attempts.record(connection, "guessed", "127.0.0.1")
    tries = [browser.send("/password", old="wrong words", password="another password") for _ in range(2)]
    assert [t.status_code for t in tries] == [401, 429]
    with pytest.raises(BoardError) as caught:
        site.board.run(access.sign_in(site.board.services, "guessed", PASSWORD, "127.0.0.1"))
    assert caught.value.status == 429
    assert site.board.run(access.sign_in(site.board.services, "guessed", PASSWORD, "10.0.0.9")), "not elsewhere"


def test_tokens_are_limited_to_their_scopes_and_a_revoked_one_is_refused(site: Site) -> None:
    account = local_admin.find_account(site.settings, "root")
    made = {
        s: local_admin.issue_token(site.settings, account, s, s.split("+")) for s in ("read", "write", "read+admin")
    }
    ask = lambda token, method, path, **more: httpx2.request(  # noqa: E731
        method, f"{site.base}/api/v1{path}", headers={"Authorization": f"Bearer {token}"}, **more, timeout=60
    )
    topic = {"board_id": "talk", "title": "t", "body": "b"}
    assert [ask(t, "POST", "/topics", json=topic).status_code for t in made.values()] == [403, 201, 403]
    assert [ask(t, "GET", "/admin/accounts").status_code for t in made.values()] == [403, 403, 200]
    assert [ask(t, "POST", "/robots/quadruped/stop").status_code for t in made.values()] == [200] * 3, "law 15"
    token_id = next(t for t in ask(made["read+admin"], "GET", "/admin/accounts/root/tokens").json()["items"]
                    if t["label"] == "write")["id"]  # fmt: skip
    assert ask(made["read+admin"], "DELETE", f"/admin/tokens/{token_id}").status_code == 204
    assert ask(made["write"], "GET", "/me").status_code == 401
    assert ask(made["read"], "GET", "/me").status_code == 200
    assert not [t for t in made.values() if t in ask(made["read+admin"], "GET", "/admin/audit?limit=100").text]


# -------------------------------------------------------------------- addresses
ELSEWHERE = [
    *("https://evil.example", "//evil.example", "/\\evil.example", "\\\\evil.example", "javascript:alert(1)"),
    *("/%0d%0aSet-Cookie:x=1", "/\r\nSet-Cookie: x=1", "/\t/evil.example", "///evil.example", "http:evil.example"),
    *("/@evil.example\u2028", "data:text/html,x", " //evil.example", "/ /evil.example"),
]


@pytest.mark.parametrize("where", ELSEWHERE)
def test_no_url_redirects_to_another_site_or_injects_a_header(site: Site, where: str) -> None:
    signed_in, client = site.browser("bob"), httpx2.Client(base_url=site.base, timeout=60)
    csrf = signed_in.csrf("/u/bob")
    answers = [signed_in.client.get("/sign-in", params={"next": where}, follow_redirects=False)]
    form = {"csrf": csrf, "back": where}
    answers.append(signed_in.client.post("/robots/quadruped/stop", data=form, follow_redirects=False))
    answers.append(client.get("/" + quote(where.lstrip("/"), safe="%"), follow_redirects=False))
    for answer in answers:
        location = answer.headers.get("location", "/")
        assert re.match(r"/(?![/\\])", location) or location == "/", location
        assert "x" not in answer.cookies
        assert not re.search(r"[\r\n]", location)


@pytest.mark.parametrize(
    "path",
    ["/static/x/../../schema.py", "/static/..%2f..%2f/board.css", "/images/..%2f..%2fetc%2fpasswd", "/images/%2e%2e",
     "/images/1%00.jpg", "/robots/..%2fadmin", "/p/..%2f..%2f1/raw", "/api/v1/posts/..%2fme", "/u/..%2f..%2fetc",
     "/static/x/%2e%2e%2f%2e%2e%2fserver.py", "/api/v1/robots/a%2fb/frame.jpg", "/t/9999999999999999999999"],
)  # fmt: skip
def test_crafted_paths_reach_no_file(site: Site, path: str) -> None:
    with socket.create_connection(("127.0.0.1", site.settings.port)) as raw:  # a client would normalise the path
        cookie = "; ".join(f"{c.name}={c.value}" for c in site.browser("bob").client.cookies.jar)
        head = f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nCookie: {cookie}\r\nConnection: close\r\n\r\n"
        raw.sendall(head.encode())
        answer = b"".join(iter(lambda: raw.recv(65536), b""))
    assert answer.split(b" ")[1] in (b"404", b"400", b"403", b"422", b"303"), answer[:200]
    assert b"root:" not in answer
    assert b"import" not in answer


def test_links_in_posts_cause_no_requests_by_the_server(site: Site) -> None:
    with socket.create_server(("127.0.0.1", 0)) as trap:
        trap.setblocking(False)
        bait = f"http://127.0.0.1:{trap.getsockname()[1]}/x.png"
        body = f"{bait} [x]({bait}) ![x]({bait}) <img src={bait}> <{bait}>\n\n[y]: {bait}\n\n![z][y] @quadruped"
        made = site.api("alice").post("/topics", json={"board_id": "talk", "title": bait, "body": body}).json()
        browser = site.browser("bob")
        for page in ("/", "/b/talk", made["topic"]["url"], f"/p/{made['post']['id']}/history", "/u/alice"):
            assert browser.get(page).status_code == 200
        page = browser.get(made["topic"]["url"]).text
        assert not re.search(rf"<(img|link|script|iframe)[^>]*{re.escape(bait)}", page)
        site.api("alice").patch(f"/posts/{made['post']['id']}", json={"body": body + "!"}).raise_for_status()
        with pytest.raises(BlockingIOError):
            trap.accept()


# -------------------------------------------------------------------- files
def png(width: int, height: int, data: bytes = b"") -> bytes:
    """Return the header of a picture of this size, with arbitrary content."""

    def chunk(kind: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    return b"\x89PNG\r\n\x1a\n" + head + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b"")


def many_frames(count: int) -> bytes:
    file = io.BytesIO()
    frames = [Image.new("RGB", (8, 8), (n % 256, n // 256, 7)) for n in range(count)]
    frames[0].save(file, "GIF", save_all=True, append_images=frames[1:])
    return file.getvalue()


HTML = b"<!doctype html><script>alert(1)</script>"
LIES: dict[str, bytes] = {
    "a page": HTML,
    "a drawing with a script": b"<svg xmlns='http://www.w3.org/2000/svg' onload='alert(1)'/>",
    "a head only": b"\x89PNG\r\n\x1a\n",
    "a head and a page": b"GIF89a" + HTML,
    "a program": b"\x7fELF" + bytes(200),
    "an archive": b"PK\x03\x04" + bytes(200),
    "cut short": jpeg()[:200],
    "another kind of picture": b"II*\x00" + bytes(100),
    "a bomb of one colour": png(30_000, 30_000, bytes(10_000)),
    "a bomb of width": png(2**31 - 1, 1),
    "a bomb of frames": many_frames(400),
    "nothing": b"",
}


@pytest.mark.parametrize("what", LIES)
def test_a_file_with_a_wrong_type_is_refused(site: Site, what: str) -> None:
    for name, kind in (("x.png", "image/png"), ("x.html", "text/html"), ("../../x.jpg", "image/jpeg")):
        answer = site.api("alice").post("/images", files={"file": (name, LIES[what], kind)})
        assert answer.status_code in (413, 415, 422), (what, answer.status_code)


@pytest.mark.parametrize("name", ["x.html", "../../../etc/cron.d/x", "x\r\nX-Evil: 1.jpg", "<script>.jpg", "x" * 3000])
def test_a_files_name_is_ignored_and_its_type_is_detected(site: Site, name: str) -> None:
    picture = jpeg() + HTML  # a picture that a browser would take for HTML if it guessed the type
    answer = site.api("alice").post("/images", files={"file": (name, picture, "text/html")})
    assert answer.status_code in (201, 400), answer.text
    if answer.status_code == 201:
        served = httpx2.get(answer.json()["url"], headers=site.api("alice").headers, timeout=60)
        assert (served.headers["content-type"], served.headers["x-content-type-options"]) == ("image/jpeg", "nosniff")
        assert "filename" not in served.headers.get("content-disposition", "")
        assert "script-src 'self'" in served.headers["content-security-policy"]


# -------------------------------------------------------------------- names
LOOKS_LIKE = [
    *(
        "Quadruped",
        "\u051bu\u0430dru\u0440\u0435d",
        "ｑｕａｄｒｕｐｅｄ",
        "quadrup3d",
        "qu\u00adadruped",
        "𝐪𝐮𝐚𝐝𝐫𝐮𝐩𝐞𝐝",
        "Quadruped 🤖",
    ),
    *("the real quadruped", "Q.u.a.d.r.u.p.e.d", "q̈uadruped", "Ⓠuadruped", "quaⅾruped", "QUADRUPED"),
    *("Admin", "Аdmin", "m0derator"),
]


@pytest.mark.parametrize("shown", LOOKS_LIKE)
def test_law_1_a_display_name_that_looks_like_a_robot_s_or_a_role_is_refused(site: Site, shown: str) -> None:
    with pytest.raises(BoardError) as caught:
        local_admin.create_account(site.settings, "imitator", display_name=shown)
    assert caught.value.status == 422


@pytest.mark.parametrize("name", ["quadrup3d", "quad-ruped", "quad_ruped", "quadrupecl"])
def test_law_1_a_name_that_looks_like_a_robot_s_is_refused_at_sign_up(site: Site, name: str) -> None:
    sign_up = access.sign_up(site.board.services, name, PASSWORD, "10.0.0.7")
    with pytest.raises(BoardError) as caught:
        site.board.run(sign_up)
    assert caught.value.code == "looks_like_a_robot"


@pytest.mark.parametrize(
    "shown", ["Ann", "Анна Петрова", "王小明", "Robotics club", "José", "Administrative staff", "🤖"]
)
def test_ordinary_display_names_are_accepted(site: Site, shown: str) -> None:
    name = "n" + format(zlib.crc32(shown.encode()), "x")
    assert local_admin.create_account(site.settings, name, display_name=shown).display_name == shown


def test_only_an_agent_has_the_robot_badge_and_html_is_shown_as_text(site: Site) -> None:
    body = '[robot] <span class="badge badge-robot-agent">robot</span> **quadruped**: done'
    made = site.api("alice").post("/topics", json={"board_id": "talk", "title": "t", "body": body}).json()
    page = site.browser("bob").get(made["topic"]["url"]).text
    assert '<span class="badge badge-robot-agent"' not in page
    assert "by-robot" not in page
    assert "[robot]" in page
    card: dict[str, Any] = {"robot": "quadruped", "state": "done"}
    answer = site.api("alice").post(f"/topics/{made['topic']['id']}/posts", json={"body": "x", "card": card})
    assert answer.json()["code"] == "not_a_robot"
