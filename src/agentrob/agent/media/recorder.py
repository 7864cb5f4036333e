"""Record each command: camera pictures while it runs, then its data on disk and a short animation for the reply.

A recording never delays or prevents a motion, a stop or a reply: pictures are taken in a separate task or after the
motion, the animation is drawn in a separate process with a time limit, and an error loses only the recording.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import sys
import time
from collections.abc import Awaitable, Callable, Iterator, Sequence
from pathlib import Path

import httpx2
import structlog

from agentrob.agent.media import animation
from agentrob.agent.media.camera import snapshot
from agentrob.agent.media.film import TRIES, Film, past
from agentrob.agent.media.plot import asked_path, seen_from
from agentrob.agent.media.track import begins_s, lines, samples, seconds
from agentrob.config.robots import RecordingConfig, RobotConfig
from agentrob.model import ActionResult, Op, Outcome, Report
from agentrob.process.run import run_process
from agentrob.process.tls import tls
from agentrob.robots.driver.client import DriverClient

#: How long a reply waits for its animation; where a reply cannot be edited, how long it waits then; and how long after
#: a reply the animation may still be added.
DRAW_S, ONCE_S, LATE_S = 1.5, 8.0, 90.0
#: Shorter commands get no animation.
SHORTEST_S = 1.0
#: How many films wait for their reports: a model may still work on one report while the next command runs.
FILMS = 4
#: The shortest interval between pictures of the robot's own camera.
LOOK_EVERY_S = 0.5
_MAX_MOMENTS = 600
#: The block size of file systems in bytes (the default of ext4, XFS and Btrfs).
BLOCK = 4096
_log = structlog.get_logger()

Look = Callable[[], Awaitable[bytes]]


def look_of(settings: RobotConfig, driver: DriverClient) -> Look | None:
    """Return how the recorder takes pictures, or None if it takes none while the robot moves or `Camera` delivers
    them."""
    if settings.recording.view == "robot":
        return driver.look
    if settings.recording.camera:
        return None
    if settings.recording.view != "room" or not settings.room_camera:
        return None

    async def look() -> bytes:
        async with httpx2.AsyncClient(timeout=3.0, trust_env=False, verify=tls()) as http:
            return await snapshot(http, settings.room_camera)

    return look


class Recorder:
    """One robot's recorder; keeps its files in `folder`.

    `look` takes a picture now, for as long as something moves; without it, `see` gets the pictures that others take.
    """

    def __init__(self, folder: Path, settings: RecordingConfig, look: Look | None = None) -> None:
        self._folder = folder
        self._settings = settings
        self._look = look
        self._films: dict[str, Film] = {}
        self._running: Film | None = None
        self._drawing: dict[str, asyncio.Task[bytes | None]] = {}
        self._tasks: set[asyncio.Task[bytes | None]] = set()  # also those that were cancelled and have not ended

    @property
    def asks_afterwards(self) -> bool:
        """Whether the pictures come from a camera that keeps the past, so that none are taken while the robot moves."""
        return bool(self._settings.camera) and self._settings.view in ("auto", "room")

    # ------------------------------------------------------------------ while it moves
    def see(self, jpeg: bytes) -> None:
        """Add a picture that another component took."""
        if self._running is not None:
            self._running.add(jpeg)

    @contextlib.contextmanager
    def filming(self, post_id: str) -> Iterator[None]:
        """Take pictures until the context ends. Neither waits nor raises."""
        self._running = self._films[post_id] = Film()
        while len(self._films) > FILMS:  # of commands that never got a report
            del self._films[next(iter(self._films))]
        filming = asyncio.create_task(self._film(self._running, self._look)) if self._look else None
        try:
            yield
        finally:
            self._running = None
            if filming is not None:
                filming.cancel()

    async def _film(self, film: Film, look: Look) -> None:
        left = TRIES
        while left:
            begun_s = time.monotonic()
            try:
                film.add(await look())
                left = TRIES
            except Exception as e:  # whatever the camera raises, only its picture is lost
                left -= 1
                _log.info("no picture for the recording", error=str(e) or type(e).__name__)
            await asyncio.sleep(max(0.05, LOOK_EVERY_S - (time.monotonic() - begun_s)))

    # ------------------------------------------------------------------ afterwards
    async def animation(self, report: Report, *, hurry: bool = False, once: bool = False) -> bytes | None:
        """Write the recording to disk and return the animation as WebP, or None if it is not ready in time.

        `late` returns it afterwards, except with `once`: then this waits longer. With `hurry` nothing is drawn. After a
        restart the pictures that were taken are lost, and the animation shows a map.
        """
        post_id = report.command.key
        film = self._films.pop(post_id, Film())
        if not any(r.primitive.moves and r.outcome not in (Outcome.SKIPPED, Outcome.REFUSED) for r in report.results):
            return None
        try:
            await asyncio.to_thread(self._keep, report)
            if seconds(report.results) < SHORTEST_S or hurry or self._settings.view == "none":
                return None
            self._drawing[post_id] = drawing = asyncio.create_task(self._draw(post_id, report.results, film))
            self._tasks.add(drawing)
            drawing.add_done_callback(self._tasks.discard)
        except Exception as e:
            _log.warning("recording lost", post=post_id, error=str(e) or type(e).__name__)
        # Pictures of the past take seconds: the report is not delayed for them where they can be added to it.
        return await self._ready(post_id, ONCE_S if once else 0.0 if self.asks_afterwards else DRAW_S)

    async def late(self, post_id: str) -> bytes | None:
        """Wait for the animation that was not ready for the reply; None if there is none."""
        return await self._ready(post_id, LATE_S, last=True)

    def forget(self, post_id: str) -> None:
        """Drop the pictures and the animation of a command whose report is written or cannot be written."""
        self._films.pop(post_id, None)
        if (drawing := self._drawing.pop(post_id, None)) is not None:
            drawing.cancel()

    async def close(self) -> None:
        """End what is being drawn, and wait until its process is gone."""
        for task in tuple(self._tasks):
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    async def _ready(self, post_id: str, limit_s: float, *, last: bool = False) -> bytes | None:
        if (drawing := self._drawing.get(post_id)) is None:
            return None
        try:
            await asyncio.wait({drawing}, timeout=limit_s)
        except asyncio.CancelledError:
            last = True
            raise
        finally:
            if last or drawing.done():
                drawing.cancel()
                self._drawing.pop(post_id, None)
        return drawing.result() if drawing.done() and not drawing.cancelled() else None

    async def _draw(self, post_id: str, results: Sequence[ActionResult], film: Film) -> bytes | None:
        begin_s, length_s = begins_s(results), seconds(results)
        try:
            if self.asks_afterwards:
                film = await past(
                    self._settings.camera,
                    begin_s,
                    begin_s + length_s,
                    animation.frames_of(length_s),
                    lambda: self._running is not None,
                )
            scene = await asyncio.to_thread(_written, results, film, round(1000 * self._settings.max_kb))
            webp = await _drawn(scene) if scene else None
            if webp:
                await asyncio.to_thread(_write, self.file(post_id, "webp"), webp)
            return webp
        except Exception as e:
            _log.warning("animation lost", post=post_id, error=str(e) or type(e).__name__)
            return None

    def _keep(self, report: Report) -> None:
        """Write the data, then delete old recordings."""
        command, started = report.command, begins_s(report.results)
        ago_s = time.monotonic() - started
        head = {
            "post": command.post_id,
            "robot": command.robot,
            "trace_id": command.trace_id,
            "status": report.status,
            # Unknown if the machine was rebooted before the report was written.
            "began_unix_s": round(time.time() - ago_s, 3) if started and ago_s >= 0 else None,
        }
        self._folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        text = "".join(json.dumps(line, ensure_ascii=False) + "\n" for line in lines(report.results, **head))
        _write(self.file(command.key), text.encode())
        prune(self._folder, self._settings.keep_days, self._settings.keep_mb)

    def stored_path(self, post_id: str) -> str:
        """Return the path of a command's data, or an empty string if it is not stored."""
        path = self.file(post_id)
        return str(path) if path.exists() else ""

    def data(self, post_id: str) -> bytes:
        """Return a command's data as JSON lines, or nothing if it is not stored."""
        with contextlib.suppress(OSError):
            return self.file(post_id).read_bytes()
        return b""

    def file(self, post_id: str, kind: str = "jsonl") -> Path:
        """Return the path for a command's recording."""
        return self._folder / f"{safe_name(post_id)}.{kind}"


