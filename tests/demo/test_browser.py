"""The README's walk-through in a real browser: open the link, write a post, watch the robot, read the report."""

from __future__ import annotations

import json
import math
import os
import re
import time
from collections.abc import Iterator
from pathlib import Path

import httpx2
import pytest
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect, sync_playwright

from agentrob.demo.visitor import LIMIT_S
from agentrob.model import CommandState
from tests.chromium import chromium_path
from tests.demo.running import ROOT, RUNNING, RunningDemo, end_leftovers, start_demo

pytestmark = [pytest.mark.sim, pytest.mark.browser]

expect.set_options(timeout=60_000)

SENTENCE = "@quadruped walk forward 1 metre, turn left, wave and take a photo"
MOTION_MS = 60_000
#: Screenshots are kept here; the README's picture is one of them.
SCREENSHOTS = Path(os.environ.get("AGENTROB_SCREENSHOTS") or ROOT / "var/screenshots")


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDemo]:
    before = len(RUNNING)
    yield start_demo(tmp_path_factory.mktemp("demo") / "data", through_make=True)
    end_leftovers(before)


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium_path(),
            args=["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="module")
def visitor(browser: Browser, demo: RunningDemo) -> Iterator[BrowserContext]:
    context = browser.new_context(viewport={"width": 1180, "height": 900})
    page = context.new_page()
    page.goto(demo.link)
    page.get_by_role("button", name="Enter").click()
    page.wait_for_url(lambda url: "/enter/" not in url)
    page.close()
    yield context
    context.close()


@pytest.fixture
def page(visitor: BrowserContext) -> Iterator[Page]:
    """Open a page and close it after the test, because each live page holds one of a browser's six connections."""
    page = visitor.new_page()
    yield page
    page.close()


def screenshot(page: Page, name: str, element: str | None = None) -> None:
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.evaluate("window.scrollTo(0, 0)")
    path = SCREENSHOTS / f"{name}.png"
    if element:
        page.locator(element).first.screenshot(path=path)
    else:
        page.screenshot(path=path, full_page=True)


def listen_for_errors(page: Page) -> list[str]:
    wrong: list[str] = []
    page.on("console", lambda m: wrong.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda e: wrong.append(str(e)))
    return wrong


def write_post(page: Page, url: str, title: str, body: str) -> None:
    """Navigate from the home page and post a new thread, like a person."""
    page.goto(url)
    page.get_by_role("main").get_by_role("link", name="Robots", exact=True).first.click()
    page.get_by_role("link", name="New topic").first.click()
    page.get_by_label("Title").fill(title)
    page.get_by_label("Post", exact=True).fill(body)
    page.get_by_role("button", name="Post", exact=True).click()
    page.wait_for_url(re.compile("/t/"))


#: The labels of a status chip in a final state.
FINAL_CHIP = re.compile("|".join(rf"^\s*{s.label}\s*$" for s in CommandState if s.is_final), re.IGNORECASE)


def wait_for(answer: Locator, chip: str) -> None:
    """Wait until the chip of the robot's reply is final; if it is another one, fail with the text of the reply."""
    expect(answer.locator(".status .chip")).to_have_text(FINAL_CHIP, timeout=1000 * LIMIT_S)
    found = answer.locator(".status .chip").inner_text().strip().lower()
    assert found == chip, f"expected {chip!r}; the robot answered:\n{answer.inner_text()}"


#: Records every text of the newest status chip.
WATCH_CHIP = """() => {
  window.chips = [];
  const look = () => {
    const all = document.querySelectorAll("[data-post] .status .chip");
    const text = all.length ? all[all.length - 1].innerText.trim().toLowerCase() : "";
    if (text && window.chips[window.chips.length - 1] !== text) window.chips.push(text);
  };
  new MutationObserver(look).observe(document.body, {subtree: true, childList: true, characterData: true});
  look();
}"""


def marked_at(page: Page, robot: str) -> tuple[float, float]:
    """Where the map shows a robot, in metres of the room."""
    told = page.locator(f'[data-robot="{robot}"] .map-mark').first.get_attribute("transform") or ""
    x, y = told.removeprefix("translate(").split(")")[0].split()
    return float(x), -float(y)


def wait_until_moved(page: Page, robot: str, begun: tuple[float, float], by_m: float) -> None:
    """Wait until the map shows a robot further away than this from where it began."""
    page.wait_for_function(
        """([robot, x, y, by]) => {
          const told = document.querySelector(`[data-robot="${robot}"] .map-mark`).getAttribute("transform");
          const [, a, b] = /translate\\(([-.\\d]+) ([-.\\d]+)\\)/.exec(told);
          return Math.hypot(a - x, -b - y) > by;
        }""",
        arg=[robot, *begun, by_m],
        timeout=MOTION_MS,
    )


def replay(page: Page, answer: Locator, robot: str) -> None:
    """Open the record of an answer, go back to the beginning of its replay and play it to its end."""
    answer.get_by_role("link", name="Record", exact=True).click()
    page.wait_for_url(re.compile("/c/"))
    expect(page.get_by_label("Time in the replay")).to_be_visible()
    ended = marked_at(page, robot)
    page.get_by_label("Time in the replay").fill("0")
    assert math.dist(marked_at(page, robot), ended) > 0.3
    page.get_by_label("Speed").select_option("4")
    page.get_by_role("button", name="Play").click()
    expect(page.locator(".live-step")).to_have_text(re.compile(r"walk forward 1 m|turn left 90°|wave"))
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=MOTION_MS)
    assert math.dist(marked_at(page, robot), ended) < 0.01


