"""Jacobians, determinants and singular sets that textbooks print, of arms told in each book's own convention.

`tests/data/textbooks` has a file for each book, with an arm as a ROBOT.toml and what the book says of it, in its order:

    jacobian        entries, or the axes, origins and tip of which the book makes its columns, in a `frame` (base: 0);
                    six rows vx ... wz if none are named; of frame `link`, where that is not the point of interest
    determinant, inverse, manipulability, rates, torques, forces (by torques), isotropic, at (figures, rounded)
    singular        alternatives that the book prints, some with their `kinds`; `derived` are those that it leaves out
    space           the space Jacobian, rows as the book has them (twist_order), or its axes and points on them
    home_space      screws at home, a row each, of which exponentials make the space Jacobian; home_body, too
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
from qdot.exercises.arm.derivation import derive
from qdot.exercises.arm.kinematics import link_frames
from qdot.exercises.arm.robot_file import Robot, read_robot_file
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.formula.program import evaluate_variants
from qdot.exercises.formula.trees import find_names
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.singularities.classification import sample_condition
from qdot.exercises.solve.solver import Solution, solve
from qdot.exercises.verify.singular import SET_TOLERANCE
from qdot.exercises.writing.solution_steps import SingularComponent
from tests.exercises.arm.poses import exponential
from tests.exercises.arm.sets import assert_is_book, claimed, compared, rank_ratios, read_pieces, search
from tests.support import DATA

POINTS = 10
"""Configurations, each with lengths of its own, at which formulas are compared."""
Values = Mapping[str, np.ndarray]
Texts = Sequence[Sequence[str]]


@dataclass(frozen=True)
class Arm:
    """An arm as a book tells it, and what the book says of it; the file is that of the book."""

    name: str
    file: str
    told: Mapping[str, Any]

    def __repr__(self) -> str:
        return self.name


BOOKS = {path.stem: tomllib.loads(path.read_text(encoding="utf-8")) for path in (DATA / "textbooks").glob("*.toml")}
ARMS = [Arm(row["name"], file, row) for file, book in sorted(BOOKS.items()) for row in book["arm"]]


LONG = ("siciliano-anthropomorphic-with-wrist", "craig-puma-560", "craig-puma-560-without-a3",
        "murray-li-sastry-stanford")  # fmt: skip
SLOW = (*LONG, "siciliano-anthropomorphic", "chapter-scorbot", "craig-3r", "spong-elbow", "spong-spherical")
"""Arms whose singular sets take long, and those whose kinds do; families with such arms are in every suite."""


def _with(*keys: str, slow: Sequence[str] = ()) -> pytest.MarkDecorator:
    """Return the parameters of a test: the arms of which a book says any of these."""
    arms = [arm for arm in ARMS if any(key in arm.told for key in keys)]
    marks = dict.fromkeys(slow, pytest.mark.whole)
    return pytest.mark.parametrize("arm", [pytest.param(a, marks=marks.get(a.name, ()), id=a.name) for a in arms])


@cache
def _robot(name: str) -> Robot:
    text = next(arm.told["robot"] for arm in ARMS if arm.name == name)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "arm.toml"
        path.write_text(text, encoding="utf-8")
        return read_robot_file(path)


def _chain(arm: Arm) -> Chain:
    return _robot(arm.name).chain


@cache
def _solution(name: str) -> Solution:
    return solve(_robot(name).chain)


def _geometric(arm: Arm, values: Values) -> np.ndarray:
    return _ours(derive(_chain(arm)).geometric, values)


# --- in numbers ---


def _values(arm: Arm, given: Mapping[str, str] | None = None, points: int = POINTS) -> dict[str, np.ndarray]:
    """Return values of every joint and length, and of forces and velocities x and y; some may be given as formulas."""
    chain, stream = _chain(arm), Stream(arm.name)
    values = {q.name: _drawn(stream, -3, 3, points) for q in chain.q}
    values |= {symbol.name: _drawn(stream, 0.3, 1.2, points) for symbol in chain.parameters}
    values |= {name: _drawn(stream, -1, 1, points) for name in "xy"}
    for name, text in (given or {}).items():
        assert name in values
        values[name] = _book(text, values)
    return values


def _drawn(stream: Stream, low: float, high: float, points: int) -> np.ndarray:
    return np.array([stream.uniform(low, high) for _ in range(points)])


def _book(text: str, values: Values) -> np.ndarray:
    """Return the values of a book's formula, (points,)."""
    node, points = parse_formula(text), len(values["x"])
    assert find_names(node) <= {*values, "pi"}, text
    found = evaluate_variants([node], values, points)[0]
    assert np.isfinite(found).all() and np.abs(found.imag).max() < 1e-12, text
    return np.asarray(found.real)


