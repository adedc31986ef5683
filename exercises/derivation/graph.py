"""Compute a derivation as a student does it: in stages that build on one another, any of which may contain a mistake.

A *stage* is one step of the derivation with one result, such as the rotations, the axes or the Jacobian (STAGES). A
mistake replaces the result of a stage, and later stages use the wrong result. Results are arrays. The first axes of an
array are the rows and columns of a vector or matrix. The last axes, shown as "…" in shapes, belong to the arithmetic:
in numbers, for example, there is one axis for the configurations (see `arithmetic`).
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import REVOLUTE, Chain, HasKind
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.kinematics import compute_frames_and_point
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.derivation.arithmetic import (
    Arithmetic,
    NumericArithmetic,
    SympyArithmetic,
    TreeArithmetic,
    apply_matrix,
    cofactor_signs,
    cross,
    determinant,
    list_rows,
    matrix_product,
    minors,
)

RESULT = "result"
"""The name by which mistakes change the finished answer, (rows, columns, …), after all stages; it is not in STAGES."""


@dataclass(frozen=True)
class TableRow(HasKind):
    """A row of the DH table, with all four entries as values of the arithmetic."""

    theta: np.ndarray
    d: np.ndarray
    a: np.ndarray
    alpha: np.ndarray


@dataclass(frozen=True)
class Table:
    """The DH table with the base and the point of interest: the result of the first stage."""

    rows: tuple[TableRow, ...]
    base_position: np.ndarray
    """The position of the base, (3, …)."""
    base_yaw: np.ndarray
    """The angle (rad) by which the base is rotated about z_w; it is then rotated by `base_tilt` (rad) about x_0."""
    base_tilt: np.ndarray
    point_offset: np.ndarray
    """The coordinates of the point of interest in the frame in which it is fixed, (3, …)."""

    def with_row(self, index: int, **entries: Any) -> "Table":
        """Return the table with changed `entries` in the row with an index (from 0)."""
        rows = list(self.rows)
        rows[index] = replace(rows[index], **entries)
        return replace(self, rows=tuple(rows))


Change = Callable[["StageResults", Any], Any]
"""A mistake in a stage: a function that returns the wrong result, given all stages and the correct result."""


@dataclass
class StageResults:
    """The results of a derivation for one arm in one arithmetic; stages (STAGES) are computed on demand.

    `changes` are the mistakes in the derivation, each with the name of its stage. `with_mistakes` returns a copy with
    further mistakes, the `new_changes`. The copy takes the results that they can't affect from `base_results`, the
    original.
    """

    chain: Chain
    arithmetic: Arithmetic
    changes: tuple[tuple[str, Change], ...] = ()
    new_changes: tuple[tuple[str, Change], ...] = ()
    base_results: "StageResults | None" = None
    _results: dict[str, Any] = field(default_factory=dict)
    _shortened_results: dict[int, "StageResults"] = field(default_factory=dict)
    _row_rotations: dict[tuple[int, int], tuple[TableRow, np.ndarray]] = field(default_factory=dict)

    def __getitem__(self, stage: str) -> Any:
        """Return the result of a stage."""
        if stage not in self._results:
            self._results[stage] = self._compute(stage)
        return self._results[stage]

    def _compute(self, stage: str) -> Any:
        """Return the result of a stage, after the mistakes in this stage."""
        is_affected = any(name in list_prerequisites(stage) for name, _ in self.new_changes)
        if self.base_results is None or is_affected:
            result, changes = STAGES[stage].compute_result(self), self.changes
        else:
            result, changes = self.base_results[stage], self.new_changes
        for name, change in changes:
            if name == stage:
                result = change(self, result)
        return result

    def with_mistakes(self, changes: Mapping[str, Change]) -> "StageResults":
        """Return the stages of the same derivation with further mistakes: a change for each named stage."""
        new_changes = tuple(changes.items())
        all_changes, rotations = (*self.changes, *new_changes), self._row_rotations
        return StageResults(self.chain, self.arithmetic, all_changes, new_changes, self, _row_rotations=rotations)

    def without_changes_of(self, stage: str) -> "StageResults":
        """Return the stages of the same derivation without the mistakes in a stage."""
        remaining_changes = tuple((name, change) for name, change in self.changes if name != stage)
        return StageResults(self.chain, self.arithmetic, remaining_changes, _row_rotations=self._row_rotations)

    def compute_row_rotation(self, row: TableRow) -> np.ndarray:
        """Return the rotation Rz(theta) Rx(alpha) of a row, (3, 3, …); it is cached by the arrays theta and alpha."""
        key = (id(row.theta), id(row.alpha))
        if key not in self._row_rotations:  # the row is stored, too, so that no other arrays get these ids
            rotation = matrix_product(make_rotation_z(self, row.theta), make_rotation_x(self, row.alpha))
            self._row_rotations[key] = (row, rotation)
        return self._row_rotations[key][1]

    def keep_first_joints(self, joint_count: int) -> "StageResults":
        """Return the stages, with the same mistakes, of the arm of the first `joint_count` joints.

        The point of interest of that arm is the origin of its last frame.
        """
        if joint_count not in self._shortened_results:
            base_results = self.base_results and self.base_results.keep_first_joints(joint_count)
            chain = base_results.chain if base_results else convention_of(self.chain).keep_first_joints(joint_count)
            results = replace(self, chain=chain, base_results=base_results, _results={}, _shortened_results={})
            self._shortened_results[joint_count] = results
        return self._shortened_results[joint_count]

    def depends_on(self, stage: str) -> bool:
        """Return whether a result computed so far depends on a stage, including the results of `keep_first_joints`."""
        computed_stages = {name for stages in (self, *self._shortened_results.values()) for name in stages._results}
        return any(stage == name or stage in list_prerequisites(name) for name in computed_stages)

    @property
    def n(self) -> int:
        """The number of joints."""
        return self.chain.n

    def stack_symbol_values(self, names: Any) -> np.ndarray:
        """Return the values of symbols that are not joint variables as a vector (k, …)."""
        return np.stack([self.arithmetic.get_symbol_value(str(name)) for name in names])


def compute_numeric_stages(chain: Chain, values: Mapping[str, np.ndarray]) -> StageResults:
    """Return the correct stages in numbers; `values` maps the name of each symbol to its values (N,)."""
    return StageResults(chain, NumericArithmetic([q.name for q in chain.q], values))


def compute_tree_stages(chain: Chain) -> StageResults:
    """Return the correct stages in formula trees, the form in which students' answers are parsed."""
    return StageResults(chain, TreeArithmetic([q.name for q in chain.q]))


