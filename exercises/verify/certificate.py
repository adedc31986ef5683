"""Certify a problem: test every reference by methods that are independent of its derivation."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.standard_table import compute_home_geometry
from qdot.exercises.common.json_form import to_jsonable
from qdot.exercises.formula.trees import ParseError, find_names
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.record import Digests, compute_digests
from qdot.exercises.verify import concepts, formulas, numbers, path, rank, screws, short_questions, singular
from qdot.exercises.verify.custom import check_custom
from qdot.exercises.verify.formulas import PartCheck
from qdot.exercises.verify.numeric_model import Check, Checks, NumericModel


@dataclass(frozen=True)
class ProblemCertificate:
    """The outcomes of the tests of a problem, and the digests (short hashes) that identify its content."""

    problem: ProblemId
    engine: int
    checks: tuple[Check, ...]
    digests: Digests

    def __repr__(self) -> str:
        outcome = "passed" if self.passed else f"{len(self.failures)} failed"
        return f"ProblemCertificate({self.problem}: {len(self.checks)} checks, {outcome})"

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check.passed)

    def as_json(self) -> dict[str, Any]:
        """Return the certificate in the form that `show` prints."""
        checks = [check._asdict() for check in self.checks]
        identity = {"problem": str(self.problem), "engine": self.engine, **to_jsonable(self.digests)}
        return {**identity, "passed": self.passed, "checks": checks}


def certify(problem: Problem) -> ProblemCertificate:
    """Test every reference answer of a problem, and return the certificate, which fails if a question has no test.

    >>> from qdot import generate
    >>> certify(generate("planar-2r/7", ["determinant"])).passed
    True
    """
    model = NumericModel(problem)
    failing_check = _make_failing_check("CONVENTION_CHECKS", "convention")
    check_convention = CONVENTION_CHECKS.get(problem.chain.convention) or failing_check
    checks = [_check_symbols(problem.chain), _check_full_rank(model), *check_convention(model)]
    for part in problem.parts:
        checks.append(_check_parsable(model, part))
        if checks[-1].passed:
            check_of_kind = CHECKS.get(part.kind) or _make_failing_check("CHECKS", "kind of question")
            check = check_of_kind if part.details.question is None else check_custom
            checks += [Check(f"{part.name}: {name}", passed, detail) for name, passed, detail in check(model, part)]
    return ProblemCertificate(problem.id, problem.id.engine, tuple(checks), compute_digests(problem))


def _make_failing_check(table: str, subject: str) -> Callable[..., Checks]:
    """Return a check that fails because a table of tests in this package has no entry for the subject."""
    detail = f"nothing in qdot.exercises.verify.certificate.{table} tests this {subject}"
    return lambda *_: iter([Check("known", False, detail)])


def _check_symbols(chain: Chain) -> Check:
    """Check that no symbol has two meanings; for example, a length of link 3 must not be called a1."""
    reserved_names = {symbol.name for symbol in (*chain.q, *chain.rates)} | set(VELOCITY_NAMES)
    ambiguous_names = sorted(symbol.name for symbol in chain.parameters if symbol.name in reserved_names)
    # An arm described by its axes at home shows no table.
    for symbol in chain.parameters if convention_of(chain).shows_table else ():
        match = re.fullmatch(r"([ad])([1-9]\d*)", symbol.name)
        if match and int(match.group(2)) <= chain.n:
            joint = chain.joints[int(match.group(2)) - 1]
            entry = joint.a if match.group(1) == "a" else joint.d
            if entry != 0 and not entry.has(symbol):
                ambiguous_names.append(symbol.name)
    detail = f"{', '.join(ambiguous_names)} stands for two things" if ambiguous_names else "each has one meaning"
    return Check("symbols", not ambiguous_names, detail)


FULL_RANK = "full rank"
"""The name of the check that fails if the arm can't control all components of its task."""


