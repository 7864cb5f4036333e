"""The sizes of tests: one for CI, and the full size for `make test-long` (`AGENTROB_TEST_SIZE=full`)."""

from __future__ import annotations

import os

FULL = os.environ.get("AGENTROB_TEST_SIZE", "ci") == "full"


def size(ci: int, full: int) -> int:
    """Return the number of examples, sentences or kills to try."""
    return full if FULL else ci
