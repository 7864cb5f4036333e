"""Writing without scripts: preview, pictures, quotes and replies; what is refused, and that no text is lost."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator

import httpx2
import pytest
from PIL import Image

from agentrob.board.web.posts import NAMES
from tests.board.web.page_world import Surfer, World, running_world


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    with running_world(tmp_path_factory.mktemp("board")) as world:
        yield world


@pytest.fixture
def topic(world: World) -> str:
    made = world.api("alice").post("/topics", json={"board_id": "talk", "title": "A walk", "body": "first\n\nsecond"})
    return str(made.json()["topic"]["id"])


def png(width: int = 64, height: int = 48) -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (width, height), (10, 90, 90)).save(file, "PNG")
    return file.getvalue()


def send(surfer: Surfer, path: str, page: str, file: bytes | None = None, **fields: str) -> httpx2.Response:
    """Send a form with pictures, like a browser."""
    form = re.search(rf'<form[^>]*action="{re.escape(path)}".*?</form>', surfer.get(page).text, re.DOTALL)
    assert form
    assert 'enctype="multipart/form-data"' in form[0]
    hidden = dict(re.findall(r'type="hidden" name="(\w+)" value="([^"]*)"', form[0]))
    files = {"pictures": ("a.png", file or b"", "image/png")} if file is not None else None
    return surfer.client.post(path, data=hidden | fields, files=files)


def posts(world: World, topic: str) -> list[dict[str, object]]:
    return list(world.api("alice").get(f"/topics/{topic}/posts").json()["items"])


def test_a_preview_shows_the_text_and_posts_nothing(world: World, topic: str) -> None:
    surfer = world.browser("alice")
    body = "**loud** @quadruped <script>alert(1)</script>"
    for path, page in ((f"/t/{topic}/reply", f"/t/{topic}"), ("/b/talk/new", "/b/talk/new")):
        shown = send(surfer, path, page, body=body, title="A title", do="preview").text
        preview = shown.split('aria-label="Preview"')[1].split("</section>")[0]
        assert "<strong>loud</strong>" in preview
        assert 'class="mention"' in preview
        assert "<script" not in preview
        assert "**loud** @quadruped &lt;script" in shown.split("<textarea")[1]
    assert 'value="A title"' in shown
    assert len(posts(world, topic)) == 1


def test_a_preview_needs_the_forms_token_and_an_account(world: World) -> None:
    alice = world.browser("alice")
    csrf = alice.csrf("/b/talk/new")
    assert alice.client.post("/preview", data={"csrf": csrf, "body": "*a*"}).text.count("<em>a</em>") == 1
    assert alice.client.post("/preview", data={"csrf": "0" * 64, "body": "a"}).status_code == 403
    stranger = world.browser()
    token = stranger.csrf("/sign-in")
    assert stranger.client.post("/preview", data={"csrf": token, "body": "a"}).status_code == 401
    assert alice.client.post("/preview", data={"csrf": csrf, "body": "a" * 70_000}).status_code == 413


def test_pictures_come_with_the_form_and_survive_a_preview(world: World, topic: str) -> None:
    surfer = world.browser("alice")
    path, page = f"/t/{topic}/reply", f"/t/{topic}"
    shown = send(surfer, path, page, file=png(1600, 1200), body="see", do="preview").text
    images = re.findall(r'name="images" value="(\d+)"', shown)
    assert len(images) == 1
    assert f"/images/{images[0]}/small" in shown
    answer = send(surfer, path, page, file=png(), body="see both", images=images[0])
    assert answer.status_code == 200
    written = posts(world, topic)[-1]
    assert [(i["width"], i["height"]) for i in written["images"]] == [(1600, 1200), (64, 48)]  # type: ignore[attr-defined]
    small = surfer.client.get(f"/images/{images[0]}/small")
    with Image.open(io.BytesIO(small.content)) as picture:
        assert picture.size == (960, 720)


@pytest.mark.parametrize(("name", "file", "status"), [("bob", png(), 403), ("alice", b"<svg onload=alert(1)>", 415)])
def test_pictures_that_may_not_be_are_refused_and_the_text_is_kept(
    world: World, topic: str, name: str, file: bytes, status: int
) -> None:
    surfer = world.browser(name)
    answer = send(surfer, f"/t/{topic}/reply", f"/t/{topic}", file=file, body="my long text")
    assert answer.status_code == status
    assert "my long text" in answer.text
    assert len(posts(world, topic)) == 1


def test_a_thumbnail_is_for_those_who_may_see_the_picture(world: World) -> None:
    image = world.api("alice").post("/images", files={"file": ("a.png", png(1200, 900), "image/png")}).json()["id"]
    assert world.browser("alice").client.get(f"/images/{image}/small").status_code == 200
    assert world.browser("bob").client.get(f"/images/{image}/small").status_code == 404


def test_an_answer_says_what_it_answers_and_a_quote_is_said_by_nobody(world: World, topic: str) -> None:
    first = posts(world, topic)[0]["id"]
    surfer = world.browser("bob")
    page = surfer.get(f"/t/{topic}?quote={first}").text
    assert "&gt; first\n&gt;\n&gt; second" in page.split("<textarea")[1]
    answer = send(surfer, f"/t/{topic}/reply", f"/t/{topic}?reply_to={first}", body="> @quadruped walk 1 m\n\nyes")
    assert answer.status_code == 200
    written = posts(world, topic)[-1]
    assert written["reply_to"] == first
    assert written["mentions"] == []
    assert "in reply to alice" in answer.text


def test_only_posts_of_the_topic_can_be_answered_or_quoted(world: World, topic: str) -> None:
    other = world.api("alice").post("/topics", json={"board_id": "talk", "title": "x", "body": "elsewhere"}).json()
    surfer = world.browser("bob")
    assert "&gt; elsewhere" not in surfer.get(f"/t/{topic}?quote={other['post']['id']}").text
    assert surfer.get(f"/t/{topic}?quote=999999").status_code == 404
    csrf = surfer.csrf(f"/t/{topic}")
    data = {"csrf": csrf, "body": "a", "reply_to": other["post"]["id"]}
    assert surfer.client.post(f"/t/{topic}/reply", data=data).status_code == 404


def test_names_are_offered_robots_first_with_their_state(world: World) -> None:
    world.board.add("quentin")
    world.api("quadruped").put("/robots/quadruped", json={"card": {"state": "walking"}}).raise_for_status()
    client = world.browser("bob").client
    found = client.get("/names", params={"q": "Qu"}).json()
    assert [(n["name"], n["state"]) for n in found] == [("quadruped", "walking"), ("quentin", "")]
    assert client.get("/names", params={"q": "q%"}).json() == []
    assert len(client.get("/names", params={"q": ""}).json()) <= NAMES
    assert world.browser().client.get("/names", params={"q": "q"}, follow_redirects=False).status_code == 303


def test_an_edit_can_be_looked_at_first_and_can_bring_pictures(world: World, topic: str) -> None:
    first = str(posts(world, topic)[0]["id"])
    surfer = world.browser("alice")
    path = f"/p/{first}/edit"
    assert "<em>new</em>" in send(surfer, path, path, body="*new*", do="preview").text
    assert posts(world, topic)[0]["version"] == 1
    send(surfer, path, path, file=png(), body="*new*")
    assert (posts(world, topic)[0]["version"], len(posts(world, topic)[0]["images"])) == (2, 1)  # type: ignore[arg-type]