def _check_full_rank(model: NumericModel) -> Check:
    """Check that J has full rank at some configuration: otherwise the arm is singular everywhere."""
    chain, jacobian = model.chain, model.exponential_jacobian
    sigma = np.linalg.svd(jacobian[:, model.task_rows], compute_uv=False)
    rank_found = int((sigma > rank.ZERO_RATIO * np.linalg.norm(jacobian, axis=(1, 2))[:, None]).sum(axis=1).max())
    full_rank = min(len(chain.task), chain.n)
    detail = f"J for the task {', '.join(chain.task)} has rank {rank_found}"
    if rank_found < full_rank:
        detail += f" of {full_rank}, whatever the configuration"
    return Check(FULL_RANK, rank_found == full_rank, detail)


_check_exactly = partial(formulas.check_agreement, tolerance=formulas.EXACT_TOLERANCE)


def _check_modified_table(model: NumericModel) -> Checks:
    """Check that a modified DH table gives the same joint axes and tool point as the standard table."""
    chain = model.chain
    standard_axes, convention_axes = model.frames[:, : chain.n, :3, 2], model.convention_frames[:, 1:, :3, 2]
    point = convention_of(chain).point
    pose = model.convention_frames[:, point.frame]
    offset = model.evaluate_constants(sp.Matrix(point.offset))
    convention_point = pose[:, :3, 3] + np.einsum("kij,kj->ki", pose[:, :3, :3], offset)
    yield _check_exactly("modified table: axes", convention_axes, standard_axes)
    yield _check_exactly("modified table: point", convention_point[:, None], model.point[:, None])


def _check_axes_at_home(model: NumericModel) -> Checks:
    """Check the stated directions of the axes, the points on the axes, and P at home, against the frames at home."""
    axes, point = compute_home_geometry(model.chain)
    z, origins = model.home_frames[:, :-1, :3, 2], model.home_frames[:, :-1, :3, 3]
    directions = np.stack([model.evaluate_constants(axis.direction) for axis in axes], axis=1)
    yield _check_exactly("axes at home: directions", directions, z)
    revolute_joints = [i for i, axis in enumerate(axes) if axis.is_revolute]
    if revolute_joints:
        points = np.stack([model.evaluate_constants(axes[i].point) for i in revolute_joints], axis=1)
        distances = np.cross(points - origins[:, revolute_joints], z[:, revolute_joints])
        yield _check_exactly("axes at home: points on them", distances, 0 * distances)
    home_point = model.evaluate_constants(point)[:, None]
    yield _check_exactly("axes at home: P", home_point, model.point_at_home[:, None])


CONVENTION_CHECKS: dict[str, Callable[[NumericModel], Checks]] = {
    "dh": lambda _: iter(()),  # this convention presents the standard table itself
    "modified-dh": _check_modified_table,
    "screws": _check_axes_at_home,
}
"""Maps each convention to the check that compares the arm, as the convention presents it, with the standard table.

An arm in a convention without a check can't be certified."""


def _check_parsable(model: NumericModel, part: Part) -> Check:
    """Check that every formula of the reference can be parsed, and that it contains only symbols of the problem."""
    name, known_names = f"{part.name}: readable", set(model.symbol_names)
    if part.answer.is_set:  # the formulas of a set contain only joint variables and lengths
        known_names = {symbol.name for symbol in (*model.chain.q, *model.chain.parameters)}
    try:
        used_names = set().union(*(find_names(model.parse(text)) for text in part.answer.list_formulas()))
    except ParseError as error:
        return Check(name, False, str(error))
    if unknown_names := used_names - known_names:
        return Check(name, False, f"{', '.join(sorted(unknown_names))} is not a symbol of the problem")
    return Check(name, True, "it can be parsed and contains only symbols of the problem")


CHECKS: dict[str, PartCheck] = {
    kind: check
    for module in (formulas, numbers, singular, screws, path, rank, concepts, short_questions)
    for kind, check in module.CHECKS.items()
}
"""Maps each kind of question to its test; a question without a test can't be certified."""
