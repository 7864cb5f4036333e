"""The poses of commands that have no replay yet, as files: a report after a restart of the agent still has its replay.

A file has one JSON object per line, appended about once a second while the robot moves. Nothing forces it to the disk:
it outlives the agent, not always the machine. Monotonic times are compared within one file only.
"""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from agentrob.agent.media.recorder import prune, safe_name
from agentrob.agent.media.replay import PoseLog, PoseSample
from agentrob.model import Pose, Posture

#: Files of commands that never get a report are deleted after this time, or when there are more or larger ones.
KEEP_DAYS, KEEP_MB, MOST = 2.0, 20.0, 50


class PoseFiles:
    """The files of one robot in `folder`. All methods block: call them in a thread."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def append(self, post_id: str, lines: Sequence[str]) -> None:
        """Add lines of a command. Raises `OSError`."""
        path = self._file(post_id)
        if not path.exists():
            self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            prune(self._folder, KEEP_DAYS, KEEP_MB, MOST - 1)
        with path.open("a", encoding="utf-8") as file:
            file.write("".join(line + "\n" for line in lines))

    def read(self, post_id: str) -> PoseLog | None:
        """The poses of a command, as far as they were written; None if there are none."""
        log = PoseLog()
        with contextlib.suppress(OSError):
            for line in self._file(post_id).read_text(encoding="utf-8", errors="replace").splitlines():
                with contextlib.suppress(ValueError, TypeError, KeyError):  # a line may be cut off
                    _add(log, json.loads(line))
        return log if log.samples else None

    def forget(self, post_id: str) -> None:
        """Delete the file of a command, if there is one."""
        with contextlib.suppress(OSError):
            self._file(post_id).unlink()

    def left(self) -> list[str]:
        """The commands that have a file, as `safe_name` writes them."""
        with contextlib.suppress(OSError):
            return sorted(path.stem for path in self._folder.glob("*.jsonl"))
        return []

    def _file(self, post_id: str) -> Path:
        return self._folder / f"{safe_name(post_id)}.jsonl"


class PoseLines:
    """The lines of a log that are not written yet."""

    def __init__(self, log: PoseLog) -> None:
        self._log, self._samples, self._steps, self._planned = log, 0, 0, False

    def take(self) -> list[str]:
        """The lines that are new since the last call."""
        log, lines = self._log, list[dict[str, Any]]()
        if log.samples and not self._planned:
            self._planned = True
            lines.append({"plan": log.plan})
        lines += [{"step": words, "at": at_s} for at_s, words in log.steps[self._steps :]]
        for sample in log.samples[self._samples :]:
            pose = sample.pose
            lines.append({"at": sample.at_s, "pose": [pose.x_m, pose.y_m, pose.yaw_rad], "body": sample.body})
        self._samples, self._steps = len(log.samples), len(log.steps)
        return [json.dumps(line, separators=(",", ":"), ensure_ascii=False) for line in lines]


def _add(log: PoseLog, line: dict[str, Any]) -> None:
    if "plan" in line:
        log.plan = [(float(x), float(y)) for x, y in line["plan"]]
    elif "step" in line:
        log.steps.append((float(line["at"]), str(line["step"])))
    else:
        x_m, y_m, yaw_rad = (float(v) for v in line["pose"])
        body = [float(v) for v in line["body"]]
        if not all(map(math.isfinite, (x_m, y_m, yaw_rad, *body))):
            return
        posture = Posture(0.0)
        if len(body) > 5:
            posture = Posture(0.0, None, body[0], (body[1], body[2], body[3], body[4]), tuple(body[5:]))
        log.add(PoseSample(float(line["at"]), Pose(x_m, y_m, yaw_rad), posture))
