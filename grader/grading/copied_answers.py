"""Detect answers that are correct for another student's problem; later parts earn no points by following from them.

For each part, the correct answers of all students are evaluated at the same random values of the symbols. The digest of
these values is the fingerprint of an answer: equal answers have equal fingerprints. A slot is the place of a problem in
the assignment, such as "p1"; each student has a different problem there.
"""

import hashlib
from collections.abc import Iterable, Iterator, Sequence, Set
from contextlib import suppress

import numpy as np

from qdot.exercises.arm.chain import Chain
from qdot.exercises.assignment.assignment import Assignment, Slot
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.graph import compute_numeric_stages
from qdot.exercises.formula.equality import READABLE_POINTS, Domain
from qdot.exercises.formula.program import compile_program, evaluate
from qdot.exercises.formula.trees import Node, find_names
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step

SAMPLE_COUNT = 2
"""Number of configurations at which answers are evaluated."""
ROUNDING_FACTOR = 1e6
"""Values are multiplied by this number and rounded to integers before their digest is computed."""


class ClassAnswers:
    """The correct answers to the problems of a whole class, as fingerprints.

    The fingerprints for a part are computed when they are first needed, in a few milliseconds per student.
    """

    def __init__(self, assignment: Assignment) -> None:
        self._assignment = assignment
        self._fingerprints: dict[tuple[str, str], set[bytes]] = {}
        self._sampled_values: dict[str, np.ndarray] = {}

    def is_correct_for_another(
        self, problem: Problem, slot_name: str, part: Part, rows: Sequence[Sequence[Node]]
    ) -> bool:
        """Return whether a wrong answer to a part is correct for another student's problem in the same slot.

        `rows` are the formulas of the answer, in rows and columns.
        """
        if not is_derived_step_by_step(part):
            return False
        fingerprints = self.find_fingerprints(slot_name, part)
        entries = [entry for row in rows for entry in row]
        names = set().union(*map(find_names, entries)) | {q.name for q in problem.chain.q}
        program = compile_program(entries)
        samples = self._sample_values(names)
        symbols = problem.symbols.items()
        numbers = {name: np.full(SAMPLE_COUNT, float(info.value)) for name, info in symbols if info.value is not None}
        # A length that is a number here may be symbolic in the other problem, so both are tried.
        results = (evaluate(program, all_samples, SAMPLE_COUNT) for all_samples in (samples | numbers, samples))
        return any(_compute_digest(values.real) in fingerprints for values, _ in results)

    def find_fingerprints(self, slot_name: str, part: Part) -> Set[bytes]:
        """Return the fingerprints of the correct answers to a part; empty if they can't be computed from the arm."""
        key = (slot_name, part.kind)
        if key not in self._fingerprints and is_derived_step_by_step(part):
            slot = next(slot for slot in self._assignment.slots if slot.name == slot_name)
            self._fingerprints[key] = {self._compute_fingerprint(chain, part) for chain in self._generate_chains(slot)}
        return self._fingerprints.get(key, frozenset())

    def _generate_chains(self, slot: Slot) -> Iterator[Chain]:
        """Yield the arm of each student in a slot of the assignment."""
        assignment = self._assignment
        for student in assignment.roster:
            with suppress(QdotError, RuntimeError):  # a student without this problem has no answer to copy
                if slot.family.has_varied_structure:
                    seed_number = assignment.seed_number_of(slot, student.id)
                    yield slot.generate_problem(assignment.secret, student.id, seed_number).chain
                else:
                    yield sample_chain(assignment.make_problem_id(slot, student.id), slot.family)

    def _compute_fingerprint(self, chain: Chain, part: Part) -> bytes:
        """Return the fingerprint of the correct answer to a part for an arm."""
        symbols = [*chain.q, *chain.rates, *chain.parameters, *part.symbols, *chain.task]
        values = compute_answer(compute_numeric_stages(chain, self._sample_values(map(str, symbols))), part)
        return _compute_digest(values.reshape(-1, SAMPLE_COUNT))

    def _sample_values(self, symbol_names: Iterable[str]) -> dict[str, np.ndarray]:
        """Return random values of at least these symbols; a symbol has the same values for the whole class."""
        for name in (name for name in symbol_names if name not in self._sampled_values):
            stream = Stream(f"{self._assignment.secret}/copies/{name}")
            # Any values will do if they are the same for the whole class, so all symbols are sampled like angles.
            samples = Domain({name: "angle"}).sample({name}, READABLE_POINTS + SAMPLE_COUNT, stream)
            self._sampled_values[name] = samples[name][READABLE_POINTS:]
        return self._sampled_values


def _compute_digest(values: np.ndarray) -> bytes:
    """Return a digest of values; these are rounded first, so that rounding errors don't change the digest."""
    with np.errstate(all="ignore"):
        rounded_values = np.nan_to_num(np.round(values * ROUNDING_FACTOR), nan=0.0, posinf=0.0, neginf=0.0)
    return hashlib.sha256(rounded_values.astype(np.int64).tobytes()).digest()