def _book_matrix(rows: Texts, values: Values) -> np.ndarray:
    """Return the values of a book's matrix, (points, rows, columns)."""
    assert len({len(row) for row in rows}) == 1
    entries = np.array([[_book(text, values) for text in row] for row in rows])
    return np.moveaxis(entries, -1, 0)


def _ours(matrix: sp.Matrix, values: Values) -> np.ndarray:
    """Return the values of a matrix that was derived, (points, rows, columns)."""
    symbols = sorted(matrix.free_symbols, key=str)
    function = sp.lambdify(symbols, matrix.tolist(), modules="numpy")
    columns = [values[symbol.name] for symbol in symbols]
    points = range(len(values["x"]))
    return np.array([function(*(column[k] for column in columns)) for k in points], dtype=float)


def _task(arm: Arm, six: np.ndarray, rows: Sequence[str] = ()) -> np.ndarray:
    """Return the named rows of a 6 x n Jacobian, those of the arm's task if none are named."""
    return six[:, [VELOCITY_NAMES.index(row) for row in rows or _chain(arm).task]]


def _is_near(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and np.allclose(a, b, rtol=1e-9, atol=1e-9)


# --- Jacobians ---


def _as_told(arm: Arm) -> Chain:
    """Return the arm with the frames of its own convention on its links."""
    robot = _robot(arm.name)
    return replace(robot.chain, convention=robot.written_arm.convention.name if robot.written_arm else "dh")


def _rotation(arm: Arm, frame: int, values: Values) -> np.ndarray:
    """Return the rotation of a frame of the arm's own convention, (points, 3, 3)."""
    return _ours(link_frames(_as_told(arm))[frame].rotation, values)


def _seen_from(rotation: np.ndarray, six: np.ndarray) -> np.ndarray:
    """Return a 6 x n matrix of two vectors in each column, told in a frame of that rotation."""
    back = rotation.swapaxes(1, 2)
    return np.concatenate([back @ six[:, :3], back @ six[:, 3:]], axis=1)


def _by_axes(arm: Arm, told: Mapping[str, Any], values: Values) -> np.ndarray:
    """Return the Jacobian that axes, origins and the tip make: (z x (tip - o), z), and (z, 0) of a slide."""
    z, origins = (_book_matrix(told[key], values) for key in ("axes", "origins"))
    (tip,) = np.moveaxis(_book_matrix([told["tip"]], values), 1, 0)
    slides = _slides(arm)
    linear = np.where(slides, z, np.cross(z, tip[:, None] - origins))
    return np.concatenate([linear, np.where(slides, 0, z)], axis=2).swapaxes(1, 2)


def _slides(arm: Arm) -> np.ndarray:
    return np.array([[joint.is_prismatic] for joint in _chain(arm).joints])


@_with("jacobian")
def test_the_jacobian_is_the_books(arm: Arm) -> None:
    values = _values(arm)
    for told in arm.told["jacobian"]:
        assert {*told} <= {"frame", "rows", "entries", "axes", "origins", "tip", "link"}
        rows = told.get("rows", VELOCITY_NAMES)
        book = _book_matrix(told["entries"], values) if "entries" in told else None
        if book is None:
            book = _task(arm, _by_axes(arm, told, values), rows)
        of_link = _ours(derive(_as_told(arm)).link_jacobian(told["link"]), values) if "link" in told else None
        six = _geometric(arm, values) if of_link is None else of_link
        seen = _seen_from(_rotation(arm, told.get("frame", 0), values), six)
        assert _is_near(_task(arm, seen, rows), book)


@_with("at")
def test_figures_at_a_configuration_are_the_books(arm: Arm) -> None:
    for told in arm.told["at"]:
        values = _values(arm, told["values"], points=1)
        figures = _task(arm, _geometric(arm, values), told["rows"])
        assert np.abs(figures - _book_matrix(told["entries"], values)).max() <= 0.5 * 10 ** -told["decimals"] + 1e-12


@_with("determinant")
def test_the_determinant_is_the_books(arm: Arm) -> None:
    values = _values(arm)
    book = _book(arm.told["determinant"], values)
    assert _is_near(_ours(sp.Matrix([[derive(_chain(arm)).determinant]]), values)[:, 0, 0], book)
    assert _is_near(np.linalg.det(_task(arm, _geometric(arm, values))), book)
    if not book.any():
        solution = _solution(arm.name)
        assert solution.singular is None and "every configuration" in (solution.note or "")


@_with("inverse")
def test_the_inverse_is_the_books(arm: Arm) -> None:
    values = _values(arm)
    assert _is_near(_ours(derive(_chain(arm)).inverse, values), _book_matrix(arm.told["inverse"], values))


@_with("rates")
def test_rates_for_a_velocity_are_the_books(arm: Arm) -> None:
    chain = _chain(arm)
    for told in arm.told["rates"]:
        velocity = dict(zip(chain.task, told["velocity"], strict=True))
        values = _values(arm)
        values |= {row: _book(text, values) for row, text in velocity.items()}
        ours = _ours(derive(chain).rate_law(), values)[:, :, 0]
        assert _is_near(ours, _book_matrix([told["values"]], values)[:, 0])


@_with("torques")
def test_torques_that_hold_a_force_are_the_books(arm: Arm) -> None:
    values = _values(arm)
    for told in arm.told["torques"]:
        force = _rotation(arm, told.get("frame", 0), values) @ _book_matrix([[f] for f in told["force"]], values)
        linear = _geometric(arm, values)[:, :3]
        assert _is_near((linear.swapaxes(1, 2) @ force)[:, :, 0], _book_matrix([told["values"]], values)[:, 0])


@_with("forces")
def test_forces_by_torques_are_the_books(arm: Arm) -> None:
    values = _values(arm)
    for told in arm.told["forces"]:
        seen = _seen_from(_rotation(arm, told["frame"], values), _geometric(arm, values))
        assert _is_near(np.linalg.inv(_task(arm, seen).swapaxes(1, 2)), _book_matrix(told["entries"], values))


@_with("manipulability")
def test_manipulability_is_the_books(arm: Arm) -> None:
    values = _values(arm)
    jacobian = _task(arm, _geometric(arm, values))
    ours = np.sqrt(np.linalg.det(jacobian @ jacobian.swapaxes(1, 2)))
    assert np.allclose(ours, _book(arm.told["manipulability"], values), rtol=1e-7)


@_with("isotropic")
def test_isotropic_configurations_are_the_books(arm: Arm) -> None:
    for told in arm.told["isotropic"]:
        jacobian = _task(arm, _geometric(arm, _values(arm, told)))
        sigma = np.linalg.svd(jacobian, compute_uv=False)
        assert sigma.min() > 0.1 and np.allclose(sigma[:, 0], sigma[:, -1])


# --- screws ---


def _space_jacobian(arm: Arm, values: Values) -> np.ndarray:
    """Return the space Jacobian, rows (omega, v), from the derived axes and vectors from them to the point."""
    d = derive(_chain(arm))
    z, p_star = (_ours(matrix.T, values) for matrix in (d.z, d.p_star))
    return _columns(arm, z, _ours(d.position.T, values) - p_star)


def _columns(arm: Arm, axes: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return (omega, -omega x q) of each axis omega with a point q on it, and (0, v) of a slide, (points, 6, n)."""
    slides = _slides(arm)
    linear = np.where(slides, axes, -np.cross(axes, points))
    return np.concatenate([np.where(slides, 0, axes), linear], axis=2).swapaxes(1, 2)


def _body_jacobian(arm: Arm, values: Values) -> np.ndarray:
    """Return the body Jacobian, rows (omega, v), in a frame at the point that is turned as the base at home."""
    chain = _chain(arm)
    turned = link_frames(chain)[-1].rotation
    rotation = turned * turned.xreplace(dict.fromkeys(chain.q, sp.S.Zero)).T
    geometric = _geometric(arm, values)
    return _seen_from(_ours(rotation, values), np.concatenate([geometric[:, 3:], geometric[:, :3]], axis=1))


def _skew(vector: np.ndarray) -> np.ndarray:
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def _adjoint_of_motion(screw: np.ndarray, q: float) -> np.ndarray:
    """Return the 6 x 6 adjoint of exp([S] q); S = (omega, v), omega of length 1 and v across it, or omega 0."""
    slides = not screw[:3].any()
    pose = exponential(screw[3:] if slides else screw[:3], q, slides, np.cross(screw[:3], screw[3:]))
    rotation = pose[:3, :3]
    return np.block([[rotation, np.zeros((3, 3))], [_skew(pose[:3, 3]) @ rotation, rotation]])


def _by_exponentials(screws: np.ndarray, q: np.ndarray, body: bool) -> np.ndarray:
    """Return the Jacobian of screws at home, n x 6: each moved by joints before it, in the body by those behind."""
    columns, moved = [], np.eye(6)
    order = range(len(screws))
    for i in reversed(order) if body else order:
        columns.append(moved @ screws[i])
        moved = moved @ _adjoint_of_motion(screws[i], -q[i] if body else q[i])
    return np.array(columns[::-1] if body else columns).T


@_with("space")
def test_the_space_jacobian_is_the_books(arm: Arm) -> None:
    values, chain = _values(arm), _chain(arm)
    asked, _ = QUESTIONS["space-jacobian"].ask(chain, Stream(arm.name))
    book = _book_matrix(arm.told["space"], values)
    assert _is_near(_ours(asked.as_matrix(), values), book)
    linear_first = chain.twist_order == "v-omega"
    assert _is_near(_space_jacobian(arm, values), np.roll(book, 3, axis=1) if linear_first else book)


@_with("space_axes")
def test_axes_and_points_of_the_space_jacobian_are_the_books(arm: Arm) -> None:
    values = _values(arm)
    axes, points = (_book_matrix(arm.told[key], values) for key in ("space_axes", "space_points"))
    assert _is_near(_space_jacobian(arm, values), _columns(arm, axes, points))


def _jacobian_of_screws(arm: Arm, key: str, values: Values) -> np.ndarray:
    screws = _book_matrix(arm.told[key], values)
    q = np.stack([values[joint.name] for joint in _chain(arm).q], axis=1)
    return np.array([_by_exponentials(s, at, key == "home_body") for s, at in zip(screws, q, strict=True)])


@_with("home_space", "home_body", slow=LONG)
def test_screws_at_home_make_the_space_and_the_body_jacobian(arm: Arm) -> None:
    values = _values(arm)
    for key, jacobian in (("home_space", _space_jacobian), ("home_body", _body_jacobian)):
        assert key not in arm.told or _is_near(jacobian(arm, values), _jacobian_of_screws(arm, key, values)), key


# --- singular sets ---


def _all_singular(arm: Arm) -> list[str]:
    return [*arm.told.get("singular", ()), *arm.told.get("derived", ())]


def _shown(component: SingularComponent) -> str:
    """Return the condition that `solve` shows, by values of joints where it gives any."""
    if component.solutions is None:
        return " and ".join(f"{condition} = 0" for condition in component.conditions)
    shown = ((joint, ", ".join(map(str, values))) for joint, values in component.solutions)
    return " and ".join(f"{joint} in {{{values}}}" for joint, values in shown)


@_with("singular", "derived", slow=LONG)
def test_the_singular_set_is_the_books(arm: Arm) -> None:
    """Each printed condition is found, and nothing is but these and what is said to be missing from the book.

    Rank is lost at each of them, and a search finds no singular configuration beside them.
    """
    chain, book = _chain(arm), _all_singular(arm)
    assert_is_book(chain, claimed(chain), book)
    for text in book:
        samples = sample_condition(chain, text, arm.name, arm_count=3, samples_per_arm=3)
        assert samples, text
        assert all(rank_ratios(sample.arm, chain, sample.q) < 1e-7 for sample in samples), text
    found = search(chain, f"{arm.name}/search", 20)
    assert (rank_ratios(found.arm, chain, found.starts) > 1e-6).all()
    assert len(found.reached)
    assert found.are_in(read_pieces(chain, book), SET_TOLERANCE).all()


@_with("singular", "derived", slow=SLOW)
def test_what_is_shown_of_singularities_and_their_kinds_are_the_books(arm: Arm) -> None:
    """Boundary where some are: stretched over its own base, an arm with an offset there is inside of its reach."""
    chain = _chain(arm)
    components = {_shown(component): component.kind for component in _solution(arm.name).singular or ()}
    assert_is_book(chain, read_pieces(chain, components), _all_singular(arm))
    for text, kind in arm.told.get("kinds", {}).items():
        (found,) = (
            one for shown, one in components.items() if compared(chain, read_pieces(chain, [shown]), [text]).are_equal
        )
        assert found.kind == kind
