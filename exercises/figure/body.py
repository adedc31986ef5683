"""The arm without frames and lettering, and the view that fits a drawing into its box."""

from collections.abc import Callable

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.figure.arm import Scene, ground, joint, link, way_to_point
from qdot.exercises.figure.plane import camera
from qdot.exercises.figure.pose import Skeleton
from qdot.exercises.figure.shapes import Circle, Glyph, Pair, Shape
from qdot.exercises.figure.view import Drawing, View


def body(stage: Scene) -> Drawing:
    """Return ground, links and joints from back to front, with the lengths of the links."""
    chain, bones, view = stage.chain, stage.bones, stage.view
    hides = not stage.is_planar and view.toward(bones.frames[0, :3, 2]) < -1e-9
    part = Drawing() if hides else ground(stage)
    for i in range(1, chain.n + 1):
        along = view.toward(bones.corners[i - 1] - bones.origins[i - 1])
        pair = [joint(stage, i), link(stage, i)]
        part += pair[0] + pair[1] if along > 1e-9 and chain.joints[i - 1].kind == "R" else pair[1] + pair[0]
        if i == chain.point.frame:
            part += way_to_point(stage)
        if i == 1 and hides:
            part += ground(stage)
    return part


def fit_drawing(
    chain: Chain,
    bones: Skeleton,
    draw: Callable[[View], Drawing],
    room: Pair,
    size: Pair,
    margin: Pair,
    axes: np.ndarray | None = None,
) -> tuple[Drawing, View]:
    """Return a drawing that fits into `size` less `margin` on each side, and its view.

    The skeleton takes at most `room`. `axes` are the view's directions right, up and towards the reader (rows), if it
    is not the usual view.
    """
    view = _first_view(chain, bones, room, camera(chain) if axes is None else axes)
    for _ in range(3):
        part = draw(view)
        low, high = extent(part.shapes)
        spread = max(high[0] - low[0], 1e-9), max(high[1] - low[1], 1e-9)
        shrink = min((size[0] - 2 * margin[0]) / spread[0], (size[1] - 2 * margin[1]) / spread[1])
        by = (size[0] / 2 - (low[0] + high[0]) / 2, size[1] / 2 - (low[1] + high[1]) / 2)
        shift = (by[0] + view.shift[0], by[1] + view.shift[1])
        if shrink >= 0.999:
            return part.shift(by), View(view.axes, view.scale, shift)
        view = View(view.axes, view.scale * shrink, shift)
    return draw(view), view


def _first_view(chain: Chain, bones: Skeleton, room: Pair, axes: np.ndarray) -> View:
    points = [*bones.origins, *bones.corners, *bones.path]
    if not chain.base.is_world:
        points.append(np.zeros(3))
    spread = np.ptp(np.array(points) @ axes[:2].T, axis=0)
    return View(axes, float(np.min(np.array(room) / np.maximum(spread, 1e-3))))


def extent(shapes: tuple[Shape, ...]) -> tuple[Pair, Pair]:
    """Return the least and the greatest coordinates of shapes."""
    points: list[Pair] = []
    for shape in shapes:
        for inner in shape.shapes if isinstance(shape, Glyph) else (shape,):
            if isinstance(inner, Circle):
                (x, y), r = inner.center, inner.radius
                points += [(x - r, y - r), (x + r, y + r)]
            else:
                points += inner.points
    across, down = [x for x, _ in points], [y for _, y in points]
    return (min(across), min(down)), (max(across), max(down))
