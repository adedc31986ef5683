"""Jacobians, determinants and singular sets from textbooks, of arms described in each book's own convention.

`tests/data/textbooks` has a file for each book, with each arm as a ROBOT.toml and the book's results, in its order:

    jacobian        entries, or the axes, origins and tip from which the book builds the columns, in a `frame`
                    (base: 0); six rows vx ... wz if none are named; of frame `link` if it is not the point
    determinant, inverse, manipulability, rates, torques, forces (by torques), isotropic, at (figures, rounded)
    singular        alternatives that the book prints, some with their `kinds`; `derived` are those that it omits
    space           the space Jacobian with the book's order of rows (twist_order), or its axes and points on them
    home_space      screws at home, one per row, whose exponentials give the space Jacobian; home_body likewise
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import compute_link_frames
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.derivation import derive
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import evaluate_trees
from qdot.exercises.formula.trees import find_names
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.robots.robot_file import Robot, read_robot_file
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.solve.solver import Solution, solve
from qdot.exercises.verify.singular import SET_TOLERANCE
from qdot.exercises.writing.solution_steps import SingularComponent
from tests.exercises.arm.poses import compute_exponential
from tests.exercises.arm.sets import (
    assert_same_set,
    compare_with_book,
    compute_rank_ratios,
    read_pieces,
    read_singular_set,
    search_singularities,
)
from tests.support import DATA

POINTS = 10
"""The number of configurations, each with different lengths, at which formulas are compared."""
Values = Mapping[str, np.ndarray]
Texts = Sequence[Sequence[str]]


@dataclass(frozen=True)
class Arm:
    """An arm as a book describes it, the book's file, and its entry for the arm."""

    name: str
    file: str
    entry: Mapping[str, Any]

    def __repr__(self) -> str:
        return self.name


BOOKS = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in (DATA / "textbooks").glob("*.toml")}
ARMS = [Arm(row["name"], file, row) for file, book in sorted(BOOKS.items()) for row in book["arm"]]
LONG = ("siciliano-anthropomorphic-with-wrist", "craig-puma-560", "craig-puma-560-without-a3",
        "murray-li-sastry-stanford")  # fmt: skip
SLOW = (*LONG, "siciliano-anthropomorphic", "chapter-scorbot", "craig-3r", "spong-elbow", "spong-spherical")
"""Arms whose singular sets or kinds take long; families with such arms are in every suite."""


def _parametrize_arms(*keys: str, slow: Sequence[str] = ()) -> pytest.MarkDecorator:
    """Parametrize a test by the arms whose entries have any of these keys."""
    arms = [arm for arm in ARMS if any(key in arm.entry for key in keys)]
    marks = dict.fromkeys(slow, pytest.mark.whole)
    return pytest.mark.parametrize("arm", [pytest.param(a, marks=marks.get(a.name, ()), id=a.name) for a in arms])


@cache
def _read_robot(name: str) -> Robot:
    text = next(arm.entry["robot"] for arm in ARMS if arm.name == name)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(text, encoding="utf-8")
        return read_robot_file(path)


def _get_chain(arm: Arm) -> Chain:
    return _read_robot(arm.name).chain


@cache
def _solve(name: str) -> Solution:
    return solve(_read_robot(name).chain)


def _compute_geometric_jacobian(arm: Arm, values: Values) -> np.ndarray:
    return _evaluate_matrix(derive(_get_chain(arm)).geometric_jacobian, values)


def _sample_values(arm: Arm, formulas: Mapping[str, str] | None = None, points: int = POINTS) -> dict[str, np.ndarray]:
    """Return values of every joint and length, and of forces and velocities x and y; formulas replace some of them."""
    chain, stream = _get_chain(arm), Stream(arm.name)
    values = {q.name: _sample(stream, -3, 3, points) for q in chain.q}
    values |= {symbol.name: _sample(stream, 0.3, 1.2, points) for symbol in chain.parameters}
    values |= {name: _sample(stream, -1, 1, points) for name in "xy"}
    for name, text in (formulas or {}).items():
        assert name in values
        values[name] = _evaluate_formula(text, values)
    return values


def _sample(stream: Stream, low: float, high: float, points: int) -> np.ndarray:
    return np.array([stream.uniform(low, high) for _ in range(points)])


def _evaluate_formula(text: str, values: Values) -> np.ndarray:
    """Evaluate a book's formula, (points,)."""
    node, points = parse_formula(text), len(values["x"])
    assert find_names(node) <= {*values, "pi"}, text
    results = evaluate_trees([node], values, points)[0]
    assert np.isfinite(results).all() and np.abs(results.imag).max() < 1e-12, text
    return np.asarray(results.real)


