"""Estimate from the meaning of a post whether it asks for something dangerous: a second opinion beside the rules.

A linear classifier on the vectors of `agentrob.semantic.encoder`. It knows topics, not details: "hit the wall" and
"paint the wall" are hard to tell apart for it. So its opinion may make a robot ask, and never refuses or allows
anything. `scripts/train_harm_classifier.py` trains it on the project's own sentences; the file of weights carries its
licence and the checksums of what it was trained on, and a file that was changed is not loaded.
"""

from __future__ import annotations

import hashlib
import json
import math
import operator
import re
import struct
import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from agentrob.errors import ConfigError
from agentrob.semantic.encoder import EXTRA, MODEL, SIZE, Encoder, TextEncoder, require_model

WEIGHTS = Path(__file__).with_name("harm_weights.json")
#: The checksum of `WEIGHTS`; the training script prints it.
SHA256 = "2cf67951efd4045ab62023cfef0433cb0f9041ce3a49985570254b692df537b6"
#: Longer posts are judged by their beginning: the encoder's time grows with the length.
MOST_CHARS = 400
_CAMEL = re.compile(r"(?<=[a-z])(?=[A-Z])")


@dataclass(frozen=True, slots=True)
class HarmClassifier:
    """Scores vectors; texts above the threshold of their language are suspected."""

    weights: tuple[float, ...]
    thresholds: Mapping[str, float]

    def score(self, vector: bytes) -> float:
        """Return the score of one vector; minus infinity for that of an empty text."""
        numbers = struct.unpack(f"{SIZE}b", vector)
        length = math.hypot(*numbers)
        if not length:
            return -math.inf
        return float(sum(map(operator.mul, self.weights, numbers))) / length

    def is_suspect(self, vector: bytes, language: str) -> bool:
        """Return whether the text of a vector is suspected; other languages have the highest of the thresholds."""
        return self.score(vector) > self.thresholds.get(language, max(self.thresholds.values()))


def load_classifier(path: Path = WEIGHTS, sha256: str = SHA256) -> HarmClassifier:
    """Read the weights. Raises `ConfigError` if the file is absent, was changed or belongs to another encoder."""
    try:
        content = path.read_bytes()
    except OSError as e:
        raise ConfigError(f"the weights of the harm classifier cannot be read: {e}; install agentrob again") from None
    if hashlib.sha256(content).hexdigest() != sha256:
        raise ConfigError(f"{path} does not have the expected checksum: install agentrob again")
    model = json.loads(content)
    if model["encoder"] != MODEL or len(model["weights"]) != SIZE:
        raise ConfigError(f"{path} was trained for another encoder: {model['encoder']}")
    return HarmClassifier(tuple(model["weights"]), model["thresholds"])


def normalised(text: str) -> str:
    """Return a text as the classifier reads it: without capitals, which the encoder takes for names."""
    return _CAMEL.sub(" ", text[:MOST_CHARS]).lower().strip(" .!\"'")


def is_suspected(text: str, language: str, encoder: TextEncoder, classifier: HarmClassifier) -> bool:
    """Return whether the classifier suspects harm in a text. Blocks; raises `EncoderError`."""
    (vector,) = encoder.encode([normalised(text)])
    return classifier.is_suspect(vector, language)


class HarmDetector:
    """The shipped classifier with an encoder of its own; `close` it after use."""

    def __init__(self) -> None:
        """Raises `ConfigError` if the extra is not installed or the weights cannot be used."""
        try:
            require_model()
        except ConfigError:
            raise ConfigError(f'an extra is not installed: pip install "{EXTRA}"') from None
        self._classifier = load_classifier()
        self._encoder = Encoder()

    def suspects(self, text: str, language: str) -> bool:
        """Return whether harm is suspected in a text. Blocks; raises `EncoderError`."""
        return is_suspected(text, language, self._encoder, self._classifier)

    def close(self) -> None:
        self._encoder.close()


def check_harm_classifier() -> float:
    """Judge one sentence; return the seconds that this took, including the loading of the model.

    Raises `ConfigError` if the classifier cannot be loaded, `EncoderError` if it does not answer.
    """
    begun_s = time.monotonic()
    with closing(HarmDetector()) as detector:
        detector.suspects("walk forward 1 m", "en")
    return time.monotonic() - begun_s
