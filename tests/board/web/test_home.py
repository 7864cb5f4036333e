"""The home page: one box for commands with examples, robots as cards, threads with their outcomes, Stop by Escape."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import Any

import pytest
from PIL import Image
from playwright.sync_api import expect

from agentrob.model import EventKind
from agentrob.wiring.command_reader import ReaderProcess
from tests.board.web.browser_windows import RUNNING, Windows
from tests.board.web.forum_site import CARD, Site, running_site

pytestmark = pytest.mark.browser
SEEN = CARD | {"boards": ["robots"], "limits": {"step_m": 5}}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with running_site(tmp_path_factory.mktemp("board"), sign_up=True, public_read=True, reader=ReaderProcess) as site:
        yield site


@pytest.fixture(autouse=True)
def _connected(site: Site) -> None:
    publish(site)


def publish(site: Site, **more: Any) -> None:
    """Send the robot's card, as its agent does every five seconds."""
    site.api("quadruped").put("/robots/quadruped", json={"card": SEEN | more}).raise_for_status()


def png() -> bytes:
    file = io.BytesIO()
    Image.new("RGB", (1280, 720), (20, 90, 160)).save(file, "PNG")
    return file.getvalue()


def moving() -> bytes:
    file = io.BytesIO()
    first, *rest = (Image.new("RGB", (640, 360), (20 + 60 * n, 90, 160)) for n in range(3))
    first.save(file, "WEBP", save_all=True, append_images=rest, duration=50, loop=0)
    return file.getvalue()


def run_command(site: Site, text: str, card: dict[str, Any], body: str = "Seen.", picture: bytes = b"") -> str:
    """Post a command and the robot's claim of it; return the id of the command's post."""
    made = site.api("alice").post("/topics", json={"board_id": "robots", "title": text[11:], "body": text}).json()
    topic, post, robot = made["topic"]["id"], made["post"]["id"], site.api("quadruped")
    images = (
        [robot.post("/images", files={"file": ("a", picture, "application/octet-stream")}).json()["id"]]
        if picture
        else []
    )
    reply = {"body": body, "reply_to": post, "card": card, "images": images}
    robot.post(f"/topics/{topic}/posts", json=reply, headers={"Idempotency-Key": f"claim:{post}"}).raise_for_status()
    return str(post)


def stops(site: Site) -> int:
    """Return how many stops the forum has stored."""
    events, after = 0, "0"
    while items := site.api("alice").get("/changes", params={"after": after, "limit": 100}).json()["items"]:
        events += sum(item["kind"] == EventKind.ROBOT_STOP for item in items)
        after = items[-1]["id"]
    return events


def wait_for_stops(site: Site, windows_page: Any, number: int) -> None:
    for _ in range(200):
        if stops(site) == number:
            return
        windows_page.wait_for_timeout(50)
    assert stops(site) == number


# -------------------------------------------------------------------- without scripts
def test_without_scripts_an_example_fills_the_box_and_the_topic_gets_a_title(site: Site) -> None:
    alice = site.browser("alice")
    home = alice.get("/").text
    examples = re.findall(r'class="example" href="([^"]+)"', home)
    assert len(examples) == 3
    filled = alice.get(examples[0].replace("&amp;", "&").split("#")[0]).text
    said = re.search(r"<textarea[^>]*>([^<]+)</textarea>", filled)
    assert said
    assert said[1].startswith("@quadruped walk forward 1 m")
    topic = alice.send("/command", "/", body=said[1])
    assert '<h1 dir="auto">Walk forward 1 m, then turn left 90 degrees, then wave</h1>' in topic.text
    assert '<a href="/b/robots">' in topic.text, "on the board of the robot that it names"


def test_a_title_can_be_given_and_a_preview_says_what_the_robot_would_do(site: Site) -> None:
    alice = site.browser("alice")
    shown = alice.send("/command", "/", body="@quadruped walk forward 9 m", title="Far", do="preview").text
    assert "Too far: 5 m a step at most." in shown
    assert 'value="Far"' in shown
    assert '<h1 dir="auto">Far away</h1>' in alice.send("/command", "/", body="@quadruped wave", title="Far away").text
    assert "a post needs a text" in alice.send("/command", "/", body="  ").text.lower()


@pytest.mark.parametrize("text", ["@quadruped", "@quadruped\n\n", "x" * 300, "@quadruped, and @bob: hi\nthere", "<b>"])
def test_any_text_gives_a_title(site: Site, text: str) -> None:
    page = site.browser("alice").send("/command", "/", body=text)
    title = re.search(r'<h1 dir="auto">([^<]+)</h1>', page.text)
    assert title
    assert 0 < len(title[1]) <= 80