def _evaluate_rows(rows: Texts, values: Values) -> np.ndarray:
    """Evaluate a book's matrix, (points, rows, columns)."""
    assert len({len(row) for row in rows}) == 1
    entries = np.array([[_evaluate_formula(text, values) for text in row] for row in rows])
    return np.moveaxis(entries, -1, 0)


def _evaluate_matrix(matrix: sp.Matrix, values: Values) -> np.ndarray:
    """Evaluate a derived matrix, (points, rows, columns)."""
    symbols = sorted(matrix.free_symbols, key=str)
    function = sp.lambdify(symbols, matrix.tolist(), modules="numpy")
    columns = [values[symbol.name] for symbol in symbols]
    points = range(len(values["x"]))
    return np.array([function(*(column[k] for column in columns)) for k in points], dtype=float)


def _select_rows(arm: Arm, six: np.ndarray, rows: Sequence[str] = ()) -> np.ndarray:
    """Return the named rows of a 6 x n Jacobian, those of the arm's task if none are named."""
    return six[:, [VELOCITY_NAMES.index(row) for row in rows or _get_chain(arm).task]]


def _is_near(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-9)


def _get_original_chain(arm: Arm) -> Chain:
    """Return the arm with the link frames of the book's convention."""
    robot = _read_robot(arm.name)
    return replace(robot.chain, convention=robot.written_arm.convention.name if robot.written_arm else "dh")


def _compute_rotation(arm: Arm, frame: int, values: Values) -> np.ndarray:
    """Return the rotation of a frame of the book's convention, (points, 3, 3)."""
    return _evaluate_matrix(compute_link_frames(_get_original_chain(arm))[frame].rotation, values)


def _express_in_frame(rotation: np.ndarray, six: np.ndarray) -> np.ndarray:
    """Express a 6 x n matrix with two vectors in each column in a frame of that rotation."""
    inverse = rotation.swapaxes(1, 2)
    return np.concatenate([inverse @ six[:, :3], inverse @ six[:, 3:]], axis=1)


def _build_jacobian(arm: Arm, source: Mapping[str, Any], values: Values) -> np.ndarray:
    """Build the Jacobian from axes, origins and tip: (z x (tip - o), z), and (z, 0) for a prismatic joint."""
    z, origins = (_evaluate_rows(source[key], values) for key in ("axes", "origins"))
    (tip,) = np.moveaxis(_evaluate_rows([source["tip"]], values), 1, 0)
    prismatic = _find_prismatic(arm)
    linear = np.where(prismatic, z, np.cross(z, tip[:, None] - origins))
    return np.concatenate([linear, np.where(prismatic, 0, z)], axis=2).swapaxes(1, 2)


def _find_prismatic(arm: Arm) -> np.ndarray:
    return np.array([[joint.is_prismatic] for joint in _get_chain(arm).joints])


@_parametrize_arms("jacobian")
def test_jacobian_agrees_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    for source in arm.entry["jacobian"]:
        assert {*source} <= {"frame", "rows", "entries", "axes", "origins", "tip", "link"}
        rows = source.get("rows", VELOCITY_NAMES)
        book = _evaluate_rows(source["entries"], values) if "entries" in source else None
        if book is None:
            book = _select_rows(arm, _build_jacobian(arm, source, values), rows)
        six = _compute_geometric_jacobian(arm, values)
        if "link" in source:
            six = _evaluate_matrix(derive(_get_original_chain(arm)).derive_link_jacobian(source["link"]), values)
        in_frame = _express_in_frame(_compute_rotation(arm, source.get("frame", 0), values), six)
        assert _is_near(_select_rows(arm, in_frame, rows), book)


@_parametrize_arms("at")
def test_numeric_jacobian_agrees_with_the_book(arm: Arm) -> None:
    for source in arm.entry["at"]:
        values = _sample_values(arm, source["values"], points=1)
        figures = _select_rows(arm, _compute_geometric_jacobian(arm, values), source["rows"])
        differences = np.abs(figures - _evaluate_rows(source["entries"], values))
        assert differences.max() <= 0.5 * 10 ** -source["decimals"] + 1e-12


@_parametrize_arms("determinant")
def test_determinant_agrees_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    book = _evaluate_formula(arm.entry["determinant"], values)
    assert _is_near(_evaluate_matrix(sp.Matrix([[derive(_get_chain(arm)).determinant]]), values)[:, 0, 0], book)
    assert _is_near(np.linalg.det(_select_rows(arm, _compute_geometric_jacobian(arm, values))), book)
    if not book.any():
        solution = _solve(arm.name)
        assert solution.singular is None and "every configuration" in (solution.note or "")