#: Remember that the map has shown the plan: on a busy machine the command may end before the test looks.
NOTE_PLAN = """(selector) => {
    const plan = document.querySelector(selector);
    const look = () => { if (/\\d/.test(plan.getAttribute("points"))) document.body.dataset.planShown = "yes"; };
    new MutationObserver(look).observe(plan, {attributes: true});
    look();
}"""


def test_a_first_visit_from_an_example_to_a_stop_and_again(page: Page, demo: RunningDemo) -> None:
    """Click an example, watch the robot move on the map, stop it with one key, run the command again to its end, and
    replay it."""
    wrong = listen_for_errors(page)
    page.goto(demo.url)
    example = page.locator(".example").first
    said = example.inner_text()
    robot = said.split()[0]
    example.click()
    box = page.get_by_label("Command", exact=True)
    expect(box).to_have_value(said)
    expect(page.locator("[data-reading]")).to_contain_text("I would walk forward 1 m")
    screenshot(page, "home")
    page.get_by_role("button", name="Send").click()
    page.wait_for_url(re.compile("/t/"))
    expect(page.get_by_role("heading", level=1)).to_have_text(re.compile("^Walk forward 1 m"))
    expect(page.locator(".live-state")).to_have_text("now")
    name = robot.removeprefix("@")
    begun = marked_at(page, name)
    page.evaluate(NOTE_PLAN, f'[data-robot="{name}"] .map-plan')
    answer = page.locator("article.by-robot").first
    expect(answer.locator(".stop.moves")).to_be_visible(timeout=MOTION_MS)
    wait_until_moved(page, name, begun, 0.1)
    expect(page.locator("body")).to_have_attribute("data-plan-shown", "yes", timeout=MOTION_MS)
    page.keyboard.press("Escape")
    wait_for(answer, "stopped")
    expect(answer.locator(".body").first).to_contain_text("Stopped")
    answer.get_by_role("link", name="Run again").click()
    reply = page.get_by_label("Reply", exact=True)
    expect(reply).to_have_value(said)
    expect(page.locator("[data-reading]")).to_contain_text("I would walk forward 1 m")
    page.get_by_role("button", name="Reply", exact=True).click()
    expect(page.locator("article.by-robot")).to_have_count(2, timeout=MOTION_MS)
    again = page.locator("article.by-robot").last
    wait_for(again, "done")
    expect(again.locator(".body").first).to_contain_text(re.compile(r"Done: walked [01]\.\d\d m, turned left \d+°"))
    expect(again.locator(".pictures figcaption").first).to_be_visible()
    replay(page, again, name)
    page.goto(demo.url)
    row = page.locator(".rows .row").first
    expect(row).to_contain_text("Done: walked")
    expect(row).to_contain_text(robot)
    screenshot(page, "home-after")
    assert not wrong


