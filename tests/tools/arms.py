"""Solve random arms with `qdot solve`, and check numerically every statement that it prints.

`python -m tests.tools.arms --count 300 --seed x` generates 300 arms of one to seven joints (special lengths, oblique
twists, prismatic joints in any order, free lengths that occur twice, other tasks and points) and `--seeds` problems of
each family from random-2 to random-4. It prints every false statement with its arm. It checks that:

- position and Jacobians agree with the numeric product of the table, and det J with the determinant of the numeric J;
- J loses rank where the conditions of a component hold, and the printed joint values satisfy these conditions;
- searches for lost rank end only where some component holds;
- descriptions and kinds of singular configurations are true, even for special lengths;
- a derivation ends within `--seconds`, and is complete or says what is missing.
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, Joint, Point
from qdot.exercises.arm.conventions.base import VELOCITY_NAMES
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.common.stream import Stream
from qdot.exercises.derivation.lengths import substitute_in_arm
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.robots.entry import to_sympy
from qdot.exercises.robots.robot_file import Robot, choose_default_task
from qdot.exercises.robots.robot_text import write_robot_text
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.solve.numeric_rank_check import check_rank_loss
from qdot.exercises.solve.solver import solve
from qdot.exercises.solve.time_limited import write_solution
from qdot.exercises.verify.singularity_statements import all_have_kind, statement_holds
from qdot.exercises.writing.solution_steps import SingularComponent

FAMILIES = ("random-2", "random-3", "random-4")
LENGTHS = ("1/5", "1/5", "3/10", "1/2", "7/10")
"""A few lengths, so that many are equal or add up to another."""
OBLIQUE_TWISTS = (30, 45, 60, 40, 135, -30, -75)
SLACK = 10.0
"""Seconds of processor time allowed for writing the results after the time limit."""
SEARCH_COUNT = 30


# --- arms ---


def generate_arms(count: int, seed: str) -> Iterator[Robot]:
    for number in range(count):
        yield generate_arm(number, seed)


def generate_arm(number: int, seed: str) -> Robot:
    name = f"{seed}/{number}"
    rng = Stream(f"arms/{name}")
    n = rng.choice((1, 2, 2, 3, 3, 3, 4, 4, 5, 6, 7))
    is_open = rng.integer_below(3) == 0
    joints = tuple(_generate_joint(rng, i, is_open, oblique=rng.integer_below(4) == 0) for i in range(1, n + 1))
    tool = None
    if rng.integer_below(4) == 0:
        tool = Point(rng.choice(range(1, n + 1)), tuple(_generate_length(rng, is_open, "b") for _ in range(3)))
    base = Base(yaw=sp.pi / 6, tilt=rng.choice((sp.S.Zero, sp.pi / 2))) if rng.integer_below(5) == 0 else Base()
    chain = Chain(name, joints, ("vx",), base, tool, name)
    return Robot(chain.with_task(*_choose_task(chain, rng)))


def _generate_joint(rng: Stream, i: int, is_open: bool, oblique: bool) -> Joint:
    alpha = rng.choice(OBLIQUE_TWISTS if oblique and rng.integer_below(2) else (0, 0, 90, -90, 90, 180)) * sp.pi / 180
    is_prismatic = rng.integer_below(4) == 0
    a, d = _generate_length(rng, is_open, "a"), _generate_length(rng, is_open, "d")
    offset = rng.choice((0, 0, 0, 90, 180, 30)) * sp.pi / 180
    if is_prismatic:
        theta = rng.choice((0, 0, 90, 45 if oblique else 0)) * sp.pi / 180
        return Joint("P", theta, sp.Symbol(f"d{i}") + rng.choice((0, 0, sp.Rational(1, 10))), a, alpha)
    return Joint("R", sp.Symbol(f"theta{i}") + offset, d, a, alpha)


def _generate_length(rng: Stream, is_open: bool, letter: str) -> sp.Expr:
    if rng.integer_below(5) < 2:
        return sp.S.Zero
    if is_open and rng.integer_below(3):
        return sp.Symbol(f"{letter if letter != 'd' else 'h'}{1 + rng.integer_below(3)}")
    return sp.Rational(rng.choice(LENGTHS)) * rng.choice((1, 1, 1, -1))


def _choose_task(chain: Chain, rng: Stream) -> tuple[str, ...]:
    default_task = choose_default_task(chain)
    if rng.integer_below(3) or len(default_task) == 1:
        return default_task
    return tuple(row for row in VELOCITY_NAMES if row in default_task and rng.integer_below(4)) or default_task


# --- false statements ---


@dataclass(frozen=True)
class Outcome:
    """The false statements about an arm, the missing results, and the time taken."""

    false: tuple[str, ...]
    missing: tuple[str, ...]
    seconds: float


def check_arm(robot: Robot, seconds: float) -> Outcome:
    chunks: list[str] = []
    start_time = time.process_time()
    write_solution(robot, "json", seconds, chunks.append, lambda _: nullcontext())
    elapsed = time.process_time() - start_time
    content = json.loads("".join(chunks))
    missing = tuple(content.get("missing", ()))
    singular = () if missing else solve(robot.chain).singular or ()
    false_statements = [
        *_find_false_formulas(robot.chain, content, missing),
        *_find_false_descriptions(robot.chain, singular, content),
    ]
    if elapsed > seconds + SLACK:
        false_statements.append(f"it took {elapsed:.1f} s of the {seconds:g} s allowed")
    if missing and "All results given here are complete." not in content["note"]:
        false_statements.append("a result is missing, but the note doesn't say so")
    return Outcome(tuple(false_statements), missing, elapsed)


def _find_false_formulas(chain: Chain, content: Mapping[str, Any], missing: Sequence[str]) -> Iterator[str]:
    rng = Stream(f"looked at/{chain.name}")
    for _ in range(3):
        values = {s.name: 0.3 + rng.integer_below(900) / 1000 for s in chain.parameters}
        joints = {q.name: rng.uniform(-3, 3) for q in chain.q}
        numeric_arm, q = NumericChain(chain, values), np.array([joints[s.name] for s in chain.q])
        symbol_values = {**values, **joints}
        jacobian = numeric_arm.compute_jacobian(q)
        yield from _compare("the position", content["position"], numeric_arm.compute_point(q), symbol_values)
        yield from _compare("the Jacobian of the point", content["jacobian"], jacobian[:3], symbol_values)
        yield from _compare("the geometric Jacobian", content["geometric_jacobian"], jacobian, symbol_values)
        rows = [VELOCITY_NAMES.index(row) for row in chain.task]
        if content["determinant"] is not None:
            yield from _compare("det J", content["determinant"], np.linalg.det(jacobian[rows]), symbol_values)
    if "singular" not in missing:
        yield from _find_false_conditions(chain, content, "tested" in missing)


def _compare(name: str, printed: Any, expected: Any, values: Mapping[str, float]) -> Iterator[str]:
    if printed is not None and not np.allclose(_evaluate(printed, values), expected, atol=1e-9):
        yield f"{name} differs: {_evaluate(printed, values)} instead of {expected}"


def _evaluate(printed: Any, values: Mapping[str, float]) -> Any:
    if isinstance(printed, list):
        return np.array([_evaluate(entry, values) for entry in printed])
    replacements = {sp.Symbol(name): sp.Float(value, 20) for name, value in values.items()}
    return complex(sp.N(_parse(printed).xreplace(replacements))).real


def _parse(text: str) -> sp.Expr:
    return to_sympy(parse_formula(text))


def _find_false_conditions(chain: Chain, content: Mapping[str, Any], is_untested: bool) -> Iterator[str]:
    """Yield false statements about a singular set.

    If the set `is_untested`, the output need not report conditions without samples.
    """
    note = content.get("note", "")
    if content["singular"] is None:
        if "every configuration" in note and not _loses_rank_everywhere(chain):
            yield "the note says that J loses rank everywhere, but it doesn't"
        return
    parts = content["singular"]
    conditions = [[_parse(text) for text in part["conditions"]] for part in parts]
    loss = check_rank_loss(chain, conditions, SEARCH_COUNT)
    for k in loss.full_rank_branches:
        yield f"J keeps its rank where {parts[k]['condition']} = 0"
    for k, part in enumerate(parts):
        is_reported = is_untested or "No configuration was found" in note
        if not loss.samples[k] and not chain.parameters and not is_reported:
            yield f"no configuration was found in which {part['condition']} = 0"
        yield from _find_false_solutions(chain, part, conditions[k])
    if loss.unexplained_configurations and "is not complete" not in note:
        count, q = len(loss.unexplained_configurations), loss.unexplained_configurations[0].round(5)
        yield f"{count} of {loss.search_count} searches ended elsewhere, as in {q}"


def _find_false_descriptions(
    chain: Chain, singular: Sequence[SingularComponent], content: Mapping[str, Any]
) -> Iterator[str]:
    """Yield false descriptions and kinds of singular configurations, tested at configurations found by a search."""
    for component in singular:
        yield from _find_false_classification(chain, component.conditions, component.classification)
        for values, classification in component.cases:
            equations = [equation for joint, value in values for equation in _write_equations(joint, value)]
            yield from _find_false_classification(chain, equations, classification)
    for special in content.get("special_lengths", ()):
        length, value = map(_parse, special["lengths"].split(" = "))
        for part in special["singular"]:
            classification = Classification(part["type"] or "", bool(part["uniform"]), part["meaning"] or "")
            special_chain = substitute_in_arm(chain, {length: value})
            conditions = [_parse(text) for text in part["conditions"]]
            for statement in _find_false_classification(special_chain, conditions, classification):
                yield f"for {special['lengths']}: {statement}"


def _write_equations(joint: sp.Symbol, value: sp.Expr) -> list[sp.Expr]:
    difference = joint - value
    return [sp.sin(difference), sp.cos(difference) - 1] if joint.name.startswith("theta") else [difference]


def _find_false_classification(
    chain: Chain, conditions: Sequence[sp.Expr], classification: Classification
) -> Iterator[str]:
    loss = check_rank_loss(chain, [conditions], SEARCH_COUNT, seed="looks")
    samples = loss.samples[0]
    conditions_text = " and ".join(f"{condition} = 0" for condition in conditions)
    meaning = classification.meaning
    counterexamples = [sample for sample in samples if meaning and not statement_holds(chain, meaning, sample)]
    if counterexamples:
        q, other_count = counterexamples[0].q.round(5), len(counterexamples) - 1
        yield f"{meaning}, is said where {conditions_text}, but is false at {q} and {other_count} more"
    other_kinds = [sample for sample in samples if not all_have_kind(chain, classification, [sample])]
    if len(other_kinds) > len(samples) // 25:  # some lie close to a point where another condition holds
        yield f"{classification.kind}, is said where {conditions_text}, but there are other kinds"


def _loses_rank_everywhere(chain: Chain) -> bool:
    rng = Stream(f"everywhere/{chain.name}")
    rows = [VELOCITY_NAMES.index(row) for row in chain.task]
    numeric_arm = NumericChain(chain, {s.name: rng.uniform(0.3, 1.2) for s in chain.parameters})
    q = np.array([[rng.uniform(-3, 3) for _ in chain.q] for _ in range(5)])
    ranks = np.linalg.matrix_rank(numeric_arm.compute_jacobian(q)[:, rows], tol=1e-9)
    return bool(np.all(ranks < min(len(rows), chain.n)))


def _find_false_solutions(chain: Chain, part: Mapping[str, Any], conditions: Sequence[sp.Expr]) -> Iterator[str]:
    """Yield joint values that don't satisfy the conditions, except values that are complex for some lengths."""
    if part["solutions"] is None:
        return
    lengths = {s: sp.Rational(37 + 11 * i, 100) for i, s in enumerate(chain.parameters)}
    names, values = zip(*part["solutions"].items(), strict=True)
    for texts in product(*values):
        solution = dict(zip(names, texts, strict=True))
        point = {sp.Symbol(name): sp.N(_parse(text).xreplace(lengths), 30) for name, text in solution.items()}
        if any(abs(sp.im(value)) > 1e-12 for value in point.values()):
            continue
        residuals = [abs(complex(sp.N(condition.xreplace(lengths).xreplace(point), 20))) for condition in conditions]
        if max(residuals) > 1e-9:
            yield f"{solution} is given for {part['condition']} = 0, but is no solution"


