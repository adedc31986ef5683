"""The figure of an arm: what must hold for the drawing of any chain."""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from functools import cache
from itertools import combinations

import numpy as np
import pytest
import sympy as sp

from exercises.arm.chain import Base, Chain, Joint, Point
from exercises.arm.kinematics import NumericChain
from exercises.arm.singularity import singular_set
from exercises.families import FAMILIES
from exercises.figure import (
    TRIED,
    alt_text,
    arm_figure,
    figure_svg,
    fixed,
    options_svg,
    singular_panel,
    singular_svg,
    thumbnail_svg,
)
from exercises.figure.plane import exact
from exercises.figure.pose import LONG, best_poses, candidates, drawn_chain
from exercises.figure.shapes import FONT, Circle, Figure, Glyph, Pair, Polyline, Text, extent, roman
from exercises.figure.small import PANEL, Panel
from exercises.generation import sample_chain
from exercises.problem import ProblemId
from exercises.variation import STEPS
from tests.support.figures import crossings, faults
from tests.support.suites import families_for

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
SAMPLED = (*(f"{name}/1" for name in families_for()), *REPORTED)


@cache
def drawn(chain: Chain) -> Figure:
    return arm_figure(chain)


@cache
def sampled(identity: str) -> Chain:
    return sample_chain(ProblemId.parse(identity))


@cache
def panel(chain: Chain) -> Panel:
    return singular_panel(chain)


def svg_text(chain: Chain) -> list[str]:
    return [text.text or "" for text in ET.fromstring(singular_svg(chain)).iter(f"{SVG}text")]


every_arm = pytest.mark.parametrize("chain", ARMS.values(), ids=ARMS)
every_family = pytest.mark.parametrize(
    "identity", [pytest.param(one, marks=pytest.mark.xdist_group(one.split("/")[0])) for one in SAMPLED]
)
of_all = pytest.mark.xdist_group("figures")  # each is drawn once


@every_arm
def test_svg_is_well_formed_and_has_a_text_alternative(chain: Chain) -> None:
    root = ET.fromstring(figure_svg(chain, name="problem-7"))
    assert root.tag == f"{SVG}svg" and root.get("role") == "img"
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    assert root.get("aria-labelledby", "").split() == ids == ["problem-7-title", "problem-7-desc"]
    assert root.findtext(f"{SVG}desc") == alt_text(chain)


@every_arm
def test_svg_is_self_contained_and_has_clean_numbers(chain: Chain) -> None:
    svg = figure_svg(chain)
    assert not re.search(r"<style|<script|href|url\(", svg)
    assert "nan" not in svg.lower() and "inf" not in svg.lower() and not re.search(r"-0\.0(?!\d)", svg)
    assert all(re.fullmatch(r"-?\d+\.\d", pair) for points in re.findall(r' points="([^"]*)"', svg)
               for pair in re.split(r"[ ,]", points))  # fmt: skip


HOME = {"theta1": 0.0, "theta2": 0.0, "d3": 0.0}
BY_AXES = [
    (Base(), turning(1, 0, -PI / 2, D1), turning(2, A2), sliding(3, theta=PI / 2)),
    (Base((0, 0, Q(1, 2))), turning(1, 0, -PI / 2, D1), turning(2, A2), sliding(3, offset=Q(1, 5))),
]


def names(figure: Figure) -> list[str]:
    return ["".join(run.text for run in text.runs) for text in figure.texts]


def by_axes(base: Base, *joints: Joint, tool: Point | None = None) -> Chain:
    return Chain("axes", joints, ("vx", "vy", "vz"), base, tool, convention="screws")


