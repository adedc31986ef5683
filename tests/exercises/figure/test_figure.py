"""The figure of an arm: what must hold for the drawing of any chain, of any given pose, and in the dark."""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.variation import VARIATION_STEPS
from qdot.exercises.families import FAMILIES
from qdot.exercises.figure import arm_figure as drawing
from qdot.exercises.figure.arm_figure import (
    TRIED_POSE_COUNT,
    draw_figure_svg,
    draw_options_svg,
    draw_singular_svg,
    draw_thumbnail_svg,
)
from qdot.exercises.figure.lettering import LETTERING_HEIGHT, measure_width, write_upright
from qdot.exercises.figure.plane import is_drawn_flat, make_numbers_exact
from qdot.exercises.figure.pose import LONG_ARM_JOINTS, find_best_poses, list_candidate_poses, make_drawable_chain
from qdot.exercises.figure.shapes import Box, Circle, Figure, Glyph, Polyline, Text, Vector2D
from qdot.exercises.figure.small import PANEL_SIZE, PanelSet, draw_singular_panels
from qdot.exercises.figure.words import describe_figure
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.singular_set import find_singular_set
from tests.support import ROOT, problems
from tests.support.figures import count_link_crossings, draw_arm, find_faults
from tests.support.problems import LONG_ARMS
from tests.support.suites import few_families, on_families, select_families, select_for_suite

SVG = "{http://www.w3.org/2000/svg}"
PI = sp.pi
A1, A2, A3, D1, D4, D6, H = sp.symbols("a1 a2 a3 d1 d4 d6 h")
Q = sp.Rational


def turning(i: int, a: sp.Expr = 0, alpha: sp.Expr = 0, d: sp.Expr = 0, offset: sp.Expr = 0) -> Joint:
    return Joint("R", sp.Symbol(f"theta{i}") + offset, d, a, alpha)


def sliding(i: int, a: sp.Expr = 0, alpha: sp.Expr = 0, theta: sp.Expr = 0, offset: sp.Expr = 0) -> Joint:
    return Joint("P", theta, sp.Symbol(f"d{i}") + offset, a, alpha)


def flat(*joints: Joint, base: Base | None = None, tool: Point | None = None) -> Chain:
    return Chain("flat", joints, ("vx", "vy"), base or Base(), tool)


def spatial(*joints: Joint, base: Base | None = None) -> Chain:
    return Chain("spatial", joints, ("vx", "vy", "vz"), base or Base())


def elbow(base: Base | None = None, alpha: sp.Expr = -PI / 2, offset: sp.Expr = 0) -> Chain:
    first = turning(1, Q(1, 10), alpha, Q(7, 20), offset)
    return spatial(first, turning(2, A2, offset=-offset), turning(3, Q(11, 50)), base=base)


