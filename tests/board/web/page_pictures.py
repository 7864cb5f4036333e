"""Pictures of the forum's pages for docs/board.md: each page on a desktop and a phone, light and dark, on one sheet.

    scripts/board-pictures [--only NAME …] [--whole FOLDER]

`--whole` also writes each page in its full length as PNG, to look at closely.
"""

from __future__ import annotations

import argparse
import io
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
from tests.board.web.page_world import World, running_world
from tests.board.web.shown_pages import PAGES, Shown, alive, fill

SHEETS = Path(__file__).parents[3] / "docs/images/board"
LOOKS = {
    "desktop-light": ((1280, 900), "light"),
    "desktop-dark": ((1280, 900), "dark"),
    "phone-light": ((390, 844), "light"),
    "phone-dark": ((390, 844), "dark"),
}
HEIGHT, GAP = 640, 8
MOST_BYTES = 150_000


def sheet(pictures: Sequence[bytes]) -> bytes:
    """The looks of one page side by side, as WebP of at most `MOST_BYTES`."""
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


def settle(world: World, names: Mapping[str, str], page: Page, path: str) -> None:
    """Go there and wait until its pictures are there; a live camera never ends loading."""
    page.goto(path, wait_until="domcontentloaded")
    page.evaluate(LOADED)
    if "/robots/" in path and page.locator("[data-camera]").count():
        page.locator(".camera img").wait_for()
        for _ in range(2):  # a browser shows a live picture when the next one comes
            alive(world, names)
        page.evaluate(SEEN)


SEEN = """async () => {
  for (const until = Date.now() + 5000; !document.querySelector('.camera img')?.naturalWidth;) {
    if (Date.now() > until) throw new Error('no live picture');
    await new Promise(done => setTimeout(done, 50));
  }
}"""


def understood(world: World) -> None:
    """Wait until what the posts mean is known."""
    asked, pause, until_s = {"q": "walk", "mode": "meaning"}, threading.Event(), time.monotonic() + 60.0
    while not world.api("alice").get("/search", params=asked).json()["items"]:
        if time.monotonic() > until_s:
            raise TimeoutError("no post was understood within a minute")
        pause.wait(0.2)


def take(world: World, windows: Windows, wanted: Sequence[Shown], whole: Path | None) -> dict[str, list[bytes]]:
    names = fill(world)
    understood(world)
    taken: dict[str, list[bytes]] = {shown.name: [] for shown in wanted}
    for look, ((width, height), theme) in LOOKS.items():
        for who in sorted({shown.who or "" for shown in wanted}):
            size = {"width": width, "height": height}
            page = windows.open(who or None, viewport=size, color_scheme=theme, reduced_motion="no-preference")
            for shown in (s for s in wanted if (s.who or "") == who):
                alive(world, names)
                settle(world, names, page, shown.path.format(**names))
                taken[shown.name].append(page.screenshot())
                if whole:
                    page.screenshot(path=whole / f"{shown.name}-{look}.png", full_page=True)
    return taken


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", nargs="*", default=[], help="names of pages")
    parser.add_argument("--whole", type=Path, help="a folder for whole pages as PNG")
    given = parser.parse_args()
    wanted = [shown for shown in PAGES if not given.only or shown.name in given.only]
    if given.whole:
        given.whole.mkdir(parents=True, exist_ok=True)
    SHEETS.mkdir(parents=True, exist_ok=True)
    with (
        TemporaryDirectory() as folder,
        running_world(Path(folder), sign_up=True, encoder=Encoder) as world,
        running_chromium() as chromium,
    ):
        for name, pictures in take(world, Windows(world, chromium), wanted, given.whole).items():
            (SHEETS / f"{name}.webp").write_bytes(sheet(pictures))
            sys.stdout.write(f"{name}\n")


if __name__ == "__main__":
    main()