@pytest.mark.parametrize("told", BY_AXES, ids=["world", "moved"])
def test_the_body_frame_stands_in_the_point_at_home_and_nowhere_else(told: tuple[Base, Joint, Joint, Joint]) -> None:
    chain = by_axes(*told)
    home = names(arm_figure(chain, HOME))
    assert {"P, {b}", "xb", "yb", "zb", "xs", "ys", "zs"} <= {*home}
    assert "".join(text for text in ET.fromstring(figure_svg(chain)).itertext()).count("{b}") == 1
    assert "body frame b" in alt_text(chain)
    inner = by_axes(*told, tool=Point(2))
    for figure in (arm_figure(chain, {**HOME, "theta2": 0.3}), arm_figure(inner, HOME)):
        assert "P" in names(figure) and not {"xb", "yb", "zb", "P, {b}"} & {*names(figure)}
    assert "body frame" not in alt_text(inner)


def test_the_axes_of_the_body_frame_are_parallel_to_those_of_the_space_frame_and_start_in_the_point() -> None:
    figure = arm_figure(by_axes(*BY_AXES[1]), HOME)
    ways = [line.points for line in figure.shapes if isinstance(line, Polyline) and line.style == "axis-w"]
    (p,) = [shape.center for shape in figure.shapes if isinstance(shape, Circle) and shape.style == "point"]
    starts = Counter(tuple(np.round(line[0], 6)) for line in ways if len(line) == 2)
    assert starts[tuple(np.round(p, 6))] == 3 and sorted(starts.values()) == [3, 3]
    turned = [np.subtract(line[-1], line[0]) for line in ways if len(line) == 2]
    angles = sorted(round(float(np.arctan2(*way)), 4) for way in turned)
    assert angles[::2] == angles[1::2] and len(set(angles)) == 3


def test_the_names_of_joint_axes_are_as_large_as_other_names() -> None:
    """The letter is low, and in the fonts of PDFs smaller than others of a size."""
    texts = [text for text in arm_figure(by_axes(*BY_AXES[0]), HOME).texts if text.runs[0].text == "ω"]
    assert len(texts) == 2
    for text in texts:
        assert text.runs[0].size > 1.2 * FONT and text.runs[1].size < FONT
        wide, _ = extent(tuple((run.text, run.italic, run.size < FONT) for run in text.runs))
        assert text.box[2] - text.box[0] == pytest.approx(wide) and wide > text.runs[0].size * 0.9


def test_where_the_point_is_in_the_origin_the_axes_have_the_names_of_both_frames() -> None:
    figure = arm_figure(
        by_axes(Base(), turning(1, 0, -PI / 2), turning(2, 0, PI / 2), turning(3)),
        dict.fromkeys(("theta1", "theta2", "theta3"), 0.0),
    )
    assert {"xs, xb", "ys, yb", "zs, zb", "P, {b}"} <= {*names(figure)}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("variation", ["chapter", "full"])
@pytest.mark.parametrize("family", ["wrist-zyz", "wrist-rpy"])
def test_a_wrist_has_all_frames_on_its_joints_axes_named(family: str, variation: str, seed: int) -> None:
    shown = {
        name for told in names(drawn(sampled(f"{family}/{seed}@{variation}@modified-dh"))) for name in told.split(", ")
    }
    assert {f"{axis}{i}" for axis in "xz" for i in range(4)} <= shown


@every_arm
def test_same_arm_same_figure(chain: Chain) -> None:
    assert arm_figure(chain) == drawn(chain)


@every_arm
def test_one_glyph_for_each_joint(chain: Chain) -> None:
    glyphs = [shape for shape in drawn(chain).shapes if isinstance(shape, Glyph)]
    assert sorted((glyph.number, glyph.kind) for glyph in glyphs) == [
        (i, joint.kind) for i, joint in enumerate(chain.joints, 1)
    ]
    assert figure_svg(chain).count("data-joint=") == chain.n


@every_arm
def test_labels_keep_apart(chain: Chain) -> None:
    boxes = [text.box for text in drawn(chain).texts]
    for a, b in combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