def compute_symbolic_stages(chain: Chain) -> StageResults:
    """Return the correct stages in SymPy expressions."""
    return StageResults(chain, SympyArithmetic([q.name for q in chain.q]))


# --- the functions that compute the stages ---


def _compute_table(stages: StageResults) -> Table:
    base, convert = stages.chain.base, stages.arithmetic.convert_entry
    rows = tuple(TableRow(j.kind, *map(convert, (j.theta, j.d, j.a, j.alpha))) for j in stages.chain.joints)
    base_position, point_offset = (np.stack([*map(convert, v)]) for v in (base.position, stages.chain.point.offset))
    return Table(rows, base_position, convert(base.yaw), convert(base.tilt), point_offset)


def make_rotation_z(stages: StageResults, angle: np.ndarray) -> np.ndarray:
    """Return the rotation about z by an angle, (3, 3, …)."""
    c, s = stages.arithmetic.cos(angle), stages.arithmetic.sin(angle)
    zero, unit = angle * 0, angle * 0 + 1
    return _make_matrix(c, -s, zero, s, c, zero, zero, zero, unit)


def make_rotation_x(stages: StageResults, angle: np.ndarray) -> np.ndarray:
    """Return the rotation about x by an angle, (3, 3, …)."""
    c, s = stages.arithmetic.cos(angle), stages.arithmetic.sin(angle)
    zero, unit = angle * 0, angle * 0 + 1
    return _make_matrix(unit, zero, zero, zero, c, -s, zero, s, c)


def _make_matrix(*entries: np.ndarray) -> np.ndarray:
    """Return the 3 x 3 matrix with these entries, given row by row."""
    return np.array(entries).reshape(3, 3, *entries[0].shape)


def _compute_base_rotation(stages: StageResults) -> np.ndarray:
    """Return the rotation R_0 of frame 0, (3, 3, …)."""
    table = stages["table"]
    return matrix_product(make_rotation_z(stages, table.base_yaw), make_rotation_x(stages, table.base_tilt))


