"""Account for what a model's answer cost: tokens, money if a price is configured, and time. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from agentrob.config.minds import PriceConfig

#: Tokens counted for an image if the server does not report them (large providers: 765 to 1,600 for 1024 px).
IMAGE_TOKENS = 1_600


@dataclass(frozen=True, slots=True)
class Usage:
    """One question to one model: who answered, what it cost, or why it failed.

    `mind` is the name in the configuration, `model` the name the server uses. `input_tokens` and `output_tokens` are
    None if unknown; `counted_tokens` is what counted against the limits (an estimate if unknown). `cost` is None
    without a configured price. `attempts` counts requests; `failed` is an `ErrorKind`, empty if it answered.
    """

    mind: str
    model: str
    input_tokens: int | None = None
    output_tokens: int | None = None
    counted_tokens: int = 0
    cost: float | None = None
    currency: str = ""
    latency_ms: float = 0.0
    attempts: int = 1
    failed: str = ""

    def as_data(self) -> dict[str, Any]:
        """Return the usage for records and logs."""
        return {**asdict(self), "latency_ms": round(self.latency_ms, 1)}

    def line(self) -> str:
        """Return one line for people: "clever (gpt-x): 812 + 40 tokens, 0.0031 USD, 640 ms"."""
        if self.failed:
            return f"{self.mind} ({self.model}): {self.failed} after {self.latency_ms:.0f} ms"
        tokens = "tokens unknown"
        if self.input_tokens is not None and self.output_tokens is not None:
            tokens = f"{self.input_tokens} + {self.output_tokens} tokens"
        money = "" if self.cost is None else f", {self.cost:.4f} {self.currency}"
        return f"{self.mind} ({self.model}): {tokens}{money}, {self.latency_ms:.0f} ms"


def cost_of(input_tokens: int, output_tokens: int, price: PriceConfig | None) -> float | None:
    """Return the cost by the configured price, None without one."""
    if price is None:
        return None
    return (input_tokens * price.input_per_million + output_tokens * price.output_per_million) / 1e6


def estimate_tokens(texts: Iterable[str], images: int = 0) -> int:
    """Estimate the tokens of texts, rather high: one per 3 Latin letters or bytes, 1.5 per Chinese character."""
    size = sum(sum(1.5 if ord(c) > 0x2FF else 1 / 3 for c in text) for text in texts)
    return int(size) + 16 + images * IMAGE_TOKENS


def spent_by(mind: str, usage: Sequence[Usage]) -> tuple[int, float]:
    """Return the tokens and money that one mind has used."""
    mine = [u for u in usage if u.mind == mind]
    return sum(u.counted_tokens for u in mine), sum(u.cost or 0.0 for u in mine)
