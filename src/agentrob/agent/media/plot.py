"""Plot the path of a robot: the requested one beside the measured one, or beside those of a preview.

matplotlib comes with the extra `plots`; without it, replies have no plots.
"""

from __future__ import annotations

import importlib.util
import io
import math
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from typing import Any

from PIL import Image

from agentrob.model import ActionResult, Direction, Op, Pose, Primitive
from agentrob.rehearsal.preview import Basis, Preview

# A slate background, which suits light and dark pages.
_CARD, _GRID, _TEXT = "#20262f", "#39424f", "#c9d1dc"
_ASKED, _MEASURED, _START, _END = "#8b98a9", "#4db6f5", "#7bd88f", "#ffb454"
# Few inches at a high resolution: the labels stay readable when a thread shows the picture at half its width.
_WIDTH_IN, _HEIGHT_IN, _DPI = 4.0, 3.0, 200
_AXES = (0.15, 0.16, 0.81, 0.72)
#: Held while the figure of paths is drawn on.
_drawing = threading.Lock()
_WIDE = _AXES[2] * _WIDTH_IN / (_AXES[3] * _HEIGHT_IN)


@cache
def available() -> bool:
    """Return whether matplotlib is installed."""
    return importlib.util.find_spec("matplotlib") is not None


def path_plot(results: Sequence[ActionResult]) -> bytes | None:
    """Return a PNG of 800x600 pixels, or None without a path or matplotlib. Takes about 50 ms: call it in a thread.

    The frame is the robot's at the start: x forward (up in the picture), y left, in metres.
    """
    measured = [Pose(*point[1:]) for r in results for point in r.path]
    if len(measured) < 2 or not available():
        return None
    start = measured[0]
    local = [seen_from(start, pose) for pose in measured]
    asked = list(asked_path(results))
    with _drawing:
        figure, axes = _path_canvas()
        for drawn in (*axes.lines, *axes.texts):  # of the path before
            drawn.remove()
        _line(axes, asked, color=_ASKED, linestyle=(0, (4, 3)), linewidth=1.5, label="asked")
        _line(axes, local, color=_MEASURED, linewidth=2.4, label="measured")
        span = _frame(axes, [*asked, *local])
        for pose, color, name in ((local[0], _START, "start"), (local[-1], _END, "end")):
            _marker(axes, pose, color, name, 0.09 * span)
        if axes.get_legend() is None:  # it is the same for all paths
            _legend(axes)
        return _png(figure)