def _compute_rotations(stages: StageResults) -> list[np.ndarray]:
    """Return the rotations R_0 ... R_n of the standard frames, each (3, 3, …)."""
    rotations = [stages["base rotation"]]
    for row in stages["table"].rows:
        rotations.append(matrix_product(rotations[-1], stages.compute_row_rotation(row)))
    return rotations


def _compute_local_links(stages: StageResults) -> list[np.ndarray]:
    """Return the link vectors r_i in frame i-1 (below (6.13)), and P in the coordinates of P's frame, each (3, …)."""
    cos, sin, table = stages.arithmetic.cos, stages.arithmetic.sin, stages["table"]
    vectors = [np.stack([row.a * cos(row.theta), row.a * sin(row.theta), row.d]) for row in table.rows]
    return [*vectors, table.point_offset]


def _compute_links(stages: StageResults) -> list[np.ndarray]:
    """Return the link vectors and the vector to P in the world frame, each (3, …)."""
    rotations, local_vectors = stages["rotations"], stages["local link vectors"]
    vectors = [apply_matrix(rotations[k], local_vectors[k]) for k in range(stages.n)]
    return [*vectors, apply_matrix(rotations[stages.chain.point.frame], local_vectors[stages.n])]


def list_links_to_point(chain: Chain) -> list[int]:
    """Return the indices of the link vectors (from 0) whose sum leads from O_0 to the point of interest."""
    return [*range(chain.point.frame), chain.n]


def _stack_without_derivatives(stages: StageResults, vectors: list[np.ndarray]) -> np.ndarray:
    """Return vectors without their derivatives as one array, (k, 3, …)."""
    return np.stack([stages.arithmetic.drop_derivatives(vector) for vector in vectors])


def _compute_origins(stages: StageResults) -> np.ndarray:
    """Return the origins O_0 ... O_n of the standard frames, (n + 1, 3, …)."""
    vectors = [stages["table"].base_position, *stages["link vectors"][:-1]]
    return np.cumsum(_stack_without_derivatives(stages, vectors), axis=0)


def _compute_point(stages: StageResults) -> np.ndarray:
    """Return the point of interest P, (3, …)."""
    base_position = stages.arithmetic.drop_derivatives(stages["table"].base_position)
    links = _stack_without_derivatives(stages, stages["link vectors"])[list_links_to_point(stages.chain)]
    return np.asarray(base_position + links.sum(axis=0))


def differentiate_links(stages: StageResults) -> np.ndarray:
    """Return the derivatives of the n + 1 link vectors with respect to the joint variables, (n, n + 1, 3, …)."""
    vectors, compute_derivatives = stages["link vectors"], stages.arithmetic.compute_derivatives
    return np.stack([compute_derivatives(vector)[: stages.n] for vector in vectors], axis=1)


def _compute_link_derivatives(stages: StageResults) -> np.ndarray:
    """Return the derivatives of the link vectors that lead to P; those of other link vectors are zero.

    So the derivatives of P are the sums over all link vectors.
    """
    derivatives = differentiate_links(stages)
    other_links = [k for k in range(stages.n + 1) if k not in list_links_to_point(stages.chain)]
    derivatives[:, other_links] = derivatives[:, other_links] * 0
    return derivatives


def _compute_origins_on_axes(stages: StageResults) -> np.ndarray:
    """Return the origin of the convention's frame on each joint axis, then that of the last frame, (n + 1, 3, …)."""
    if not convention_of(stages.chain).is_proximal:
        return np.asarray(stages["origins"])
    offsets = [row.d * rotation[:, 2] for row, rotation in zip(stages["table"].rows, stages["rotations"], strict=False)]
    origins = stages["origins"][: stages.n] + _stack_without_derivatives(stages, offsets)
    return np.concatenate([origins, origins[-1:]])


def compute_convention_rotation(stages: StageResults, frame: int) -> np.ndarray:
    """Return the rotation of the frame with a number (from 0) in the arm's convention, (3, 3, …)."""
    rotation, table = stages["rotations"][frame], stages["table"]
    if convention_of(stages.chain).is_proximal:  # in a modified table, the next row contains alpha
        alpha = table.rows[frame - 1].alpha if frame else table.base_tilt
        rotation = matrix_product(rotation, make_rotation_x(stages, -alpha))
    return np.asarray(stages.arithmetic.drop_derivatives(rotation))


