"""Bare arms: what is established of them holds for all arms that have them, and is the same as for each by itself."""

import pytest
import sympy as sp

from exercises.arm.bare import bare, bare_pieces, turns_all
from exercises.arm.chain import TASK_ROWS, Base, Chain, Joint
from exercises.arm.classification import classify, classify_pieces, samples_on
from exercises.arm.kinds import kind_at, kinds_at
from exercises.arm.singularity import singular_set
from exercises.generation import sample_chain
from exercises.problem import ProblemId

A1, A2 = sp.symbols("a1 a2")


def two_links(*offsets: sp.Expr, base: Base = Base()) -> Chain:  # noqa: B008 - frozen
    q = sp.symbols("theta1 theta2")
    rows = (Joint("R", angle + offset, 0, a, 0) for angle, offset, a in zip(q, offsets, (A1, A2), strict=True))
    return Chain("two", tuple(rows), ("vx", "vy"), base, title="two links")


def test_zeros_of_joints_and_the_place_of_the_base_are_left_out() -> None:
    moved = two_links(sp.pi / 6, -sp.pi / 2, base=Base((sp.Rational(1, 2), sp.Symbol("b_y"), sp.S.Zero), sp.pi / 3))
    assert bare(moved) == bare(two_links(sp.S.Zero, sp.S.Zero, base=Base(yaw=sp.pi / 3)))
    assert bare(moved).parameters == (A1, A2)
    assert bare(moved) != bare(two_links(sp.S.Zero, sp.S.Zero))


def test_the_same_configurations_are_the_same_pieces() -> None:
    chains = [two_links(sp.S.Zero, offset) for offset in (sp.S.Zero, sp.pi / 6, -sp.pi / 2, sp.pi)]
    pieces = {tuple(bare_pieces(chain, component)) for chain in chains for component in singular_set(chain) or ()}
    assert pieces == {("theta2 = 0", "theta2 = pi")}


def test_a_slide_is_counted_from_its_own_zero() -> None:
    rows = (Joint("R", "theta1", 0, 0, sp.pi / 2), Joint("P", 0, sp.Symbol("d2") + 4, 0, 0))
    chain = Chain("far", rows, ("vx", "vy"))
    (component,) = singular_set(chain) or ()
    assert component.pieces() == ["d2 = -4"]
    assert bare_pieces(chain, component) == ["d2 = 0"]


@pytest.mark.parametrize(
    "name", ["planar-2r/3", "elbow-3r/8@full", "polar-rp/5", "planar-3r/2", "random-3/4", "scara/2@full"]
)
def test_a_kind_is_that_of_the_arm_by_itself(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    components = singular_set(chain) or ()
    assert components
    for component in components:
        assert classify(chain, component) == classify_pieces(chain, component.pieces())


@pytest.mark.parametrize("name", ["planar-3r/2", "spherical/3", "wrist-zyz/1", "puma-560/1"])
def test_kinds_are_the_same_one_by_one_and_at_once(name: str) -> None:
    chain = sample_chain(ProblemId.parse(name))
    pieces = [piece for component in singular_set(chain) or () for piece in component.pieces()]
    samples = [sample for piece in pieces for sample in samples_on(chain, piece, "at once", arms=2, each=2)]
    assert kinds_at(chain, samples) == [kind_at(chain, sample) for sample in samples]
    assert len(samples) > 3
    assert kinds_at(chain, []) == []


@pytest.mark.parametrize(
    ("task", "tilt", "turns"),
    [
        (("vx", "vy"), 0, True),
        (("vx", "vy", "wz"), 0, True),
        (("vx", "vy", "vz"), sp.pi / 2, True),
        (TASK_ROWS, sp.pi / 2, True),
        (("vx", "vz"), 0, False),
        (("vx", "vy"), sp.pi / 2, False),
        (("vx", "vy", "wx"), 0, False),
    ],
)
def test_a_turn_about_the_first_axis_changes_nothing_where_the_rows_turn_into_each_other(
    task: tuple[str, ...], tilt: sp.Expr, turns: bool
) -> None:
    rows = tuple(Joint("R", f"theta{i}", 0, 1, sp.pi / 2) for i in range(1, 4))
    assert turns_all(Chain("turned", rows, task, Base(tilt=sp.S(tilt)))) is turns