@every_arm
def test_everything_is_inside(chain: Chain) -> None:
    figure = drawn(chain)
    shapes = [inner for shape in figure.shapes for inner in (shape.shapes if isinstance(shape, Glyph) else (shape,))]
    points = [p for shape in shapes if isinstance(shape, Polyline) for p in shape.points]
    points += [corner for text in figure.texts for corner in (text.box[:2], text.box[2:])]
    assert all(0 <= x <= figure.width and 0 <= y <= figure.height for x, y in points)


@every_arm
def test_all_variables_and_the_point_are_named(chain: Chain) -> None:
    words = ["".join(run.text for run in text.runs) for text in drawn(chain).texts]
    for variable in chain.q:
        name = variable.name.replace("theta", "θ")
        assert any(word.startswith(name) for word in words), name
    assert any(word.startswith("P") for word in words)


@pytest.mark.families(tuple(FAMILIES))
def test_no_name_lies_on_another_and_no_link_across_one_at_any_step(family: str) -> None:
    """A link crosses another one only where it does so in every pose that is looked at."""
    for step in STEPS:
        chain = exact(sample_chain(ProblemId(family, 1, variation=step)))
        figure, arm = drawn(chain), drawn_chain(chain)
        assert not faults(figure), (step, faults(figure))
        tried = best_poses(chain, arm, TRIED[chain.n > LONG])
        crossed = [crossings(chain, arm, entries) for entries in tried]
        assert not any(crossed) or min(crossings(chain, arm, entries) for entries in candidates(chain, arm)), step


def test_offset_is_part_of_the_drawn_angle() -> None:
    words = ["".join(run.text for run in text.runs) for text in drawn(ARMS["3r"]).texts]
    assert "θ2 + 30°" in words and "θ1" in words


def test_all_z_axes_are_named_where_one_lies_in_the_plane() -> None:
    words = ["".join(run.text for run in text.runs) for text in drawn(ARMS["rp"]).texts]
    assert all(any(f"z{i}" in word for word in words) for i in range(3))
    assert not any("z" in run.text for text in drawn(ARMS["2r"]).texts for run in text.runs)


def test_told_pose_is_drawn() -> None:
    stretched = arm_figure(ARMS["2r"], {"theta1": 0.0, "theta2": 0.0})
    links = [shape for shape in stretched.shapes if isinstance(shape, Polyline) and shape.style == "link"]
    assert len({round(y, 6) for link in links for _, y in link.points}) == 1


def test_alt_text_says_what_is_drawn() -> None:
    assert alt_text(ARMS["2r-l"]) == (
        "A planar arm with two joints in series, drawn flat in the plane of x_w and y_w, seen from +z_w. "
        "The base frame O0 is the world frame. "
        "Joint 1 is revolute: it turns by θ1 about z0; link 1 is a1 along x1. "
        "Joint 2 is revolute: it turns by θ2 about z1; link 2 is a2 along x2. "
        "The point P is at (0, h, 0) in frame 2, the last frame. Lengths are not to scale."
    )
    assert "mounted on the wall" in alt_text(ARMS["elbow-wall"])
    assert "turns by θ1 minus 90 degrees" in alt_text(flat(turning(1, A1, offset=-PI / 2)))


def test_numbers_have_one_decimal_and_no_negative_zero() -> None:
    assert [fixed(value) for value in (-0.04, 0.0, 12.25, -3.21)] == ["0.0", "0.0", "12.3", "-3.2"]


def glyph_places(figure: Figure) -> list[Pair]:
    """The middles of the joints' glyphs, in the order of the joints."""
    places = {}
    for glyph in figure.shapes:
        if isinstance(glyph, Glyph):
            points = [p for inner in glyph.shapes if isinstance(inner, Polyline) for p in inner.points]
            points += [inner.center for inner in glyph.shapes if isinstance(inner, Circle)]
            places[glyph.number] = (sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points))
    return [places[number] for number in sorted(places)]


@every_arm
def test_joints_at_one_point_are_drawn_apart(chain: Chain) -> None:
    for (x, y), (u, v) in combinations(glyph_places(drawn(chain)), 2):
        assert (x - u) ** 2 + (y - v) ** 2 > 16**2


