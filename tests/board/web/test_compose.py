"""Writing posts without scripts: preview, pictures, quotes and replies; errors never lose the text."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator

import httpx2
import pytest
from PIL import Image

from agentrob.board.web.posts import NAMES
from tests.board.web.forum_site import PageClient, Site, running_site


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board")) as site:
        yield site


@pytest.fixture
def topic(site: Site) -> str:
    made = site.api("alice").post("/topics", json={"board_id": "talk", "title": "A walk", "body": "first\n\nsecond"})
    return str(made.json()["topic"]["id"])


def png(width: int = 64, height: int = 48) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (width, height), (10, 90, 90)).save(file, "PNG")
    return file.getvalue()


def send(visitor: PageClient, path: str, page: str, file: bytes | None = None, **fields: str) -> httpx2.Response:
    """Submit a form with pictures, like a browser."""
    form = re.search(rf'<form[^>]*action="{re.escape(path)}".*?</form>', visitor.get(page).text, re.DOTALL)
    assert form
    assert 'enctype="multipart/form-data"' in form[0]
    hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form[0]))
    files = {"pictures": ("a.png", file or b"", "image/png")} if file is not None else None
    return visitor.client.post(path, data=hidden | fields, files=files)


def posts(site: Site, topic: str) -> list[dict[str, object]]:
    return list(site.api("alice").get(f"/topics/{topic}/posts").json()["items"])


def test_a_preview_shows_the_text_and_posts_nothing(site: Site, topic: str) -> None:
    visitor = site.browser("alice")
    body = "**loud** @quadruped <script>alert(1)</script>"
    for path, page in ((f"/t/{topic}/reply", f"/t/{topic}"), ("/b/talk/new", "/b/talk/new")):
        shown = send(visitor, path, page, body=body, title="A title", do="preview").text
        preview = shown.split('aria-label="Preview"')[1].split("</section>")[0]
        assert "<strong>loud</strong>" in preview
        assert 'class="mention"' in preview
        assert "<script" not in preview
        assert "**loud** @quadruped &lt;script" in shown.split("<textarea")[1]
    assert 'value="A title"' in shown
    assert len(posts(site, topic)) == 1


def test_a_preview_requires_the_csrf_token_and_an_account(site: Site) -> None:
    alice = site.browser("alice")
    csrf = alice.csrf("/b/talk/new")
    assert alice.client.post("/preview", data={"csrf": csrf, "body": "*a*"}).text.count("<em>a</em>") == 1
    assert alice.client.post("/preview", data={"csrf": "0" * 64, "body": "a"}).status_code == 403
    stranger = site.browser()
    token = stranger.csrf("/sign-in")
    assert stranger.client.post("/preview", data={"csrf": token, "body": "a"}).status_code == 401
    assert alice.client.post("/preview", data={"csrf": csrf, "body": "a" * 70_000}).status_code == 413


def test_pictures_are_uploaded_with_the_form_and_survive_a_preview(site: Site, topic: str) -> None:
    visitor = site.browser("alice")
    path, page = f"/t/{topic}/reply", f"/t/{topic}"
    shown = send(visitor, path, page, file=png(1600, 1200), body="see", do="preview").text
    images = re.findall(r'name="images" value="(\d+)"', shown)
    assert len(images) == 1
    assert f"/images/{images[0]}/small" in shown
    answer = send(visitor, path, page, file=png(), body="see both", images=images[0])
    assert answer.status_code == 200
    written = posts(site, topic)[-1]
    assert [(i["width"], i["height"]) for i in written["images"]] == [(1600, 1200), (64, 48)]  # type: ignore[attr-defined]
    small = visitor.client.get(f"/images/{images[0]}/small")
    with Image.open(io.BytesIO(small.content)) as picture:
        assert picture.size == (960, 720)


@pytest.mark.parametrize(("name", "file", "status"), [("bob", png(), 403), ("alice", b"<svg onload=alert(1)>", 415)])
def test_invalid_pictures_are_refused_and_the_text_is_kept(
    site: Site, topic: str, name: str, file: bytes, status: int
) -> None:
    visitor = site.browser(name)
    answer = send(visitor, f"/t/{topic}/reply", f"/t/{topic}", file=file, body="my long text")
    assert answer.status_code == status
    assert "my long text" in answer.text
    assert len(posts(site, topic)) == 1


def test_a_thumbnail_requires_the_same_rights_as_its_picture(site: Site) -> None:
    image = site.api("alice").post("/images", files={"file": ("a.png", png(1200, 900), "image/png")}).json()["id"]
    assert site.browser("alice").client.get(f"/images/{image}/small").status_code == 200
    assert site.browser("bob").client.get(f"/images/{image}/small").status_code == 404


def test_a_reply_shows_its_target_and_a_quote_commands_nothing(site: Site, topic: str) -> None:
    first = posts(site, topic)[0]["id"]
    visitor = site.browser("bob")
    page = visitor.get(f"/t/{topic}?quote={first}").text
    assert "&gt; first\n&gt;\n&gt; second" in page.split("<textarea")[1]
    answer = send(visitor, f"/t/{topic}/reply", f"/t/{topic}?reply_to={first}", body="> @quadruped walk 1 m\n\nyes")
    assert answer.status_code == 200
    written = posts(site, topic)[-1]
    assert written["reply_to"] == first
    assert written["mentions"] == []
    assert "in reply to alice" in answer.text


def test_only_posts_of_the_same_topic_can_be_replied_to_or_quoted(site: Site, topic: str) -> None:
    other = site.api("alice").post("/topics", json={"board_id": "talk", "title": "x", "body": "elsewhere"}).json()
    visitor = site.browser("bob")
    assert "&gt; elsewhere" not in visitor.get(f"/t/{topic}?quote={other['post']['id']}").text
    assert visitor.get(f"/t/{topic}?quote=999999").status_code == 404
    csrf = visitor.csrf(f"/t/{topic}")
    data = {"csrf": csrf, "body": "a", "reply_to": other["post"]["id"]}
    assert visitor.client.post(f"/t/{topic}/reply", data=data).status_code == 404


def test_completions_list_robots_first_with_their_state(site: Site) -> None:
    site.board.add("quentin")
    site.api("quadruped").put("/robots/quadruped", json={"card": {"state": "walking"}}).raise_for_status()
    client = site.browser("bob").client
    found = client.get("/names", params={"q": "Qu"}).json()
    assert [(n["name"], n["state"]) for n in found] == [("quadruped", "walking"), ("quentin", "")]
    assert client.get("/names", params={"q": "q%"}).json() == []
    assert len(client.get("/names", params={"q": ""}).json()) <= NAMES
    assert site.browser().client.get("/names", params={"q": "q"}, follow_redirects=False).status_code == 303


def test_an_edit_can_be_previewed_and_can_add_pictures(site: Site, topic: str) -> None:
    first = str(posts(site, topic)[0]["id"])
    visitor = site.browser("alice")
    path = f"/p/{first}/edit"
    assert "<em>new</em>" in send(visitor, path, path, body="*new*", do="preview").text
    assert posts(site, topic)[0]["version"] == 1
    send(visitor, path, path, file=png(), body="*new*")
    assert (posts(site, topic)[0]["version"], len(posts(site, topic)[0]["images"])) == (2, 1)  # type: ignore[arg-type]
