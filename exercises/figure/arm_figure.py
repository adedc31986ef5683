"""Draw the figure of an arm with labels, in its clearest pose or a given pose, and figures of several drawings.

A pose has the joint variables by name: "theta1" in rad, "d2" in m. Figures are in pixels, y down.
"""

import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.figure import frames
from qdot.exercises.figure.arm_parts import draw_joint_variable, draw_links_and_joints, fit_drawing, make_scene
from qdot.exercises.figure.labels import Layout
from qdot.exercises.figure.lettering import FONT_SIZE, measure_width, write_upright
from qdot.exercises.figure.model import make_model
from qdot.exercises.figure.plane import choose_view, is_drawn_flat, make_numbers_exact
from qdot.exercises.figure.pose import (
    HEIGHT,
    LONG_ARM_JOINTS,
    MAX_ARM_SIZE,
    WIDTH,
    Skeleton,
    compute_skeleton,
    compute_table_entries,
    find_best_poses,
    find_best_views,
    make_drawable_chain,
)
from qdot.exercises.figure.shapes import Figure, format_one_decimal, format_svg_points
from qdot.exercises.figure.small import PANEL_SIZE, choose_grid, draw_in_pose, draw_singular_panels, draw_thumbnail
from qdot.exercises.figure.view import Drawing, View
from qdot.exercises.figure.words import describe_figure, describe_panels, make_panels_title, make_title
from qdot.exercises.problem.problem import Part
from qdot.exercises.reference_answers import LETTERS
from qdot.exercises.short_questions.configurations import find_options_to_draw
from qdot.exercises.writing.languages import ENGLISH, load_catalogue
from qdot.exercises.writing.render import render

MARGIN = (34.0, 26.0)
"""Margins for the labels around the drawing, in pixels: on the left and right, and above and below."""
TRIED_POSE_COUNT = {False: 7, True: 16}
"""Number of poses that are drawn with labels in order to find the best-labelled pose; True is for a long arm."""
LATER_POSE_COST = 6.0
"""Cost that a pose has for each pose with a better score, on the same scale as the costs of labels (`places`)."""
GOOD_LABEL_COST = 8.0
"""If the average cost of a label is at most this, no further pose is tried. Each pose tried raises the limit."""
ABANDON_COST_LEAD = 0.2
"""A drawing is abandoned if it costs this much more than another drawing; costs are rounded to 0.1."""
LABEL_ROUNDS = 3
"""How often the labels of the chosen pose are placed. After the first time, each label avoids all other labels."""
TRIED_VIEW_COUNT = 5
"""Number of views that are tried for a spatial arm in a given pose."""
CLEAR_LABEL_COST = {True: 30.0, False: 16.0}
"""Maximum average cost of a label; if the average cost is higher, the drawing gets fewer names.

True is for a flat drawing. Its maximum is higher, because labels have more room and no arrow points at the reader.
"""
BASE_DISTANCE_FACTORS = (1.0, 1.3, 1.6, 0.75, 2.0)
"""Factors for the base's distance from the world's origin, tried in turn while origins coincide in the drawing."""

PoseKey = tuple[tuple[str, float], ...]
"""A pose as a value that can be a key of a cache."""

PANEL_PERCENT, PANEL_GAP, LINE_HEIGHT, LETTER_WIDTH = 60, 12, 20, 8
"""Scale of small drawings in per cent. In pixels: gap between drawings, height of a line of text, width of a letter."""


class LabelledDrawing(NamedTuple):
    """A drawing and the current layout of its labels."""

    drawing: Drawing
    layout: Layout


def find_figure_pose(chain: Chain) -> dict[str, float]:
    """Return the pose in which `draw_figure_svg` draws an arm by default."""
    home = {q.name: 0.0 for q in chain.q}
    if convention_of(chain).is_drawn_at_home:
        return home
    _, entries = draw_with_labels(chain, None)
    offsets = compute_table_entries(chain, home)
    return {name: round(float(entry - offset), 9) for name, entry, offset in zip(home, entries, offsets, strict=True)}