def test_axes_of_a_wrist_are_not_all_drawn() -> None:
    words = ["".join(run.text for run in text.runs) for text in drawn(ARMS["wrist"]).texts]
    assert {"x0", "x3", "z0", "z1"} <= set(words) and not {"x1", "x2"} & set(words)


def test_arms_that_stay_in_a_plane_are_drawn_flat() -> None:
    for name, seen in (("rpr", "x_w and y_w, seen from +z_w"), ("prr-upright", "x_w and z_w, seen from -y_w")):
        assert f"drawn flat in the plane of {seen}" in alt_text(ARMS[name])
        turning_joints = [s for s in drawn(ARMS[name]).shapes if isinstance(s, Glyph) and s.kind == "R"]
        assert all(isinstance(glyph.shapes[0], Circle) for glyph in turning_joints)
    assert "drawn in space" in alt_text(ARMS["spherical"])


@every_arm
def test_thumbnail_is_the_arm_without_lettering(chain: Chain) -> None:
    svg = thumbnail_svg(chain, "small")
    root = ET.fromstring(svg)
    assert (root.get("width"), root.get("height")) == ("192", "144")
    assert svg.count("data-joint=") == chain.n and "<text" not in svg
    assert root.findtext(f"{SVG}desc") == alt_text(chain)


SINGULAR = ("2r", "2r-l", "3r", "rp", "elbow-floor", "elbow-wall", "spherical", "rpr")


@pytest.mark.parametrize("name", SINGULAR)
def test_singular_configurations_are_drawn_inside_their_panels(name: str) -> None:
    figures = panel(ARMS[name]).drawings
    assert figures[0][0] == "regular" and all(caption[0].isdigit() for caption, _ in figures[1:])
    for _, figure in figures:
        shapes = [
            inner for shape in figure.shapes for inner in (shape.shapes if isinstance(shape, Glyph) else (shape,))
        ]
        points = [point for shape in shapes if isinstance(shape, Polyline) for point in shape.points]
        assert (figure.width, figure.height) == PANEL
        assert all(0 <= x <= figure.width and 0 <= y <= figure.height for x, y in points)
    root = ET.fromstring(singular_svg(ARMS[name], "where"))
    captions = [caption for caption, _ in figures]
    assert [text.text for text in root.iter(f"{SVG}text")][: len(captions)] == captions
    assert all(caption in root.findtext(f"{SVG}desc", "") for caption, _ in figures[1:])
    assert singular_svg(ARMS[name], "where") == singular_svg(ARMS[name], "where")


def sizes(svg: str) -> tuple[str | None, set[str | None]]:
    """The width of a drawing, and the sizes of its lettering but for subscripts."""
    root = ET.fromstring(svg)
    texts = [(text, next(iter(text), text)) for text in root.iter(f"{SVG}text")]
    return root.get("width"), {text.get("font-size") or first.get("font-size") for text, first in texts}


@every_family
def test_lettering_has_one_size_in_all_drawings_of_one_width(identity: str) -> None:
    """Notebooks and platforms show all drawings equally wide: then all names and captions are equally large."""
    chain = sampled(identity)
    drawings = [figure_svg(chain), singular_svg(chain)]
    if not chain.parameters:
        drawings.append(options_svg(chain, [{q.name: 0.1 * k for q in chain.q} for k in range(4)]))
    assert {(width, *found) for width, found in map(sizes, filter(None, drawings))} == {("520", "15.0")}


