"""The replay of a command: its poses as compressed JSON, for the viewer of the command's page."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple

from agentrob.agent.media.room_map import Point
from agentrob.language.messages.plan_text import step_label
from agentrob.model import Pose, Posture
from agentrob.rehearsal.preview import Preview

VERSION = 1
#: A longer replay keeps every second pose, until it is as small as this.
MOST_BYTES = 20_000
#: A command takes at most a minute or two; more samples than this are not kept.
MOST_SAMPLES = 3000
FEWEST_SAMPLES = 50


class PoseSample(NamedTuple):
    """One pose in the frame of the room at `at_s` (monotonic), and how the body was held."""

    at_s: float
    pose: Pose
    posture: Posture

    @property
    def body(self) -> list[float]:
        """Height, tilt (w, x, y, z) and joint angles; empty if they are not known."""
        if self.posture.height_m is None or self.posture.tilt is None or not self.posture.joints_rad:
            return []
        return [round(v, 3) for v in (self.posture.height_m, *self.posture.tilt, *self.posture.joints_rad)]


@dataclass
class PoseLog:
    """The poses of one command. `plan` is its requested path, `steps` when each step began: (monotonic s, words)."""

    plan: list[Point] = field(default_factory=list)
    samples: list[PoseSample] = field(default_factory=list)
    steps: list[tuple[float, str]] = field(default_factory=list)

    def add(self, sample: PoseSample) -> None:
        if len(self.samples) < MOST_SAMPLES:
            self.samples.append(sample)


def preview_log(preview: Preview) -> PoseLog:
    """The first run of a preview, as the poses of a command; empty if it was not simulated."""
    log = PoseLog([(round(x_m, 3), round(y_m, 3)) for x_m, y_m, _ in preview.planned])
    labels = [step_label(step, "en") for step in preview.plan.steps]
    log.steps += list(zip(preview.step_times_s, labels, strict=False))
    for at_s, x_m, y_m, yaw_rad, height_m, w, x, y, z, *joints in preview.frames:
        log.add(PoseSample(at_s, Pose(x_m, y_m, yaw_rad), Posture(0.0, None, height_m, (w, x, y, z), tuple(joints))))
    return log


def encoded(log: PoseLog, **head: Any) -> bytes:
    """The gzipped replay, or nothing if fewer than two poses are known.

    `t` are milliseconds, `pose` the three channels of the pose in mm and mrad, `body` those of the body in
    thousandths; each value but the first is the difference from the one before.
    """
    samples: Sequence[PoseSample] = log.samples
    if len(samples) < 2:
        return b""
    written = _written(log, samples, head)
    while len(written) > MOST_BYTES and len(samples) > FEWEST_SAMPLES:
        samples = samples[::2]
        written = _written(log, samples, head)
    return written


def _written(log: PoseLog, samples: Sequence[PoseSample], head: dict[str, Any]) -> bytes:
    zero_s = log.samples[0].at_s
    bodies = [sample.body for sample in samples]
    width = max(map(len, bodies))
    known = next((body for body in bodies if len(body) == width), [])
    for n, body in enumerate(bodies):
        bodies[n] = known = body if len(body) == width else known
    data = {
        "version": VERSION,
        **head,
        "plan": log.plan,
        "steps": [[max(0, round(1000 * (at_s - zero_s))), words] for at_s, words in log.steps],
        "t": _differences([round(1000 * (s.at_s - zero_s)) for s in samples]),
        "pose": [_differences([round(1000 * read(s.pose)) for s in samples]) for read in _CHANNELS],
        "body": [_differences([round(1000 * body[n]) for body in bodies]) for n in range(width)],
    }
    return gzip.compress(json.dumps(data, separators=(",", ":"), ensure_ascii=False).encode(), mtime=0)


_CHANNELS: tuple[Callable[[Pose], float], ...] = (lambda p: p.x_m, lambda p: p.y_m, lambda p: p.yaw_rad)


def _differences(values: Sequence[int]) -> list[int]:
    return [*values[:1], *(after - before for before, after in pairwise(values))]