def test_a_post_moves_the_robot_and_the_thread_gets_a_report(page: Page, demo: RunningDemo) -> None:
    wrong = listen_for_errors(page)
    reset_room(page, demo)  # else it would wave beside the humanoid
    write_post(page, demo.url, "First steps", SENTENCE)
    page.evaluate(WATCH_CHIP)
    wait_for(page.locator("article.by-robot").last, "done")
    chips = page.evaluate("window.chips")
    assert chips[-1] == "done"
    assert "running" in chips, f"the thread must tell what the robot is doing; it showed {chips}"
    answer = page.locator("article.by-robot").last
    expect(answer.locator("table")).to_be_visible()
    expect(answer).to_contain_text("1 m")
    expect(answer).to_contain_text("90")
    pictures = answer.locator(".pictures img")
    expect(pictures).not_to_have_count(0)
    pictures.last.scroll_into_view_if_needed()
    widths = pictures.evaluate_all(
        "async (all) => { for (const i of all) await i.decode(); return all.map(i => i.naturalWidth); }"
    )
    assert len(widths) >= 2, "a photo and the plot of the path"
    assert min(widths) >= 400
    expect(answer.locator(".pictures figcaption").first).to_be_visible()
    screenshot(page, "thread")
    page.set_viewport_size({"width": 390, "height": 844})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    screenshot(page, "thread-phone")
    page.emulate_media(color_scheme="dark")
    screenshot(page, "thread-phone-dark")
    assert not wrong


def test_the_robot_page_shows_the_room_while_it_moves_and_its_button_stops_the_robot(
    page: Page, demo: RunningDemo
) -> None:
    wrong = listen_for_errors(page)
    write_post(page, demo.url, "Turn and be stopped", "@quadruped turn right 360 degrees")
    expect(page.locator(".status .chip")).to_have_text(re.compile("running", re.IGNORECASE), timeout=MOTION_MS)
    thread = page.url
    page.goto(f"{demo.url}/robots/quadruped")
    page.locator(".camera").scroll_into_view_if_needed()  # it runs only while it is on the screen
    picture = page.locator(".camera img")
    expect(picture).to_be_visible(timeout=60_000)
    width = picture.evaluate(
        "async (i) => { while (!i.naturalWidth) await new Promise(requestAnimationFrame); return i.naturalWidth; }"
    )
    assert width >= 320
    screenshot(page, "robot")
    page.get_by_role("button", name=re.compile("Stop")).first.click()
    page.goto(thread)
    wait_for(page.locator("article.by-robot").last, "stopped")
    expect(page.locator("article.by-robot").last).to_contain_text("ms")
    screenshot(page, "thread-stopped")
    assert not wrong


def test_both_robots_are_shown_and_a_post_to_both_is_answered_by_each(page: Page, demo: RunningDemo) -> None:
    wrong = listen_for_errors(page)
    page.goto(f"{demo.url}/robots")
    for name, model in (("quadruped", "go2"), ("humanoid", "g1")):
        card = page.get_by_role("main").locator(".robot-card", has_text=f"@{name}")
        expect(card).to_contain_text(model)
        expect(card).to_contain_text("simulated")
    write_post(page, demo.url, "Both of you", "@quadruped turn left 30 degrees. @humanoid wave.")
    answers = page.locator("article.by-robot")
    expect(answers).to_have_count(2, timeout=60_000)
    for name, action in (("quadruped", "30"), ("humanoid", "wave")):
        answer = page.locator("article.by-robot", has=page.locator(".post-by", has_text=name))
        wait_for(answer, "done")
        expect(answer).to_contain_text(action)
    screenshot(page, "thread-both")
    assert not wrong


