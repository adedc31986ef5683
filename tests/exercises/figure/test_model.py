"""Models of arms, drawn once for all that look alike, in a pose of their own, with labels at the cheapest places."""

import math
from itertools import product

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint
from qdot.exercises.figure import arm_figure as figure
from qdot.exercises.figure import small
from qdot.exercises.figure.arm_figure import find_figure_pose
from qdot.exercises.figure.labels import Layout
from qdot.exercises.figure.lettering import measure_width, write_with_index
from qdot.exercises.figure.model import make_model
from qdot.exercises.figure.places import InkPoints, LabelPlaces, LabelRequest, LeaderLine, sample_points
from qdot.exercises.figure.pose import DEFAULT_LENGTH, compute_table_entries, list_candidate_poses
from qdot.exercises.figure.shapes import Box, Circle, Figure, Glyph, Polyline, Shape
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from tests.support.figures import draw_arm

Q1, Q2, Q3 = sp.symbols("theta1 theta2 theta3")


def planar(*rows: tuple[sp.Expr, object], base: Base = Base()) -> Chain:  # noqa: B008 - frozen
    return Chain("arm", tuple(Joint("R", theta, 0, a, 0) for theta, a in rows), ("vx", "vy"), base)


def texts(drawing: Figure) -> list[str]:
    return ["".join(run.text for run in text.runs) for text in drawing.texts]


def test_arms_that_look_alike_have_one_model_and_their_own_labels() -> None:
    one = planar((Q1 + sp.pi / 4, sp.Rational(45, 100)), (Q2, sp.Rational(3, 10)))
    other = planar((Q1 - sp.pi / 2, sp.Rational(6, 10)), (Q2, sp.Rational(4, 10)))
    assert make_model(one).chain == make_model(other).chain
    first, second = draw_arm(one), draw_arm(other)
    assert first.shapes == second.shapes
    assert [(text.x, text.y) for text in first.texts] == [(text.x, text.y) for text in second.texts]
    assert {"0.45 m", "0.3 m", "θ1 + 45°"} <= set(texts(first))
    assert {"0.6 m", "0.4 m", "θ1 − 90°"} <= set(texts(second))


def test_longer_lengths_are_longer_and_equal_ones_equal() -> None:
    lengths = [sp.Rational(k, 100) for k in (70, 68, 70)]
    rows = make_model(planar(*zip((Q1, Q2, Q3), lengths, strict=True))).chain.joints
    assert rows[0].a == rows[2].a > rows[1].a > 0
    negative = make_model(planar((Q1, sp.Rational(1, 2)), (Q2, -sp.Rational(1, 2)))).chain.joints
    assert negative[0].a == -negative[1].a > 0


def test_an_arm_that_can_have_no_other_is_its_own() -> None:
    """Its base stands at numbers, a label would be too wide, or it has more lengths than there are steps."""
    alone = planar((Q1, sp.Rational(1, 2)), (Q2, sp.Symbol("a2")), base=Base((sp.Rational(1, 3), sp.S.Zero, sp.S.Zero)))
    assert make_model(alone).chain.joints == alone.joints
    wide = planar((Q1 + sp.pi / 180 * sp.Rational(225, 2), sp.Rational(12345, 100)), (Q2, sp.Rational(1, 2)))
    assert make_model(wide).chain.joints == wide.joints
    joints = tuple(Joint("R", f"theta{i}", sp.Rational(i, 10), sp.Rational(i, 7), sp.pi / 2) for i in range(1, 6))
    many = Chain("many", joints, ("vx", "vy", "vz"))
    assert make_model(many).chain.joints == many.joints


def test_symbols_stay_as_they_are() -> None:
    chain = planar((Q1, sp.Symbol("a1")), (Q2 + sp.Symbol("beta"), sp.Rational(1, 4)))
    joints = make_model(chain).chain.joints
    assert (joints[0].a, joints[1].theta) == (chain.joints[0].a, chain.joints[1].theta)


@pytest.mark.parametrize("name", ["polar-rp/5", "random-3/4", "cylindrical/3@modified-dh", "planar-rpr/4@full"])
def test_a_pose_of_the_model_is_the_arms(name: str) -> None:
    """Slides are as much longer as the arm is, and angles the same, with other zeros."""
    chain = sample_chain(ProblemId.parse(name))
    model, pose = make_model(chain), find_figure_pose(chain)
    entries = compute_table_entries(model.chain, dict(model.convert_to_model_pose(pose)))
    assert model.convert_to_arm_entries(entries) == pytest.approx(compute_table_entries(chain, pose), abs=1e-8)