# --- the program ---


def list_all_arms(count: int, seed: str, seeds: int) -> Iterator[tuple[str, Robot]]:
    yield from ((robot.chain.name, robot) for robot in generate_arms(count, seed))
    yield from generate_family_arms(seeds)


def generate_family_arms(seeds: int) -> Iterator[tuple[str, Robot]]:
    for family, seed in product(FAMILIES, range(seeds)):
        yield f"{family}/{seed}", Robot(sample_chain(ProblemId(family, seed, variation="full")))


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seeds", type=int, default=60, help="problems of each family random-2 to -4")
    parser.add_argument("--seed", default="a")
    parser.add_argument("--seconds", type=float, default=20)
    options = parser.parse_args()
    false_arm_count = 0
    for name, robot in list_all_arms(options.count, options.seed, options.seeds):
        result = check_arm(robot, options.seconds)
        missing = f", without {', '.join(result.missing)}" if result.missing else ""
        print(f"{name}: {result.seconds:.1f} s{missing}", flush=True)
        if result.false:
            false_arm_count += 1
            print(*result.false, write_robot_text(robot, "dh"), sep="\n  ", flush=True)
    print(f"{false_arm_count} arms have false statements")
    return 1 if false_arm_count else 0


if __name__ == "__main__":
    sys.exit(main())