@cache
def _matplotlib() -> tuple[Any, Any]:
    """Import matplotlib, which is slow, when the first path is drawn; without `pyplot`, which has global state."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    return Figure, FigureCanvasAgg


def warm_up() -> None:
    """Import the plotting libraries, which takes up to a second. Call it at the start, because even in a thread the
    import would delay a stop."""
    if available():
        _matplotlib()
    Image.preinit()


def _canvas() -> tuple[Any, Any]:
    figure_of, canvas_of = _matplotlib()
    figure = figure_of(figsize=(_WIDTH_IN, _HEIGHT_IN), dpi=_DPI, facecolor=_CARD)
    canvas_of(figure)
    axes = figure.add_axes(_AXES, facecolor=_CARD)
    axes.set_aspect("equal", adjustable="box")
    axes.locator_params(nbins=6)
    axes.xaxis.set_major_formatter(lambda x, _: f"{abs(x):.3g}")  # the label says which side
    axes.yaxis.set_major_formatter(lambda y, _: f"{y:.3g}")
    axes.grid(color=_GRID, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.tick_params(colors=_TEXT, labelsize=8.5, length=0)
    for spine in axes.spines.values():
        spine.set_color(_GRID)
    axes.set_xlabel("left  ·  right (m)", color=_TEXT, fontsize=9)
    axes.set_ylabel("forward (m)", color=_TEXT, fontsize=9)
    return figure, axes


@cache
def _path_canvas() -> tuple[Any, Any]:
    """One figure for all paths: to make axes and ticks takes a third of the time of a plot."""
    return _canvas()


def _png(figure: Any) -> bytes:
    """The drawn figure. Compressing takes 30 % less time than by default, for a quarter more bytes."""
    picture = io.BytesIO()
    figure.savefig(
        picture, format="png", facecolor=_CARD, metadata={"Software": None}, pil_kwargs={"compress_level": 3}
    )
    return picture.getvalue()


def _legend(axes: Any) -> None:
    row = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncol": 4, "columnspacing": 1.2, "handlelength": 1.6}
    axes.legend(**row, frameon=False, labelcolor=_TEXT, fontsize=9)


def _line(axes: Any, path: Sequence[Pose], **style: Any) -> None:
    # Forward is up and left is left, as seen from behind the robot.
    axes.plot([-p.y_m for p in path], [p.x_m for p in path], solid_capstyle="round", **style)


def _marker(axes: Any, pose: Pose, color: str, name: str, arrow_m: float) -> None:
    x, y = -pose.y_m, pose.x_m
    axes.plot([x], [y], "o", color=color, markersize=8, markeredgecolor=_CARD, label=name, linestyle="none", zorder=4)
    tip = (x - arrow_m * 1.6 * math.sin(pose.yaw_rad), y + arrow_m * 1.6 * math.cos(pose.yaw_rad))
    arrow = {"arrowstyle": "-|>", "color": color, "linewidth": 2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    axes.annotate("", xy=tip, xytext=(x, y), arrowprops=arrow, zorder=3)


def _frame(axes: Any, path: Sequence[Pose]) -> float:
    """Set equal axes with a margin around the path, about a metre high at least; return the height in metres."""
    xs, ys = [-p.y_m for p in path], [p.x_m for p in path]
    height = max((max(xs) - min(xs)) / _WIDE, max(ys) - min(ys), 0.7) * 1.35
    for seen, half, limit in ((xs, height * _WIDE / 2, axes.set_xlim), (ys, height / 2, axes.set_ylim)):
        centre = (max(seen) + min(seen)) / 2
        limit(centre - half, centre + half)
    return float(height)


def seen_from(start: Pose, pose: Pose) -> Pose:
    dx, dy = pose.x_m - start.x_m, pose.y_m - start.y_m
    c, s = math.cos(start.yaw_rad), math.sin(start.yaw_rad)
    return Pose(c * dx + s * dy, -s * dx + c * dy, pose.yaw_rad - start.yaw_rad)


def asked_path(results: Sequence[ActionResult]) -> Iterator[Pose]:
    """Return the requested path, as if every step were exact."""
    return path_of(r.primitive for r in results)


def path_of(steps: Iterable[Primitive]) -> Iterator[Pose]:
    """Yield the path of steps in the frame of its start, as if every step were exact."""
    x = y = yaw = 0.0
    yield Pose(x, y, yaw)
    for step in steps:
        if step.op is Op.TURN and step.degrees:
            yaw += math.radians(step.degrees) * (1 if step.direction is Direction.LEFT else -1)
        elif step.op is Op.MOVE and step.distance_m:
            ahead, left = (step.direction or Direction.FORWARD).unit_vector
            x += step.distance_m * (ahead * math.cos(yaw) - left * math.sin(yaw))
            y += step.distance_m * (ahead * math.sin(yaw) + left * math.cos(yaw))
        yield Pose(x, y, yaw)


# -------------------------------------------------------------------- previews
#: How much of the room the picture of a preview shows around the paths.
AROUND_M = 0.6


def preview_plot(preview: Preview, room: Mapping[str, Any]) -> bytes | None:
    """Return a PNG of 800x600 pixels with the paths of all runs in the room, or None without a path or matplotlib.

    `room` is the description of the map (`RoomMap.as_data`). The frame is the room's: x to the right, y up, in metres.
    """
    paths = [[Pose(*point) for point in run.path] for run in preview.runs if len(run.path) > 1]
    if not paths or preview.start is None or not available():
        return None
    figure, axes = _canvas()
    axes.set_xlabel("x (m)", color=_TEXT, fontsize=9)
    axes.set_ylabel("y (m)", color=_TEXT, fontsize=9)
    axes.xaxis.set_major_formatter(lambda x, _: f"{x:.3g}")
    _draw_room(axes, room)
    for other in preview.others:
        axes.plot([other.pose.x_m], [other.pose.y_m], "s", color=_ASKED, markersize=9, zorder=3)
        axes.annotate(other.name, (other.pose.x_m, other.pose.y_m), color=_TEXT, fontsize=7.5, xytext=(6, 6),
                      textcoords="offset points")  # fmt: skip
    planned = preview.planned
    style = {"color": _ASKED, "linestyle": (0, (4, 3)), "linewidth": 1.5, "label": "planned"}
    axes.plot([p[0] for p in planned], [p[1] for p in planned], **style)
    for number, path in enumerate(paths):
        label = {"label": "runs" if preview.basis is Basis.SIMULATION else "exact path"} if not number else {}
        xs, ys = [p.x_m for p in path], [p.y_m for p in path]
        axes.plot(xs, ys, color=_MEASURED, linewidth=2.0, alpha=0.6, solid_capstyle="round", **label)
        axes.plot(xs[-1:], ys[-1:], "o", color=_END, markersize=5, zorder=4, linestyle="none",
                  **({"label": "end"} if not number else {}))  # fmt: skip
    start = preview.start
    axes.plot([start.x_m], [start.y_m], "o", color=_START, markersize=8, label="start", linestyle="none", zorder=5)
    moved = [*(pose for path in paths for pose in path), *(Pose(*point) for point in planned)]
    shown = [Pose(p.x_m + side, p.y_m + side, 0.0) for p in moved for side in (-AROUND_M, AROUND_M)]
    span = _frame(axes, [Pose(pose.y_m, -pose.x_m, 0.0) for pose in shown])
    tip = start.x_m + 0.14 * span * math.cos(start.yaw_rad), start.y_m + 0.14 * span * math.sin(start.yaw_rad)
    arrow = {"arrowstyle": "-|>", "color": _START, "linewidth": 2, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 13}
    axes.annotate("", xy=tip, xytext=(start.x_m, start.y_m), arrowprops=arrow, zorder=5)
    _legend(axes)
    return _png(figure)


def _draw_room(axes: Any, room: Mapping[str, Any]) -> None:
    """Draw the walls, the fence and the things of a map."""
    from matplotlib.patches import Circle, Polygon, Rectangle

    if size := room.get("size_m"):
        corner = (-size[0] / 2, -size[1] / 2)
        axes.add_patch(Rectangle(corner, size[0], size[1], fill=False, edgecolor=_TEXT, linewidth=1.5, zorder=1))
    fence: dict[str, Any] = {
        "closed": True,
        "fill": False,
        "edgecolor": _END,
        "linewidth": 1.0,
        "linestyle": (0, (2, 3)),
        "zorder": 1,
    }
    axes.add_patch(Polygon(room["fence"], **fence))
    for thing in room["things"]:
        look: dict[str, Any] = {
            "facecolor": thing.get("colour", _GRID),
            "edgecolor": _GRID,
            "linewidth": 0.8,
            "alpha": 0.8,
        }
        x_m, y_m = thing["at_m"]
        if size := thing.get("size_m"):
            corner = (x_m - size[0] / 2, y_m - size[1] / 2)
            turned: dict[str, Any] = {"angle": thing.get("turned_deg", 0.0), "rotation_point": "center"}
            axes.add_patch(Rectangle(corner, size[0], size[1], **turned, **look, zorder=2))
        else:
            axes.add_patch(Circle((x_m, y_m), thing["radius_m"], **look, zorder=2))