ARMS = {
    "1r": flat(turning(1, A1)),
    "2r": flat(turning(1, A1), turning(2, A2)),
    "2r-l": flat(turning(1, A1), turning(2, A2), tool=Point(2, (sp.S.Zero, H, sp.S.Zero))),
    "2r-moved": flat(turning(1, Q(9, 20)), turning(2, Q(1, 10)), base=Base((Q(-3, 10), Q(1, 5), sp.S.Zero), -PI / 4)),
    "2r-counted-back": flat(turning(1, A1, PI), turning(2, A2), tool=Point(2, (sp.S.Zero, -H, sp.S.Zero))),
    "2r-from-behind": flat(turning(1, A1, PI), turning(2, A2), base=Base(yaw=PI / 6, tilt=PI)),
    "3r": flat(turning(1, A1), turning(2, A2, offset=PI / 6), turning(3, A3)),
    "rp": flat(turning(1, A1, PI / 2), sliding(2)),
    "rp-back": flat(turning(1, Q(1, 10), -PI / 2, offset=PI / 2), sliding(2, offset=Q(1, 5))),
    "rp-straight": flat(turning(1, 0, PI / 2), sliding(2, theta=PI), tool=Point(2, (H, sp.S.Zero, sp.S.Zero))),
    "elbow-floor": elbow(),
    "elbow-wall": elbow(Base((0, 0, Q(1, 2)), PI / 2, PI / 2), PI / 2, PI / 2),
    "elbow-ceiling": elbow(Base((0, 0, sp.S.One), 0, PI), offset=PI / 2),
    "spherical": spatial(turning(1, 0, -PI / 2, D1), turning(2, 0, PI / 2), sliding(3)),
    "stanford": spatial(turning(1, 0, -PI / 2, Q(2, 5)), turning(2, 0, PI / 2, Q(3, 20)), sliding(3)),
    "scara": spatial(turning(1, A1, 0, D1), turning(2, A2, PI), sliding(3), turning(4, 0, 0, D4)),
    "gantry": spatial(sliding(1, 0, -PI / 2), sliding(2, 0, -PI / 2, -PI / 2), sliding(3)),
    "wrist": spatial(turning(1, 0, -PI / 2), turning(2, 0, PI / 2), turning(3)),
    "wrist-on-wall": spatial(
        turning(1, 0, -PI / 2), turning(2, 0, PI / 2), turning(3), base=Base((0, 0, Q(1, 2)), PI / 2, PI / 2)
    ),
    "rpr": flat(turning(1, 0, PI / 2), sliding(2, 0, -PI / 2), turning(3, A3)),
    "prr-upright": flat(sliding(1, 0, -PI / 2), turning(2, A2), turning(3, A3)),
    "lbr": spatial(
        turning(1, 0, -PI / 2, D1), turning(2, 0, PI / 2), turning(3, 0, PI / 2, Q(2, 5)), turning(4, 0, -PI / 2),
        turning(5, 0, -PI / 2, D4), turning(6, 0, PI / 2), turning(7, 0, 0, D6),
    ),
    "puma": spatial(
        turning(1, 0, -PI / 2, Q(33, 50)), turning(2, Q(43, 100), 0, Q(3, 20)), turning(3, Q(-1, 50), PI / 2),
        turning(4, 0, -PI / 2, Q(43, 100)), turning(5, 0, PI / 2), turning(6, 0, 0, D6),
    ),
}  # fmt: skip
REPORTED = ("pan-tilt/2", "elbow/1", "puma-560/3", "ur-6r/2", "random-3/3", "random-3/4")
"""Problems whose figures were once hard to read."""
SAMPLED = (*(f"{name}/1" for name in select_families()), *REPORTED)


@cache
def drawn(chain: Chain) -> Figure:
    return draw_arm(chain)


@cache
def sampled(identity: str) -> Chain:
    return sample_chain(ProblemId.parse(identity))


@cache
def panel(chain: Chain) -> PanelSet:
    return draw_singular_panels(chain)


def svg_text(chain: Chain) -> list[str]:
    return [text.text or "" for text in ET.fromstring(draw_singular_svg(chain)).iter(f"{SVG}text")]


every_arm = pytest.mark.parametrize("chain", ARMS.values(), ids=ARMS)
every_family = pytest.mark.parametrize(
    "identity", [pytest.param(one, marks=pytest.mark.xdist_group(one.split("/")[0])) for one in SAMPLED]
)
of_all = pytest.mark.xdist_group("figures")  # each is drawn once


def words(figure: Figure) -> list[str]:
    return ["".join(run.text for run in text.runs) for text in figure.texts]


def strokes(figure: Figure, *styles: str) -> list[tuple[Vector2D, ...]]:
    return [shape.points for shape in figure.shapes if isinstance(shape, Polyline) and shape.style in styles]


def glyphs(figure: Figure) -> list[Glyph]:
    return sorted((shape for shape in figure.shapes if isinstance(shape, Glyph)), key=lambda glyph: glyph.number)


def ink(figure: Figure) -> list[tuple[str, tuple[Vector2D, ...]]]:
    inner = [one for shape in figure.shapes for one in (shape.shapes if isinstance(shape, Glyph) else (shape,))]
    return [(one.style, one.points if isinstance(one, Polyline) else (one.center,)) for one in inner]


def is_inside(figure: Figure, *more: Vector2D) -> bool:
    """Return whether all lines of a figure, and more points, are on its paper."""
    points = [point for _, stroke in ink(figure) for point in stroke]
    return all(0 <= x <= figure.width and 0 <= y <= figure.height for x, y in (*points, *more))


def overlap(a: Box, b: Box) -> bool:
    return not (a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1])