@_parametrize_arms("inverse")
def test_inverse_agrees_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    ours = _evaluate_matrix(derive(_get_chain(arm)).inverse, values)
    assert _is_near(ours, _evaluate_rows(arm.entry["inverse"], values))


@_parametrize_arms("rates")
def test_joint_rates_agree_with_the_book(arm: Arm) -> None:
    chain = _get_chain(arm)
    for source in arm.entry["rates"]:
        velocity = dict(zip(chain.task, source["velocity"], strict=True))
        values = _sample_values(arm)
        values |= {row: _evaluate_formula(text, values) for row, text in velocity.items()}
        ours = _evaluate_matrix(derive(chain).derive_rate_law(), values)[:, :, 0]
        assert _is_near(ours, _evaluate_rows([source["values"]], values)[:, 0])


@_parametrize_arms("torques")
def test_joint_torques_agree_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    for source in arm.entry["torques"]:
        in_frame = _evaluate_rows([[f] for f in source["force"]], values)
        force = _compute_rotation(arm, source.get("frame", 0), values) @ in_frame
        linear = _compute_geometric_jacobian(arm, values)[:, :3]
        assert _is_near((linear.swapaxes(1, 2) @ force)[:, :, 0], _evaluate_rows([source["values"]], values)[:, 0])


@_parametrize_arms("forces")
def test_tip_forces_agree_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    for source in arm.entry["forces"]:
        rotation = _compute_rotation(arm, source["frame"], values)
        in_frame = _select_rows(arm, _express_in_frame(rotation, _compute_geometric_jacobian(arm, values)))
        assert _is_near(np.linalg.inv(in_frame.swapaxes(1, 2)), _evaluate_rows(source["entries"], values))


@_parametrize_arms("manipulability")
def test_manipulability_agrees_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    jacobian = _select_rows(arm, _compute_geometric_jacobian(arm, values))
    ours = np.sqrt(np.linalg.det(jacobian @ jacobian.swapaxes(1, 2)))
    assert np.allclose(ours, _evaluate_formula(arm.entry["manipulability"], values), rtol=1e-7)


@_parametrize_arms("isotropic")
def test_isotropic_configurations_of_the_book_are_isotropic(arm: Arm) -> None:
    for formulas in arm.entry["isotropic"]:
        jacobian = _select_rows(arm, _compute_geometric_jacobian(arm, _sample_values(arm, formulas)))
        sigma = np.linalg.svd(jacobian, compute_uv=False)
        assert sigma.min() > 0.1 and np.allclose(sigma[:, 0], sigma[:, -1])


def _compute_space_jacobian(arm: Arm, values: Values) -> np.ndarray:
    """Return the space Jacobian, rows (omega, v), from the derived axes and vectors from them to the point."""
    d = derive(_get_chain(arm))
    z, p_star = (_evaluate_matrix(matrix.T, values) for matrix in (d.z, d.p_star))
    return _build_screw_columns(arm, z, _evaluate_matrix(d.position.T, values) - p_star)


