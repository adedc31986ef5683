"""The drawing of an arm as in a robotics textbook, made from its DH table: shapes in numbers, SVG, and words.

Planar arms are drawn flat, from +z_w; others in one fixed axonometric view, but in a told pose, where links and axes
may lie over one another, from the side from which they are seen apart, and with fewer names. What is drawn for joint i
is the entry of the table, theta_i or d_i with its offset. Lengths are brought nearer to each other, so that small ones
are seen.

    shapes, view            plain shapes in pixels; from metres to pixels
    plane, aspect, pose     which way an arm is looked at, in general and in a told pose; the pose in which it is drawn
    model                   the arm that is drawn in the place of others that look alike, but for their labels
    arm, frames, body       links and joints; axes, origins and the base's place; an arm without lettering
    ink, places, labels     the lines of a drawing as points; the places of one label; where all labels go
    small                   thumbnails, and singular configurations beside a regular one
    tikz, words             the drawing for LaTeX; what it shows, in words
"""

import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np

from qdot.exercises.answers import LETTERS
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure import frames
from qdot.exercises.figure.arm import joint_angle, scene, slide
from qdot.exercises.figure.aspect import sides
from qdot.exercises.figure.body import body, fitted
from qdot.exercises.figure.labels import Layout
from qdot.exercises.figure.model import model_of
from qdot.exercises.figure.plane import camera, exact, is_flat
from qdot.exercises.figure.pose import HEIGHT, LONG, ROOM, WIDTH, Skeleton, best_poses, drawn_chain, skeleton, told_pose
from qdot.exercises.figure.shapes import FONT, Figure, extent, fixed, path, roman
from qdot.exercises.figure.small import PANEL, cells, posed, singular_panel, thumbnail
from qdot.exercises.figure.view import Drawn, View
from qdot.exercises.figure.words import alt_text, panels_text, panels_title, title_text
from qdot.exercises.problem.problem import Part
from qdot.exercises.quizzes.places import drawn_options
from qdot.exercises.writing.languages import ENGLISH, catalogue
from qdot.exercises.writing.render import render

__all__ = [
    "Example",
    "alt_text",
    "arm_figure",
    "examples_svg",
    "figure_pose",
    "figure_svg",
    "fixed",
    "options_svg",
    "part_alt",
    "part_svg",
    "singular_panel",
    "singular_svg",
    "thumbnail_svg",
]

MARGIN = (34.0, 26.0)
"""Pixels kept free at the left and right, and above and below, for labels outside of all lines."""
TRIED = {False: 7, True: 16}
"""How many of the best poses are drawn in full at most, to take the one whose labels find the best places."""
DELAY = 6.0
"""What a pose costs for each better one before it, as labels cost (see `labels`)."""
GOOD = 8.0
"""What a label may cost on average in a pose that is taken without looking at others; more after each look."""
CLEARLY = 0.2
"""By so much a drawing must cost more than another to be given up before it is complete; costs are rounded to 0.1."""
ROUNDS = 3
"""How often the labels of the pose that is taken are placed, each time with all others in sight."""
SIDES, CLEAR = 5, {True: 30.0, False: 16.0}
"""From so many sides an arm in a told pose is drawn in space; what a label may cost on average there with all names.

More in a flat drawing, where labels have more room and no arrow points towards the reader.
"""
STRETCHES = (1.0, 1.3, 1.6, 0.75, 2.0)
"""Factors for the base's distance from the world's origin, tried one by one while origins are drawn at one place."""

Composed = tuple[Drawn, Layout]
"""A drawing, and its labels as they are placed so far."""

SHRUNK, GAP, LINE, LETTER = 60, 12, 20, 8
"""Small drawings are shown at so many per cent; pixels between them, for the line of a caption, and for a letter."""


def arm_figure(chain: Chain, pose: Mapping[str, float] | None = None) -> Figure:
    """Draw an arm.

    `pose` tells the joint variables by name ("theta1" in rad, "d2" in m); without it the clearest of a fixed list of
    poses is taken. The figure is in pixels, y down; it is kept for those who show it again, under other names.
    """
    return _shown(chain, None if pose is None else tuple(pose.items()))[0]


def figure_pose(chain: Chain) -> dict[str, float]:
    """Return the joint variables by name (rad, m) in the pose in which `figure_svg` draws an arm of its own accord."""
    zero = {q.name: 0.0 for q in chain.q}
    if not convention_of(chain).has_frames:
        return zero
    entries, offsets = _shown(chain, None)[1], told_pose(chain, zero)
    return {name: round(float(entry - offset), 9) for name, entry, offset in zip(zero, entries, offsets, strict=True)}


@lru_cache(maxsize=64)
def _shown(chain: Chain, pose: tuple[tuple[str, float], ...] | None) -> tuple[Figure, tuple[float, ...]]:
    """Return the drawing, and the entries of the table (n) in its pose: the model's, with the arm's own labels."""
    model = model_of(exact(chain))
    figure, entries = _drawn(model.chain, None if pose is None else model.pose(dict(pose)))
    return model.lettered(figure), model.entries(entries)


