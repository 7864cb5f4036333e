"""Excerpts are the first sentences of prose of a post; search results show the words that were found."""

from __future__ import annotations

import time
from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from agentrob.agent.media.pictures import Picture
from agentrob.agent.reporting import report as words
from agentrob.board.content.excerpts import (
    AROUND_FROM,
    EXCERPT_FROM,
    LENGTH,
    ReportParts,
    around,
    excerpt,
    report_parts,
)
from agentrob.board.content.markdown import render
from agentrob.model import (
    Account,
    ActionResult,
    Command,
    CommandState,
    Direction,
    Op,
    Outcome,
    Plan,
    Primitive,
    Report,
)

TABLE = "| Step | Asked | Measured |\n| ---: | --- | --- |\n| 1 | walk forward 1 m | 1.02 m |"


def html(raw: str) -> str:
    return render(raw, lambda name: name == "quadruped")


def robot_report(status: CommandState, *results: ActionResult) -> str:
    alice = Account("2", "alice")
    command = Command("1", "1", "h", alice, "quadruped", "…", "en", datetime.now(UTC), "4f1c22aa")
    plan = Plan(tuple(result.primitive for result in results))
    report = Report(command, status, plan=plan, results=results, timings_ms={"seen": 31.0, "first_motion": 148.0})
    return words.final(report, [Picture("step", b"", 1)], page="/c/1")


# -------------------------------------------------------------------- excerpts
def test_an_excerpt_of_a_robots_report_says_what_happened_without_its_table() -> None:
    walk = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    done = ActionResult(walk, Outcome.DONE, {"distance_m": 1.02})
    text = excerpt(html(robot_report(CommandState.DONE, done)))
    assert text == "Done: walked 1.02 m."

    blocked = ActionResult(walk, Outcome.FAILED, {"distance_m": 0.41}, "obstacle", "Something is 0.5 m ahead.")
    text = excerpt(html(robot_report(CommandState.FAILED, done, blocked)))
    assert text == (
        "Failed at step 2. Something is 0.5 m ahead. Clear the way, or ask for a shorter distance or another direction."
    )


@pytest.mark.parametrize(
    ("raw", "expected"),
    [
        (f"It walked.\n\n{TABLE}\n\nIt saw a door.", "It walked. It saw a door."),
        ("Like this:\n\n```python\nimport os\n```\n\nThen run it.", "Like this: Then run it."),
        ("> walk 1 m\n\nThat was quick.", "That was quick."),
        ("# Results\n\nIt walked.", "It walked."),
        ("![the door](/images/abc.png) It saw a door.", "It saw a door."),
        ("Use `walk 1 m` and [the *page*](https://example.org/x).", "Use walk 1 m and the page."),
        ("@quadruped walk 1 m & wave <now>", "@quadruped walk 1 m & wave <now>"),
        ("one\ntwo\n\n- three\n- four", "one two · three · four"),
        ("向前走了两米。\n\n然后挥手。", "向前走了两米。 然后挥手。"),
        ("> only a quote", "only a quote"),
        ("# only a heading", "only a heading"),
        ("*only small print*", "only small print"),
        (TABLE, "(a table)"),
        ("```\nimport os\n```", "(code)"),
        ("![x](/images/abc.png)", "(a picture)"),
        ("", "(a picture)"),
    ],
)
def test_an_excerpt_is_prose_without_tables_pictures_code_and_quotations(raw: str, expected: str) -> None:
    assert excerpt(html(raw)) == expected


def test_a_long_excerpt_ends_with_a_sentence_or_with_an_ellipsis() -> None:
    sentence = "The robot walked to the window and took a photo of the garden."
    assert excerpt(html(f"{sentence} {sentence} {sentence}")) == f"{sentence} {sentence}"
    text = excerpt(html(f"Yes. {'The robot walked and ' * 20}stopped."))
    assert text.startswith("Yes. The robot walked")
    assert text.endswith("…")
    assert LENGTH / 2 < len(text) <= LENGTH + 1


@given(st.text())
def test_any_text_has_an_excerpt_of_one_line(raw: str) -> None:
    text = excerpt(html(raw))
    assert "\n" not in text
    assert 0 < len(text) <= LENGTH + 1