def safe_name(post_id: str) -> str:
    """Return a forum's post id as a safe file name, without path separators."""
    return "".join(c if c.isascii() and (c.isalnum() or c in "_-") else "_" for c in post_id)[:80]


def prune(folder: Path, keep_days: float, keep_mb: float, most: int | None = None) -> None:
    """Delete files older than `keep_days`, then the oldest until at most `keep_mb` and at most `most` files are left.

    Sizes are rounded up to whole blocks, because most recordings are far smaller than one.
    """
    files = []
    for path in folder.iterdir():
        with contextlib.suppress(OSError):
            files.append((path.stat().st_mtime, path.stat().st_size, path))
    left, oldest_s = keep_mb * 2**20, time.time() - keep_days * 86400
    for number, (at_s, size, path) in enumerate(sorted(files, reverse=True)):
        left -= math.ceil(size / BLOCK) * BLOCK
        if left < 0 or at_s < oldest_s or (most is not None and number >= most):
            with contextlib.suppress(OSError):
                path.unlink()


def _write(path: Path, data: bytes) -> None:
    part = path.with_suffix(path.suffix + ".part")
    part.write_bytes(data)
    part.replace(path)


def _scene(
    results: Sequence[ActionResult], film: Film, most_bytes: int = animation.MAX_BYTES
) -> tuple[animation.Scene, list[bytes]]:
    """Return the scene for the drawing process."""
    zero_s, moments = begins_s(results), list(samples(results))
    thin = moments[:: 1 + len(moments) // _MAX_MOMENTS]
    seen = [(m, seen_from(moments[0].pose, m.pose)) for m in thin]
    frames = [(t_s - zero_s, jpeg) for t_s, jpeg in film.frames]
    scene = animation.Scene(
        seconds=seconds(results),
        moments=[
            (
                m.t_s, m.step, -p.y_m, p.x_m, p.yaw_rad,
                m.measured.speed_mps, m.measured.turn_rps, m.commanded.speed_mps, m.commanded.turn_rps,
            )
            for m, p in seen
        ],
        asked=[(-p.y_m, p.x_m) for p in asked_path(results)] if moments else [],
        steps=[_asked_of(r) for r in results],
        frames=[(t_s, len(jpeg)) for t_s, jpeg in frames],
        follows=film.follows,
        most_bytes=most_bytes,
    )  # fmt: skip
    return scene, [jpeg for _, jpeg in frames]


def _written(results: Sequence[ActionResult], film: Film, most_bytes: int) -> bytes:
    """Return the serialised scene for the drawing process, or nothing if there is nothing to show."""
    scene, pictures = _scene(results, film, most_bytes)
    return animation.write_scene(scene, pictures) if pictures or len(scene.moments) > 1 else b""


def _asked_of(result: ActionResult) -> tuple[float, str]:
    step = result.primitive
    if step.op is Op.TURN:
        return step.degrees or 0.0, "°"
    return (step.distance_m or 0.0, "m") if step.op is Op.MOVE else (0.0, "")


async def _drawn(scene: bytes) -> bytes | None:
    """Run the drawing process and return its output, or None if it fails. It never outlives this call."""
    done = await run_process((sys.executable, "-m", "agentrob.agent.media.animation"), scene)
    return done.stdout if done.returncode == 0 and done.stdout[:4] == b"RIFF" else None