@pytest.mark.parametrize(
    ("body", "posted"),
    [
        ("@quadruped wave", "preview: @quadruped wave"),
        ("@quadruped 挥手", "预演：@quadruped 挥手"),
        ("@quadruped preview wave", "@quadruped preview wave"),
    ],
)
def test_the_rehearse_button_posts_a_request_for_a_preview(site: Site, body: str, posted: str) -> None:
    alice = site.browser("alice")
    assert '<button type="submit" name="do" value="rehearse"' in alice.get("/").text
    topic = alice.send("/command", "/", body=body, do="rehearse")
    topic_id = re.search(r"/t/(\d+)", str(topic.url))
    assert topic_id
    (post,) = site.api("alice").get(f"/topics/{topic_id[1]}/posts").json()["items"]
    assert post["raw"] == posted


def test_who_is_not_signed_in_sees_what_this_is_and_cannot_command(site: Site) -> None:
    nobody = site.browser()
    page = nobody.get("/").text
    assert "the robot carries it out and replies in the thread" in page
    assert "@quadruped walk forward 1 m" in page
    assert 'href="/sign-up"' in page
    assert "<textarea" not in page
    assert "/stop" not in page
    assert nobody.client.post("/command", data={"body": "@quadruped wave", "csrf": ""}).status_code in (401, 403)


def test_the_examples_are_what_the_robots_can_do(site: Site) -> None:
    publish(site, ops=["heart", "clap"])
    found = re.findall(r'data-fill="([^"]+)"', site.browser("alice").get("/").text)
    assert found == [
        "@quadruped make a heart, then clap your hands",
        "@quadruped make a heart",
        "@quadruped clap your hands",
    ]
    publish(site, ops=[])
    assert "data-fill" not in site.browser("alice").get("/").text


def test_threads_show_robot_outcome_sentence_and_picture(site: Site) -> None:
    done = "**Done:** walked 0.97 m.\n\n| Step |\n|---|\n| 1 |\n\nAssumed: x.\n\n#### Details\n\n*trace `4f1c`*"
    run_command(site, "@quadruped walk there", {"robot": "quadruped", "state": "done"}, done, picture=png())
    row = site.browser("alice").get("/").text.split("walk there")[1].split("</li>")[0]
    assert '<span class="row-text" dir="auto">Done: walked 0.97 m.</span>' in row
    assert '<span class="chip small is-done">done</span> @quadruped' in row
    assert "<summary>Done: walked 0.97 m.</summary>" in site.browser("alice").get("/feed.atom").text
    thumb = re.search(r'class="thumb" src="([^"]+)"', row)
    assert thumb
    picture = site.browser("alice").get(thumb[1])
    assert picture.headers["content-type"] == "image/webp"
    assert max(Image.open(io.BytesIO(picture.content)).size) == 240
    site.admin_api().patch("/admin/robots/quadruped", json={"camera_role": "admin"}).raise_for_status()
    assert "thumb" not in site.browser("bob").get("/").text, "who may not see its camera sees no picture of it"
    assert site.browser("bob").get(thumb[1]).status_code == 403
    site.admin_api().patch("/admin/robots/quadruped", json={"camera_role": "guest"}).raise_for_status()


def test_only_an_admin_is_offered_to_invite_somebody(site: Site) -> None:
    assert "Invite someone" in site.browser("root").get("/").text
    assert "Invite someone" not in site.browser("alice").get("/").text
    form = site.browser("root").get("/admin/invites?simulated=1").text
    assert "<option selected>member</option>" in form
    assert 'name="commands_simulated" checked' in form


def test_the_first_page_is_small(site: Site) -> None:
    """60 kB with its styles and scripts, as they are sent; without pictures and the viewer."""
    browser = site.browser("alice")
    page = browser.get("/")
    files = re.findall(r'(?:href|src)="(/static/[^"]+\.(?:css|js|svg))"', page.text)
    assert len(files) >= 3
    sent = len(page.content)
    for file in dict.fromkeys(files):
        with browser.client.stream("GET", file, headers={"Accept-Encoding": "gzip"}) as answer:
            sent += sum(len(chunk) for chunk in answer.iter_raw())
    assert sent <= 60_000


