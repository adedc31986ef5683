"""Detect answers that are correct for another student's problem; they earn no follow-through points."""

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation_graph import compute_numeric_stages
from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.equality import Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, find_names
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import compute_answer, is_derived

SAMPLE_COUNT = 2
ROUNDING_FACTOR = 1e6


class ClassAnswers:
    """The correct answers to the problems of a whole class, as digests of their values at a few configurations.

    The digests for a part are computed when they are first needed, in a few milliseconds per student.
    """

    def __init__(self, assignment: Assignment) -> None:
        self._assignment = assignment
        self._fingerprints: dict[tuple[str, str], set[bytes]] = {}
        self._sampled_values: dict[str, np.ndarray] = {}

    def is_correct_for_another(
        self, problem: Problem, slot_name: str, part: Part, rows: Sequence[Sequence[Node]]
    ) -> bool:
        """Return whether a wrong answer to a part is correct for another student's problem in the same slot."""
        if not is_derived(part):
            return False
        slot = next(slot for slot in self._assignment.slots if slot.name == slot_name)
        key = (slot_name, part.kind)
        if key not in self._fingerprints:
            self._fingerprints[key] = {self._fingerprint_of(chain, part) for chain in self._chains(slot)}
        entries = [entry for row in rows for entry in row]
        names = set().union(*map(find_names, entries)) | {q.name for q in problem.chain.q}
        numbers = {name: float(info.value) for name, info in problem.symbols.items() if info.value is not None}
        program = compile_program(entries)
        # A length that is a number here may be symbolic in the other problem, so both are tried.
        candidates = (self._shared_values(names, known_values) for known_values in (numbers, {}))
        results = (evaluate(program, values, SAMPLE_COUNT)[0].real for values in candidates)
        return any(_digest_values(values) in self._fingerprints[key] for values in results)

    def _chains(self, slot: Slot) -> Iterator[Chain]:
        for student in self._assignment.roster:
            with suppress(QdotError, RuntimeError):  # a student without this problem has no answer to copy
                yield self._chain(slot, student.id)

    def _chain(self, slot: Slot, student: str) -> Chain:
        assignment = self._assignment
        if slot.family.has_varied_structure:
            return slot.generate_problem(assignment.secret, student, assignment.seed_number_of(slot, student)).chain
        return sample_chain(assignment.make_problem_id(slot, student), slot.family)

    def _fingerprint_of(self, chain: Chain, part: Part) -> bytes:
        symbols = [*chain.q, *chain.rates, *chain.parameters, *part.symbols, *chain.task]
        values = compute_answer(compute_numeric_stages(chain, self._shared_values(map(str, symbols), {})), part)
        return _digest_values(values.reshape(-1, SAMPLE_COUNT))

    def _shared_values(self, symbol_names: Iterable[str], given_values: Mapping[str, float]) -> dict[str, np.ndarray]:
        """Return values for symbols: the given ones, and otherwise random ones that the whole class shares."""
        repeated_values = {name: np.full(SAMPLE_COUNT, value) for name, value in given_values.items()}
        return {
            name: repeated_values[name] if name in repeated_values else self._shared_value(name)
            for name in symbol_names
        }

    def _shared_value(self, name: str) -> np.ndarray:
        if name not in self._sampled_values:
            stream = Stream(f"{self._assignment.secret}/copies/{name}")
            self._sampled_values[name] = Domain({name: "angle"}).sample({name}, 10, stream)[name][-SAMPLE_COUNT:]
        return self._sampled_values[name]


def _digest_values(values: np.ndarray) -> bytes:
    """Return a digest of values; they are rounded first, so that rounding errors don't change it."""
    with np.errstate(all="ignore"):
        rounded_values = np.nan_to_num(np.round(values * ROUNDING_FACTOR), nan=0.0, posinf=0.0, neginf=0.0) + 0.0
    return hashlib.sha256(rounded_values.astype(np.int64).tobytes()).digest()