@lru_cache(maxsize=1024)
def _drawn(chain: Chain, pose: tuple[tuple[str, float], ...] | None) -> tuple[Figure, tuple[float, ...]]:
    """Return the drawing of a model, and the entries of its table (n)."""
    if pose is None:
        (part, layout), entries = _own(chain)
    else:
        entries = told_pose(chain, dict(pose))
        part, layout = _told(chain, entries)
    for _ in range(1, ROUNDS):
        layout.place_all()
    placed = layout.placement
    return Figure(WIDTH, HEIGHT, part.shapes + placed.leaders, placed.texts), tuple(map(float, entries))


def _own(chain: Chain) -> tuple[Composed, np.ndarray]:
    """Return the drawing in the clearest of a fixed list of poses, and that pose."""
    best: tuple[float, Composed, np.ndarray] | None = None
    for order, entries in enumerate(best_poses(chain, drawn_chain(chain), TRIED[chain.n > LONG])):
        most = math.inf if best is None else best[0] - DELAY * order
        composed, cost = _compose(chain, _choices(chain, entries), most)
        cost = round(cost + DELAY * order, 1)  # rounded: a tie goes to the first on every machine
        if best is None or cost < best[0]:
            best = (cost, composed, entries)
        if best[0] <= max(GOOD * (1 + order / 5) * len(composed[0].labels), DELAY * (order + 1)):
            break
    assert best is not None
    return best[1:]


def _told(chain: Chain, entries: np.ndarray) -> Composed:
    """Return the drawing in a told pose: with all names if it is clear from some side, else with few of them."""
    flat = is_flat(chain)
    views = [camera(chain)] if flat else sides(drawn_chain(chain), entries, SIDES)
    for sparse in (False, True) if chain.n <= LONG else (True,):
        best: tuple[float, Composed] | None = None
        for axes in views:
            most = math.inf if best is None else best[0]
            composed, cost = _compose(chain, _choices(chain, entries), most, axes, sparse)
            if best is None or round(cost, 1) < best[0]:
                best = (round(cost, 1), composed)
        assert best is not None
        cost, composed = best
        if cost <= CLEAR[flat] * len(composed[0].labels):
            break
    return composed


def figure_svg(chain: Chain, name: str = "arm", pose: Mapping[str, float] | None = None) -> str:
    """Return the drawing as a self-contained SVG element; `name` makes its ids unique in a page.

    An arm that is told by its axes is drawn at home, unless another pose is told.
    """
    if pose is None and not convention_of(chain).has_frames:
        pose = {q.name: 0.0 for q in chain.q}
    return _svg(chain, name, None if pose is None else tuple(pose.items()))


@lru_cache(maxsize=64)
def _svg(chain: Chain, name: str, pose: tuple[tuple[str, float], ...] | None) -> str:
    """Return the same, kept for those who show it again at once: the staff's notebook, the store."""
    return render(
        "figure/arm.svg.j2",
        figure=_shown(chain, pose)[0],
        name=name,
        title=title_text(chain),
        description=alt_text(chain, pose is not None and any(value for _, value in pose)),
        fixed=fixed,
        path=path,
    )


def part_svg(chain: Chain, part: Part, name: str) -> str:
    """Return the figure under a part's prompt: its configuration, or those to choose from; nothing if there is none."""
    options = drawn_options(chain, part)
    if options is not None:
        return options_svg(*options, name)
    return "" if part.pose is None else figure_svg(chain, name, part.pose)