# -------------------------------------------------------------------- in a browser
def test_an_example_fills_the_box_which_says_what_the_robot_would_do(site: Site, windows: Windows) -> None:
    page = windows.open("alice")
    page.goto("/")
    page.get_by_role("link", name="@quadruped take a photo").click()
    box, reading = page.get_by_label("Command", exact=True), page.locator("[data-reading]")
    expect(box).to_have_value("@quadruped take a photo")
    expect(box).to_be_focused()
    expect(reading).to_have_text("I would take a photo.")
    publish(site)
    box.fill("@quadruped walk forward 9 m")
    expect(reading).to_have_text("Too far: 5 m a step at most.")
    expect(reading).to_have_attribute("data-outcome", "not")
    box.fill("@quadrupd wave")
    expect(reading).to_contain_text("Did you mean @quadruped?")
    box.fill("@quadruped walk")
    expect(reading.locator("code").first).to_have_text("walk")
    box.fill("@quadruped turn left")
    page.keyboard.press("Control+Enter")
    page.wait_for_url(re.compile("/t/"))
    expect(page.get_by_role("heading", level=1)).to_have_text("Turn left")


def test_stop_is_outlined_while_a_robot_is_idle_and_solid_while_it_moves(site: Site, windows: Windows) -> None:
    page = windows.open("bob")
    page.goto("/")
    stop = page.get_by_role("button", name="Stop @quadruped")
    background = "e => getComputedStyle(e).backgroundColor"
    idle = stop.evaluate(background)
    publish(site, state="walking")
    expect(page.locator(".stop.moves")).to_be_visible()
    assert page.locator(".stop.moves").evaluate(background) != idle
    publish(site, state="idle")
    expect(page.locator(".stop.moves")).to_have_count(0)
    post = run_command(site, "@quadruped walk on", RUNNING)
    publish(site, state="idle", line=[post])
    expect(page.locator(".robot-card .doing")).to_have_text("Now: turning")
    expect(page.locator(".stop.moves")).to_be_visible()


def test_law_13_escape_stops_what_moves_and_twice_all(site: Site, windows: Windows) -> None:
    page = windows.open("bob")
    page.goto("/")
    before = stops(site)
    page.keyboard.press("Escape")
    page.wait_for_timeout(200)
    assert stops(site) == before, "nothing moves"
    page.keyboard.press("Escape")
    wait_for_stops(site, page, before + 1)
    publish(site, state="walking")
    expect(page.locator(".stop.moves")).to_be_visible()
    page.get_by_label("Command", exact=True).press_sequentially("@qu")
    expect(page.get_by_role("option")).to_have_count(1)
    page.keyboard.press("Escape")
    wait_for_stops(site, page, before + 2)


def test_a_picture_opens_in_place_and_escape_closes_it(site: Site, windows: Windows) -> None:
    post = run_command(site, "@quadruped look", {"robot": "quadruped", "state": "done"}, "Done.", picture=png())
    page = windows.open("bob")
    page.goto(f"/p/{post}")
    address, before = page.url, stops(site)
    page.locator(".pictures a").click()
    dialog = page.get_by_role("dialog")
    expect(dialog).to_be_visible()
    assert dialog.locator("img").evaluate("async i => { await i.decode(); return i.naturalWidth; }") == 1280
    page.keyboard.press("Escape")
    expect(dialog).not_to_be_visible()
    assert page.url == address
    assert stops(site) == before


def test_the_preview_of_a_command_that_waits_for_an_approval_is_named(site: Site, windows: Windows) -> None:
    waiting = RUNNING | {"state": "waiting"}
    post = run_command(site, "@quadruped walk far", waiting)
    page, robot = windows.open("bob"), site.api("quadruped")
    page.goto(f"/p/{post}")
    reply = page.locator("article.by-robot").get_attribute("data-post")
    image = robot.post("/images", files={"file": ("a.png", png(), "image/png")}).json()["id"]
    edit = {"body": "**Waits for approval.**", "card": waiting, "images": [image]}
    robot.patch(f"/posts/{reply}", json=edit).raise_for_status()
    expect(page.locator(".pictures .plot figcaption")).to_have_text("Paths of the preview")