def propagate_linear_rows(stages: StageResults, _: Any = None) -> np.ndarray:
    """Return the linear rows by propagation, (3, n, …): z x p* for a revolute joint, z for a prismatic joint (6.12).

    The function can replace the result of the stage "linear rows"; its second argument, this result, is ignored.
    """
    columns = []
    for i, kind in enumerate(stages["joint kinds"]):
        column = stages["cross products"][i] if kind == REVOLUTE else stages["axes"][i]
        columns.append(column if i < stages.chain.point.frame else column * 0)
    return np.stack(columns, axis=1)


def _compute_angular_rows(stages: StageResults) -> np.ndarray:
    """Return the angular rows, (3, n, …): z for a revolute joint, zero for a prismatic joint."""
    pairs = zip(stages["joint kinds"], stages["axes"], strict=False)
    return np.stack([axis if kind == REVOLUTE else axis * 0 for kind, axis in pairs], axis=1)


def _compute_inverse(stages: StageResults) -> np.ndarray:
    """Return the inverse of a square J, (n, n, …); its entries are not finite if J is singular."""
    with np.errstate(all="ignore"):
        return np.asarray(stages["adjugate"] / stages["determinant"])


def _compute_pseudo_inverse(stages: StageResults) -> np.ndarray:
    """Return J^T (J J^T)^-1, (n, task rows, …)."""
    gram = stages["gram matrix"]
    with np.errstate(all="ignore"):
        inverse = (cofactor_signs(len(gram))[..., None] * minors(gram)).swapaxes(0, 1) / determinant(gram)
    return matrix_product(stages["transposed jacobian"], inverse)


def _compute_self_motion(stages: StageResults) -> np.ndarray:
    """Return joint rates (n, …) that cause no motion, if J (m x n) has n = m + 1 columns, else nan.

    Rate i is the minor of J without column i, with alternating signs.
    """
    jacobian = stages["jacobian"]
    if jacobian.shape[1] != jacobian.shape[0] + 1:  # J has several independent self-motions, or none
        return np.asarray(jacobian[0] * np.nan)
    return np.stack([(-1) ** i * determinant(np.delete(jacobian, i, axis=1)) for i in range(stages.n)])


class SingularValueDecomposition(NamedTuple):
    """The singular value decomposition U diag(sigma) V^T of the m x n task Jacobian at N configurations.

    The shapes are (m, m, N), (min(m, n), N) and (n, n, N).
    """

    u: np.ndarray
    sigma: np.ndarray
    v_transposed: np.ndarray


def decompose_jacobian(stages: StageResults) -> SingularValueDecomposition:
    """Return the singular value decomposition of the task Jacobian."""
    u, sigma, v_transposed = np.linalg.svd(np.nan_to_num(np.moveaxis(stages["jacobian"], -1, 0).astype(float)))
    return SingularValueDecomposition(np.moveaxis(u, 0, -1), sigma.T, np.moveaxis(v_transposed, 0, -1))


def _compute_condition_number(stages: StageResults) -> np.ndarray:
    """Return the largest singular value of J divided by the smallest, (N,)."""
    sigma = decompose_jacobian(stages).sigma
    with np.errstate(all="ignore"):
        return np.asarray(sigma[0] / sigma[-1])


def _compute_wrist_block(stages: StageResults) -> np.ndarray:
    """Return the axes of joints 4, 5 and 6 in the convention's frame on the axis of joint 4, (3, 3, …)."""
    rotation = compute_convention_rotation(stages, convention_of(stages.chain).find_frame_on_axis(4)).swapaxes(0, 1)
    return np.stack([apply_matrix(rotation, stages["axes"][i]) for i in (3, 4, 5)], axis=1)


