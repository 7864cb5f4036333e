"""Draw a short animation of a command: camera pictures or a map, above a chart of commanded and measured speeds.

It is drawn in a separate process of low priority with resource limits, so that it cannot delay a stop or crash the
agent: `python -m agentrob.agent.media.animation` reads a scene on standard input and writes a WebP to standard output.
"""

from __future__ import annotations

import importlib.util
import io
import json
import math
import os
import resource
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

from PIL import Image, ImageChops, ImageDraw, ImageFilter, ImageFont, ImageOps

#: The default of `max_kb`. NodeBB takes files of 2048 kB unless its admin allows more, Discourse pictures of 4096 kB,
#: the embedded forum 8 MB.
MAX_BYTES = 2_000_000
#: The most frames, and the most a second; so a gesture of 1.6 s has 32.
MAX_FRAMES, FPS = 72, 20
#: The maximum playing time; longer commands are played faster. The last picture is shown for `LAST_S`, then it begins
#: again, without end.
PLAY_S, LAST_S, FOR_EVER = 12.0, 2.0, 0
#: If the animation is too large: lower quality, then fewer frames, then a smaller picture.
_ATTEMPTS = ((72, 1.0, 1.0), (50, 1.0, 1.0), (40, 0.67, 1.0), (40, 0.5, 0.75), (25, 0.33, 0.5))
#: The smallest change of a grey level that counts as motion, and the smallest crop relative to the picture's width.
_CHANGED, _NEAREST = 24, 0.42
#: A picture that was taken this long after a frame's time belongs to it.
_SAME_S = 0.005
#: The progress of a step is shown until this long after its last sample.
_SILENT_S = 0.8
_CPU_S, _MEMORY = 30, 2 * 2**30
_W, _H, _STRIP = 640, 476, 116
_FINE = 2  # lines are drawn this many times as large and scaled down, because Pillow does not antialias them
# The same colours as in the plot (agentrob.agent.media.plot).
_CARD, _GRID, _TEXT = "#20262f", "#39424f", "#c9d1dc"
_ASKED, _MEASURED, _TURNING, _START, _END = "#8b98a9", "#4db6f5", "#c79bf2", "#7bd88f", "#ffb454"

Point = tuple[float, float]


@dataclass(frozen=True)
class Scene:
    """The content of an animation, in the robot's frame at the start: x to the right, y forward, in metres.

    Times are seconds after the start of the first step.

    `moments` are (seconds, step from 1, x, y, heading in radians counter-clockwise from forward, measured m/s, measured
    rad/s, commanded m/s, commanded rad/s). `steps` are the requested amounts with their units ("m", "°" or empty).
    `frames` are the times of the pictures and the sizes of their JPEGs in bytes; with `follows` their camera followed
    the robot. `most_bytes` is the largest animation.
    """

    seconds: float
    moments: list[tuple[float, int, float, float, float, float, float, float, float]]
    asked: list[Point] = field(default_factory=list)
    steps: list[tuple[float, str]] = field(default_factory=list)
    frames: list[tuple[float, int]] = field(default_factory=list)
    follows: bool = False
    most_bytes: int = MAX_BYTES


def frames_of(seconds: float) -> int:
    """How many frames the animation of so many seconds has."""
    return max(8, min(MAX_FRAMES, round(FPS * seconds)))


def write_scene(scene: Scene, pictures: Sequence[bytes]) -> bytes:
    """Serialise a scene and its JPEGs for the drawing process."""
    return json.dumps(asdict(scene)).encode() + b"\n" + b"".join(pictures)


def read_scene(stream: BinaryIO) -> tuple[Scene, list[bytes]]:
    scene = Scene(**json.loads(stream.readline()))
    return scene, [stream.read(size) for _, size in scene.frames]


def draw(scene: Scene, pictures: Sequence[bytes]) -> bytes | None:
    """Return the animation as a WebP, or None if it does not fit into `most_bytes`."""
    drawn: dict[int, list[Image.Image]] = {}
    for quality, share, scale in _ATTEMPTS:
        count = max(8, round(share * frames_of(scene.seconds)))
        if count not in drawn:
            drawn = {count: list(_images(scene, pictures, count))}
        images = drawn[count]
        if scale < 1:
            size = round(scale * images[0].width), round(scale * images[0].height)
            images = [image.resize(size, Image.Resampling.BOX) for image in images]
        if len(webp := _encoded(images, scene.seconds, quality)) <= scene.most_bytes:
            return webp
    return None