def test_a_report_comes_with_its_captions_and_its_recording_is_added_without_a_flicker(
    site: Site, windows: Windows
) -> None:
    """As a robot's agent does it: its record first, then the report; later the same for the recording."""
    post = run_command(site, "@quadruped snap", RUNNING)
    page, robot = windows.open("bob"), site.api("quadruped")
    page.goto(f"/p/{post}")
    reply = page.locator("article.by-robot").get_attribute("data-post")

    def report(body: str, kinds: list[dict[str, Any]], picture: bytes) -> None:
        told = {"record": {"status": "done", "pictures": kinds}, "reply_id": reply}
        robot.put(f"/commands/{post}", json=told).raise_for_status()
        image = robot.post("/images", files={"file": ("a", picture, "application/octet-stream")}).json()["id"]
        edit = {"body": body, "card": RUNNING | {"state": "done"}, "images": [image]}
        robot.patch(f"/posts/{reply}", json=edit).raise_for_status()

    # Each state of the reply that the reader sees: its number of pictures and of captions.
    page.evaluate("""() => {
      window.states = [];
      const count = (what) => document.querySelectorAll(`article.by-robot ${what}`).length;
      const note = () => window.states.push([count("img[data-picture], .pictures img"), count("figcaption")].join());
      new MutationObserver(note).observe(document.getElementById("posts"), { childList: true });
    }""")
    kinds: list[dict[str, Any]] = [{"kind": "path", "step": 0}]
    report("Done.\n\n#### Details\n\nHere.", kinds, png())
    expect(page.locator(".pictures figcaption")).to_have_text("Path that was measured")
    page.locator(".pictures img").evaluate("async image => { await image.decode(); window.seen = image; }")
    page.locator("article.by-robot summary").click()
    kinds.append({"kind": "recording", "step": 0})
    report("Done.\n\nWith a recording.\n\n#### Details\n\nHere.", kinds, moving())
    expect(page.locator(".pictures figcaption")).to_have_text(["Path that was measured", "Recording"])
    assert page.evaluate("window.states") == ["1,1", "2,2"]
    assert page.evaluate("window.seen.isConnected && window.seen.complete"), "the picture that was there stays"
    expect(page.locator("article.by-robot details")).to_have_attribute("open", "")


def test_a_recording_can_be_paused(site: Site, windows: Windows) -> None:
    post = run_command(site, "@quadruped film", {"robot": "quadruped", "state": "done"}, "Done.", picture=moving())
    page = windows.open("bob", reduced_motion="no-preference")
    page.goto(f"/p/{post}")
    shown = page.locator(".pictures img")
    expect(shown).to_be_visible()
    page.get_by_role("button", name="Pause").click()
    expect(page.locator(".pictures canvas")).to_be_visible()
    expect(shown).to_be_hidden()
    page.get_by_role("button", name="Play").click()
    expect(shown).to_be_visible()
    calm = windows.open("bob")
    calm.goto(f"/p/{post}")
    expect(calm.get_by_role("link", name="Play the recording")).to_be_visible()
    expect(calm.get_by_role("button", name="Pause")).to_be_hidden()


def test_times_are_relative_with_the_exact_time_on_hover(site: Site, windows: Windows) -> None:
    page = windows.open("bob", timezone_id="Asia/Shanghai")
    page.clock.install(time=datetime(2026, 11, 22, 12, tzinfo=UTC))
    page.goto("/")
    words = page.evaluate(
        """seconds => seconds.map(s => {
          const t = document.createElement('time');
          t.dateTime = new Date(Date.now() - s * 1000).toISOString();
          t.dataset.ago = '';
          document.body.replaceChildren(t);
          localTimes(document);
          return t.textContent;
        })""",
        [5, 60, 50 * 60, 3 * 3600, 30 * 3600, 5 * 86400, 400 * 86400],
    )
    assert words[:6] == ["just now", "1 min ago", "50 min ago", "3 h ago", "1 day ago", "5 days ago"]
    assert words[6] == "18 Oct 2025, 20:00"
    assert "2025" in str(page.locator("time").get_attribute("title"))


@pytest.mark.parametrize("width", [1280, 390])
def test_the_footer_is_at_the_bottom_and_on_a_phone_the_box_comes_first(
    site: Site, windows: Windows, width: int
) -> None:
    page = windows.open("alice", viewport={"width": width, "height": 1600})
    page.goto("/tags")
    bottom = page.locator("footer.end").evaluate("e => e.getBoundingClientRect().bottom")
    assert abs(bottom - 1600) < 2
    page.goto("/")
    box, room = (page.locator(css).bounding_box() for css in (".tell", ".room"))
    assert box is not None
    assert room is not None
    if width == 390:
        assert box["y"] + box["height"] <= room["y"] < page.locator(".robots").evaluate("e => e.offsetTop")
    else:
        assert abs(box["y"] - room["y"]) < 30, "side by side"
