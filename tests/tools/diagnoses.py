"""`make diagnoses`: make every mistake of the catalogue on every family and question, and check its diagnosis.

A wrong answer is written as a student would write it: formulas as text, numbers with five digits, sets as conditions,
options as letters. The diagnosis is right if it names the mistake, or another one that gives the same answer. For
random wrong answers, it must name no mistake.
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

from qdot.exercises.arm.trigonometry import to_textbook_form
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.arithmetic import determinant
from qdot.exercises.derivation.graph import (
    RESULT,
    StageResults,
    compute_numeric_stages,
    compute_symbolic_stages,
    to_sympy_matrix,
)
from qdot.exercises.families import FAMILIES
from qdot.exercises.formula.sympy_text import format_expression
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
from qdot.exercises.questions.results import compute_answer, is_derived_step_by_step
from qdot.exercises.reference_answers import Choice, ConditionSet, Direction, Expression, Matching, Number, Selection
from qdot.grader.diagnosis.numbers import is_distinctive
from qdot.grader.judging.judge import judge
from qdot.grader.judging.verdict import Outcome
from tests.support.judging import diagnose
from tests.support.problems import get_problem

MAX_LENGTH = 40_000


@dataclass(frozen=True)
class WrongAnswer:
    problem: Problem
    part: Part
    mistake: str
    text: str


def list_parts(family: str, seed: int, questions: Collection[str] = tuple(QUESTIONS)) -> Iterator[tuple[Problem, Part]]:
    """Yield the problem with all questions of a family, with each of its parts that is in `questions`."""
    problem = get_problem(family, seed)
    for part in problem.parts:
        if part.name in questions:
            yield problem, part


def make_wrong_answers(
    problem: Problem, part: Part, max_count: int | None = None, mistakes: Collection[str] = tuple(CATALOGUE)
) -> list[WrongAnswer]:
    """Return the answers that the mistakes with these names produce, or a sample of at most `max_count`.

    Answers that are correct, zero or undefined are left out.
    """
    wrong_answers = [
        WrongAnswer(problem, part, mistake.name, _write_short_answer(replace(part, answer=mistaken.answer)))
        for mistake, mistaken in generate_mistaken_answers(problem.chain, part)
        if mistake.name in mistakes
    ]
    if is_derived_step_by_step(part) and (
        part.kind != "lost-direction" or _is_numeric(part)
    ):  # which is derived in numbers
        values = sample_configurations(problem.chain, part, problem.domain, 3, Stream("answers"))
        numeric = compute_numeric_stages(problem.chain, values)
        correct_answer, is_direction = compute_answer(numeric, part), isinstance(part.answer, Direction)
        variants = [
            (mistake, key)
            for mistake in list_likely_mistakes(part)
            if mistake.name in mistakes
            for key, prediction in _enumerate_variants(apply_mistake(mistake, numeric, part))
            if _is_wrong(prediction.answer, correct_answer, is_direction)
        ]
        stages = numeric if _is_numeric(part) else compute_symbolic_stages(problem.chain)
        for mistake, key in _sample(variants, max_count, f"{problem.id}/{part.name}"):
            prediction = dict(_enumerate_variants(apply_mistake(mistake, stages, part))).get(key)
            text = None if prediction is None else _write_answer(part, prediction, stages)
            if text is not None:
                wrong_answers.append(WrongAnswer(problem, part, mistake.name, text))
    return _sample(wrong_answers, max_count, f"{problem.id}/{part.name}")


def _enumerate_variants(answers: Iterable[PredictedAnswer]) -> Iterator[tuple[tuple[str, int], PredictedAnswer]]:
    """Yield each wrong answer with its words and its number among the answers with the same words.

    There may be fewer numeric variants than symbolic ones, because only numbers show that a mistake changes nothing.
    """
    counts: Counter[str] = Counter()
    for answer in answers:
        words = str(answer.variant.words)
        yield (words, counts[words]), answer
        counts[words] += 1


Item = TypeVar("Item")


def _sample(items: list[Item], max_count: int | None, seed: str) -> list[Item]:
    return items if max_count is None or len(items) <= max_count else random.Random(seed).sample(items, max_count)


def _is_numeric(part: Part) -> bool:
    answer = part.answer
    return isinstance(answer, (Number, Choice)) or (isinstance(answer, Direction) and answer.tolerance is not None)


def _is_wrong(answer: np.ndarray, expected: np.ndarray, is_direction: bool) -> bool:
    """Return whether an answer differs from the correct one and is distinctive."""
    if not np.isfinite(answer).all() or not np.abs(answer).max() > 1e-6 or np.abs(answer).max() > 1e9:
        return False
    if not is_distinctive(answer):
        return False
    if answer.shape != expected.shape:
        return True
    if is_direction:
        answer, expected = (vector / np.sqrt((vector * vector).sum(axis=0)) for vector in (answer, expected))
        answer = answer * np.sign((answer * expected).sum(axis=0))
    # The largest value of each configuration, because lengths differ a hundredfold between configurations.
    largest_values = np.abs(expected).max(axis=tuple(range(expected.ndim - 1)))
    return bool((np.abs(answer - expected) > 1e-2 * np.abs(expected) + 1e-3 * largest_values).any())


def _write_short_answer(part: Part) -> str:
    answer = part.answer
    if isinstance(answer, Choice):
        return answer.letters
    if isinstance(answer, ConditionSet):
        return f"[{', '.join(answer.list_pieces())}]"
    assert isinstance(answer, Number)
    return str([float(value) for value in answer.reference])


def _write_answer(part: Part, prediction: PredictedAnswer, stages: StageResults) -> str | None:
    if isinstance(part.answer, Choice):
        return _find_option(part, prediction.answer)
    if _is_numeric(part):
        return str([[float(f"{value:.5g}") for value in row] for row in prediction.answer[..., 0].tolist()])
    is_long_determinant = part.kind == "determinant" and stages.n > 3
    matrix = _compute_short_determinant(prediction) if is_long_determinant else to_sympy_matrix(prediction.answer)
    if isinstance(part.answer, Expression):
        text = format_expression(matrix[0])
    else:
        text = "[" + ", ".join(f"[{', '.join(map(format_expression, row))}]" for row in matrix.tolist()) + "]"
    return None if len(text) > MAX_LENGTH or "nan" in text or "zoo" in text else text


def _compute_short_determinant(prediction: PredictedAnswer) -> sp.Matrix:
    """Return the determinant of a wrong Jacobian of many joints, from entries in their shortest form."""
    if "determinant" in prediction.variant.changes or RESULT in prediction.variant.changes:
        return sp.Matrix([[sp.nan]])
    entries = np.frompyfunc(_shorten, 1, 1)(prediction.stages["jacobian"])
    return sp.Matrix([[sp.expand(determinant(entries).item())]])


def _shorten(entry: sp.Expr) -> sp.Expr:
    try:
        return to_textbook_form(sp.expand(entry))
    except ValueError:  # angles in degrees or with an offset
        return sp.expand(entry)


def _find_option(part: Part, vector: np.ndarray) -> str | None:
    assert isinstance(part.answer, Choice)
    option = f"({', '.join(f'{float(value) + 0.0:.3f}' for value in vector[:, 0, 0])})"
    options = list(part.answer.options)
    return "ABCDEFGH"[options.index(option)] if option in options else None


def generate_random_answers(problem: Problem, part: Part, count: int) -> Iterator[str]:
    rng = random.Random(f"{problem.id}/{part.name}")
    given_joints = part.details.given_joints  # a term with their sines may vanish where it is asked
    revolute_joints = [q for joint, q in zip(problem.chain.joints, problem.chain.q, strict=True) if joint.is_revolute]
    joint_names = [q.name for q in revolute_joints if q not in given_joints]
    lengths = [s.name for s in problem.chain.parameters] or ["1"]

    def make_sine_or_cosine() -> str:
        angle = " + ".join(rng.choice(joint_names or ["1"]) for _ in range(rng.randint(1, 2)))
        return f"{rng.choice(('sin', 'cos'))}({angle})"

    def make_noise() -> str:
        trigs = "*".join(make_sine_or_cosine() for _ in range(rng.randint(1, 2)))
        return f"{rng.randint(2, 9)}/{rng.choice((7, 11, 13))}*{rng.choice(lengths)}*{trigs}"

    def spoil(entry: str) -> str:
        product = f"(({entry}) + {make_noise()})*({make_noise()} + {make_noise()})"
        return rng.choice((product, f"{make_noise()} + {make_noise()}"))

    answer = part.answer
    for _ in range(count):
        if isinstance(answer, Expression):
            yield spoil(format_expression(answer.reference))
        elif isinstance(answer, Number):
            yield str([float(f"{float(value) * rng.uniform(0.3, 3):.5g}") for value in answer.reference])
        elif isinstance(answer, (ConditionSet, Choice, Selection, Matching)):
            return
        else:
            rows = [[format_expression(entry) for entry in row] for row in answer.as_matrix().tolist()]
            places = [(i, j) for i, row in enumerate(rows) for j, entry in enumerate(row) if entry != "0"]
            for i, j in rng.sample(places, min(len(places), rng.randint(1, 3))):
                rows[i][j] = spoil(rows[i][j])
            yield "[" + ", ".join(f"[{', '.join(row)}]" for row in rows) + "]"


def sweep(
    families: list[str], seeds: Collection[int], questions: Collection[str], max_count: int | None, random_count: int
) -> tuple[Counter[str], list[WrongAnswer]]:
    counts: Counter[str] = Counter()
    wrong_diagnoses: list[WrongAnswer] = []
    for family in families:
        start = time.perf_counter()
        for seed in seeds:
            for problem, part in list_parts(family, seed, questions):
                for answer in make_wrong_answers(problem, part, max_count):
                    outcome = classify_diagnosis(answer)
                    counts[outcome] += 1
                    if outcome not in ("named", "same answer"):
                        wrong_diagnoses.append(answer)
                for text in generate_random_answers(problem, part, random_count):
                    diagnosis = diagnose(problem, part, text, "random")
                    counts["random, blamed" if diagnosis else "random, not blamed"] += 1
                    if diagnosis:
                        wrong_diagnoses.append(WrongAnswer(problem, part, " and ".join(diagnosis.mistakes), text))
        sys.stderr.write(f"{family}: {time.perf_counter() - start:.1f} s {dict(counts)}\n")
    return counts, wrong_diagnoses


def classify_diagnosis(answer: WrongAnswer) -> str:
    """Return "named", "same answer" (the diagnosis names another mistake), "nothing" or "judged right"."""
    if judge(answer.problem, answer.part, answer.text, "sweep").outcome is Outcome.CORRECT:
        return "judged right"
    diagnosis = diagnose(answer.problem, answer.part, answer.text, "sweep")
    if diagnosis is None:
        return "nothing"
    return "named" if answer.mistake in diagnosis.mistakes else "same answer"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--family", action="append", choices=FAMILIES)
    parser.add_argument("--question", action="append", choices=QUESTIONS)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--few", type=int, help="sample of wrong answers for each question; all by default")
    parser.add_argument("--random", type=int, default=5)
    options = parser.parse_args()
    families, questions = options.family or list(FAMILIES), tuple(options.question or QUESTIONS)
    counts, wrong_diagnoses = sweep(families, range(options.seeds), questions, options.few, options.random)
    for answer in wrong_diagnoses:
        sys.stdout.write(f"{answer.problem.id} {answer.part.name} {answer.mistake}: {answer.text[:200]}\n")
    mistake_count = sum(counts[name] for name in ("named", "same answer", "nothing"))
    sys.stdout.write(f"{mistake_count} mistakes: {dict(counts)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
