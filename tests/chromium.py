"""Which Chromium the tests start: Debian's headless shell, if it is installed.

It is the same engine without the windows of the browser, and takes a third of the CPU time: 5 s for the eight tests of
the pages' layout, 10 s in Chromium.
"""

from __future__ import annotations

import shutil
from functools import cache

NAMES = ("chromium-headless-shell", "chromium", "google-chrome")


@cache
def chromium_path() -> str:
    found = next(filter(None, map(shutil.which, NAMES)), None)
    assert found, f"the browser tests need one of {', '.join(NAMES)} (make test installs one when it may)"
    return found