@every_family
def test_captions_stand_apart_and_inside_their_drawing(identity: str) -> None:
    root = ET.fromstring(singular_svg(sampled(identity)) or "<svg/>")
    boxes = []
    for text in root.iter(f"{SVG}text"):
        (wide, high), x, y = extent(roman(text.text or "")), float(text.get("x", 0)), float(text.get("y", 0))
        boxes.append((x - wide / 2, y - 0.8 * high, x + wide / 2, y + 0.2 * high))
    for left, top, right, bottom in boxes:
        assert (
            left >= 0 and top >= 0 and right <= float(root.get("width", 0)) and bottom <= float(root.get("height", 0))
        )
    for a, b in combinations(boxes, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def lost(figure: Figure) -> list[Polyline]:
    return [shape for shape in figure.shapes if isinstance(shape, Polyline) and shape.style == "lost"]


def test_stretched_and_folded_arm_cannot_move_along_itself() -> None:
    (_, regular), *singular = panel(ARMS["2r"]).drawings
    assert [caption for caption, _ in singular] == ["1a. θ₂ = 0°", "1b. θ₂ = 180°"] and not lost(regular)
    for _, figure in singular:
        (arrow,) = lost(figure)
        (x, y), (u, v) = arrow.points
        for link in (shape for shape in figure.shapes if isinstance(shape, Polyline) and shape.style == "link"):
            assert all(abs((px - x) * (v - y) - (py - y) * (u - x)) < 1e-6 for px, py in link.points)


def test_shoulder_singularity_is_drawn_with_the_point_on_the_axis() -> None:
    captions = dict(panel(elbow()).drawings)
    figure = next(figure for caption, figure in captions.items() if caption.startswith("2."))
    point = next(shape for shape in figure.shapes if isinstance(shape, Circle) and shape.style == "point")
    assert point.center[0] == pytest.approx(glyph_places(figure)[0][0], abs=0.01)  # the axis is upright


def test_nothing_is_drawn_where_there_is_no_singular_configuration() -> None:
    assert singular_svg(ARMS["gantry"]) == "" and panel(ARMS["gantry"]) == Panel()


def test_a_wrist_folded_onto_itself_looks_folded() -> None:
    chain = ARMS["wrist"].with_task("wx", "wy", "wz")
    figures = dict(panel(chain).drawings)
    stretched, folded = (glyph_places(figures[caption]) for caption in ("1a. θ₂ = 0°", "1b. θ₂ = 180°"))
    assert stretched[2][1] < stretched[1][1] and folded[2][1] > folded[1][1]


def test_singular_configurations_are_the_arms_own() -> None:
    """The bent tool moves the singular angles: the caption tells the numbers at which the Jacobian loses rank."""
    chain = flat(turning(1, Q(1, 2)), turning(2, Q(3, 10)), tool=Point(2, (sp.S.Zero, Q(1, 5), sp.S.Zero)))
    told = [caption.split("= ")[1].replace("−", "-") for caption, _ in panel(chain).drawings[1:]]
    angles = [np.radians(float(angle.removesuffix("°"))) for angle in told]
    for angle in angles:
        jacobian = NumericChain(chain, {}).jacobian(np.array([0.4, angle]))[:2]
        assert abs(jacobian[0, 0] * jacobian[1, 1] - jacobian[0, 1] * jacobian[1, 0]) < 1e-3
    assert len(angles) == 2 and abs(angles[0] - angles[1]) == pytest.approx(3.1416, abs=0.002)


@every_family
def test_every_condition_has_a_drawing_or_is_named_as_left_out(identity: str) -> None:
    chain = sampled(identity)
    found = panel(chain)
    numbers = [caption.split(".")[0] for caption, _ in found.drawings[1:]]
    shown = [int(number.rstrip("abcdefgh")) for number in numbers]
    assert len(set(numbers)) == len(numbers)
    for number, component in enumerate(singular_set(chain) or (), 1):
        known = np.prod([len(values) for _, values in component.solutions or ()])
        assert number in shown
        assert (
            shown.count(number) == known or f"{known - shown.count(number)} more of condition {number}" in found.remark
        )
    assert shown == sorted(shown) and (found.remark == "" or len(shown) == 8)


def test_what_is_left_out_is_told_below_the_drawings() -> None:
    """The 7R arm has more singular configurations than there is room for."""
    chain = sampled("lbr-7r/1")
    remark = "Not drawn: 2 more of condition 2; 2 more of condition 3; 2 more of condition 4."
    assert panel(chain).remark == remark and remark in " ".join(svg_text(chain))
    assert remark in ET.fromstring(singular_svg(chain)).findtext(f"{SVG}desc", "")


@every_family
def test_captions_tell_angles_in_degrees_and_lengths_in_metres(identity: str) -> None:
    for caption, _ in panel(sampled(identity)).drawings[1:]:
        assert "π" not in caption
        for name, value in re.findall(r"([θd])[₀-₉]+ = (−?[\d.]+°?(?: m)?)$", caption):
            assert value.endswith("°" if name == "θ" else " m")


def test_multiples_of_a_degree_are_exact_in_captions() -> None:
    assert any(caption.endswith(". θ₂ = −45°") for caption, _ in panel(sampled("pan-tilt/0")).drawings)
    assert any(caption.endswith(". θ₂ = −63.43°") for caption, _ in panel(sampled("planar-2r/6@full")).drawings)


def test_words_of_small_drawings_are_those_of_the_language() -> None:
    chain = sampled("planar-2r/6@full")
    told = " ".join(ET.fromstring(singular_svg(chain, language="de")).itertext())
    assert (
        "regulär" in told and "−63,43°" in told and "Gestrichelt: In diese Richtung kann P sich nicht bewegen." in told
    )
    for english in ("regular ", "ashed", "Drawn", "configuration", "arm with", "−63.43"):
        assert english not in told


@every_family
def test_rods_end_in_their_sleeves(identity: str) -> None:
    """An end that looks out of the sleeve by a pixel or two is read as a mark of some kind."""
    figure = drawn(sampled(identity))
    sleeves = [shape.shapes for shape in figure.shapes if isinstance(shape, Glyph) and shape.kind == "P"]
    boxes = [np.array([p for face in faces if isinstance(face, Polyline) for p in face.points]) for faces in sleeves]
    rods = [shape.points for shape in figure.shapes if isinstance(shape, Polyline) and shape.style == "rod"]
    for rod in rods:
        assert any((box.min(axis=0) <= rod[0]).all() and (rod[0] <= box.max(axis=0)).all() for box in boxes)


def ink(figure: Figure) -> list[tuple[str, tuple[Pair, ...]]]:
    """All lines and circles of a drawing but the ground, with the class of each."""
    inner = [one for shape in figure.shapes for one in (shape.shapes if isinstance(shape, Glyph) else (shape,))]
    return [
        (one.style, one.points if isinstance(one, Polyline) else (one.center,))
        for one in inner
        if one.style not in ("plate", "hatch", "ground", "pedestal")
    ]


def look_alike(first: Figure, second: Figure) -> bool:
    """Whether each line of one drawing is in the other, give or take 6 pixels of the 280 of its width."""
    pairs = list(zip(ink(first), ink(second), strict=False))
    return len(ink(first)) == len(ink(second)) and all(
        a[0] == b[0] and len(a[1]) == len(b[1]) and np.abs(np.subtract(a[1], b[1])).max() < 6 for a, b in pairs
    )


@every_family
def test_configurations_of_a_panel_look_different(identity: str) -> None:
    for (_, first), (_, second) in combinations(panel(sampled(identity)).drawings, 2):
        assert not look_alike(first, second)


@pytest.mark.parametrize("identity", ["ur-6r/2", "lbr-7r/7"])
def test_a_hand_that_only_turns_has_an_arrow(identity: str) -> None:
    """The 6R arm's wrist turns about one point, which is P: only z6 tells that it does."""
    chain = sampled(identity)
    arrows = [[one.points for one in figure.shapes if isinstance(one, Polyline) and one.style == "axis-z"]
              for _, figure in panel(chain).drawings]  # fmt: skip
    assert all(len(found) == 1 for found in arrows)
    assert f"blue: z{'₆₇'[chain.n - 6]}." in panel(chain).key
    assert panel(chain).key in " ".join(svg_text(chain))


def test_what_the_marks_mean_is_told_where_they_are_drawn() -> None:
    for name in SINGULAR:
        marked = any(shape.style == "lost" for _, f in panel(ARMS[name]).drawings for shape in f.shapes
                     if not isinstance(shape, Glyph))  # fmt: skip
        assert ("Dashed: P cannot move that way" in panel(ARMS[name]).key) == marked


def tips(figure: Figure) -> dict[Pair, str]:
    """Where the arrows of axes end, each with the axis it is of."""
    heads = [
        shape for shape in figure.shapes if isinstance(shape, Polyline) and re.fullmatch("axis-.-head", shape.style)
    ]
    return {head.points[0]: head.style[5] for head in heads}


def gap(text: Text, point: Pair) -> float:
    """How far a label is from a point, in pixels."""
    (x, y), (left, top, right, bottom) = point, text.box
    return float(np.hypot(max(left - x, x - right, 0.0), max(top - y, y - bottom, 0.0)))


def has_leader(figure: Figure, text: Text) -> bool:
    lines = [one.points for one in figure.shapes if isinstance(one, Polyline) and one.style == "leader"]
    return any(gap(text, start) < 0.01 and np.hypot(*np.subtract(end, text.at)) < 3 for start, end in lines)


def all_drawn() -> list[Figure]:
    return [drawn(chain) for chain in (*ARMS.values(), *map(sampled, SAMPLED))]


@of_all
def test_an_axis_label_is_nearest_to_its_own_arrow_or_has_a_leader() -> None:
    for figure in all_drawn():
        ends = tips(figure)
        for text in figure.texts:
            if text.style not in "xyzw" or text.at not in ends:  # an axis seen end-on has no arrow
                continue
            assert ends[text.at] == text.style
            nearest = min(gap(text, end) for end in ends if end != text.at)
            assert gap(text, text.at) <= nearest or has_leader(figure, text)


@of_all
def test_a_label_far_from_what_it_names_has_a_leader() -> None:
    for figure in all_drawn():
        for text in figure.texts:
            assert gap(text, text.at) <= 24 or has_leader(figure, text)
            on_arrow = text.style == "angle" or text.at in tips(figure)
            assert not on_arrow or gap(text, text.at) <= 16 or has_leader(figure, text)


@of_all
def test_leaders_are_few() -> None:
    """They are a way out: most labels stand where they belong."""
    shapes = [shape for figure in all_drawn() for shape in figure.shapes if isinstance(shape, Polyline)]
    leaders = sum(shape.style == "leader" for shape in shapes)
    assert 0 < leaders < 0.08 * sum(len(figure.texts) for figure in all_drawn())


@every_family
def test_origins_of_different_frames_are_drawn_apart(identity: str) -> None:
    """Lengths are not to scale: no two frames may look like one because two of them are drawn equal."""
    starts: list[Pair] = []
    for shape in drawn(sampled(identity)).shapes:
        if isinstance(shape, Polyline) and shape.style in ("axis-x", "axis-y", "axis-z", "axis-w"):
            start = shape.points[0]
            if all(np.hypot(*np.subtract(start, other)) > 0.5 for other in starts):
                starts.append(start)
    for first, second in combinations(starts, 2):
        assert np.hypot(*np.subtract(first, second)) > 24


@pytest.mark.parametrize("place", [(0, 0, 0), (Q(3, 10), Q(1, 5), 0)])
def test_the_origin_of_the_world_is_named_where_it_is_not_that_of_the_base(place: tuple[sp.Expr, ...]) -> None:
    joints = (Joint("R", sp.Symbol("theta1"), 0, A1, 0), Joint("R", sp.Symbol("theta2"), 0, A2, 0))
    figure = arm_figure(Chain("moved", joints, ("vx", "vy"), base=Base(place, PI / 6)))
    named = {"".join(run.text for run in text.runs) for text in figure.texts}
    assert ("Ow" in named) == any(place)