def _encoded(images: Sequence[Image.Image], seconds: float, quality: int) -> bytes:
    play_ms = round(1000 * min(PLAY_S, max(0.5, seconds)) / len(images))
    file = io.BytesIO()
    images[0].save(
        file, "WEBP", save_all=True, append_images=images[1:], quality=quality, method=1, loop=FOR_EVER,
        duration=[play_ms] * (len(images) - 1) + [round(1000 * LAST_S)],
    )  # fmt: skip
    return file.getvalue()


def _images(scene: Scene, pictures: Sequence[bytes], count: int) -> Iterator[Image.Image]:
    stage, size = _Stage(scene, fast=scene.seconds > PLAY_S), (_W, _H - _STRIP)
    decoded = [_decoded(jpeg, size) for jpeg in pictures]
    film = [ImageOps.fit(picture, size) for picture in decoded] if scene.follows else _near(decoded, size)
    for k in range(count):
        t_s = scene.seconds * k / (count - 1)
        at = max((i for i, (taken_s, _) in enumerate(scene.frames) if taken_s <= t_s + _SAME_S), default=0)
        if film and not scene.moments:  # a gesture has no path and no speed
            yield film[at]
            continue
        image = Image.new("RGB", (_W, _H), _CARD)
        image.paste(film[at] if film else stage.map(size, t_s), (0, 0))
        stage.strip(image, t_s, with_map=bool(film))
        yield image


def _decoded(jpeg: bytes, size: tuple[int, int]) -> Image.Image:
    with Image.open(io.BytesIO(jpeg), formats=("JPEG",)) as picture:
        picture.draft("RGB", (size[0] * 2, size[1] * 2))  # decodes at a reduced size
        return picture.convert("RGB")


def _near(film: Sequence[Image.Image], size: tuple[int, int]) -> list[Image.Image]:
    """Crop the pictures to the part where something moves: on a camera on a wall, a robot is small."""
    if not film or any(picture.size != film[0].size for picture in film):
        return [ImageOps.fit(picture, size) for picture in film]
    (w, h), small = film[0].size, (160, 90)
    greys = [picture.convert("L").resize(small, Image.Resampling.BOX) for picture in film]
    changed = Image.new("L", small)
    for grey in greys:
        changed = ImageChops.lighter(changed, ImageChops.difference(grey, greys[0]))
    box = changed.point(lambda v: 255 * (v > _CHANGED)).filter(ImageFilter.MedianFilter(3)).getbbox() or (0, 0, *small)
    x, y = (box[0] + box[2]) / 2 * w / small[0], (box[1] + box[3]) / 2 * h / small[1]
    wide = max((box[2] - box[0]) * w / small[0], (box[3] - box[1]) * h / small[1] * size[0] / size[1])
    wide = min(max(wide * 1.5, w * _NEAREST), w, h * size[0] / size[1])
    high = wide * size[1] / size[0]
    left, top = min(max(0, x - wide / 2), w - wide), min(max(0, y - high / 2), h - high)
    return [picture.resize(size, Image.Resampling.BILINEAR, (left, top, left + wide, top + high)) for picture in film]