@lru_cache(maxsize=64)
def draw_with_labels(chain: Chain, pose: PoseKey | None) -> tuple[Figure, tuple[float, ...]]:
    """Return the figure of an arm, and the entries of its table (n) in the drawn pose; cached.

    Without a pose, the clearest of a fixed list of poses is used. Arms with the same model share one drawing.
    """
    model = make_model(make_numbers_exact(chain))
    figure, entries = _draw_model(model.chain, None if pose is None else model.convert_to_model_pose(dict(pose)))
    return model.relabel(figure), model.convert_to_arm_entries(entries)


@lru_cache(maxsize=1024)
def _draw_model(chain: Chain, pose: PoseKey | None) -> tuple[Figure, tuple[float, ...]]:
    """Return the figure of a model (see `model`), and the entries of its table (n) in the drawn pose."""
    if pose is None:
        (drawing, layout), entries = _draw_in_clearest_pose(chain)
    else:
        entries = compute_table_entries(chain, dict(pose))
        drawing, layout = _draw_in_given_pose(chain, entries)
    for _ in range(1, LABEL_ROUNDS):
        layout.place_all()
    return Figure(WIDTH, HEIGHT, drawing.shapes + layout.leaders, layout.texts), tuple(map(float, entries))


def _draw_in_clearest_pose(chain: Chain) -> tuple[LabelledDrawing, np.ndarray]:
    """Return the drawing in the clearest of a fixed list of poses, and the table's entries (n) in this pose."""
    best_cost, best_drawing_and_entries = math.inf, None
    poses = find_best_poses(chain, make_drawable_chain(chain), TRIED_POSE_COUNT[chain.n > LONG_ARM_JOINTS])
    for rank, entries in enumerate(poses):
        rank_cost = LATER_POSE_COST * rank
        labelled_drawing, cost = _draw_and_label(chain, _make_skeletons(chain, entries), best_cost - rank_cost)
        cost = round(cost + rank_cost, 1)  # rounded, so that every machine chooses the first of equally good poses
        if best_drawing_and_entries is None or cost < best_cost:
            best_cost, best_drawing_and_entries = cost, (labelled_drawing, entries)
        good_cost = GOOD_LABEL_COST * (1 + rank / 5) * len(labelled_drawing.drawing.labels)
        if best_cost <= max(good_cost, LATER_POSE_COST * (rank + 1)):
            break
    assert best_drawing_and_entries is not None
    return best_drawing_and_entries


def _draw_in_given_pose(chain: Chain, entries: np.ndarray) -> LabelledDrawing:
    """Return the drawing in a given pose: with all names if the drawing is clear in some view, otherwise with few."""
    is_flat = is_drawn_flat(chain)
    views = [choose_view(chain)] if is_flat else find_best_views(make_drawable_chain(chain), entries, TRIED_VIEW_COUNT)
    for is_sparse in (False, True) if chain.n <= LONG_ARM_JOINTS else (True,):
        best_cost, best_drawing = math.inf, None
        for axes in views:
            labelled_drawing, cost = _draw_and_label(chain, _make_skeletons(chain, entries), best_cost, axes, is_sparse)
            if best_drawing is None or round(cost, 1) < best_cost:
                best_cost, best_drawing = round(cost, 1), labelled_drawing
        assert best_drawing is not None
        clearest_drawing = best_drawing
        if best_cost <= CLEAR_LABEL_COST[is_flat] * len(best_drawing.drawing.labels):
            break
    return clearest_drawing


def draw_figure_svg(chain: Chain, name: str = "arm", pose: Mapping[str, float] | None = None) -> str:
    """Return the figure of an arm as a self-contained SVG element; `name` makes its ids unique in a page.

    Without a pose, an arm described by its axes is drawn at home, and any other arm in its clearest pose.
    """
    is_at_home = pose is None and convention_of(chain).is_drawn_at_home
    drawn_pose = {q.name: 0.0 for q in chain.q} if is_at_home else pose
    return _draw_cached_svg(chain, name, None if drawn_pose is None else tuple(drawn_pose.items()))


@lru_cache(maxsize=64)
def _draw_cached_svg(chain: Chain, name: str, pose: PoseKey | None) -> str:
    """Return the figure as SVG; cached, because the staff's notebook and the problem store both need it."""
    description = describe_figure(chain, pose is not None and any(value for _, value in pose))
    figure, _ = draw_with_labels(chain, pose)
    return _render("arm", name, make_title(chain), description, figure=figure)


