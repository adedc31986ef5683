"""`make diagnoses`: every mistake of the catalogue made on every family and question, and what the diagnosis says.

A wrong answer is written down as a student would who made the mistake: formulas as text, numbers to five digits, sets
as conditions, options by their letter. The diagnosis is right if it names the mistake, or another one that gives the
very same answer. Answers that are wrong at random must be blamed on nothing.
"""

import argparse
import random
import sys
import time
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import sympy as sp

from qdot.exercises.arm.arithmetic import determinant
from qdot.exercises.arm.derivation_graph import (
    RESULT,
    StageResults,
    compute_numeric_stages,
    compute_symbolic_stages,
    to_sympy_matrix,
)
from qdot.exercises.arm.trigonometry import textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.sympy_text import expression_text
from qdot.exercises.mistakes.catalogue import (
    CATALOGUE,
    PredictedAnswer,
    apply_mistake,
    generate_mistaken_answers,
    list_likely_mistakes,
)
from qdot.exercises.mistakes.configurations import sample_configurations
from qdot.exercises.problem.problem import Part, Problem
from qdot.exercises.questions import QUESTIONS
from qdot.exercises.questions.results import compute_answer, is_derived
from qdot.exercises.reference_answers import Choice, ConditionSet, Direction, Expression, Matching, Number, Selection
from qdot.grader.diagnosis.numbers import is_distinctive
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import diagnose
from tests.support.problems import get_problem

LONGEST = 40_000


@dataclass(frozen=True)
class Made:
    """A wrong answer as text, the mistakes that give it, and what the diagnosis named."""

    problem: Problem
    part: Part
    mistake: str
    text: str


def problems(family: str, seed: int, questions: Collection[str] = tuple(QUESTIONS)) -> Iterator[tuple[Problem, Part]]:
    """Yield the parts of a problem in which a family is asked everything that applies, those that are named."""
    problem = get_problem(family, seed)
    for part in problem.parts:
        if part.name in questions:
            yield problem, part


def answers_with(
    problem: Problem, part: Part, few: int | None = None, only: Collection[str] = tuple(CATALOGUE)
) -> list[Made]:
    """Return what mistakes make of an answer, `only` some, `few` of them drawn; none is right, zero or undefined."""
    told = [
        Made(problem, part, mistake.name, _told(replace(part, answer=slip.answer)))
        for mistake, slip in generate_mistaken_answers(problem.chain, part)
        if mistake.name in only
    ]
    if is_derived(part) and (part.kind != "lost-direction" or _is_numeric(part)):  # which is worked out in numbers
        values = sample_configurations(problem.chain, part, problem.domain, 3, Stream("answers"))
        rough = compute_numeric_stages(problem.chain, values)
        right, is_direction = compute_answer(rough, part), isinstance(part.answer, Direction)
        variants = [
            (mistake, key)
            for mistake in list_likely_mistakes(part)
            if mistake.name in only
            for key, wrong in _numbered(apply_mistake(mistake, rough, part))
            if _applies(wrong.answer, right, is_direction)
        ]
        w = rough if _is_numeric(part) else compute_symbolic_stages(problem.chain)
        for mistake, key in _drawn(variants, few, f"{problem.id}/{part.name}"):
            wrong = dict(_numbered(apply_mistake(mistake, w, part))).get(key)
            text = None if wrong is None else _written(part, wrong, w)
            if text is not None:
                told.append(Made(problem, part, mistake.name, text))
    return _drawn(told, few, f"{problem.id}/{part.name}")


def _numbered(answers: Iterable[PredictedAnswer]) -> Iterator[tuple[tuple[str, int], PredictedAnswer]]:
    """Yield each wrong answer with its words and its number among those with the same words.

    Numbers show that a mistake at a joint changes nothing where formulas may not, and then have fewer variants.
    """
    counts: Counter[str] = Counter()
    for answer in answers:
        words = str(answer.variant.words)
        yield (words, counts[words]), answer
        counts[words] += 1


Item = TypeVar("Item")


def _drawn(items: list[Item], few: int | None, seed: str) -> list[Item]:
    """Return some of the items, the same at every call, or all."""
    return items if few is None or len(items) <= few else random.Random(seed).sample(items, few)


def _is_numeric(part: Part) -> bool:
    answer = part.answer
    return isinstance(answer, (Number, Choice)) or (isinstance(answer, Direction) and answer.tolerance is not None)


def _applies(found: np.ndarray, right: np.ndarray, is_direction: bool) -> bool:
    """Tell whether a wrong answer differs from the right one, and says something."""
    if not np.isfinite(found).all() or not np.abs(found).max() > 1e-6 or np.abs(found).max() > 1e9:
        return False
    if not is_distinctive(found):
        return False
    if found.shape != right.shape:
        return True
    if is_direction:
        found, right = (a / np.sqrt((a * a).sum(axis=0)) for a in (found, right))
        found = found * np.sign((found * right).sum(axis=0))
    largest = np.abs(right).max(
        axis=tuple(range(right.ndim - 1))
    )  # lengths differ a hundredfold between configurations
    return bool((np.abs(found - right) > 1e-2 * np.abs(right) + 1e-3 * largest).any())


def _told(part: Part) -> str:
    """Return an answer as text."""
    answer = part.answer
    if isinstance(answer, Choice):
        return answer.letters
    if isinstance(answer, ConditionSet):
        return f"[{', '.join(answer.pieces())}]"
    assert isinstance(answer, Number)
    return str([float(value) for value in answer.reference])


