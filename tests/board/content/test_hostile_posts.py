"""Hostile Markdown (laws 15 and 16): rendered in another process, within limits, and no stop waits for it."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from html import unescape
from pathlib import Path
from typing import Any

import httpx2
import pytest

from agentrob.board import access
from agentrob.board.content import renderer as renderer_module
from agentrob.board.content.markdown import TOO_COMPLEX
from agentrob.board.content.rendered import MAX_HTML, Rendered
from agentrob.board.content.renderer import MAX_NAMES, Renderer
from agentrob.board.db.writer import Transaction
from agentrob.config.board import BoardLimitsConfig
from agentrob.errors import BoardError
from agentrob.model import Account, AccountKind, Role
from tests.board.events.test_streams import post_topic, stream, until
from tests.board.running_board import LIMIT_S, RunningBoard
from tests.language.hostile_markdown import SIZE, TEXTS, fill

#: The event loop's limit of CPU time for one text, well above the measured time.
LOOP_S = 0.1
HOSTILE = [fill("!["), fill("[a]("), fill("*_"), TEXTS["a long link used again and again"], fill("- a\n* a\n")]
WRITER = Account("7", "writer", AccountKind.HUMAN, Role.MEMBER, False)


@pytest.fixture
async def renderer() -> Any:
    made = Renderer(lambda names: frozenset(names) & {"quadruped", "stop"})
    yield made
    await asyncio.to_thread(made.close)


# -------------------------------------------------------------------- rendering
async def test_law_15_no_hostile_text_holds_the_event_loop(renderer: Renderer) -> None:
    for name, text in TEXTS.items():
        begun_s = time.thread_time()
        if name == "different names":
            with pytest.raises(BoardError, match="8000 different names"):
                await renderer.render(text, WRITER)
            continue
        made = await renderer.render(text, WRITER)
        assert time.thread_time() - begun_s < LOOP_S, name
        assert len(made.html) <= MAX_HTML <= 10 * SIZE, f"{name}: bounded in size"
        assert made.raw == text


async def test_a_text_that_renders_too_slowly_is_shown_as_typed(renderer: Renderer) -> None:
    text = "Read this: <b>&amp;\n\n" + fill("![")[: SIZE - 100]
    made = await renderer.render(text, WRITER)
    assert TOO_COMPLEX in made.html
    shown = unescape(made.html.split("</p>\n<p>")[1].removesuffix("</p>\n").replace("<br>", "\n"))
    assert shown == text
    assert "<b>" not in made.html
    assert "read" in made.words.lower(), "its words are indexed"


async def test_a_long_normal_text_is_rendered(renderer: Renderer) -> None:
    for path in sorted((Path(__file__).parents[3] / "docs").rglob("*.md")):
        made = await renderer.render("@quadruped\n\n" + path.read_text()[:40_000], WRITER)
        assert TOO_COMPLEX not in made.html, path.name
        assert 'href="/u/quadruped"' in made.html


async def test_the_render_process_gives_the_same_result_as_this_process(renderer: Renderer) -> None:
    from agentrob.board.content.rendered import Text

    text = "**@quadruped** and @nobody: go 走路\n\n| a | b |\n|---|---|\n| 1 | @quadruped |\n\n" * 40
    assert await renderer.render(text, WRITER) == Text(text).rendered({"quadruped"})


async def test_a_killed_render_process_is_restarted(renderer: Renderer) -> None:
    text = fill("*a* ")[:6_000]  # takes a quarter of the time limit
    first = await renderer.render(text, WRITER)
    assert TOO_COMPLEX not in first.html
    process = renderer._people._process._process._child
    assert process is not None
    process.kill()
    process.wait()
    assert TOO_COMPLEX in (await renderer.render(text, WRITER)).html, "it is not lost"
    assert await renderer.render(text, WRITER) == first


async def test_texts_of_one_account_wait_for_each_other_and_then_are_refused(
    renderer: Renderer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(renderer_module, "PATIENCE_S", 60.0)  # a busy machine renders slowly: that is another refusal
    texts = [renderer.render(fill("*a* ")[: 20_000 + n], WRITER) for n in range(12)]
    other = renderer.render(fill("*b* ")[:20_000], Account("8", "other", AccountKind.HUMAN, Role.MEMBER, False))
    answers = await asyncio.gather(other, *texts, return_exceptions=True)
    refused = [a for a in answers if isinstance(a, BoardError)]
    assert {(e.status, e.code) for e in refused} == {(429, "too_many_texts")}
    assert isinstance(answers[0], Rendered)
    assert len(answers) - len(refused) >= 4
    assert isinstance(await renderer.render(fill("*a* ")[:20_000], WRITER), Rendered), "then there is room again"


async def test_a_text_may_mention_a_hundred_accounts(renderer: Renderer) -> None:
    names = [f"@n{n}" for n in range(MAX_NAMES + 1)]
    for text in (" ".join(names), "\n".join(names) + " word" * 3_000):
        with pytest.raises(BoardError) as caught:
            await renderer.render(text, WRITER)
        assert (caught.value.status, caught.value.code) == (422, "too_many_names")
        assert "at most 100" in str(caught.value.hint)
    assert (await renderer.render(" ".join(names[1:-1]) + " @quadruped", WRITER)).mentions == ("quadruped",)


async def test_html_is_bounded_although_a_long_link_is_repeated(renderer: Renderer) -> None:
    made = await renderer.render("[a]: " + "u" * 30_000 + "\n\n" + "[a] " * 500, WRITER)
    assert len(made.html) <= MAX_HTML
    assert TOO_COMPLEX in made.html


# -------------------------------------------------------------------- stops under load
def crowd(board: RunningBoard, count: int) -> list[httpx2.Client]:
    return [board.client(board.add(f"hostile{n}").name) for n in range(count)]


@pytest.fixture
def under_load(fresh_board: Callable[..., RunningBoard]) -> Iterator[tuple[RunningBoard, threading.Event]]:
    """A board where 24 accounts post, edit and preview hostile texts and mention everybody until the event is set."""
    board, over, busy = fresh_board(), threading.Event(), threading.Semaphore(0)
    topic = post_topic(board.client("op"))["topic"]["id"]
    clients = crowd(board, 24)
    browsers = [board.browser(f"hostile{n}") for n in range(24)]

    def write(n: int) -> None:
        client, browser, round_ = clients[n], browsers[n], 0
        csrf = access.csrf_token(str(browser.cookies[board.settings.cookie]))
        names = " ".join(f"@hostile{m}" for m in range(24))
        while not over.is_set():
            text, round_ = HOSTILE[(n + round_) % len(HOSTILE)], round_ + 1
            made = client.post(f"/topics/{topic}/posts", json={"body": text}, timeout=100)
            busy.release()
            if made.status_code == 201:
                client.patch(f"/posts/{made.json()['post']['id']}", json={"body": text + "!"}, timeout=100)
            browser.post("/preview", data={"csrf": csrf, "body": text}, timeout=100)
            client.post(f"/topics/{topic}/posts", json={"body": names + " " + "a *b* " * 2_000}, timeout=100)

    with ThreadPoolExecutor(24) as pool:
        writing = [pool.submit(write, n) for n in range(24)]
        try:
            for _ in range(3):
                assert busy.acquire(timeout=60)
            yield board, over
        finally:
            over.set()
        for task in writing:
            task.result()


def test_law_15_a_stop_does_not_wait_for_hostile_posts(under_load: tuple[RunningBoard, threading.Event]) -> None:
    board, _ = under_load
    op, robot = board.client("op"), board.client("quadruped")
    topic = post_topic(op)["topic"]["id"]
    took_s = []
    with stream(robot, topic_id=topic) as of_topic, stream(robot, heartbeat=0.25) as of_all:
        for n in range(5):
            begun_s = time.monotonic()
            op.post(f"/topics/{topic}/posts", json={"body": f"@quadruped stop{'!' * n}"}).raise_for_status()
            assert until(of_topic, 1)[0]["data"]["post"]["raw"].startswith("@quadruped stop")
            took_s.append(time.monotonic() - begun_s)
            begun_s = time.monotonic()
            op.post("/robots/quadruped/stop").raise_for_status()
            while next(of_all)["event"] != "robot.stop":
                pass
            took_s.append(time.monotonic() - begun_s)
    # The 24 clients run in this process and compete for the GIL, so this bound is generous; the benchmark measures it.
    assert sorted(took_s)[len(took_s) // 2] < 1.0, took_s


def test_law_15_a_stop_is_written_before_all_waiting_posts(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    store, hold, held = board.services.store, threading.Event(), threading.Event()

    def block(_: Transaction) -> None:
        held.set()
        hold.wait(LIMIT_S)

    topic = post_topic(board.client("op"))["topic"]["id"]

    async def say() -> None:
        op = store.reader.account("op")
        assert op is not None
        bodies = [*(f"words {n}" for n in range(10)), "stop"]
        waiting = [asyncio.create_task(store.reply(op, topic, body)) for body in bodies]
        await asyncio.sleep(0)  # now all of them wait for the writer
        hold.set()
        await asyncio.gather(*waiting)

    with stream(board.client("quadruped"), topic_id=topic) as events, ThreadPoolExecutor(1) as pool:
        blocked = pool.submit(board.run, store.do(block))
        assert held.wait(LIMIT_S)
        board.run(say())
        blocked.result()
        order = [event["data"]["post"]["raw"] for event in until(events, 11)]
    assert order == ["stop", *(f"words {n}" for n in range(10))]


def test_law_16_heartbeats_pause_while_stop_posts_cannot_be_written(
    fresh_board: Callable[..., RunningBoard],
) -> None:
    board = fresh_board()
    hold, held = threading.Event(), threading.Event()

    def block(_: Transaction) -> None:
        held.set()
        hold.wait(LIMIT_S)

    with stream(board.client("quadruped"), heartbeat=0.25) as events:
        assert [next(events)["event"] for _ in range(3)] == ["heartbeat"] * 3
        with ThreadPoolExecutor(1) as pool:
            blocked = pool.submit(board.run, board.services.store.do(block))
            assert held.wait(LIMIT_S)
            threading.Timer(2.5, hold.set).start()
            begun_s = time.monotonic()
            gaps = []
            while not gaps or max(gaps) < 1.5:
                before_s = time.monotonic()
                assert next(events)["event"] == "heartbeat"
                gaps.append(time.monotonic() - before_s)
                assert time.monotonic() - begun_s < LIMIT_S
            blocked.result()
        assert [next(events)["event"] for _ in range(3)] == ["heartbeat"] * 3, "they come again"


# -------------------------------------------------------------------- limits and rights
def test_previews_queue_and_are_refused_beyond_a_limit(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    browser = board.browser("member")
    csrf = access.csrf_token(str(browser.cookies[board.settings.cookie]))
    ask = lambda n: browser.post("/preview", data={"csrf": csrf, "body": fill("*_")[: 20_000 + n]})  # noqa: E731
    with ThreadPoolExecutor(12) as pool:
        answers = list(pool.map(ask, range(12)))
    assert {answer.status_code for answer in answers} == {200, 429}
    assert "still being rendered" in next(a.text for a in answers if a.status_code == 429)


STOP_AND_MORE = "stop\n\n> anything"


@pytest.fixture
def strict(fresh_board: Callable[..., RunningBoard]) -> RunningBoard:
    return fresh_board(limits=BoardLimitsConfig(posts=3, commands=2, uploads=2, sign_ups=2))


def test_law_15_a_guest_may_start_a_topic_that_stops_and_no_other(strict: RunningBoard) -> None:
    strict.add("guest", role=Role.GUEST)
    guest = strict.client("guest")
    topic = {"board_id": "robots", "title": "Buy this", "tags": ["cheap"]}
    for body in (STOP_AND_MORE, "stop and buy", "stop ![](http://a/b)"):
        assert guest.post("/topics", json=topic | {"body": body}).json()["code"] == "board_role"
    for _ in range(5):
        made = guest.post("/topics", json=topic | {"body": "@quadruped stop!"})
        assert made.status_code == 201
        assert (made.json()["topic"]["title"], made.json()["topic"]["tags"]) == ("Stop", [])
    mine = made.json()["post"]["id"]
    assert guest.patch(f"/posts/{mine}", json={"body": "Buy this"}).status_code == 403
    assert guest.patch(f"/posts/{mine}", json={"body": "@quadruped please stop"}).status_code == 200


def test_law_15_beyond_the_limit_only_a_stop_is_accepted(strict: RunningBoard) -> None:
    op, topic = strict.client("op"), {"board_id": "robots", "title": "Mine", "body": "words"}
    made = [op.post("/topics", json=topic).json() for _ in range(3)]
    for body in (STOP_AND_MORE, "stop " * 100):
        assert op.post("/topics", json=topic | {"body": body}).json()["code"] == "too_many_posts"
        reply = op.post(f"/topics/{made[0]['topic']['id']}/posts", json={"body": body})
        assert reply.json()["code"] == "too_many_posts"
    for _ in range(6):
        assert op.post(f"/topics/{made[0]['topic']['id']}/posts", json={"body": "stop"}).status_code == 201
    assert op.post("/topics", json=topic | {"body": "stop"}).json()["topic"]["title"] == "Stop"


def test_law_15_a_locked_topic_accepts_only_a_stop(fresh_board: Callable[..., RunningBoard]) -> None:
    board = fresh_board()
    topic = post_topic(board.client("op"))["topic"]["id"]
    board.client("admin").post(f"/topics/{topic}/lock", json={"locked": True}).raise_for_status()
    say = lambda body: board.client("member").post(f"/topics/{topic}/posts", json={"body": body})  # noqa: E731
    assert say(STOP_AND_MORE).json()["code"] == "locked"
    assert "a post that only says stop is taken" in say("words").json()["hint"]
    assert say("停下！").status_code == 201


def test_a_stop_by_an_authorised_account_keeps_its_title(board: RunningBoard) -> None:
    op = board.client("op")
    made = op.post("/topics", json={"board_id": "robots", "title": "It falls", "body": "@quadruped stop"}).json()
    assert made["topic"]["title"] == "It falls"