def _build_screw_columns(arm: Arm, axes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (omega, -omega x q) for each axis omega and point q, and (0, v) for a prismatic joint, (points, 6, n)."""
    prismatic = _find_prismatic(arm)
    linear = np.where(prismatic, axes, -np.cross(axes, points))
    return np.concatenate([np.where(prismatic, 0, axes), linear], axis=2).swapaxes(1, 2)


def _compute_body_jacobian(arm: Arm, values: Values) -> np.ndarray:
    """Return the body Jacobian, rows (omega, v), in a frame at the point that is parallel to the base at home."""
    chain = _get_chain(arm)
    turned = compute_link_frames(chain)[-1].rotation
    rotation = turned * turned.xreplace(dict.fromkeys(chain.q, sp.S.Zero)).T
    geometric = _compute_geometric_jacobian(arm, values)
    return _express_in_frame(_evaluate_matrix(rotation, values), np.roll(geometric, 3, axis=1))


def _make_skew_matrix(vector: np.ndarray) -> np.ndarray:
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _compute_adjoint(screw: np.ndarray, q: float) -> np.ndarray:
    """Return the 6 x 6 adjoint of exp([S] q); S = (omega, v) with |omega| = 1 and v normal to it, or omega = 0."""
    is_prismatic = not screw[:3].any()
    omega, v = screw[:3], screw[3:]
    pose = compute_exponential(v if is_prismatic else omega, q, is_prismatic, np.cross(omega, v))
    rotation = pose[:3, :3]
    return np.block([[rotation, np.zeros((3, 3))], [_make_skew_matrix(pose[:3, 3]) @ rotation, rotation]])


def _multiply_exponentials(screws: np.ndarray, q: np.ndarray, body: bool) -> np.ndarray:
    """Return the Jacobian of home screws, n x 6: moved by the joints before, in the body by those after."""
    columns, moved = [], np.eye(6)
    order = range(len(screws))
    for i in reversed(order) if body else order:
        columns.append(moved @ screws[i])
        moved = moved @ _compute_adjoint(screws[i], -q[i] if body else q[i])
    return np.array(columns[::-1] if body else columns).T


@_parametrize_arms("space")
def test_space_jacobian_agrees_with_the_book(arm: Arm) -> None:
    values, chain = _sample_values(arm), _get_chain(arm)
    answer, _ = QUESTIONS["space-jacobian"].ask(chain, Stream(arm.name))
    book = _evaluate_rows(arm.entry["space"], values)
    assert _is_near(_evaluate_matrix(answer.as_matrix(), values), book)
    linear_first = chain.twist_order == "v-omega"
    assert _is_near(_compute_space_jacobian(arm, values), np.roll(book, 3, axis=1) if linear_first else book)


@_parametrize_arms("space_axes")
def test_screw_axes_agree_with_the_book(arm: Arm) -> None:
    values = _sample_values(arm)
    axes, points = (_evaluate_rows(arm.entry[key], values) for key in ("space_axes", "space_points"))
    assert _is_near(_compute_space_jacobian(arm, values), _build_screw_columns(arm, axes, points))


def _compute_screw_jacobian(arm: Arm, key: str, values: Values) -> np.ndarray:
    screws = _evaluate_rows(arm.entry[key], values)
    q = np.stack([values[joint.name] for joint in _get_chain(arm).q], axis=1)
    return np.array([_multiply_exponentials(s, at, key == "home_body") for s, at in zip(screws, q, strict=True)])


@_parametrize_arms("home_space", "home_body", slow=(*SLOW, "lynch-park-6r", "lynch-park-wam"))
def test_home_screws_give_the_space_and_body_jacobians(arm: Arm) -> None:
    values = _sample_values(arm)
    for key, jacobian in (("home_space", _compute_space_jacobian), ("home_body", _compute_body_jacobian)):
        assert key not in arm.entry or _is_near(jacobian(arm, values), _compute_screw_jacobian(arm, key, values)), key


def _list_singular_conditions(arm: Arm) -> list[str]:
    return [*arm.entry.get("singular", ()), *arm.entry.get("derived", ())]


def _format_component(component: SingularComponent) -> str:
    """Return the condition that `solve` shows, with joint values if there are any."""
    if component.solutions is None:
        return " and ".join(f"{condition} = 0" for condition in component.conditions)
    shown = ((joint, ", ".join(map(str, values))) for joint, values in component.solutions)
    return " and ".join(f"{joint} in {{{values}}}" for joint, values in shown)


@_parametrize_arms("singular", "derived", slow=LONG)
def test_singular_set_agrees_with_the_book(arm: Arm) -> None:
    """The derived set is exactly the printed conditions and those listed as missing from the book.

    Rank is lost at each of them, and a search finds no other singular configuration.
    """
    chain, book = _get_chain(arm), _list_singular_conditions(arm)
    assert_same_set(chain, read_singular_set(chain), book)
    for text in book:
        samples = sample_condition(chain, text, arm.name, arm_count=3, samples_per_arm=3)
        assert samples, text
        assert all(compute_rank_ratios(sample.arm, chain, sample.q) < 1e-7 for sample in samples), text
    search = search_singularities(chain, f"{arm.name}/search", 20)
    assert (compute_rank_ratios(search.arm, chain, search.starts) > 1e-6).all()
    assert len(search.reached)
    assert search.are_in(read_pieces(chain, book), SET_TOLERANCE).all()


@_parametrize_arms("singular", "derived", slow=SLOW)
def test_displayed_singularities_and_kinds_agree_with_the_book(arm: Arm) -> None:
    """A kind is boundary if some configurations are: an arm with an offset, stretched over its base, is not."""
    chain = _get_chain(arm)
    components = {
        _format_component(component): component.classification for component in _solve(arm.name).singular or ()
    }
    assert_same_set(chain, read_pieces(chain, components), _list_singular_conditions(arm))
    for text, kind in arm.entry.get("kinds", {}).items():
        (shown,) = (s for s in components if compare_with_book(chain, read_pieces(chain, [s]), [text]).are_equal)
        assert components[shown].kind == kind
