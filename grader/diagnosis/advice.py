"""What to look at in a wrong answer that no mistake of the catalogue gives: what a teacher would ask first.

Each remark is true of the answer, as it was compared with the right one in numbers, and gives no part of that away: a
factor that is the same everywhere, units, a joint on which it should or should not depend, a pose that is easily drawn.
"""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np

from qdot.exercises.arm.derivation_graph import numbers
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.conditions import Space, compare_sets
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.set_parser import parse_claims, parse_pieces
from qdot.exercises.formula.trees import ReadError, names
from qdot.exercises.mistakes.configurations import Values, sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_derived, result
from qdot.grader.diagnosis.formula_mistakes import in_words
from qdot.grader.diagnosis.numbers import unit
from qdot.grader.judging.answer import ParsedAnswer, with_joint
from qdot.grader.judging.verdict import Diagnosis

POINTS = 5
BASE_UNITS = ("N", "m", "s")
UNITS = {
    "rad": (0, 0, 0), "m": (0, 1, 0), "rad/s": (0, 0, -1), "m/s": (0, 1, -1), "N": (1, 0, 0), "N m": (1, 1, 0),
}  # fmt: skip
"""Powers of the BASE_UNITS in the units that symbols have."""
PRECISE = 1e-3
"""How near a single number has to be to a known factor."""
SAME = 1e-7
FACTORS = {
    2.0: "by the factor 2",
    100.0: "by the factor 100, as between metres and centimetres",
    1000.0: "by the factor 1000, as between metres and millimetres",
    180 / np.pi: "by the factor between degrees and radians",
    2 * np.pi: "by the factor 2 pi, as between turns and radians",
}
"""What is said of a factor between an answer and the right one, or one over it."""
AGAIN = "Work it out again step by step, and look at each number that you took from the problem."
EASY = (0.0, np.pi / 2, np.pi / 6)
MOST_POSES = 81


def advise(problem: Problem, part: Part, given: ParsedAnswer, seed: str = "") -> Diagnosis | None:
    """Return what to look at in a wrong answer that was read; nothing where it is a letter, or text that is none."""
    if part.answer.is_a_set:
        says = _of_set(problem, part, given, seed)
    elif given.rows is None or any(given.blanks):
        says = None
    elif not is_derived(part):
        says = _of_numbers(part, given) if part.type == "number" else None
    else:
        says = _of_formulas(problem, part, given, seed)
    return None if says is None else Diagnosis((), says)


def _of_numbers(part: Part, given: ParsedAnswer) -> str | None:
    """Look at the factor between numbers that come out of no derivation and those that are due."""
    try:
        mine = evaluate(compile_program(list(given.entries)), {}, 1)[0]
    except (KeyError, ReadError):  # names among the numbers
        return None
    if all(entry.is_Integer for entry in part.answer.as_matrix()):  # as a rank, which is counted
        return AGAIN
    right = np.array([complex(entry) for entry in part.answer.as_matrix()])[:, None]
    return next(_ratio(mine, right, 5e-3), AGAIN)