@every_arm
def test_svg_is_well_formed_self_contained_and_has_a_text_alternative(chain: Chain) -> None:
    svg, small = draw_figure_svg(chain, name="problem-7"), draw_thumbnail_svg(chain, "small")
    root = ET.fromstring(svg)
    assert root.tag == f"{SVG}svg" and root.get("role") == "img"
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert root.get("aria-labelledby", "").split() == ids == ["problem-7-title", "problem-7-desc"]
    assert not re.search(r"<style|<script|href|url\(", svg)
    assert "nan" not in svg.lower() and "inf" not in svg.lower() and not re.search(r"-0\.0(?!\d)", svg)
    points = re.findall(r' points="([^"]*)"', svg)
    assert all(re.fullmatch(r"-?\d+\.\d", number) for text in points for number in re.split(r"[ ,]", text))
    thumbnail = ET.fromstring(small)
    assert (thumbnail.get("width"), thumbnail.get("height")) == ("192", "144") and "<text" not in small
    assert root.findtext(f"{SVG}desc") == thumbnail.findtext(f"{SVG}desc") == describe_figure(chain)
    assert svg.count("data-joint=") == small.count("data-joint=") == chain.n


HOME = {"theta1": 0.0, "theta2": 0.0, "d3": 0.0}


def by_axes(*joints: Joint, base: Base | None = None) -> Chain:
    return Chain("axes", joints, ("vx", "vy", "vz"), base or Base(), convention="screws")


BY_AXES = [
    by_axes(turning(1, 0, -PI / 2, D1), turning(2, A2), sliding(3, theta=PI / 2)),
    by_axes(turning(1, 0, -PI / 2, D1), turning(2, A2), sliding(3, offset=Q(1, 5)), base=Base((0, 0, Q(1, 2)))),
]


@pytest.mark.parametrize("chain", BY_AXES, ids=["world", "moved"])
def test_the_body_frame_stands_in_the_point_at_home_and_nowhere_else(chain: Chain) -> None:
    home = words(draw_arm(chain, HOME))
    assert {"P, {b}", "xb", "yb", "zb", "xs", "ys", "zs"} <= {*home}
    assert "".join(ET.fromstring(draw_figure_svg(chain)).itertext()).count("{b}") == 1
    assert "body frame b" in describe_figure(chain)
    inner = replace(chain, tool=Point(2))
    for figure in (draw_arm(chain, {**HOME, "theta2": 0.3}), draw_arm(inner, HOME)):
        assert "P" in words(figure) and not {"xb", "yb", "zb", "P, {b}"} & {*words(figure)}
    assert "body frame" not in describe_figure(inner)


def test_the_axes_of_the_body_frame_are_parallel_to_those_of_the_space_frame_and_start_in_the_point() -> None:
    figure = draw_arm(BY_AXES[1], HOME)
    ways = [points for points in strokes(figure, "axis-w") if len(points) == 2]
    (p,) = [shape.center for shape in figure.shapes if isinstance(shape, Circle) and shape.style == "point"]
    starts = Counter(tuple(np.round(start, 6)) for start, _ in ways)
    assert starts[tuple(np.round(p, 6))] == 3 and sorted(starts.values()) == [3, 3]
    angles = sorted(round(float(np.arctan2(*np.subtract(end, start))), 4) for start, end in ways)
    assert angles[::2] == angles[1::2] and len(set(angles)) == 3


def test_where_the_point_is_in_the_origin_the_axes_have_the_names_of_both_frames() -> None:
    wrist = by_axes(turning(1, 0, -PI / 2), turning(2, 0, PI / 2), turning(3))
    figure = draw_arm(wrist, dict.fromkeys(("theta1", "theta2", "theta3"), 0.0))
    assert {"xs, xb", "ys, yb", "zs, zb", "P, {b}"} <= {*words(figure)}


WRISTS = ("wrist-zyz/1@chapter", "wrist-zyz/2@full", "wrist-rpy/2@chapter", "wrist-rpy/1@full")


@pytest.mark.parametrize("identity", WRISTS)
def test_a_wrist_has_all_frames_on_its_joints_axes_named(identity: str) -> None:
    shown = {name for word in words(drawn(sampled(f"{identity}@modified-dh"))) for name in word.split(", ")}
    assert {f"{axis}{i}" for axis in "xz" for i in range(4)} <= shown


