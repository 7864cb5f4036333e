"""XSS payloads rendered as posts, in a real browser: none runs a script, sends a request or changes the page's layout.

A few payloads in this file always run. A large collection is added if it exists (`AGENTROB_EVAL`, or the folder
`shared/eval` beside the checkout); otherwise the test prints that it was not measured.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from agentrob.board.content.markdown import _CLEANER, _MARKDOWN, render
from tests.board.web.browser_windows import CHROMIUM_ARGS
from tests.chromium import chromium_path

pytestmark = pytest.mark.browser

EVAL = Path(os.environ.get("AGENTROB_EVAL") or Path(__file__).parents[4] / "shared/eval")

OWN = [
    "<script>alert(1)</script>",
    "<img src=x onerror=alert(1)>",
    "<svg/onload=alert(1)>",
    "![x](javascript:alert(1))",
    '![x" onerror="alert(1)](/images/a.png)',
    '![x](/images/a.png "t\\" onerror=alert(1) x=\\"")',
    "[x](javascript&colon;alert(1))",
    "[x](java\nscript:alert(1))",
    "[x](\x01javascript:alert(1))",
    "<javascript:alert(1)>",
    "[x]: javascript:alert(1)\n\n[x]",
    "```\n</code></pre><script>alert(1)</script>\n```",
    "`</code><img src=x onerror=alert(1)>`",
    "|<script>alert(1)</script>|\n|-|\n|<svg onload=alert(1)>|",
    "@quadruped<script>alert(1)</script>",
    "https://example.org/\"onmouseover=alert(1)//'",
    "<style>*{background:url(http://evil.test/x)}</style>",
    "<iframe srcdoc='<script>parent.alert(1)</script>'></iframe>",
    "<math><mtext><table><mglyph><style><!--</style><img title='--&gt;&lt;img src=1 onerror=alert(1)&gt;'>",
    "<a href='javascript:alert(1)' autofocus onfocus=alert(1) tabindex=1>x</a>",
    "<form action=http://evil.test><input name=csrf><button autofocus>go</button></form>",
    "<base href=http://evil.test/><meta http-equiv=refresh content='0;url=http://evil.test'>",
]

#: Records the calls by which a payload commonly shows that it ran.
TRAP = """
window.ran = [];
for (const name of ['alert', 'confirm', 'prompt', 'print', 'open', 'fetch'])
  window[name] = (...args) => { window.ran.push(name + '(' + args.join() + ')'); };
addEventListener('error', e => { if (e.message) window.ran.push('error ' + e.message); });
"""

#: Sends mouse, keyboard and form events to every element, without following links to other pages.
POKE = """() => {
  document.addEventListener('click', e => { if (!e.target.closest('a[href^="javascript"]')) e.preventDefault(); });
  document.addEventListener('submit', e => e.preventDefault());
  for (const element of document.querySelectorAll('body *')) {
    for (const kind of ['mouseover', 'mouseout', 'click', 'focus', 'blur', 'input', 'error', 'load', 'toggle'])
      element.dispatchEvent(new Event(kind, {bubbles: true, cancelable: true}));
    element.focus?.();
  }
  return document.querySelectorAll('script, style, iframe, object, embed, form, input, button, svg, math, base, '
    + 'meta:not([charset]), [style], [id]:not(#here)').length;
}"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=chromium_path(), args=CHROMIUM_ARGS)
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    context = browser.new_context()
    page = context.new_page()
    page.add_init_script(TRAP)
    yield page
    context.close()


def say(line: str) -> None:
    """Print a line even while pytest captures output."""
    sys.__stdout__.write(f"\n{line}\n") if sys.__stdout__ else None


def all_payloads() -> list[str]:
    path = EVAL / "xss.jsonl"
    if not path.exists():
        say(f"NOT MEASURED: the collection of attacks {path} is absent; only {len(OWN)} attacks of our own ran")
        return OWN
    with path.open(encoding="utf-8") as lines:
        found = [json.loads(line)["text"] for line in lines]
    say(f"measured on {len(found)} attacks from {path.name} and {len(OWN)} of our own")
    return OWN + found


def attack(page: Page, fragments: list[str]) -> tuple[list[str], list[str], int]:
    """Show HTML fragments on one page without a content security policy.

    Return the calls that ran, the URLs that were requested, and the number of elements that no post may contain.
    """
    asked: list[str] = []
    body = "\n".join(f"<article>{fragment}</article>" for fragment in fragments)
    document = f"<!doctype html><meta charset=utf-8><title>x</title><body id=here>{body}</body>"

    def answer(route: object) -> None:
        url = route.request.url  # type: ignore[attr-defined]
        if url == "http://board.test/t/1":
            route.fulfill(body=document, content_type="text/html")  # type: ignore[attr-defined]
            return
        if not url.startswith("http://board.test/images/"):
            asked.append(url)
        route.abort()  # type: ignore[attr-defined]

    page.route("**/*", answer)
    page.on("dialog", lambda dialog: (asked.append(f"dialog {dialog.message}"), dialog.dismiss()))
    page.goto("http://board.test/t/1")
    foreign = page.evaluate(POKE)
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => setTimeout(done, 100)))")
    asked = [url for url in asked if not url.endswith("/favicon.ico")]
    return page.evaluate("window.ran"), asked, foreign


def test_an_unsanitised_payload_is_detected(page: Page) -> None:
    ran, asked, foreign = attack(page, ["<img src=http://evil.test/x onerror=alert(7)>", "<svg onload=alert(8)></svg>"])
    assert "alert(7)" in ran
    assert asked == ["http://evil.test/x"]
    assert foreign == 1


def test_no_payload_has_any_effect_in_a_post(page: Page) -> None:
    fragments = [render(text, lambda _: True) for text in all_payloads()]
    assert attack(page, fragments) == ([], [], 0)


def test_the_sanitiser_alone_stops_every_script(page: Page) -> None:
    """The sanitiser must suffice if the Markdown parser let HTML through."""
    assert attack(page, [_CLEANER.clean(text) for text in all_payloads()]) == ([], [], 0)


def test_the_parser_alone_stops_every_script(page: Page) -> None:
    """The Markdown parser must suffice if its output were not sanitised."""
    ran, asked, _ = attack(page, [_MARKDOWN.render(text, {"is_account": lambda _: True}) for text in all_payloads()])
    assert (ran, asked) == ([], [])