@pytest.mark.parametrize("name", ["planar-3r/2", "elbow-3r/8", "scara/2", "puma-560/1"])
def test_the_arms_labels_find_the_room_that_its_models_have(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    for text in draw_arm(chain).texts:
        width = sum(measure_width(((run.text, run.is_italic, run.size < 15.0),)) - 2.0 for run in text.runs) + 2.0
        assert width <= text.box[2] - text.box[0] + 1e-6


@pytest.mark.parametrize("name", ["planar-2r", "polar-rp", "elbow-3r"])
def test_a_figure_is_the_same_whichever_arm_of_its_model_was_drawn_first(name: str) -> None:
    chains = [sample_chain(ProblemId.parse(f"{name}/{seed}")) for seed in range(6)]

    def drawn(order: list[Chain]) -> dict[Chain, tuple[str, str]]:
        for kept in (
            figure.draw_with_labels,
            figure._draw_model,
            figure._draw_cached_svg,
            small.draw_singular_panels,
            small._draw_cached,
        ):
            kept.cache_clear()
        return {chain: (figure.draw_figure_svg(chain), figure.draw_singular_svg(chain)) for chain in order}

    assert drawn(chains) == drawn(chains[::-1])


SHAPES: tuple[Shape, ...] = (
    Polyline(((40.0, 300.0), (180.0, 140.0), (330.0, 170.0)), "link"),
    Polyline(((20.0, 310.0), (60.0, 310.0), (40.0, 330.0)), "plate", True),
    Glyph(1, "R", (Circle((180.0, 140.0), 9.0, "joint-face"), Circle((180.0, 140.0), 2.4, "dot"))),
)
BOXES = [(x, y, x + 31.0, y + 17.4) for x, y in product(range(10, 340, 15), range(100, 330, 11))]
SIZE = (520.0, 360.0)


def by_hand(box: Box, shapes: tuple[Shape, ...]) -> int:
    left, top, right, bottom = box
    points = sample_points(shapes).tolist()
    return sum(left - r < x < right + r and top - r < y < bottom + r for x, y, r in points)


def places(*rivals: tuple[float, float]) -> LabelPlaces:
    anchors = (((180.0, 140.0), (0.6, 0.8)), ((330.0, 170.0), (0.0, -1.0)))
    return LabelPlaces(LabelRequest(write_with_index("O", "1"), anchors, gap=11.0), rivals, InkPoints(SHAPES), SIZE)


def test_points_in_a_box_are_counted_as_one_by_one() -> None:
    ink, counts = InkPoints(SHAPES), [by_hand(box, SHAPES) for box in BOXES]
    assert [ink.count_covered(box) for box in BOXES] == counts and len(set(counts)) > 5


def test_a_leader_is_a_line_like_others() -> None:
    shape = Polyline(((100.0, 200.0), (140.0, 260.0)), "leader")
    line = LeaderLine(shape)
    assert [line.count_covered(box) for box in BOXES] == [by_hand(box, (shape,)) for box in BOXES]
    assert all(line.is_near(box) for box in BOXES if line.count_covered(box) or line.is_covered_by(box))
    assert line.crosses((90.0, 240.0), (150.0, 220.0)) and not line.crosses((90.0, 240.0), (90.0, 200.0))


@pytest.mark.parametrize("rivals", [(), ((195.0, 160.0), (330.0, 150.0))])
def test_no_place_is_cheaper_than_the_best(rivals: tuple[tuple[float, float], ...]) -> None:
    taken = [(190.0, 145.0, 230.0, 165.0), (310.0, 130.0, 360.0, 150.0)]
    found = places(*rivals).find_best_place(taken, [], math.inf)
    assert found is not None
    box, cost = found
    assert places(*rivals).find_best_place(taken, [], cost) == found
    assert places(*rivals).find_best_place(taken, [], cost - 0.02) is None
    assert not any(box[0] < b[2] and b[0] < box[2] and box[1] < b[3] and b[1] < box[3] for b in taken)


def test_a_link_seen_end_on_still_has_a_label() -> None:
    request = LabelRequest(write_with_index("a", "1"), (((90.0, 90.0), (0.0, -0.0)),), gap=8.0)
    nowhere = LabelPlaces(request, (), InkPoints(SHAPES), SIZE)
    assert nowhere.find_best_place([], [], math.inf) is not None


def test_labels_that_cost_too_much_are_given_up() -> None:
    requests = [
        LabelRequest(write_with_index("O", str(k)), (((180.0, 140.0), (0.6, 0.8)),), kind="origin") for k in range(4)
    ]
    whole = Layout(requests, SHAPES, SIZE)
    assert whole.place_all() and whole.cost > 1.0
    assert Layout(requests, SHAPES, SIZE).place_all(whole.cost)
    assert not Layout(requests, SHAPES, SIZE).place_all(whole.cost - 1.0)


def _point(chain: Chain, pose: dict[str, float] | None) -> tuple[float, float]:
    (dot,) = [s for s in draw_arm(chain, pose).shapes if isinstance(s, Circle) and s.style == "point"]
    return dot.center


@pytest.mark.parametrize("family", ["planar-2r", "planar-pr", "planar-3r"])
def test_a_flat_arm_in_that_pose_has_its_point_at_the_same_place(family: str) -> None:
    chain = sample_chain(ProblemId(family, 3, variation="full"))
    pose = find_figure_pose(chain)
    assert list(pose) == [q.name for q in chain.q]
    assert _point(chain, pose) == pytest.approx(_point(chain, None), abs=0.5)
    other = {name: value + 0.5 for name, value in pose.items()}
    assert _point(chain, other) != pytest.approx(_point(chain, None), abs=5)


@pytest.mark.parametrize(("family", "least", "most"), [("polar-rp", 1.5, 2.0), ("scara", 0.5, 1.0)])
def test_a_slide_is_longer_than_any_link_in_the_plane_only(family: str, least: float, most: float) -> None:
    """In the plane its sleeve and its rod are seen from the side, and take room."""
    chain = sample_chain(ProblemId(family, 0))
    slide = next(i for i, joint in enumerate(chain.joints) if joint.is_prismatic)
    lengths = [abs(float(v)) for joint in chain.joints for v in (joint.a, joint.d) if v.is_number]
    extensions = list_candidate_poses(chain, chain)[:, slide] / (max([*lengths, 0.0]) or DEFAULT_LENGTH)
    assert least <= extensions.min() and extensions.max() <= most