def _render(template: str, name: str, title: str, description: str, **content: Any) -> str:
    """Return a figure as SVG, from a template and its content; screen readers read the title and the description."""
    content |= {"name": name, "title": title, "description": description}
    content |= {"format_number": format_one_decimal, "format_points": format_svg_points}
    return render(f"figure/{template}.svg.j2", **content)


def draw_part_svg(chain: Chain, part: Part, name: str) -> str:
    """Return the figure under a part's prompt as SVG: the part's configuration, or configurations to choose from.

    Return an empty text if the part has no figure.
    """
    options = find_options_to_draw(chain, part)
    if options is not None:
        return draw_options_svg(*options, name)
    return "" if part.details.pose is None else draw_figure_svg(chain, name, part.details.pose)


def draw_thumbnail_svg(chain: Chain, name: str = "arm") -> str:
    """Return a small drawing of the arm without labels as a self-contained SVG element."""
    figure = draw_thumbnail(chain)
    size = tuple(PANEL_PERCENT * length // 100 for length in (figure.width, figure.height))
    return _render(
        "thumbnail", name, make_title(chain), describe_figure(chain, is_away_from_home=True), figure=figure, size=size
    )


def draw_singular_svg(chain: Chain, name: str = "singular", language: str = ENGLISH) -> str:
    """Return drawings of a regular and the singular configurations side by side as a self-contained SVG element.

    The text is empty for an arm without singular configurations or without regular configurations.
    """
    panels, catalogue = draw_singular_panels(chain, language), load_catalogue(language)
    if not panels.drawings:
        return ""
    captions = [caption for caption, _ in panels.drawings]
    description = describe_panels(captions, panels.legend, panels.remark, panels.has_lost_direction, catalogue)
    title, remark = make_panels_title(chain, catalogue), f"{panels.legend} {panels.remark}"
    return _render_panels(panels.drawings, remark, name, title, description)


def describe_part_figure(chain: Chain, part: Part) -> str:
    """Return a description of the figure under a part's prompt."""
    options = find_options_to_draw(chain, part)
    if options is None:
        return describe_figure(chain, is_away_from_home=True)
    _, poses = options
    return f"Configurations to choose from. {describe_options(poses)}"


def draw_options_svg(chain: Chain, poses: Sequence[Mapping[str, float]], name: str = "options") -> str:
    """Return drawings of an arm with numeric lengths in several configurations, with letters A, B, … under them."""
    drawings = [(LETTERS[k], draw_in_pose(chain, pose)) for k, pose in enumerate(poses)]
    title = f"{make_title(chain)}: configurations to choose from"
    return _render_panels(drawings, "", name, title, describe_options(poses))


@dataclass(frozen=True)
class Example:
    """A configuration to draw with a caption, of an arm with numeric lengths.

    `mark_offset` (3, in m) is the vector from P to a point that is marked, if any.
    """

    caption: str
    chain: Chain
    pose: Mapping[str, float]
    mark_offset: np.ndarray | None = None


def draw_examples_svg(examples: Sequence[Example], name: str, remark: str = "") -> str:
    """Return drawings to scale of arms with numeric lengths in given configurations, side by side, with captions."""
    drawings = [
        (example.caption, draw_in_pose(example.chain, example.pose, example.mark_offset)) for example in examples
    ]
    descriptions = [f"{example.caption}: {_describe_pose(example.pose)}" for example in examples]
    title = f"{make_title(examples[0].chain)}: where the answer differs"
    return _render_panels(drawings, remark, name, title, f"{'; '.join(descriptions)}.")


def describe_options(poses: Sequence[Mapping[str, float]]) -> str:
    """Return a description of drawings to choose from."""
    return "; ".join(f"{letter}: {_describe_pose(pose)}" for letter, pose in zip(LETTERS, poses, strict=False)) + "."


def _describe_pose(pose: Mapping[str, float]) -> str:
    return ", ".join(
        f"{joint} = {np.degrees(value):.4g} degrees" if joint.startswith("theta") else f"{joint} = {value:.4g} m"
        for joint, value in pose.items()
    )


def _render_panels(drawings: Sequence[tuple[str, Figure]], remark: str, name: str, title: str, description: str) -> str:
    """Return drawings with captions as one SVG element. It is as wide as an arm's figure, with labels of equal size."""
    widest_caption = max(measure_width(write_upright(caption)) for caption, _ in drawings)
    columns, rows = choose_grid(len(drawings), widest_caption, WIDTH)
    panel_width, panel_height = (PANEL_PERCENT * length // 100 for length in PANEL_SIZE)
    row_height = panel_height + PANEL_GAP + LINE_HEIGHT
    panels = []
    for k, (caption, figure) in enumerate(drawings):
        row, column = divmod(k, columns)
        middle, top = WIDTH * (2 * column + 1) / (2 * columns), row_height * row
        panels.append({"x": middle - panel_width / 2, "middle": middle, "y": PANEL_GAP // 2 + top, "caption": caption,
                       "baseline": top + row_height - LINE_HEIGHT // 2, "figure": figure})  # fmt: skip
    remark_lines = textwrap.wrap(remark, (WIDTH - 2 * PANEL_GAP) // LETTER_WIDTH)
    return _render(
        "panels", name, title, description, panels=panels, remark=remark_lines, font=FONT_SIZE, width=WIDTH,
        end=row_height * rows, line_height=LINE_HEIGHT, scale=PANEL_PERCENT / 100,
    )  # fmt: skip


def _make_skeletons(chain: Chain, entries: np.ndarray) -> Iterator[Skeleton]:
    """Yield the skeletons of an arm in a pose (n) with the base at different distances from the world's origin."""
    for factor in BASE_DISTANCE_FACTORS if any(chain.base.position) else BASE_DISTANCE_FACTORS[:1]:
        yield compute_skeleton(make_drawable_chain(chain, factor), entries)


def _draw_and_label(
    chain: Chain,
    skeletons: Iterable[Skeleton],
    max_cost: float,
    axes: np.ndarray | None = None,
    is_sparse: bool = False,
) -> tuple[LabelledDrawing, float]:
    """Return the drawing of one pose with its labels placed once, and the cost of the places of labels and origins.

    `skeletons` have the same pose, but different distances of the base. The drawing uses the first skeleton whose
    origins are apart from the world's origin and axes. A drawing that costs clearly more than `max_cost` is not
    completed; its cost is infinite.
    """
    candidates: list[tuple[float, float, Drawing]] = []
    for skeleton in skeletons:
        draw = partial(_draw_parts, chain, skeleton, is_sparse)
        drawing, view = fit_drawing(chain, skeleton, draw, MAX_ARM_SIZE, (WIDTH, HEIGHT), MARGIN, axes)
        arm_cost, world_cost = frames.compute_crowding_costs(make_scene(chain, skeleton, view))
        candidates.append((round(world_cost, 1), arm_cost, drawing))
        if world_cost == 0.0:
            break
    world_cost, arm_cost, drawing = min(candidates, key=lambda candidate: candidate[0])
    layout = Layout(drawing.labels, drawing.shapes, (WIDTH, HEIGHT))
    is_complete = layout.place_all(max_cost + ABANDON_COST_LEAD - arm_cost - world_cost)
    cost = layout.cost + arm_cost + world_cost if is_complete else math.inf
    return LabelledDrawing(drawing, layout), cost


def _draw_parts(chain: Chain, skeleton: Skeleton, is_sparse: bool, view: View) -> Drawing:
    """Return the drawing of an arm with its labels, from back to front."""
    scene = make_scene(chain, skeleton, view, is_sparse)
    arm, world = draw_links_and_joints(scene), frames.draw_world(scene)
    if is_sparse:
        arm = Drawing(arm.shapes)
    # At home, a link may run along an axis of the space frame, which is then drawn on top.
    drawing = arm + world if scene.convention.is_drawn_at_home else world + arm
    if not is_sparse:
        for i in range(1, chain.n + 1):
            drawing += draw_joint_variable(scene, i)
    drawing += frames.draw_body_frame(scene) + frames.draw_axes(scene)
    return drawing + frames.draw_end_on_z_names(scene) + frames.draw_origins(scene)