def test_a_question_is_asked_back_in_chinese(page: Page, demo: RunningDemo) -> None:
    write_post(page, demo.url, "向前走", "@quadruped 向前走")
    wait_for(page.locator("article.by-robot").last, "asks back")
    expect(page.locator("article.by-robot").last).to_contain_text(re.compile("[\u4e00-\u9fff]"))
    screenshot(page, "thread-chinese")


def test_after_a_reset_of_the_room_the_robot_continues_from_the_start(page: Page, demo: RunningDemo) -> None:
    write_post(page, demo.url, "Away from the start", "@quadruped walk backward 50 cm")
    wait_for(page.locator("article.by-robot").last, "done")
    reset_room(page, demo)
    write_post(page, demo.url, "After the reset", "@quadruped turn left 45 degrees")
    wait_for(page.locator("article.by-robot").last, "done")


def reset_room(page: Page, demo: RunningDemo) -> None:
    """Reset the room by its button, and wait until the robots, one of which was away from its start, were put back."""
    truth = json.loads((demo.data / "demo.json").read_text())["room"] + "/truth"
    away = positions(truth)
    page.goto(f"{demo.url}/robots/quadruped")
    page.get_by_role("link", name="Reset the room").click()
    page.get_by_role("button", name="Reset the room").click()
    expect(page.get_by_role("status").first).to_contain_text("to be reset")
    deadline = time.monotonic() + 60
    while math.dist(positions(truth), away) < 0.3:
        assert time.monotonic() < deadline, "the robots were not put back"


def positions(truth: str) -> list[float]:
    """Return the robots' true positions in the simulated world: x and y of each, in metres."""
    robots = httpx2.get(truth, timeout=60).json()["robots"]
    return [robots[kind][axis] for kind in ("go2", "g1") for axis in ("x_m", "y_m")]


def test_the_robot_is_seen_moving_on_the_map_and_its_page_replays_it(page: Page, demo: RunningDemo) -> None:
    wrong = listen_for_errors(page)
    write_post(page, demo.url, "On the map", "@quadruped walk forward 0.6 metres and turn left 90 degrees")
    expect(page.locator(".live-state")).to_have_text("now")
    begun, post = marked_at(page, "quadruped"), page.locator("article.post").first.get_attribute("data-post")
    wait_until_moved(page, "quadruped", begun, 0.4)
    assert page.locator('[data-robot="quadruped"] .map-plan').get_attribute("points")
    screenshot(page, "map")
    wait_for(page.locator("article.by-robot").last, "done")
    ended = marked_at(page, "quadruped")
    page.get_by_role("button", name="3D").first.click()
    expect(page.locator(".live-stage canvas, .live-state:has-text('3D is not available')").first).to_be_visible()
    page.goto(f"{demo.url}/c/{post}")
    slider = page.get_by_label("Time in the replay")
    slider.fill("0")
    assert math.dist(marked_at(page, "quadruped"), begun) < 0.15
    page.get_by_label("Speed").select_option("4")
    page.get_by_role("button", name="Play").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible(timeout=MOTION_MS)
    assert math.dist(marked_at(page, "quadruped"), ended) < 0.15
    screenshot(page, "replay")
    assert not wrong


def test_law_17_the_visitor_can_release_a_locked_robot_on_its_page(page: Page, demo: RunningDemo) -> None:
    write_post(page, demo.url, "Emergency", "@quadruped emergency stop")
    answer = page.locator("article.by-robot").last
    expect(answer).to_contain_text("It refuses all motion until its owner releases it.", timeout=MOTION_MS)
    expect(answer).to_contain_text("agentrob release quadruped")
    answer.get_by_role("link", name="my page").click()
    expect(page.locator(".lock")).to_contain_text("Locked by visitor since")
    screenshot(page, "locked")
    page.get_by_role("link", name="Release @quadruped").click()
    page.get_by_role("button", name="Release @quadruped").click()
    expect(page.get_by_text("Released (visitor, ")).to_be_visible()
    expect(page.locator(".lock")).to_have_count(0)
    write_post(page, demo.url, "Afterwards", "@quadruped walk forward 0.3 metres")
    wait_for(page.locator("article.by-robot").last, "done")
