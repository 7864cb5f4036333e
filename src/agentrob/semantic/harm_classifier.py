"""Estimate from the meaning of a post whether it asks for something dangerous: a second opinion beside the rules.

A linear classifier on the vectors of `agentrob.semantic.encoder`. It knows topics, not details: "hit the wall" and
"paint the wall" are hard to tell apart for it. So its opinion may make a robot ask, and never refuses or allows
anything. `scripts/train_harm_classifier.py` trains it on the project's own pairs; the weights carry their licence, and
a file that was changed is not loaded.
"""

from __future__ import annotations

import hashlib
import json
import math
import operator
import struct
from dataclasses import dataclass
from pathlib import Path

from agentrob.errors import ConfigError
from agentrob.semantic.encoder import MODEL, SIZE, TextEncoder

WEIGHTS = Path(__file__).with_name("harm_weights.json")
#: The checksum of `WEIGHTS`; the training script prints it.
SHA256 = "20c51e85e0a821dbf2b0efe7526a2b8683c23e4f8dff32a8dcf0f9d4fd6b421b"
#: Longer posts are judged by their beginning: the encoder's time grows with the length.
MOST_CHARS = 400


@dataclass(frozen=True, slots=True)
class HarmClassifier:
    """Scores vectors: above 0 means that the text is more likely dangerous than the threshold of the training."""

    weights: tuple[float, ...]
    bias: float

    def score(self, vector: bytes) -> float:
        """Return the score of one vector; minus infinity for that of an empty text."""
        numbers = struct.unpack(f"{SIZE}b", vector)
        length = math.hypot(*numbers)
        if not length:
            return -math.inf
        return float(sum(map(operator.mul, self.weights, numbers))) / length + self.bias


def load_classifier(path: Path = WEIGHTS, sha256: str | None = None) -> HarmClassifier:
    """Read the weights. Raises `ConfigError` if the file was changed or belongs to another encoder."""
    content = path.read_bytes()
    if hashlib.sha256(content).hexdigest() != (SHA256 if sha256 is None else sha256):
        raise ConfigError(f"{path} does not have the expected checksum: install agentrob again")
    told = json.loads(content)
    if told["encoder"] != MODEL or len(told["weights"]) != SIZE:
        raise ConfigError(f"{path} was trained for another encoder: {told['encoder']}")
    return HarmClassifier(tuple(told["weights"]), told["bias"])


def is_suspected(text: str, encoder: TextEncoder, classifier: HarmClassifier) -> bool:
    """Return whether the classifier suspects harm in a text. Blocks; raises `EncoderError`."""
    (vector,) = encoder.encode([text[:MOST_CHARS]])
    return classifier.score(vector) > 0