def thumbnail_svg(chain: Chain, name: str = "arm") -> str:
    """Return a small drawing of the arm without lettering as a self-contained SVG element."""
    figure = thumbnail(chain)
    size = tuple(SHRUNK * length // 100 for length in (figure.width, figure.height))
    return render(
        "figure/thumbnail.svg.j2",
        figure=figure,
        name=name,
        size=size,
        title=title_text(chain),
        description=alt_text(chain, posed=True),
        fixed=fixed,
        path=path,
    )


def singular_svg(chain: Chain, name: str = "singular", language: str = ENGLISH) -> str:
    """Return drawings of a regular and the singular configurations side by side as a self-contained SVG element.

    It is empty where there is nothing to draw: an arm without singular, or without regular configurations.
    """
    panel, words = singular_panel(chain, language), catalogue(language)
    if not panel.drawings:
        return ""
    captions = [caption for caption, _ in panel.drawings]
    description = panels_text(captions, panel.key, panel.remark, words, panel.has_lost)
    return _side_by_side(panel.drawings, f"{panel.key} {panel.remark}", name, panels_title(chain, words), description)


def part_alt(chain: Chain, part: Part) -> str:
    """Return the figure under a part's prompt in words."""
    options = drawn_options(chain, part)
    return (
        alt_text(chain, posed=True) if options is None else f"Configurations to choose from. {options_text(options[1])}"
    )


def options_svg(chain: Chain, poses: Sequence[Mapping[str, float]], name: str = "options") -> str:
    """Return drawings of an arm in numbers in several configurations, with the letters A, B, … under them."""
    drawings = [(LETTERS[k], posed(chain, pose)) for k, pose in enumerate(poses)]
    title = f"{title_text(chain)}: configurations to choose from"
    return _side_by_side(drawings, "", name, title, options_text(poses))


@dataclass(frozen=True)
class Example:
    """A configuration to be shown: its caption, an arm in numbers, joint values by name, and what leads to a point."""

    caption: str
    chain: Chain
    pose: Mapping[str, float]
    beside: np.ndarray | None = None


def examples_svg(examples: Sequence[Example], name: str, below: str = "") -> str:
    """Return arms in numbers in told configurations side by side, each with its caption, to scale."""
    drawings = [(one.caption, posed(one.chain, one.pose, one.beside)) for one in examples]
    said = (f"{one.caption}: {', '.join(_in_words(q, value) for q, value in one.pose.items())}" for one in examples)
    title = f"{title_text(examples[0].chain)}: where the answer differs"
    return _side_by_side(drawings, below, name, title, f"{'; '.join(said)}.")


def options_text(poses: Sequence[Mapping[str, float]]) -> str:
    """Return what drawings to choose from show, in words."""
    said = (", ".join(_in_words(q, value) for q, value in pose.items()) for pose in poses)
    return "; ".join(f"{letter}: {pose}" for letter, pose in zip(LETTERS, said, strict=False)) + "."


def _in_words(joint: str, value: float) -> str:
    return f"{joint} = {value * 180 / np.pi:.4g} degrees" if joint.startswith("theta") else f"{joint} = {value:.4g} m"


def _side_by_side(drawings: Sequence[tuple[str, Figure]], below: str, name: str, title: str, description: str) -> str:
    """Return drawings with captions, as wide as an arm's own figure: where both are shown, they are lettered alike."""
    columns, rows = cells(len(drawings), max(extent(roman(caption))[0] for caption, _ in drawings), WIDTH)
    wide, high = (SHRUNK * length // 100 for length in PANEL)
    high += GAP
    middles = [WIDTH * (2 * column + 1) / (2 * columns) for column in range(columns)]
    panels = [
        {
            "x": middles[k % columns] - wide / 2,
            "y": GAP // 2 + (high + LINE) * (k // columns),
            "middle": middles[k % columns],
            "base": (high + LINE) * (k // columns) + high + LINE // 2,
            "figure": figure,
            "caption": caption,
        }
        for k, (caption, figure) in enumerate(drawings)
    ]
    end = (high + LINE) * rows
    remark = [
        {"y": end + LINE * k + LINE // 2, "text": text}
        for k, text in enumerate(textwrap.wrap(below, (WIDTH - 2 * GAP) // LETTER))
    ]
    return render(
        "figure/panels.svg.j2",
        panels=panels,
        remark=remark,
        name=name,
        font=FONT,
        width=WIDTH,
        height=end + LINE * len(remark),
        scale=SHRUNK / 100,
        title=title,
        description=description,
        fixed=fixed,
        path=path,
    )


def _choices(chain: Chain, entries: np.ndarray) -> Iterator[Skeleton]:
    """Yield the arm in a pose (n) with the base in different distances, worked out when they are asked for."""
    for stretch in STRETCHES if any(chain.base.position) else STRETCHES[:1]:
        yield skeleton(drawn_chain(chain, stretch), entries)


def _compose(
    chain: Chain, choices: Iterable[Skeleton], most: float, axes: np.ndarray | None = None, sparse: bool = False
) -> tuple[Composed, float]:
    """Return the drawing of one pose with its labels placed once, and how badly labels and origins are placed.

    `choices` are the pose in different lengths: the first is taken in which no origin is drawn at the world's. What
    costs clearly more than `most` is not completed; its cost is infinite.
    """
    layers: list[tuple[float, float, Drawn]] = []
    for bones in choices:
        part, view = fitted(chain, bones, partial(_parts, chain, bones, sparse), ROOM, (WIDTH, HEIGHT), MARGIN, axes)
        own, world = frames.crowding(scene(chain, bones, view))
        layers.append((round(world, 1), own, part))
        if world == 0.0:
            break
    world, own, part = min(layers, key=lambda one: one[0])
    layout = Layout(part.labels, part.shapes, (WIDTH, HEIGHT))
    complete = layout.place_all(most + CLEARLY - own - world)
    return (part, layout), layout.cost + own + world if complete else math.inf


def _parts(chain: Chain, bones: Skeleton, sparse: bool, view: View) -> Drawn:
    """Return all parts from back to front."""
    stage = scene(chain, bones, view, sparse)
    on_top = not convention_of(chain).has_frames  # at home, a link may run along an axis of the space frame
    before, behind = (Drawn(), frames.world(stage)) if on_top else (frames.world(stage), Drawn())
    if sparse:
        part = before + Drawn(body(stage).shapes) + behind
    else:
        part = before + body(stage) + behind
        for i in range(1, chain.n + 1):
            part += joint_angle(stage, i) + slide(stage, i)
    return part + frames.body_frame(stage) + frames.axes(stage) + frames.page_normals(stage) + frames.origins(stage)
