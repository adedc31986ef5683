"""The drawing of an arm as in a robotics textbook, made from its DH table: shapes in numbers, SVG, and words.

Planar arms are drawn flat, from +z_w; others in one fixed axonometric view. What is drawn for joint i is the entry
of the table, theta_i or d_i with its offset. Lengths are brought nearer to each other, so that small ones are seen.
"""

from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from exercises.arm.chain import Chain
from exercises.figure import frames
from exercises.figure.arm import ground, joint, joint_angle, link, scene, slide, way_to_point
from exercises.figure.labels import Placement, place
from exercises.figure.pose import HEIGHT, ROOM, WIDTH, Skeleton, best_poses, camera, drawn_chain, skeleton, told_pose
from exercises.figure.shapes import Circle, Figure, Glyph, Pair, Shape
from exercises.figure.view import Part, View
from exercises.figure.words import alt_text, exact, title_text
from exercises.render import render

__all__ = ["alt_text", "arm_figure", "figure_svg"]

MARGIN = (34.0, 26.0)
"""Pixels kept free at the left and right, and above and below, for labels outside of all lines."""
TRIED = 7
"""How many of the best poses are drawn in full, to take the one whose labels find the best places."""


def arm_figure(chain: Chain, pose: Mapping[str, float] | None = None) -> Figure:
    """Draw an arm.

    `pose` tells the joint variables by name ("theta1" in rad, "d2" in m); without it the clearest of a fixed list of
    poses is taken. The figure is in pixels, y down.
    """
    chain = exact(chain)
    drawn = drawn_chain(chain)
    poses = best_poses(chain, drawn, TRIED) if pose is None else told_pose(chain, pose)[None]
    best: tuple[float, Figure] | None = None
    for order, entries in enumerate(poses):
        figure, cost = _compose(chain, skeleton(drawn, entries))
        cost = round(cost + 6.0 * order, 1)  # rounded: a tie goes to the first on every machine
        if best is None or cost < best[0]:
            best = (cost, figure)
    assert best is not None
    return best[1]


@lru_cache(maxsize=512)
def _drawn(chain: Chain) -> Figure:
    return arm_figure(chain)


def figure_svg(chain: Chain, name: str = "arm", pose: Mapping[str, float] | None = None) -> str:
    """Return the drawing as a self-contained SVG element; `name` makes its ids unique in a page."""
    figure = _drawn(chain) if pose is None else arm_figure(chain, pose)
    return render(
        "figure.svg.j2", figure=figure, name=name, title=title_text(chain), description=alt_text(chain), fixed=fixed
    )


def fixed(value: float) -> str:
    """Return a number with one decimal, the same on every machine.

    >>> fixed(-0.04), fixed(12.25)
    ('0.0', '12.3')
    """
    text = f"{value + 1.37e-4:.1f}"  # the shift takes exact ties, on which machines might differ, off the edge
    return "0.0" if text == "-0.0" else text


def _compose(chain: Chain, bones: Skeleton) -> tuple[Figure, float]:
    """Return the figure of one pose, and how badly its labels are placed."""
    view = _first_view(chain, bones)
    for _ in range(3):
        low, high = _extent(_parts(chain, bones, view).shapes)
        room = np.array([WIDTH, HEIGHT]) - 2 * np.array(MARGIN)
        shrink = float(np.min(room / np.maximum(high - low, 1e-9)))
        scale = view.scale * (min(shrink, 1.0) if shrink < 0.999 else 1.0)
        middle = (low + high) / 2
        x, y = (WIDTH / 2 - middle[0] + view.shift[0], HEIGHT / 2 - middle[1] + view.shift[1])
        view = View(view.axes, scale, (float(x), float(y)))
    part = _parts(chain, bones, view)
    placed: Placement = place(list(part.labels), list(part.shapes), WIDTH, HEIGHT)
    return Figure(WIDTH, HEIGHT, part.shapes, placed.texts), placed.cost


def _first_view(chain: Chain, bones: Skeleton) -> View:
    points = [*bones.origins, *bones.corners, *bones.path]
    if not chain.base.is_world:
        points.append(np.zeros(3))
    axes = camera(chain)
    spread = np.ptp(np.array(points) @ axes[:2].T, axis=0)
    return View(axes, float(np.min(np.array(ROOM) / np.maximum(spread, 1e-3))))


def _parts(chain: Chain, bones: Skeleton, view: View) -> Part:
    """Return all parts from back to front."""
    stage = scene(chain, bones, view)
    hides = not chain.is_planar and float(view.axes[2] @ bones.frames[0, :3, 2]) < -1e-9
    part = frames.world(stage) + (Part() if hides else ground(stage))
    for i in range(1, chain.n + 1):
        along = (bones.corners[i - 1] - bones.origins[i - 1]) @ view.axes[2]
        pair = [joint(stage, i), link(stage, i)]
        part += pair[0] + pair[1] if along > 1e-9 and chain.joints[i - 1].kind == "R" else pair[1] + pair[0]
        if i == chain.point.frame:
            part += way_to_point(stage)
        if i == 1 and hides:
            part += ground(stage)
    for i in range(1, chain.n + 1):
        part += joint_angle(stage, i) + slide(stage, i)
    return part + frames.axes(stage) + frames.page_normals(stage) + frames.origins(stage)


def _extent(shapes: tuple[Shape, ...]) -> tuple[np.ndarray, np.ndarray]:
    points: list[Pair] = []
    for shape in shapes:
        if isinstance(shape, Glyph):
            low, high = _extent(shape.shapes)
            points += [(float(low[0]), float(low[1])), (float(high[0]), float(high[1]))]
        elif isinstance(shape, Circle):
            (x, y), r = shape.center, shape.radius
            points += [(x - r, y - r), (x + r, y + r)]
        else:
            points += shape.points
    return np.min(points, axis=0), np.max(points, axis=0)
