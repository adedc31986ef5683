"""Whether an answer is the right one to another student's problem: nothing may follow from what was copied."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import numbers
from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.identity import Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, names
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import is_derived, result

POINTS = 2
DIGITS = 1e6


class Copies:
    """The answers to the problems of a whole class, by their values at configurations of its own.

    They are worked out for a place of the assignment when it is asked for the first time: some milliseconds a student.
    """

    def __init__(self, assignment: Assignment) -> None:
        self._assignment = assignment
        self._known: dict[tuple[str, str], set[bytes]] = {}
        self._drawn: dict[str, np.ndarray] = {}

    def is_right_for_another(
        self, problem: Problem, slot_name: str, part: Part, rows: Sequence[Sequence[Node]]
    ) -> bool:
        """Tell whether a wrong answer to a part is right for somebody else's problem in the same place."""
        if not is_derived(part):
            return False
        slot = next(slot for slot in self._assignment.slots if slot.name == slot_name)
        key = (slot_name, part.kind)
        if key not in self._known:
            self._known[key] = {self._of(chain, part) for chain in self._chains(slot)}
        entries = [entry for row in rows for entry in row]
        used = set().union(*map(names, entries)) | {q.name for q in problem.chain.q}
        symbols = problem.symbols().items()
        given = {name: float(info.value) for name, info in symbols if name in used and info.value is not None}
        program = compile_program(entries)
        # A length that is given here may be open in the other problem, whose answer holds its symbol then.
        as_read = (evaluate(program, self._values(used, known), POINTS)[0].real for known in (given, {}))
        return any(_print(values) in self._known[key] for values in as_read)

    def _chains(self, slot: Slot) -> list[Chain]:
        chains = []
        for student in self._assignment.roster:
            with suppress(QdotError, RuntimeError):  # who has no such problem has no answer that could be copied
                chains.append(self._chain(slot, student.id))
        return chains

    def _chain(self, slot: Slot, student: str) -> Chain:
        of = self._assignment
        if slot.family.varied:
            return slot.problem(of.secret, student, of.draw_of(slot, student)).chain
        return sample_chain(of.identity(slot, student), slot.family)

    def _of(self, chain: Chain, part: Part) -> bytes:
        symbols = [*chain.q, *chain.rates, *chain.parameters, *part.symbols, *chain.task]
        values = result(numbers(chain, self._values(map(str, symbols), {})), part)
        return _print(values.reshape(-1, POINTS))

    def _values(self, used: Iterable[str], given: Mapping[str, float]) -> dict[str, np.ndarray]:
        """Return values of names that are the same for the whole class."""
        return {name: np.full(POINTS, given[name]) if name in given else self._value(name) for name in used}

    def _value(self, name: str) -> np.ndarray:
        if name not in self._drawn:
            drawn = Domain({name: "angle"}).sample({name}, 10, Stream(f"{self._assignment.secret}/copies/{name}"))[name]
            self._drawn[name] = drawn[-POINTS:]
        return self._drawn[name]


def _print(values: np.ndarray) -> bytes:
    """Return what values are known by, rounded to what rounding errors leave alone."""
    with np.errstate(all="ignore"):
        whole = np.nan_to_num(np.round(values * DIGITS), nan=0.0, posinf=0.0, neginf=0.0) + 0.0
    return hashlib.sha256(whole.astype(np.int64).tobytes()).digest()