@given(st.text(alphabet="a |-:*`#>\n", max_size=40))
def test_an_excerpt_shows_no_tags(raw: str) -> None:
    assert not set(excerpt(html(raw))) & set("</")


@pytest.mark.parametrize(
    "hostile", ["|", "--", "\n", "*", "*a ", "<p>", "<table>", "<p><em>", "&amp;", "<li>a", "</em>"]
)
def test_an_excerpt_of_hostile_html_does_not_hold_up_the_event_loop(hostile: str) -> None:
    """Only a part of a post of 640 KiB is read, because a page shows thirty excerpts."""
    long = hostile * (640 * 1024 // len(hostile))
    started = time.thread_time()
    assert excerpt(long) == excerpt(long[:EXCERPT_FROM])
    around(long, "garden path")
    assert time.thread_time() - started < 0.1


# -------------------------------------------------------------------- search results
def test_search_results_mark_words_at_their_beginning() -> None:
    assert around(html("a photo to print"), "to") == (("a photo ", False), ("to", True), (" print", False))
    assert around(html("it walked"), "walk") == (("it ", False), ("walk", True), ("ed", False))
    assert around(html("四足机器人"), "机器") == (("四足", False), ("机器", True), ("人", False))
    assert around(html("a **bold** word here"), "word") == (("a bold ", False), ("word", True), (" here", False))
    assert around(html("R&D <b>"), "r&d") == (("R&D", True), (" <b>", False))


def test_a_shown_part_begins_with_a_whole_word() -> None:
    shown = around(html(f"{'metres ' * 40}and a garden"), "garden")
    assert shown[0] == ("…", False)
    assert shown[1][0].startswith("metres metres ")
    assert around(html("前进" * 60 + "花园"), "花园")[1][0].endswith("前进")


def test_a_word_only_in_a_table_or_in_code_shows_the_first_sentences() -> None:
    assert around(html(f"It walked.\n\n{TABLE}"), "measured") == (("It walked.", False),)
    assert around(html("Run this:\n\n```\nimport os\n```"), "import") == (("Run this:", False),)
    assert around(html(f"It walked.\n\n{TABLE}"), "p") == (("It walked.", False),)


@pytest.mark.parametrize("before", ["lorem ipsum dolor. " * 2000, "lorem\n\n" * 4000, f"{TABLE}\n\n" * 400])
def test_a_word_far_down_a_long_post_is_shown(before: str) -> None:
    page = html(f"{before}\n\nThe very last words are *here*.")
    assert len(page) > 3 * AROUND_FROM
    shown = around(page, '"last words" here')
    assert [piece for piece, hit in shown if hit] == ["last words", "here"]
    assert shown[0] == ("…", False)
    assert not any("Measured" in piece for piece, _ in shown)


def test_a_search_shows_what_a_report_says_and_not_its_details() -> None:
    walk = Primitive(Op.MOVE, Direction.FORWARD, distance_m=1.0)
    found = html(robot_report(CommandState.DONE, ActionResult(walk, Outcome.DONE, {"distance_m": 1.02})))
    assert "".join(words for words, _ in around(found, "walked")) == "Done: walked 1.02 m."
    assert around(found, "4f1c22aa") == (("Done: walked 1.02 m.", False),)


def test_a_report_is_split_at_its_table_and_its_details() -> None:
    parts = report_parts(
        html("**Done:** x.\n\n| a |\n|---|\n| 1 |\n\nAssumed.\n\n#### Details\n\n*trace*\n\n#### Details\n\nz")
    )
    assert (parts.lead, parts.heading) == ("<p><strong>Done:</strong> x.</p>\n", "Details")
    assert parts.rest.startswith("<table>")
    assert "Assumed." in parts.rest
    assert "trace" in parts.details
    assert "z" in parts.details
    plain = html("No report.\n\n#### Other\n\nText")
    assert report_parts(plain) == ReportParts(plain)
    assert report_parts(html("**完成**：走了。\n\n#### 详情\n\n*x*")).heading == "详情"
