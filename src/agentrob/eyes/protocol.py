"""The protocol of a detector: a picture goes in, what can be seen in it comes out.

A detector is found by an entry point of the group `agentrob.detectors`, which names a class. It is made once, with the
options of its robot's configuration, and asked in a thread of the agent, one picture after the other.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

#: A picture: (height, width, 3) of red, green and blue from 0 to 255.
Picture = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Detection:
    """One thing in a picture.

    `thing` and `colour` are English words ("ball", "red"), empty where the detector cannot tell. `box` is (left, top,
    right, bottom) in pixels, right and bottom beyond its last pixel. `score` is from 0 to 1.
    """

    thing: str
    colour: str
    box: tuple[int, int, int, int]
    score: float


@runtime_checkable
class Detector(Protocol):
    """Finds things in a picture. `things` and `colours` are the English words that it can tell apart: of anything else
    the robot says that it cannot see it."""

    @property
    def things(self) -> Collection[str]: ...

    @property
    def colours(self) -> Collection[str]: ...

    def detect(self, picture: Picture) -> Sequence[Detection]:
        """Return what is in the picture, the surest first. It may raise any error, which the reply tells."""
        ...


class DetectorFactory(Protocol):
    """The class or function that an entry point names. Raises `ConfigError` for options that it does not know."""

    def __call__(self, options: Mapping[str, Any]) -> Detector: ...
