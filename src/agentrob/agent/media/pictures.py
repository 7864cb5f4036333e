"""Collect the pictures of a reply: photos, the path and the recording, attached to the post or stored and linked."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import structlog

from agentrob.agent.media.image_store import ImageStore, Link
from agentrob.agent.media.plot import path_plot
from agentrob.agent.media.recorder import Recorder, safe_name
from agentrob.errors import ImageStoreError
from agentrob.model import ActionResult, Report

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Picture:
    """One file of a reply: the photo of a step (from 1), the path or the paths of a preview as PNG, or the
    recording as WebP; as JSON lines, the data of the recording or a model's calls."""

    kind: Literal["step", "path", "preview", "recording", "data", "calls"]
    data: bytes
    step: int = 0
    link: Link | None = None
    there: bool = False

    @property
    def attached(self) -> bool:
        """Whether it is attached to the post itself."""
        return self.link is None

    @property
    def added(self) -> bool:
        """Whether it is attached with the reply: `there` are those that the post has already."""
        return self.attached and not self.there


async def illustrate(
    report: Report,
    recorder: Recorder,
    store: ImageStore | None,
    *,
    hurry: bool = False,
    once: bool = False,
    calls: bytes = b"",
    preview: Callable[[], bytes | None] | None = None,
) -> tuple[Picture, ...]:
    """Return all pictures of a report, stills first. Never raises: a picture that cannot be drawn is left out, and one
    that cannot be stored is attached.

    With `hurry` (the agent is shutting down) nothing is drawn or stored. `once`: the reply cannot be edited later, so
    it waits longer for its recording. `calls` are a model's calls as JSON lines. `preview` draws the
    paths of a preview.
    """
    drawn = () if hurry else report.results
    path, recording = await asyncio.gather(_path(drawn), recorder.animation(report, hurry=hurry, once=once))
    paths = await _drawn(preview) if preview is not None and not hurry else None
    pictures = [Picture("preview", paths)] if paths else []
    pictures += [Picture("step", r.image, n) for n, r in enumerate(report.results, 1) if r.image]
    pictures += [Picture("path", path)] if path else []
    pictures += [Picture("recording", recording)] if recording else []
    if store is None or hurry or not pictures:
        return tuple(pictures)
    if data := await asyncio.to_thread(recorder.data, report.command.key):
        pictures.append(Picture("data", data))
    if calls:
        pictures.append(Picture("calls", calls))
    name = safe_name(report.command.key)
    kept = await asyncio.gather(*(_upload(store, f"{name}-{p.kind}{p.step or ''}", p) for p in pictures))
    return tuple(p for p in kept if not (p.kind in ("data", "calls") and p.attached))


async def late_recording(post_id: str, recorder: Recorder, store: ImageStore | None) -> Picture | None:
    """Return the recording that was not ready for the reply, or None."""
    if (webp := await recorder.late(post_id)) is None:
        return None
    recording = Picture("recording", webp)
    return await _upload(store, f"{safe_name(post_id)}-recording", recording) if store else recording


async def _path(results: Sequence[ActionResult]) -> bytes | None:
    if not any(len(r.path) > 1 for r in results):
        return None
    return await _drawn(partial(path_plot, results))


async def _drawn(draw: Callable[[], bytes | None]) -> bytes | None:
    try:
        return await asyncio.to_thread(draw)
    except Exception as e:  # the reply must not fail because of a picture
        _log.warning("path not drawn", error=str(e) or type(e).__name__)
        return None


async def _upload(store: ImageStore, name: str, picture: Picture) -> Picture:
    """Store a picture and return it with its link; return it unchanged if the store fails."""
    try:
        return replace(picture, link=await store.keep(name, picture.data))
    except ImageStoreError as e:
        _log.warning("picture attached instead", error=str(e))
        return picture
