"""Certify problems: every reference is tested against the arm in numbers, by ways it was not derived by.

The references come from symbolic algebra on a structure (`derivation`). Here they are read back from their text, as
an answer is, evaluated at random places and held against products of 4 x 4 matrices, finite differences of the poses
and NumPy's linear algebra. A singular set is tested both ways: at every piece of it the rank is less, and every
configuration of less rank that Newton's method finds lies in it.

Beside the tests of questions, which stand in `CHECKS` below:

    numeric_reference   the arm in numbers, by 4 x 4 products and finite differences
    exponentials        the Jacobian by the product of exponentials
    appearance          what a worked solution says of singular configurations, by moving joints
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, Chain
from qdot.exercises.arm.conventions import convention_of
from qdot.exercises.arm.standard_table import axes_of
from qdot.exercises.formula.trees import Node, ReadError, names
from qdot.exercises.problem.problem import Part, Problem, ProblemId
from qdot.exercises.problem.record import digests
from qdot.exercises.verify import (
    concepts,
    formulas,
    path,
    performance,
    quizzes,
    rank,
    redundancy,
    screws,
    singular,
    statics,
    transforms,
    wrist,
)
from qdot.exercises.verify.numeric_reference import Check, NumericReference


@dataclass(frozen=True)
class ProblemCertificate:
    """What was tested of a problem, how it came out, and by what the problem is known again (`record`)."""

    problem: ProblemId
    engine: int
    checks: tuple[Check, ...]
    digests: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        how = "passed" if self.passed else f"{len(self.failures)} failed"
        return f"ProblemCertificate({self.problem}: {len(self.checks)} checks, {how})"

    @property
    def passed(self) -> bool:
        """Whether every check held."""
        return all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        """The checks that did not hold."""
        return tuple(check for check in self.checks if not check.passed)

    def as_json(self) -> dict[str, Any]:
        """Return the form in which `show` prints it."""
        checks = [check._asdict() for check in self.checks]
        return {
            "problem": str(self.problem), "engine": self.engine, **self.digests, "passed": self.passed, "checks": checks
        }  # fmt: skip


def certify(problem: Problem) -> ProblemCertificate:
    """Test every reference of a problem; a question for which there is no test here fails, too.

    >>> from qdot import generate
    >>> certify(generate("planar-2r/7", ["determinant"])).passed
    True
    """
    numeric = NumericReference(problem)
    checks = [_one_meaning(problem.chain), _full_rank(numeric), *_told(numeric)]
    for part in problem.parts:
        checks.append(_readable(numeric, part))
        if checks[-1].passed:
            checks += [Check(f"{part.name}: {name}", held, detail) for name, held, detail in _checks_of(numeric, part)]
    return ProblemCertificate(problem.id, problem.id.engine, tuple(checks), digests(problem))


def _checks_of(numeric: "NumericReference", part: Part) -> Iterator[Check]:
    known = CHECKS.get(part.kind)
    if known is None:
        yield Check("known", False, "nothing in qdot.exercises.verify.CHECKS tests this kind of question")
    else:
        yield from known(numeric, part)


def _one_meaning(chain: Chain) -> Check:
    """Look for a symbol that stands for two things, as a length named after another entry of the table does."""
    taken = {symbol.name for symbol in (*chain.q, *chain.rates)} | set(TASK_ROWS)
    twice = sorted(symbol.name for symbol in chain.parameters if symbol.name in taken)
    for symbol in () if not convention_of(chain).has_frames else chain.parameters:  # who is told axes sees no table
        match = re.fullmatch(r"([ad])([1-9]\d*)", symbol.name)
        if match and int(match.group(2)) <= chain.n:
            joint = chain.joints[int(match.group(2)) - 1]
            own = joint.a if match.group(1) == "a" else joint.d
            if own != 0 and not own.has(symbol):
                twice.append(symbol.name)
    return Check("symbols", not twice, f"{', '.join(twice)} stands for two things" if twice else "each has one meaning")


FULL_RANK = "full rank"
"""The check that an arm fails whose task is not one for it."""


def _full_rank(numeric: NumericReference) -> Check:
    """Look for a place of full rank: without one, the arm is singular everywhere, and there is little to be asked."""
    chain, jacobian = numeric.chain, numeric.exponential_jacobian
    sigma = np.linalg.svd(jacobian[:, numeric.task], compute_uv=False)
    largest = int((sigma > rank.GONE * np.linalg.norm(jacobian, axis=(1, 2))[:, None]).sum(axis=1).max())
    full = min(len(chain.task), chain.n)
    said = f"J for the task {', '.join(chain.task)} has rank {largest}"
    return Check(
        FULL_RANK, largest == full, said if largest == full else f"{said} of {full}, whatever the configuration"
    )


def _nothing(_: NumericReference) -> Iterator[Check]:
    """Check nothing of the standard table, from which all is derived."""
    yield from ()


def _told(numeric: NumericReference) -> Iterator[Check]:
    """Look whether what the statement tells leads where the standard table does, from which all is derived."""
    known = PRESENTED.get(numeric.chain.convention)
    if known is None:
        yield Check("known", False, "nothing in qdot.exercises.verify.PRESENTED tests this convention")
    else:
        yield from known(numeric)


def _told_by_table(numeric: NumericReference) -> Iterator[Check]:
    """Multiply the rows of a modified table, and look for axes and point elsewhere."""
    chain = numeric.chain
    ours, told = numeric.frames[:, : chain.n, :3, 2], numeric.told[:, 1:, :3, 2]
    point = convention_of(chain).point
    pose, offset = numeric.told[:, point.frame], numeric.numbers(sp.Matrix(point.offset))
    there = pose[:, :3, 3] + np.einsum("kij,kj->ki", pose[:, :3, :3], offset)
    yield formulas.agree("modified table: axes", told, ours, formulas.EXACT)
    yield formulas.agree("modified table: point", there[:, None], numeric.point[:, None], formulas.EXACT)


def _told_by_axes(numeric: NumericReference) -> Iterator[Check]:
    """Hold directions, points on axes and P at home against 4 x 4 products where all joint variables are zero."""
    axes, point = axes_of(numeric.chain)
    z, origins = numeric.home[:, :-1, :3, 2], numeric.home[:, :-1, :3, 3]
    told = np.stack([numeric.numbers(axis.direction) for axis in axes], axis=1)
    yield formulas.agree("axes at home: directions", told, z, formulas.EXACT)
    turning = [i for i, axis in enumerate(axes) if axis.kind == "R"]
    if turning:
        away = np.stack([numeric.numbers(axes[i].point) for i in turning], axis=1) - origins[:, turning]
        off = np.cross(away, z[:, turning])
        yield formulas.agree("axes at home: points on them", off, 0 * off, formulas.EXACT)
    yield formulas.agree(
        "axes at home: P", numeric.numbers(point)[:, None], numeric.point_at_home[:, None], formulas.EXACT
    )


PRESENTED: dict[str, Callable[[NumericReference], Iterator[Check]]] = {
    "dh": _nothing, "modified-dh": _told_by_table, "screws": _told_by_axes,
}  # fmt: skip
"""What holds the arm as a convention presents it against the standard table; without it, nothing is certified."""


def _trees(numeric: NumericReference, part: Part) -> list[Node]:
    return [numeric.tree(text) for text in part.answer.formulas()]


def _usable(numeric: NumericReference, part: Part) -> set[str]:
    """Return the symbols that a part may use: all of the problem's; joints and lengths in conditions on them."""
    if part.answer.is_a_set:
        return {symbol.name for symbol in (*numeric.chain.q, *numeric.chain.parameters)}
    return set(numeric.known)


def _readable(numeric: NumericReference, part: Part) -> Check:
    """Read every text of the reference as an answer is read, and look for symbols that the problem does not have."""
    name = f"{part.name}: readable"
    try:
        strange = set[str]().union(*map(names, _trees(numeric, part))) - _usable(numeric, part)
    except ReadError as error:
        return Check(name, False, str(error))
    if strange:
        return Check(name, False, f"{', '.join(sorted(strange))} is no symbol of the problem")
    return Check(name, True, "its text is understood, and holds the problem's symbols only")


CHECKS: dict[str, Callable[[NumericReference, Part], Iterator[Check]]] = {
    kind: check
    for module in (
        formulas, singular, transforms, screws, wrist, redundancy, path, rank, concepts, statics, performance,
        quizzes,
    )
    for kind, check in module.CHECKS.items()
}  # fmt: skip
"""The test of each kind of question; one that is not here can't be certified."""