def _of_formulas(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> str | None:
    values = sample_configurations(problem.chain, part, problem.domain(), POINTS, Stream(f"{seed}/advice"))
    if given.symbols - set(values):
        return None
    look = _Look(problem, part, given)
    try:
        if look.mine(values).shape != look.right(values).shape:
            return None  # the reason tells it
        remarks = (one for remark in (_factor, _units, _joints, _easy_pose) for one in remark(look, values))
        return next(remarks, None)
    except ReadError:
        return None


class _Look:
    """An answer and the right one, evaluated side by side."""

    def __init__(self, problem: Problem, part: Part, given: ParsedAnswer) -> None:
        self.chain, self.part, self.symbols = problem.chain, part, problem.symbols()
        self.program = compile_program(list(given.entries))

    def mine(self, values: Values) -> np.ndarray:
        """Return the answer, (entries, N); a direction up to its factor."""
        with np.errstate(all="ignore"):
            return self._counted(np.asarray(evaluate(self.program, values, len(next(iter(values.values()))))[0]))

    def right(self, values: Values) -> np.ndarray:
        """Return what is expected, (entries, N); a direction up to its factor."""
        expected = result(numbers(self.chain, values), self.part)
        return self._counted(np.asarray(expected.reshape(-1, expected.shape[-1])))

    def _counted(self, entries: np.ndarray) -> np.ndarray:
        """Return what counts: of a direction, the products of the entries of its unit vector, which have no sign."""
        if not self.part.answer.counts_up_to_a_factor:
            return entries
        direction = unit(entries)
        return (direction[:, None] * direction[None]).reshape(-1, entries.shape[-1])

    def unit_of(self, name: str) -> tuple[int, ...]:
        """Return the powers of the BASE_UNITS in the unit of a symbol."""
        return UNITS[self.symbols[name].unit] if name in self.symbols else UNITS["rad"]


def _factor(look: _Look, values: Values) -> Iterator[str]:
    room = 5e-3 if look.part.answer.is_in_numbers else SAME
    yield from _ratio(look.mine(values), look.right(values), room)


def _ratio(mine: np.ndarray, right: np.ndarray, room: float) -> Iterator[str]:
    if mine.shape != right.shape:
        return
    counted = np.abs(right) > SAME * np.abs(right).max(initial=0.0)
    if not counted.any() or (np.abs(mine[~counted]) > SAME).any():
        return
    ratios = mine[counted] / right[counted]
    factor = float(ratios[0].real)
    if not np.isfinite(ratios).all() or (np.abs(ratios - factor) > room * abs(factor)).any() or factor in (0.0, 1.0):
        return
    if len(ratios) == 1:  # a single number is some factor off in any case
        room = PRECISE
    for known, words in FACTORS.items():
        for of in (known, 1 / known):
            if abs(factor / of - 1) < room:
                yield f"All numbers are too {'large' if of > 1 else 'small'} {words}."
    if len(ratios) > 1 and np.ptp(right[counted].real) > SAME:
        yield (
            "Everything is wrong by one and the same factor: look for a unit, a root or a square, a common factor, or "
            "a vector that is to have length 1."
        )


def _units(look: _Look, values: Values) -> Iterator[str]:
    """Look at the units of an answer in formulas, if none of the lengths is a number; zero has every unit."""
    chain, details = look.chain, look.part.details
    if look.part.answer.is_in_numbers or look.part.answer.counts_up_to_a_factor or details.given_joints:
        return
    numeric = [entry for joint in chain.joints for entry in (joint.a, joint.d)] + [
        *chain.point.offset,
        *chain.base.position,
    ]
    if any(entry.is_number and entry != 0 for entry in numeric) or any(
        offset != 0 and joint.kind == "P" for offset, joint in zip(chain.offsets, chain.joints, strict=True)
    ):
        return
    mine, right = look.mine(values), look.right(values)
    if mine.shape != right.shape:
        return
    units, expected = [], []
    for base in range(len(BASE_UNITS)):
        larger = {name: value * 2.0 ** look.unit_of(name)[base] for name, value in values.items()}
        units.append(_powers(mine, look.mine(larger)))
        expected.append(_powers(right, look.right(larger)))
    rows, columns = look.part.shape or (1, 1)
    for index, (powers, due) in enumerate(zip(zip(*units, strict=True), zip(*expected, strict=True), strict=True)):
        if None in powers or None in due or MIXED in due or powers == due:  # None of what is zero, or no number
            continue
        where = in_words([divmod(index, columns)], (rows, columns))
        if MIXED in powers:
            yield f"{where} terms with different units seem to be added, or a length stands in an angle or an exponent."
        else:
            yield f"{where} every term has {_unit(powers)}, and {_unit(due)} is expected."
        return


MIXED = "mixed"
"""The power of a unit in a sum of terms with different ones."""


def _powers(before: np.ndarray, after: np.ndarray) -> list[int | str | None]:
    """Return the power with which each entry grows when a unit is halved; None if it is zero, or no number."""
    powers = list[int | str | None]()
    for smaller, larger in zip(before, after, strict=True):
        with np.errstate(all="ignore"):
            power = np.log2(np.abs(larger / smaller))
        if not np.isfinite(power).all():
            powers.append(None)
        else:
            is_same = np.abs(power - np.round(power[0])).max() < 1e-6
            powers.append(int(np.round(power[0])) if is_same else MIXED)
    return powers


def _unit(powers: Sequence[int | str | None]) -> str:
    """Return a unit in words.

    >>> _unit((0, 2, 0)), _unit((0, 1, -1)), _unit((0, 0, -1)), _unit((0, 0, 0))
    ('the unit m^2', 'the unit m/s', 'the unit 1/s', 'no unit')
    """
    known = [(name, power) for name, power in zip(BASE_UNITS, powers, strict=True) if isinstance(power, int)]
    above, below = (
        [name if abs(power) == 1 else f"{name}^{abs(power)}" for name, power in known if power * sign > 0]
        for sign in (1, -1)
    )
    text = "/".join([" ".join(above) or "1", *below])
    return "no unit" if text == "1" else f"the unit {text}"


def _joints(look: _Look, values: Values) -> Iterator[str]:
    mine, right = look.mine(values), look.right(values)
    if mine.shape != right.shape:
        return
    for i, q in enumerate(look.chain.q, 1):
        if look.part.details.given_values(look.chain) or q in look.part.details.given_joints:
            return
        moved = {**values, q.name: values[q.name] + 0.37}
        mine_moves = _differs(look.mine(moved), mine)
        right_moves = _differs(look.right(moved), right)
        if right_moves and not mine_moves:
            yield f"Your answer does not change with {q}. Move joint {i} alone: does nothing of what is asked change?"
            return
        if mine_moves and not right_moves:
            yield f"Your answer changes with {q}. Move joint {i} alone, and look at what is asked: it stays as it is."
            return


def _differs(one: np.ndarray, other: np.ndarray) -> bool:
    with np.errstate(all="ignore"):
        return bool((np.abs(one - other) > SAME * (1 + np.abs(other))).any())


def _easy_pose(look: _Look, values: Values) -> Iterator[str]:
    """Find a pose of right angles in which the answer differs, and tell its value there."""
    chain, details = look.chain, look.part.details
    if details.given_values(chain) or details.given_joints:
        yield "Work the numbers out again step by step, and put the result back into the equation that it comes from."
        return
    turning = [q for q, joint in zip(chain.q, chain.joints, strict=True) if joint.kind == "R"]
    one = {name: value[:1] for name, value in values.items()}
    for angles in list(product(EASY, repeat=len(turning)))[:MOST_POSES]:
        pose = {**one, **{q.name: np.array([angle]) for q, angle in zip(turning, angles, strict=True)}}
        mine, right = look.mine(pose), look.right(pose)
        wrong = np.flatnonzero(~(np.abs(mine - right)[:, 0] <= SAME * (1 + np.abs(right)[:, 0])))
        if mine.shape == right.shape and len(wrong) and np.isfinite(right).all():
            said = ", ".join(f"{q} = {round(np.degrees(angle))}°" for q, angle in zip(turning, angles, strict=True))
            where = _entry(look.part, int(wrong[0]))
            yield f"Draw the arm at {said or 'any place'} and work out {where} there by hand: your answer differs."
            return
    yield "Put numbers in for one pose that is easy to draw, and compare term by term with the drawing."


def _entry(part: Part, index: int) -> str:
    if part.shape is None or part.shape == (1, 1) or part.answer.counts_up_to_a_factor:
        return "what is asked"
    rows, columns = part.shape
    return f"entry {index + 1}" if 1 in (rows, columns) else f"row {index // columns + 1}, column {index % columns + 1}"


def _of_set(problem: Problem, part: Part, given: ParsedAnswer, seed: str) -> str | None:
    """Look at which joints a set speaks of, and then at what each value makes of J."""
    if given.refusal is not None or given.tree is None:
        return None
    components = singular_set(problem.chain) or ()
    due = {q.name for component in components for c in component.conditions for q in c.free_symbols}
    joints = [q.name for q in problem.chain.q]
    own = names(given.tree) & set(joints)
    for name in joints:
        if name in due and name not in own:
            return f"Nothing is said of {name}. Do the zeros of the determinant (or of all minors) depend on it?"
        if name in own and name not in due:
            return (
                f"Something is said of {name}. Put its value into the determinant (or the minors): are they zero then, "
                "whatever the other joints are?"
            )
    together = any(len(component.conditions) > 1 for component in components)
    return _of_claims(problem, part, given, seed, together)


def _of_claims(problem: Problem, part: Part, given: ParsedAnswer, seed: str, together: bool) -> str | None:
    """Look at whether what is claimed is singular; `together` tells that conditions are due that hold at once."""
    joints = [q.name for q in problem.chain.q]
    domain = problem.domain()
    try:
        claimed = parse_claims(with_joint(given.tree, joints), joints) if given.tree is not None else []
        right = [piece for (tree,) in part.answer.trees(domain.roles) for piece in parse_pieces(tree, joints)]
        found = compare_sets(claimed, right, Space(joints, domain, part.rounding), seed)
    except ReadError:
        return None
    every = (
        "look for all angles in a turn, and for what vanishes together"
        if together
        else ("set each factor to zero by itself, and look for all angles in a turn")
    )
    if found.rounded:
        return "A value that is right but for its digits earns less: write each as it is, as in pi/3 or acos(1/3)."
    if found.surplus is None:
        return f"What you give is singular, and it is not all: {every}."
    if together or any(len(piece) > 1 for piece in claimed):
        return (
            "Put each of your values into the determinant (or the minors), those that hold together at once: it has to "
            f"be zero whatever the remaining joints are. Then {every}."
        )
    return (
        "Put each of your values into the determinant (or the minors): it has to be zero whatever the other joints "
        f"are. Then {every}."
    )
