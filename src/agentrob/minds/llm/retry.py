"""When to ask again: exponential waits with full jitter, and never before the server wants it. Pure."""

from __future__ import annotations

FIRST_S = 0.5
LONGEST_S = 8.0


def wait_s(attempt: int, chance: float, retry_after_s: float | None = None) -> float:
    """Seconds to wait after failed attempt number `attempt` (1, 2, …); `chance` is evenly in 0..1.

    Full jitter (a random part of the growing bound) spreads clients that failed together; what the server asked for
    is kept and jittered above, so that they do not come back together either.
    """
    bound = min(LONGEST_S, FIRST_S * 2.0 ** (min(attempt, 32) - 1))
    if retry_after_s is None:
        return bound * chance
    return max(0.0, retry_after_s) + 0.1 * bound * chance