class _Stage:
    """Draws one moment of a scene."""

    def __init__(self, scene: Scene, fast: bool) -> None:
        self.scene = scene
        self.fast = f" ×{scene.seconds / PLAY_S:.2g}" if fast else ""
        self.fonts = {False: _font(26), True: _font(23)}  # smaller beside a map
        self._grounds: dict[int, Image.Image] = {}
        self.top_mps = max([0.2, *(max(m[5], m[7]) for m in scene.moments)])
        walked = (m[5] for m in scene.moments if scene.steps[m[1] - 1][1] == "m")
        self.fastest_mps = max(walked, default=0.0)
        self.top_rps = max([0.4, *(max(abs(m[6]), abs(m[8])) for m in scene.moments)])

    def map(self, size: tuple[int, int], t_s: float) -> Image.Image:
        """Draw the path walked until `t_s` over the requested path."""
        scene, (w, h) = self.scene, (size[0] * _FINE, size[1] * _FINE)
        at, scale = self._fit(w, h)
        fine = w / _W * 4
        if (ground := self._grounds.get(w)) is None:
            ground = self._grounds[w] = self._ground(at, scale, (w, h))
            _dashes(ImageDraw.Draw(ground), [at(p) for p in scene.asked], _ASKED, fine)
        image = ground.copy()
        pen = ImageDraw.Draw(image)
        past = [m for m in scene.moments if m[0] <= t_s] or scene.moments[:1]
        walked = [at((m[2], m[3])) for m in past]
        if len(walked) > 1:
            pen.line(walked, fill=_MEASURED, width=round(1.6 * fine) + 2, joint="curve")
        body = max(3.2 * fine, 8)
        _dot(pen, at((scene.moments[0][2], scene.moments[0][3])), body, _START)
        _arrow(pen, walked[-1], past[-1][4], 2.3 * body, _END)
        return image.reduce(_FINE)

    def _fit(self, w: int, h: int) -> tuple[Callable[[Point], Point], float]:
        points = [*self.scene.asked, *((m[2], m[3]) for m in self.scene.moments)]
        xs, ys = [p[0] for p in points], [p[1] for p in points]
        scale = min(w / max(max(xs) - min(xs), 0.7), h / max(max(ys) - min(ys), 0.7)) * 0.68
        mid_x, mid_y = (max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2
        return lambda p: (w / 2 + (p[0] - mid_x) * scale, h / 2 - (p[1] - mid_y) * scale), scale

    def _ground(self, at: Callable[[Point], Point], scale: float, size: tuple[int, int]) -> Image.Image:
        """Draw a grid through the start, with its spacing if there is room for the label."""
        image = Image.new("RGB", size, _CARD)
        pen, (w, h) = ImageDraw.Draw(image), size
        step = next(s for s in (0.25, 0.5, 1, 2, 5, 10, 20, 50, 1e9) if s * scale > h / 6)
        x0, y0 = at((0.0, 0.0))
        for k in range(-40, 41):
            pen.line([(x0 + k * step * scale, 0), (x0 + k * step * scale, h)], fill=_GRID, width=2)
            pen.line([(0, y0 + k * step * scale), (w, y0 + k * step * scale)], fill=_GRID, width=2)
        if w >= _W * _FINE:
            words, font = f"grid {step:g} m", _font(20 * _FINE)
            pen.rectangle((0, h - 30 * _FINE, pen.textlength(words, font) + 20 * _FINE, h), fill=_CARD)
            pen.text((10 * _FINE, h - 7 * _FINE), words, fill=_ASKED, font=font, anchor="ls")
        return image

    def strip(self, image: Image.Image, t_s: float, with_map: bool) -> None:
        """Draw the strip below the picture: distance, speed, time, and a chart of the speeds."""
        top, left = _H - _STRIP, 10
        if with_map:
            image.paste(self.map((152, _STRIP), t_s), (0, top))
            left = 164
        pen, font = ImageDraw.Draw(image), self.fonts[with_map]
        done, speed = self._words(t_s)
        pen.text((left, top + 31), done, fill=_TEXT, font=font, anchor="ls")
        time = f"{t_s:.1f} s{self.fast}"
        pen.text((_W - 10, top + 31), time, fill=_TEXT, font=font, anchor="rs")
        middle = (left + pen.textlength(done, font) + _W - 10 - pen.textlength(time, font)) / 2
        pen.text((middle, top + 31), speed, fill=_MEASURED, font=font, anchor="ms")
        box = (left, top + 43, _W - 10, _H - 8)
        image.paste(self._chart((box[2] - box[0], box[3] - box[1]), t_s), box[:2])

    def _words(self, t_s: float) -> tuple[str, str]:
        """Return the labels for the progress of the step and the speed."""
        scene = self.scene
        now = next((m for m in reversed(scene.moments) if m[0] <= t_s), None)
        # A gesture, a picture, or a time before the first sample has no progress.
        if now is None or (t_s - now[0] > _SILENT_S and t_s < scene.seconds):
            return "", ""
        if t_s >= scene.seconds and self.fastest_mps:
            return "", f"max {self.fastest_mps:.2f} m/s"
        amount, unit = scene.steps[now[1] - 1]
        begun = next(m for m in scene.moments if m[1] == now[1])
        if unit == "°":
            turned = 0.0
            headings = [m[4] for m in scene.moments if m[1] == now[1] and m[0] <= now[0]]
            for before, after in pairwise(headings):
                turned += math.remainder(after - before, math.tau)
            return f"{abs(math.degrees(turned)):.0f} / {amount:g}°", f"{math.degrees(abs(now[6])):.0f}°/s"
        gone = math.hypot(now[2] - begun[2], now[3] - begun[3])
        return f"{gone:.2f} / {amount:g} {unit}", f"{now[5]:.2f} m/s"

    def _chart(self, size: tuple[int, int], t_s: float) -> Image.Image:
        """Draw the speeds: commanded in grey, measured in blue, turning in violet on a separate scale."""
        w, h = size[0] * _FINE, size[1] * _FINE
        image = Image.new("RGB", (w, h), _CARD)
        pen, whole = ImageDraw.Draw(image), max(self.scene.seconds, 0.1)
        pen.line([(0, h - 2), (w, h - 2)], fill=_GRID, width=3)
        past = [m for m in self.scene.moments if m[0] <= t_s]
        for index, top, color in (
            (8, self.top_rps, _ASKED),
            (7, self.top_mps, _ASKED),
            (6, self.top_rps, _TURNING),
            (5, self.top_mps, _MEASURED),
        ):
            # Show turning only for turns: a walking robot always turns a little.
            for number, (_, unit) in enumerate(self.scene.steps, 1):
                if (unit == "°") != (index in (6, 8)):
                    continue
                line = [
                    (m[0] / whole * w, (h - 4) * (1 - min(1.0, abs(m[index]) / top)) + 2)
                    for m in past
                    if m[1] == number
                ]
                if len(line) > 1:
                    pen.line(line, fill=color, width=4 if color == _ASKED else 5, joint="curve")
        now = t_s / whole * w
        pen.line([(now, 0), (now, h)], fill=_GRID, width=3)
        return image.reduce(_FINE)


def _font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Load the font of the plot from matplotlib's files, without the slow import of matplotlib."""
    found = importlib.util.find_spec("matplotlib")
    if found is not None and found.origin:
        file = Path(found.origin).parent / "mpl-data/fonts/ttf/DejaVuSans.ttf"
        if file.exists():
            return ImageFont.truetype(str(file), size)
    return ImageFont.load_default(size)


def _dashes(pen: ImageDraw.ImageDraw, path: Sequence[Point], color: str, width: float) -> None:
    for (x1, y1), (x2, y2) in pairwise(path):
        length, dash = math.hypot(x2 - x1, y2 - y1), 5 * width
        for k in range(int(length / dash / 1.7) + 1):
            a, b = k * 1.7 * dash, min(length, k * 1.7 * dash + dash)
            if length and a < b:
                ends = [(x1 + (x2 - x1) * t / length, y1 + (y2 - y1) * t / length) for t in (a, b)]
                pen.line(ends, fill=color, width=round(width * 0.8) + 1)


def _dot(pen: ImageDraw.ImageDraw, at: Point, radius: float, color: str) -> None:
    pen.ellipse((at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius), fill=color)


def _arrow(pen: ImageDraw.ImageDraw, at: Point, heading: float, size: float, color: str) -> None:
    """Draw an arrowhead in the robot's heading."""
    corners = []
    for angle, far in ((0.0, 1.15), (2.5, 1.0), (math.pi, 0.45), (-2.5, 1.0)):
        a = heading + angle
        corners.append((at[0] - size * far * math.sin(a), at[1] - size * far * math.cos(a)))
    pen.polygon(corners, fill=color, outline=_CARD, width=2)


def main() -> None:
    """Run the drawing process."""
    os.nice(10)
    resource.setrlimit(resource.RLIMIT_CPU, (_CPU_S, _CPU_S))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    scene, pictures = read_scene(sys.stdin.buffer)
    sys.stdout.buffer.write(draw(scene, pictures) or b"")


if __name__ == "__main__":
    main()
