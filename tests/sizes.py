"""How much a test tries: a CI size, and the full size of `make test-long` (`AGENTROB_TEST_SIZE=full`)."""

from __future__ import annotations

import os

FULL = os.environ.get("AGENTROB_TEST_SIZE", "ci") == "full"


def size(ci: int, full: int) -> int:
    """How many examples, sentences or kills to try."""
    return full if FULL else ci