def glyph_places(figure: Figure) -> list[Vector2D]:
    """The middles of the joints' glyphs, in the order of the joints."""
    places = []
    for glyph in glyphs(figure):
        inner = [one.points if isinstance(one, Polyline) else (one.center,) for one in glyph.shapes]
        x, y = np.mean([point for points in inner for point in points], axis=0)
        places.append((float(x), float(y)))
    return places


@every_arm
def test_labels_and_joints_keep_apart_inside_of_the_figure_and_are_all_there(chain: Chain) -> None:
    figure = drawn(chain)
    joints = [(i, joint.kind) for i, joint in enumerate(chain.joints, 1)]
    assert [(glyph.number, glyph.kind) for glyph in glyphs(figure)] == joints
    for (x, y), (u, v) in combinations(glyph_places(figure), 2):
        assert (x - u) ** 2 + (y - v) ** 2 > 16**2
    boxes = [text.box for text in figure.texts]
    assert not any(overlap(a, b) for a, b in combinations(boxes, 2))
    assert is_inside(figure, *(corner for box in boxes for corner in (box[:2], box[2:])))
    for name in ("P", *(variable.name.replace("theta", "θ") for variable in chain.q)):
        assert any(word.startswith(name) for word in words(figure)), name


@pytest.mark.parametrize(
    ("arm", "there", "not_there"),
    [
        ("3r", {"θ2 + 30°", "θ1"}, ()),  # an offset is part of the drawn angle
        ("rp", {"z0", "z1", "z2"}, ()),  # all z axes, where one lies in the plane
        ("2r", (), {"z0", "z1", "z2"}),
        ("wrist", {"x0", "x3", "z0", "z1"}, {"x1", "x2"}),
    ],
)
def test_axes_are_named_where_they_tell_something(arm: str, there: set[str], not_there: set[str]) -> None:
    names = {name for word in words(drawn(ARMS[arm])) for name in re.split(r", | = ", word)}
    assert names >= set(there) and not names & set(not_there)


@few_families
def test_no_name_lies_on_another_and_no_link_across_one_at_any_step(family: str) -> None:
    """A link crosses another one only where it does so in every pose that is looked at."""
    for step in VARIATION_STEPS if family not in LONG_ARMS else select_for_suite(("full",), tuple(VARIATION_STEPS)):
        chain = make_numbers_exact(sample_chain(ProblemId(family, 1, variation=step)))
        figure, arm = drawn(chain), make_drawable_chain(chain)
        assert not find_faults(figure), (step, find_faults(figure))
        tried = find_best_poses(chain, arm, TRIED_POSE_COUNT[chain.n > LONG_ARM_JOINTS])
        crossed = [count_link_crossings(chain, arm, entries) for entries in tried]
        assert not any(crossed) or min(
            count_link_crossings(chain, arm, entries) for entries in list_candidate_poses(chain, arm)
        ), step


