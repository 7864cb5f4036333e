"""Take the screenshots that the documentation shows: each page on desktop and phone, light and dark, side by side in
one picture.

    scripts/board-pictures [--only NAME …] [--whole FOLDER]

`--whole` also writes full-page screenshots as PNG, for a closer look.
"""

from __future__ import annotations

import argparse
import io
import re
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image
from playwright.sync_api import Page

from agentrob.semantic.encoder import Encoder
from tests.board.web.browser_windows import Windows, running_chromium
from tests.board.web.forum_site import Site, running_site
from tests.board.web.page_list import PAGES, PageEntry, fill, send_presence

DOCS = Path(__file__).parents[3] / "docs"
FOLDER = DOCS / "images/board"
APPEARANCES = {
    "desktop-light": ((1280, 900), "light"),
    "desktop-dark": ((1280, 900), "dark"),
    "phone-light": ((390, 844), "light"),
    "phone-dark": ((390, 844), "dark"),
}
HEIGHT, GAP = 640, 8
MOST_BYTES = 150_000


def side_by_side(pictures: Sequence[bytes]) -> bytes:
    """Put the screenshots of one page side by side; return a WebP of at most `MOST_BYTES`."""
    opened = [Image.open(io.BytesIO(picture)).convert("RGB") for picture in pictures]
    scaled = [p.resize((round(p.width * HEIGHT / p.height), HEIGHT), Image.Resampling.LANCZOS) for p in opened]
    made = Image.new("RGB", (sum(p.width for p in scaled) + GAP * (len(scaled) - 1), HEIGHT), (128, 128, 128))
    x = 0
    for picture in scaled:
        made.paste(picture, (x, 0))
        x += picture.width + GAP
    for quality in (80, 70, 60, 45, 30):
        file = io.BytesIO()
        made.save(file, "WEBP", quality=quality, method=6)
        if file.tell() <= MOST_BYTES:
            break
    return file.getvalue()


LOADED = """() => Promise.race([
  new Promise(done => setTimeout(done, 5000)),
  Promise.all([...document.images].filter(image => !image.closest('.camera')).map(image => {
    image.loading = 'eager';
    return image.complete || new Promise(done => { image.onload = image.onerror = done; });
  })),
])"""


def open_and_wait(site: Site, names: Mapping[str, str], page: Page, path: str) -> None:
    """Open a page and wait until its pictures are loaded, except the live camera, which never finishes loading."""
    page.goto(path, wait_until="domcontentloaded")
    page.evaluate(LOADED)
    if "/robots/" in path and page.locator("[data-camera]").count():
        page.locator(".camera").scroll_into_view_if_needed()  # it runs only while it is on the screen
        page.locator(".camera img").wait_for()
        for _ in range(2):  # a browser shows a frame of a multipart stream only when the next one arrives
            send_presence(site, names)
        page.evaluate(FRAME_SHOWN)
        page.evaluate("scrollTo(0, 0)")


FRAME_SHOWN = """async () => {
  for (const until = Date.now() + 5000; !document.querySelector('.camera img')?.naturalWidth;) {
    if (Date.now() > until) throw new Error('no live picture');
    await new Promise(done => setTimeout(done, 50));
  }
}"""


def wait_until_indexed(site: Site) -> None:
    """Wait until the posts are indexed for search by meaning."""
    asked, pause, until_s = {"q": "walk", "mode": "meaning"}, threading.Event(), time.monotonic() + 60.0
    while not site.api("alice").get("/search", params=asked).json()["items"]:
        if time.monotonic() > until_s:
            raise TimeoutError("no post was indexed by meaning within a minute")
        pause.wait(0.2)


def take_screenshots(
    site: Site, windows: Windows, wanted: Sequence[PageEntry], whole: Path | None
) -> dict[str, list[bytes]]:
    names = fill(site)
    wait_until_indexed(site)
    taken: dict[str, list[bytes]] = {entry.name: [] for entry in wanted}
    for look, ((width, height), theme) in APPEARANCES.items():
        for who in sorted({entry.who or "" for entry in wanted}):
            size = {"width": width, "height": height}
            page = windows.open(who or None, viewport=size, color_scheme=theme, reduced_motion="no-preference")
            for entry in (s for s in wanted if (s.who or "") == who):
                send_presence(site, names)
                open_and_wait(site, names, page, entry.path.format(**names))
                taken[entry.name].append(page.screenshot())
                if whole:
                    page.screenshot(path=whole / f"{entry.name}-{look}.png", full_page=True)
    return taken


def shown() -> set[str]:
    """The names of the pictures that pages of the documentation show."""
    pages = DOCS.rglob("*.md")
    return {
        name for page in pages for name in re.findall(r"images/board/([\w-]+)\.webp", page.read_text(encoding="utf-8"))
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", nargs="*", default=[], help="names of pages")
    parser.add_argument("--whole", type=Path, help="a folder for full-page screenshots as PNG")
    given = parser.parse_args()
    wanted = [entry for entry in PAGES if entry.name in (given.only or shown())]
    if given.whole:
        given.whole.mkdir(parents=True, exist_ok=True)
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (
        TemporaryDirectory() as folder,
        running_site(Path(folder), sign_up=True, encoder=Encoder) as site,
        running_chromium() as chromium,
    ):
        for name, pictures in take_screenshots(site, Windows(site, chromium), wanted, given.whole).items():
            (FOLDER / f"{name}.webp").write_bytes(side_by_side(pictures))
            sys.stdout.write(f"{name}\n")


if __name__ == "__main__":
    main()