def rotate_rows(rotation: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """Return a Jacobian (6, n, …) with its three linear and its three angular rows rotated."""
    return np.concatenate([matrix_product(rotation, jacobian[:3]), matrix_product(rotation, jacobian[3:])])


def _compute_home_screws(stages: StageResults) -> np.ndarray:
    """Return the screws (omega, v) of the joints at home, (6, n, …)."""
    columns = []
    for axis in compute_home_geometry(stages.chain).axes:
        direction, point = convert_constant_vector(stages, axis.direction), convert_constant_vector(stages, axis.point)
        screw = [direction, -cross(direction, point)] if axis.is_revolute else [0 * direction, direction]
        columns.append(np.concatenate(screw))
    return np.stack(columns, axis=1)


def convert_constant_vector(stages: StageResults, vector: sp.Matrix) -> np.ndarray:
    """Return a vector of formulas without joint variables as values of the arithmetic, (3, …)."""
    return np.stack([stages.arithmetic.drop_derivatives(stages.arithmetic.convert_entry(entry)) for entry in vector])


def _compute_space_jacobian(stages: StageResults) -> np.ndarray:
    """Return the space Jacobian, the joints' twists (omega, v) with v at the world's origin, (6, n, …)."""
    columns = []
    for i, kind in enumerate(stages["joint kinds"]):
        z, origin = stages["axes"][i], stages["origins"][i]
        columns.append(np.concatenate([z, cross(origin, z)] if kind == REVOLUTE else [0 * z, z]))
    return np.stack(columns, axis=1)


def _compute_body_rotation(stages: StageResults) -> np.ndarray:
    """Return the rotation of the body frame, (3, 3, …).

    The body frame moves with the last link. At home it has the directions of the world frame.
    """
    last_frame = compute_frames_and_point(stages.chain).frames[-1]
    rotation_at_home = last_frame.rotation.xreplace(dict.fromkeys(stages.chain.q, sp.S.Zero))
    transpose_at_home = np.stack([convert_constant_vector(stages, rotation_at_home[:, k]) for k in range(3)])
    return matrix_product(stages.arithmetic.drop_derivatives(stages["rotations"][-1]), transpose_at_home)


def _compute_body_jacobian(stages: StageResults) -> np.ndarray:
    """Return the body Jacobian [Ad T^-1] J_s, (6, n, …): twists with v at P, in the coordinates of the body frame."""
    angular_rows, linear_rows = stages["space jacobian"][:3], stages["space jacobian"][3:]
    twists_about_point = np.concatenate([angular_rows, linear_rows + cross(angular_rows, stages["point"][:, None])])
    return rotate_rows(stages["body rotation"].swapaxes(0, 1), twists_about_point)


def make_adjoint_matrix(rotation: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return [Ad T] (6, 6, …) for twists (omega, v), given the rotation (3, 3, …) and the origin (3, …) of T."""
    blocks = [[rotation, 0 * rotation], [cross(origin[:, None], rotation), rotation]]
    return np.concatenate([np.concatenate(row, axis=1) for row in blocks])


class Stage(NamedTuple):
    """The function that computes the result of a stage, and the stages whose results this function uses."""

    compute_result: Callable[[StageResults], Any]
    direct_prerequisites: tuple[str, ...]


STAGES: dict[str, Stage] = {
    "length unit": Stage(lambda stages: stages.arithmetic.make_constant(sp.S.One), ()),
    "table": Stage(_compute_table, ()),
    "base rotation": Stage(_compute_base_rotation, ("table",)),
    "rotations": Stage(_compute_rotations, ("table", "base rotation")),
    "local link vectors": Stage(_compute_local_links, ("table",)),
    "link vectors": Stage(_compute_links, ("rotations", "local link vectors")),
    "origins": Stage(_compute_origins, ("link vectors",)),
    "point": Stage(_compute_point, ("link vectors",)),
    "link derivatives": Stage(_compute_link_derivatives, ("link vectors",)),
    "axes": Stage(
        lambda stages: _stack_without_derivatives(stages, [rotation[:, 2] for rotation in stages["rotations"]]),
        ("rotations",),
    ),
    "origins on axes": Stage(_compute_origins_on_axes, ("table", "origins", "rotations")),
    "vectors to point": Stage(lambda stages: stages["point"] - stages["origins on axes"], ("point", "origins on axes")),
    "last rotation": Stage(lambda stages: compute_convention_rotation(stages, stages.n), ("rotations", "table")),
    "last origin": Stage(lambda stages: stages["origins on axes"][-1], ("origins on axes",)),
    "joint kinds": Stage(lambda stages: [row.kind for row in stages["table"].rows], ("table",)),
    "cross products": Stage(
        lambda stages: [cross(stages["axes"][i], stages["vectors to point"][i]) for i in range(stages.n)],
        ("axes", "vectors to point"),
    ),
    "linear rows": Stage(
        lambda stages: np.moveaxis(stages["link derivatives"].sum(axis=1), 0, 1),
        ("link derivatives", "cross products", "axes", "joint kinds"),
    ),
    "angular rows": Stage(_compute_angular_rows, ("axes", "joint kinds")),
    "geometric jacobian": Stage(
        lambda stages: np.concatenate([stages["linear rows"], stages["angular rows"]]),
        ("linear rows", "angular rows"),
    ),
    "tool jacobian": Stage(
        lambda stages: rotate_rows(stages["last rotation"].swapaxes(0, 1), stages["geometric jacobian"]),
        ("last rotation", "geometric jacobian"),
    ),
    "home screws": Stage(_compute_home_screws, ()),
    "space jacobian": Stage(_compute_space_jacobian, ("axes", "origins", "joint kinds")),
    "body rotation": Stage(_compute_body_rotation, ("rotations",)),
    "body adjoint": Stage(
        lambda stages: make_adjoint_matrix(stages["body rotation"], stages["point"]),
        ("body rotation", "point"),
    ),
    "body jacobian": Stage(_compute_body_jacobian, ("space jacobian", "body rotation", "point")),
    "arm block": Stage(lambda stages: stages["geometric jacobian"][:3, :3], ("geometric jacobian",)),
    "wrist block": Stage(_compute_wrist_block, ("rotations", "axes")),
    "jacobian": Stage(lambda stages: stages["geometric jacobian"][stages.chain.task_rows], ("geometric jacobian",)),
    "transposed jacobian": Stage(lambda stages: stages["jacobian"].swapaxes(0, 1), ("jacobian",)),
    "gram matrix": Stage(
        lambda stages: matrix_product(stages["jacobian"], stages["transposed jacobian"]),
        ("transposed jacobian",),
    ),
    "pseudo-inverse": Stage(_compute_pseudo_inverse, ("gram matrix", "transposed jacobian")),
    "self-motion": Stage(_compute_self_motion, ("jacobian",)),
    "lost direction": Stage(lambda stages: decompose_jacobian(stages).u[:, -1], ("jacobian",)),
    "gram determinant": Stage(lambda stages: determinant(stages["gram matrix"]), ("gram matrix",)),
    "manipulability": Stage(lambda stages: stages.arithmetic.sqrt(stages["gram determinant"]), ("gram determinant",)),
    "condition number": Stage(_compute_condition_number, ("jacobian",)),
    "minors": Stage(lambda stages: minors(stages["jacobian"]), ("jacobian",)),
    "cofactors": Stage(lambda stages: cofactor_signs(stages.n)[..., None] * stages["minors"], ("minors",)),
    "adjugate": Stage(lambda stages: stages["cofactors"].swapaxes(0, 1), ("cofactors",)),
    "determinant": Stage(lambda stages: determinant(stages["jacobian"]), ("jacobian",)),
    "inverse": Stage(_compute_inverse, ("adjugate", "determinant")),
    "wanted velocity": Stage(lambda stages: stages.stack_symbol_values(stages.chain.task), ()),
    "joint rates": Stage(lambda stages: stages.stack_symbol_values(stages.chain.rates), ()),
    "required rates": Stage(
        lambda stages: apply_matrix(stages["inverse"], stages["wanted velocity"]),
        ("inverse", "wanted velocity"),
    ),
}
"""The stages by name.

"linear rows" is normally computed from "link derivatives" alone. A mistake may replace its result by
`propagate_linear_rows`, which uses the other stages. "length unit" is 1, unless a mistake changes the unit of lengths.
"""


@cache
def list_prerequisites(stage: str) -> frozenset[str]:
    """Return all stages on which a stage depends, directly or indirectly."""
    direct_prerequisites = STAGES[stage].direct_prerequisites
    return frozenset(direct_prerequisites).union(*map(list_prerequisites, direct_prerequisites))


def to_sympy_matrix(values: np.ndarray) -> sp.Matrix:
    """Convert the values (rows, columns, 1) of SympyArithmetic to a SymPy matrix; a scalar becomes a 1 x 1 matrix."""
    return sp.Matrix(list_rows(values))
