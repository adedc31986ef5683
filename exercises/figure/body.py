"""The arm by itself, without frames and lettering, and the view that fits a drawing into its box."""

from collections.abc import Callable

import numpy as np

from exercises.arm.chain import Chain
from exercises.figure.arm import Scene, ground, joint, link, way_to_point
from exercises.figure.plane import camera, is_flat
from exercises.figure.pose import Skeleton
from exercises.figure.shapes import Circle, Glyph, Pair, Shape
from exercises.figure.view import Part, View


def body(stage: Scene) -> Part:
    """Return ground, links and joints from back to front, with the lengths of the links."""
    chain, bones, view = stage.chain, stage.bones, stage.view
    hides = not is_flat(chain) and float(view.axes[2] @ bones.frames[0, :3, 2]) < -1e-9
    part = Part() if hides else ground(stage)
    for i in range(1, chain.n + 1):
        along = (bones.corners[i - 1] - bones.origins[i - 1]) @ view.axes[2]
        pair = [joint(stage, i), link(stage, i)]
        part += pair[0] + pair[1] if along > 1e-9 and chain.joints[i - 1].kind == "R" else pair[1] + pair[0]
        if i == chain.point.frame:
            part += way_to_point(stage)
        if i == 1 and hides:
            part += ground(stage)
    return part


def fitted(
    chain: Chain,
    bones: Skeleton,
    shapes: Callable[[View], tuple[Shape, ...]],
    room: Pair,
    size: Pair,
    margin: Pair,
    axes: np.ndarray | None = None,
) -> View:
    """Return the view in which the skeleton takes `room` at most, and all shapes `size` less `margin` on each side.

    `axes` are its directions right, up and towards the reader (rows), if it is not the usual one.
    """
    view = _first_view(chain, bones, room, camera(chain) if axes is None else axes)
    for _ in range(3):
        low, high = extent(shapes(view))
        shrink = float(np.min((np.array(size) - 2 * np.array(margin)) / np.maximum(high - low, 1e-9)))
        fits = shrink >= 0.999
        middle = (low + high) / 2
        x, y = (size[0] / 2 - middle[0] + view.shift[0], size[1] / 2 - middle[1] + view.shift[1])
        view = View(view.axes, view.scale if fits else view.scale * shrink, (float(x), float(y)))
        if fits:
            break
    return view


def _first_view(chain: Chain, bones: Skeleton, room: Pair, axes: np.ndarray) -> View:
    points = [*bones.origins, *bones.corners, *bones.path]
    if not chain.base.is_world:
        points.append(np.zeros(3))
    spread = np.ptp(np.array(points) @ axes[:2].T, axis=0)
    return View(axes, float(np.min(np.array(room) / np.maximum(spread, 1e-3))))


def extent(shapes: tuple[Shape, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the greatest coordinates of shapes (2 each)."""
    points: list[Pair] = []
    for shape in shapes:
        for inner in shape.shapes if isinstance(shape, Glyph) else (shape,):
            if isinstance(inner, Circle):
                (x, y), r = inner.center, inner.radius
                points += [(x - r, y - r), (x + r, y + r)]
            else:
                points += inner.points
    found = np.array(points)
    return found.min(axis=0), found.max(axis=0)