def _written(part: Part, wrong: PredictedAnswer, w: StageResults) -> str | None:
    """Return a wrong answer as a student writes it; None where it would be too long, or is none of the options."""
    if isinstance(part.answer, Choice):
        return _option(part, wrong.answer)
    if _is_numeric(part):
        return str([[float(f"{value:.5g}") for value in row] for row in wrong.answer[..., 0].tolist()])
    matrix = _short_determinant(wrong) if part.kind == "determinant" and w.n > 3 else to_sympy_matrix(wrong.answer)
    if isinstance(part.answer, Expression):
        text = expression_text(matrix[0])
    else:
        text = "[" + ", ".join(f"[{', '.join(map(expression_text, row))}]" for row in matrix.tolist()) + "]"
    return None if len(text) > LONGEST or "nan" in text or "zoo" in text else text


def _short_determinant(wrong: PredictedAnswer) -> sp.Matrix:
    """Return the determinant of a wrong Jacobian of many joints, from entries in their shortest form."""
    if "determinant" in wrong.variant.changes or RESULT in wrong.variant.changes:
        return sp.Matrix([[sp.nan]])
    entries = np.frompyfunc(_short, 1, 1)(wrong.stages["jacobian"])
    return sp.Matrix([[sp.expand(determinant(entries).item())]])


def _short(entry: sp.Expr) -> sp.Expr:
    try:
        return textbook_form(sp.expand(entry))
    except ValueError:  # of angles in degrees, or with a constant in them
        return sp.expand(entry)


def _option(part: Part, vector: np.ndarray) -> str | None:
    assert isinstance(part.answer, Choice)
    shown = f"({', '.join(f'{float(value) + 0.0:.3f}' for value in vector[:, 0, 0])})"
    options = list(part.answer.options)
    return "ABCDEFGH"[options.index(shown)] if shown in options else None


def random_answers(problem: Problem, part: Part, count: int) -> Iterator[str]:
    """Yield answers of the right type that are wrong in a way that is nobody's mistake."""
    rng = random.Random(f"{problem.id}/{part.name}")
    given = part.details.given_joints  # a term with their sines may vanish where it is asked
    turned = [q for joint, q in zip(problem.chain.joints, problem.chain.q, strict=True) if joint.is_revolute]
    joints = [q.name for q in turned if q not in given]
    lengths = [s.name for s in problem.chain.parameters] or ["1"]

    def sine_or_cosine() -> str:
        angle = " + ".join(rng.choice(joints or ["1"]) for _ in range(rng.randint(1, 2)))
        return f"{rng.choice(('sin', 'cos'))}({angle})"

    def noise() -> str:
        trigs = "*".join(sine_or_cosine() for _ in range(rng.randint(1, 2)))
        return f"{rng.randint(2, 9)}/{rng.choice((7, 11, 13))}*{rng.choice(lengths)}*{trigs}"

    def spoiled(entry: str) -> str:
        return rng.choice((f"(({entry}) + {noise()})*({noise()} + {noise()})", f"{noise()} + {noise()}"))

    answer = part.answer
    for _ in range(count):
        if isinstance(answer, Expression):
            yield spoiled(expression_text(answer.reference))
        elif isinstance(answer, Number):
            yield str([float(f"{float(v) * rng.uniform(0.3, 3):.5g}") for v in answer.reference])
        elif isinstance(answer, (ConditionSet, Choice, Selection, Matching)):
            return
        else:
            rows = [[expression_text(entry) for entry in row] for row in answer.as_matrix().tolist()]
            places = [(i, j) for i, row in enumerate(rows) for j, entry in enumerate(row) if entry != "0"]
            for i, j in rng.sample(places, min(len(places), rng.randint(1, 3))):
                rows[i][j] = spoiled(rows[i][j])
            yield "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


def sweep(
    families: list[str], seeds: Collection[int], questions: Collection[str], few: int | None, at_random: int
) -> tuple[Counter[str], list[Made]]:
    """Return how often the diagnosis was right, and the answers on which it was not."""
    counts: Counter[str] = Counter()
    missed: list[Made] = []
    for family in families:
        start = time.perf_counter()
        for seed in seeds:
            for problem, part in problems(family, seed, questions):
                for one in answers_with(problem, part, few):
                    outcome = verdict_on(one)
                    counts[outcome] += 1
                    if outcome not in ("named", "same answer"):
                        missed.append(one)
                for text in random_answers(problem, part, at_random):
                    blamed = diagnose(problem, part, text, "random")
                    counts["random, blamed" if blamed else "random, not blamed"] += 1
                    if blamed:
                        missed.append(Made(problem, part, " and ".join(blamed.mistakes), text))
        sys.stderr.write(f"{family}: {time.perf_counter() - start:.1f} s {dict(counts)}\n")
    return counts, missed


def verdict_on(one: Made) -> str:
    """Return "named", "same answer" (another mistake, by the same values), "nothing", or "judged right"."""
    if judge(one.problem, one.part, one.text, "sweep").outcome is Outcome.CORRECT:
        return "judged right"
    found = diagnose(one.problem, one.part, one.text, "sweep")
    if found is None:
        return "nothing"
    return "named" if one.mistake in found.mistakes else "same answer"


def main() -> int:
    """Make every mistake, and print what the diagnosis did not name."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--family", action="append", choices=FAMILIES)
    parser.add_argument("--question", action="append", choices=QUESTIONS)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--few", type=int, help="so many answers of each question, drawn; all by default")
    parser.add_argument("--random", type=int, default=5)
    options = parser.parse_args()
    counts, missed = sweep(
        options.family or list(FAMILIES),
        range(options.seeds),
        tuple(options.question or QUESTIONS),
        options.few,
        options.random,
    )
    for one in missed:
        sys.stdout.write(f"{one.problem.id} {one.part.name} {one.mistake}: {one.text[:200]}\n")
    wrong = sum(counts[name] for name in ("named", "same answer", "nothing"))
    sys.stdout.write(f"{wrong} mistakes: {dict(counts)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