def test_a_given_pose_is_drawn_from_the_clearest_side(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[tuple[float, object]] = []

    def noted(*arguments: Any) -> tuple[Any, float]:
        composed, cost = compose(*arguments)
        drawn.append((round(cost, 1), composed))
        return composed, cost

    compose = drawing._draw_and_label
    monkeypatch.setattr(drawing, "_draw_and_label", noted)
    later = 0
    for seed in range(6):
        chain = sampled(f"elbow-3r/{seed}")
        taken = drawing._draw_in_given_pose(chain, np.array([0.3 + seed, 1.1, -0.7]))
        best = min(drawn, key=lambda one: one[0])
        assert taken is best[1]
        later += best is not drawn[0]
        drawn.clear()
    assert later, "the first side was always the clearest"


def test_alt_text_says_what_is_drawn() -> None:
    text = describe_figure(ARMS["2r-l"])
    for piece in ("two joints", "seen from +z_w", "θ1 about z0", "a1 along x1", "θ2 about z1", "(0, h, 0) in frame 2"):
        assert piece in text
    assert "mounted on the wall" in describe_figure(ARMS["elbow-wall"])
    assert "rotates by θ1 minus 90 degrees" in describe_figure(flat(turning(1, A1, offset=-PI / 2)))


@pytest.mark.parametrize(("turned", "count"), [(PI / 2, 1), (0, 0)])
def test_alt_text_tells_the_angle_in_the_row_of_a_slide(turned: sp.Expr, count: int) -> None:
    text = describe_figure(flat(turning(1, 1), sliding(2, A2, theta=turned)))
    assert "Joint 2 is prismatic" in text and "x1 is rotated" not in text
    assert text.count("x2 is rotated by 90") == text.count("x2 is rotated") == count


def test_arms_that_stay_in_a_plane_are_drawn_flat() -> None:
    for name, seen in (("rpr", "x_w and y_w, seen from +z_w"), ("prr-upright", "x_w and z_w, seen from -y_w")):
        assert f"drawn flat in the plane of {seen}" in describe_figure(ARMS[name])
        assert all(isinstance(glyph.shapes[0], Circle) for glyph in glyphs(drawn(ARMS[name])) if glyph.kind == "R")
    assert "drawn in space" in describe_figure(ARMS["spherical"])


@pytest.mark.parametrize("name", ("2r", "2r-l", "3r", "rp", "elbow-floor", "elbow-wall", "spherical", "rpr"))
def test_singular_configurations_are_drawn_inside_their_panels(name: str) -> None:
    figures = panel(ARMS[name]).drawings
    captions = [caption for caption, _ in figures]
    assert captions[0] == "regular" and all(caption[0].isdigit() for caption in captions[1:])
    assert all((figure.width, figure.height) == PANEL_SIZE and is_inside(figure) for _, figure in figures)
    root = ET.fromstring(draw_singular_svg(ARMS[name], "where"))
    assert [text.text for text in root.iter(f"{SVG}text")][: len(captions)] == captions
    assert all(caption in root.findtext(f"{SVG}desc", "") for caption in captions[1:])
    marked = any(strokes(figure, "lost") for _, figure in figures)
    assert ("Dashed: P cannot move that way" in panel(ARMS[name]).legend) == marked


def sizes(svg: str) -> tuple[str | None, set[str | None]]:
    """The width of a drawing, and the sizes of its lettering but for subscripts."""
    root = ET.fromstring(svg)
    texts = [(text, next(iter(text), text)) for text in root.iter(f"{SVG}text")]
    return root.get("width"), {text.get("font-size") or first.get("font-size") for text, first in texts}


@every_family
def test_lettering_has_one_size_in_all_drawings_of_one_width(identity: str) -> None:
    """Notebooks and platforms show all drawings equally wide: then all names and captions are equally large."""
    chain = sampled(identity)
    drawings = [draw_figure_svg(chain), draw_singular_svg(chain)]
    if not chain.parameters:
        drawings.append(draw_options_svg(chain, [{q.name: 0.1 * k for q in chain.q} for k in range(4)]))
    assert {(width, *found) for width, found in map(sizes, filter(None, drawings))} == {("520", "15.0")}


@every_family
def test_captions_stand_apart_inside_their_drawing_and_tell_degrees_and_metres(identity: str) -> None:
    root = ET.fromstring(draw_singular_svg(sampled(identity)) or "<svg/>")
    boxes = []
    for text in root.iter(f"{SVG}text"):
        wide, high = measure_width(write_upright(text.text or "")), LETTERING_HEIGHT
        x, y = float(text.get("x", 0)), float(text.get("y", 0))
        boxes.append((x - wide / 2, y - 0.8 * high, x + wide / 2, y + 0.2 * high))
    width, height = float(root.get("width", 0)), float(root.get("height", 0))
    assert all(box[0] >= 0 and box[1] >= 0 and box[2] <= width and box[3] <= height for box in boxes)
    assert not any(overlap(a, b) for a, b in combinations(boxes, 2))
    for caption, _ in panel(sampled(identity)).drawings[1:]:
        assert "π" not in caption
        for name, value in re.findall(r"([θd])[₀-₉]+ = (−?[\d.]+°?(?: m)?)$", caption):
            assert value.endswith("°" if name == "θ" else " m")


def test_stretched_and_folded_arm_cannot_move_along_itself() -> None:
    (_, regular), *singular = panel(ARMS["2r"]).drawings
    assert [caption for caption, _ in singular] == ["1a. θ₂ = 0°", "1b. θ₂ = 180°"] and not strokes(regular, "lost")
    for _, figure in singular:
        (((x, y), (u, v)),) = strokes(figure, "lost")
        for link in strokes(figure, "link"):
            assert all(abs((px - x) * (v - y) - (py - y) * (u - x)) < 1e-6 for px, py in link)


def test_shoulder_singularity_is_drawn_with_the_point_on_the_axis() -> None:
    captions = dict(panel(elbow()).drawings)
    figure = next(figure for caption, figure in captions.items() if caption.startswith("2."))
    point = next(shape for shape in figure.shapes if isinstance(shape, Circle) and shape.style == "point")
    assert point.center[0] == pytest.approx(glyph_places(figure)[0][0], abs=0.01)  # the axis is upright


def test_nothing_is_drawn_where_there_is_no_singular_configuration() -> None:
    assert draw_singular_svg(ARMS["gantry"]) == "" and panel(ARMS["gantry"]) == PanelSet()


def test_a_wrist_folded_onto_itself_looks_folded() -> None:
    chain = ARMS["wrist"].with_task("wx", "wy", "wz")
    figures = dict(panel(chain).drawings)
    stretched, folded = (glyph_places(figures[caption]) for caption in ("1a. θ₂ = 0°", "1b. θ₂ = 180°"))
    assert stretched[2][1] < stretched[1][1] and folded[2][1] > folded[1][1]


def test_singular_configurations_are_the_arms_own() -> None:
    """The bent tool moves the singular angles: the caption tells the numbers at which the Jacobian loses rank."""
    chain = flat(turning(1, Q(1, 2)), turning(2, Q(3, 10)), tool=Point(2, (sp.S.Zero, Q(1, 5), sp.S.Zero)))
    shown = [caption.split("= ")[1].replace("−", "-") for caption, _ in panel(chain).drawings[1:]]
    angles = [np.radians(float(angle.removesuffix("°"))) for angle in shown]
    for angle in angles:
        assert abs(np.linalg.det(NumericChain(chain, {}).compute_jacobian(np.array([0.4, angle]))[:2])) < 1e-3
    assert len(angles) == 2 and abs(angles[0] - angles[1]) == pytest.approx(3.1416, abs=0.002)


@every_family
def test_every_condition_has_a_drawing_and_what_is_left_out_is_counted(identity: str) -> None:
    chain = sampled(identity)
    shown_panel = panel(chain)
    numbers = [caption.split(".")[0] for caption, _ in shown_panel.drawings[1:]]
    shown = [int(number.rstrip("abcdefgh")) for number in numbers]
    components = find_singular_set(chain) or ()
    assert len(set(numbers)) == len(numbers) and shown == sorted(shown)
    assert set(shown) == set(range(1, len(components) + 1))
    known = sum(int(np.prod([len(values) for _, values in component.solutions or ()])) for component in components)
    assert f"not drawn: {known - len(shown)}." in shown_panel.remark or known == len(shown)


def test_what_is_left_out_is_told_below_the_drawings() -> None:
    """The 7R arm has more singular configurations than there is room for."""
    chain = sampled("lbr-7r/1")
    remark, root = panel(chain).remark, ET.fromstring(draw_singular_svg(chain))
    assert "Singular configurations that are not drawn" in remark
    assert remark in " ".join(svg_text(chain)) and remark in root.findtext(f"{SVG}desc", "")


def test_words_of_small_drawings_are_those_of_the_language() -> None:
    told = " ".join(ET.fromstring(draw_singular_svg(sampled("planar-2r/6@full"), language="de")).itertext())
    assert "regulär" in told and "−63,43°" in told and "Gestrichelt:" in told
    assert not re.search("regular |ashed|Drawn|configuration|arm with|−63[.]43", told)


@every_family
def test_rods_end_in_their_sleeves_and_origins_of_different_frames_apart(identity: str) -> None:
    """An end that looks out of the sleeve by a pixel or two is read as a mark of some kind.

    Lengths are not to scale: no two frames may look like one because two of them are drawn equal.
    """
    figure = drawn(sampled(identity))
    sleeves = [glyph.shapes for glyph in glyphs(figure) if glyph.kind == "P"]
    boxes = [np.array([p for face in faces if isinstance(face, Polyline) for p in face.points]) for faces in sleeves]
    for end, *_ in strokes(figure, "rod"):
        assert any((box.min(axis=0) <= end).all() and (end <= box.max(axis=0)).all() for box in boxes)
    starts = [start for start, *_ in strokes(figure, "axis-x", "axis-y", "axis-z", "axis-w")]
    gaps = [float(np.hypot(*np.subtract(first, second))) for first, second in combinations(starts, 2)]
    assert not [each for each in gaps if 0.5 < each <= 24]


@every_family
def test_configurations_of_a_panel_look_different(identity: str) -> None:
    """Give or take 6 pixels of the 280 of its width, and but for the ground."""
    ground = ("plate", "hatch", "ground", "pedestal")
    figures = [figure for _, figure in panel(sampled(identity)).drawings]
    for first, second in combinations([[one for one in ink(each) if one[0] not in ground] for each in figures], 2):
        are_alike = [(a[0], len(a[1])) for a in first] == [(b[0], len(b[1])) for b in second]
        pairs = zip(first, second, strict=False)
        assert not are_alike or max(np.abs(np.subtract(a[1], b[1])).max() for a, b in pairs) >= 6


@pytest.mark.parametrize("identity", ["ur-6r/2", "lbr-7r/7"])
def test_a_hand_that_only_turns_has_an_arrow(identity: str) -> None:
    """The 6R arm's wrist turns about one point, which is P: only z6 tells that it does."""
    chain = sampled(identity)
    assert all(len(strokes(figure, "axis-z")) == 1 for _, figure in panel(chain).drawings)
    assert f"blue: z{'₆₇'[chain.n - 6]}." in panel(chain).legend
    assert panel(chain).legend in " ".join(svg_text(chain))


def tips(figure: Figure) -> dict[Vector2D, str]:
    """Return the ends of the arrows of axes, each with its axis."""
    return {points[0]: axis for axis in "xyzw" for points in strokes(figure, f"axis-{axis}-head")}


def gap(text: Text, point: Vector2D) -> float:
    """Return the distance in pixels of a label from a point."""
    (x, y), (left, top, right, bottom) = point, text.box
    return float(np.hypot(max(left - x, x - right, 0.0), max(top - y, y - bottom, 0.0)))


def has_leader(figure: Figure, text: Text) -> bool:
    lines = strokes(figure, "leader")
    return any(gap(text, start) < 0.01 and np.hypot(*np.subtract(end, text.named_point)) < 3 for start, end in lines)


@of_all
def test_a_label_is_near_to_what_it_names_or_has_a_leader() -> None:
    """An axis's label is nearest to its own arrow. Leaders are a way out: most labels stand where they belong."""
    leaders = texts = 0
    for figure in [drawn(chain) for chain in (*ARMS.values(), *map(sampled, SAMPLED))]:
        ends = tips(figure)
        leaders += len(strokes(figure, "leader"))
        texts += len(figure.texts)
        for text in figure.texts:
            most = 16.0 if text.style == "angle" or text.named_point in ends else 24.0
            if text.style in "xyzw" and text.named_point in ends:  # an axis seen end-on has no arrow
                assert ends[text.named_point] == text.style
                most = min([most, *(gap(text, end) for end in ends if end != text.named_point)])
            assert gap(text, text.named_point) <= most or has_leader(figure, text)
    assert 0 < leaders < 0.08 * texts


@pytest.mark.parametrize("place", [(0, 0, 0), (Q(3, 10), Q(1, 5), 0)])
def test_the_origin_of_the_world_is_named_where_it_is_not_that_of_the_base(place: tuple[sp.Expr, ...]) -> None:
    figure = draw_arm(flat(turning(1, A1), turning(2, A2), base=Base(place, PI / 6)))
    assert ("Ow" in words(figure)) == any(place)


APART = 8.0
"""Pixels between origins that differ, of an arm with six or seven joints, whose hand may come back to its elbow."""


@on_families(select_for_suite(("elbow-3r", "stanford-6r"), tuple(FAMILIES)))
def test_a_given_pose_can_be_read_and_names_all_joints_axes_and_the_point(family: str) -> None:
    problem = problems.get_problem(family, 0)
    chain = problem.chain
    for part in problem.parts:
        if part.details.pose is None:
            continue
        figure = draw_arm(chain, part.details.pose)
        assert not find_faults(figure), part.kind
        names = {name for word in words(figure) for name in word.replace(" = ", ", ").split(", ")}
        assert {"P", *(f"O{i}" for i in range(chain.n + 1))} <= names
        assert is_drawn_flat(chain) or {"x0", f"x{chain.n}", *(f"z{i}" for i in range(chain.n + 1))} <= names
        if family in LONG_ARMS:
            spots = [text.named_point for text, word in zip(figure.texts, words(figure), strict=True) if "O" in word]
            assert min(float(np.hypot(*np.subtract(a, b))) for a, b in combinations(spots, 2)) >= APART


PAGES = ("site/src/site.css", "templates/reports/feedback.css.j2", "templates/exports/paper.css.j2")
"""Style sheets of pages that are dark by themselves and show figures."""
FILTER = re.compile(r"invert\(([\d.]+)\) hue-rotate\(180deg\)")
HALF_TURN = np.array([[-0.574, 1.43, 0.144], [0.426, 0.43, 0.144], [0.426, 1.43, -0.856]])
"""The matrix by which hue-rotate(180deg) multiplies red, green and blue (Filter Effects, section 9.8)."""
LETTERS, LINES = 4.5, 3.0
"""Contrast that WCAG asks for, of letters and of what else has to be told apart."""
FILLING = ("link-inside", "rod-inside", "rod", "link", "joint-face", "joint-side", "plate", "pedestal", "hatch")
"""Bodies and the ground, which have outlines or are told by their shape."""


def drawings() -> Iterator[str]:
    arm = sample_chain(ProblemId.parse("elbow-3r/1@chapter"))
    numbers = sample_chain(ProblemId.parse("planar-2r/1@full"))
    yield from (draw_figure_svg(arm), draw_singular_svg(arm), draw_thumbnail_svg(arm), draw_figure_svg(numbers))
    yield draw_options_svg(arm, [{q.name: 0.3 * k for q in arm.q} for k in range(4)])


def colour(code: str) -> np.ndarray:
    return np.array([int(code[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def turned_round(rgb: np.ndarray, amount: float) -> np.ndarray:
    inverted = np.clip(amount + rgb * (1 - 2 * amount), 0, 1)
    return np.clip(HALF_TURN @ inverted, 0, 1)


def luminance(rgb: np.ndarray) -> float:
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return float(linear @ (0.2126, 0.7152, 0.0722))


def contrast(first: np.ndarray, second: np.ndarray) -> float:
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


def inks() -> dict[str, tuple[str, float]]:
    """The colours of lines and lettering by class, and the contrast that each needs."""
    shapes = (ROOT / "templates/figure/shapes.svg.j2").read_text()
    lines = re.findall(r'"([\w-]+)": .*?(?:fill|stroke)="(#\w{6})"', shapes)
    letters = re.findall(r'"(\w+)": "(#\w{6})"', shapes)
    wanted = {name: (code, LINES) for name, code in lines if name not in FILLING}
    return wanted | {f"letters of {name}": (code, LETTERS) for name, code in letters}


def test_every_drawing_lies_on_a_light_card_of_its_own() -> None:
    """JupyterLab and others are dark whatever the reader's system is: a picture there can't know, so it needs none."""
    for svg in drawings():
        root = ET.fromstring(svg)
        card = next(one for one in root if one.tag not in (f"{SVG}title", f"{SVG}desc"))
        assert card.tag == f"{SVG}rect" and card.get("fill") == "#ffffff"
        left, top, wide, high = map(float, (root.get("viewBox") or "").split())
        assert (left, top) == (0, 0)
        assert (float(card.get("width", 0)), float(card.get("height", 0))) == (wide - 1, high - 1)


@pytest.mark.parametrize("page", PAGES)
def test_what_is_drawn_is_readable_on_its_card_and_turned_round(page: str) -> None:
    amounts = {float(amount) for amount in FILTER.findall((ROOT / page).read_text())}
    assert len(amounts) == 1, "a dark page turns the lightness of drawings round"
    (amount,) = amounts
    white = np.ones(3)
    found = inks()
    assert {"axis-x", "arc", "lost", "letters of angle", "letters of z"} <= set(found)
    for name, (code, least) in found.items():
        assert contrast(colour(code), white) >= least, name
        assert contrast(turned_round(colour(code), amount), turned_round(white, amount)) >= least, name
