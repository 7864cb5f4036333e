"""Errors of models: a sentence that says what to do, and a stable word for records; never with a key."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from agentrob.errors import MindError
from agentrob.minds.usage import Usage

ErrorKind = Literal[
    "no_key",  # the environment has no key
    "no_library",  # the model libraries are not installed
    "denied",  # 401, 403
    "not_found",  # 404: wrong base_url or model
    "rejected",  # another 4xx
    "limited",  # 429, 402
    "server",  # 5xx
    "dns",
    "tls",
    "unreachable",  # refused, reset, no route
    "broken",  # an answer that broke off
    "timeout",
    "too_big",
    "malformed",  # an answer that is not in the schema, or no JSON
    "budget",  # our own limit on tokens or money
]
#: Errors that a retry may solve.
TRANSIENT: frozenset[ErrorKind] = frozenset(["limited", "server", "unreachable", "broken", "timeout"])
#: Errors before the provider served anything, so that it does not bill.
UNBILLED: frozenset[ErrorKind] = frozenset(
    ["no_key", "no_library", "denied", "not_found", "rejected", "limited", "server", "dns", "tls", "unreachable"]
)


class ModelError(MindError):
    """A model did not answer. `kind` is a stable word, `usage` what was spent, including failed attempts."""

    def __init__(
        self,
        kind: ErrorKind,
        message: str,
        retry_after_s: float | None = None,
        usage: Sequence[Usage] = (),
        final: bool = False,
    ) -> None:
        super().__init__(message)
        self.kind = kind
        self.retry_after_s = retry_after_s
        self.usage = tuple(usage)
        self._final = final

    @property
    def transient(self) -> bool:
        """Whether a retry may help."""
        return self.kind in TRANSIENT and not self._final


def one_line(text: object, secrets: Sequence[str] = (), limit: int = 160) -> str:
    """Return a text on one line for a log: short, printable, and without any of the secrets."""
    line = " ".join("".join(c if c.isprintable() else " " for c in str(text)[:10_000]).split())
    for secret in secrets:
        if secret:
            line = line.replace(secret, "[key]")
    return line if len(line) <= limit else line[: limit - 1] + "…"
