"""Random arms through `qdot solve`, and every statement that it prints checked in numbers.

`python -m tests.tools.arms --count 300 --seed x` generates 300 arms of one to seven joints (special lengths, oblique
twists, prismatic joints in any order, free lengths that occur twice, other tasks and points) and `--seeds` problems of
each family random-2 to -4, and prints every false statement with its arm. It checks that:

- position and Jacobians are those of the table multiplied out in numbers, the determinant is that of J;
- at configurations in which the conditions of a component hold, J has lost rank; joint values are such configurations;
- searches for lost rank end where some component holds, and at no end where none is told;
- what configurations are said to look like, they do, and are of the kind they are said to be, also for special lengths;
- a derivation ends within `--seconds` with all that it has, or says what is missing.
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
from qdot.exercises.arm.entry import to_sympy
from qdot.exercises.arm.kinematics import NumericChain
from qdot.exercises.arm.lengths import substitute_arm_lengths
from qdot.exercises.arm.robot_file import Robot, default_task
from qdot.exercises.arm.robot_text import robot_text
from qdot.exercises.common.stream import Stream
from qdot.exercises.formula.parser import parse_formula
from qdot.exercises.generation import sample_chain
from qdot.exercises.problem.problem import ProblemId
from qdot.exercises.singularities.axes import Sample
from qdot.exercises.singularities.classification import Classification
from qdot.exercises.singularities.numeric_rank_check import check_rank_loss
from qdot.exercises.solve.solver import solve
from qdot.exercises.solve.time_limited import write_solution
from qdot.exercises.verify.appearance import all_have_kind, statement_holds
from qdot.exercises.writing.solution_steps import SingularComponent

FAMILIES = ("random-2", "random-3", "random-4")
LENGTHS = ("1/5", "1/5", "3/10", "1/2", "7/10")
"""Few, so that many are equal or add up to another."""
OBLIQUE = (30, 45, 60, 40, 135, -30, -75)
SLACK = 10.0
"""Seconds of processor time that writing down what is there may take when the time is over."""
STARTS = 30


# --- arms ---


def arms(count: int, seed: str) -> Iterator[Robot]:
    """Yield arms that are the same for a seed."""
    for number in range(count):
        yield arm(number, seed)


def arm(number: int, seed: str) -> Robot:
    """Return one of the arms of a seed."""
    name = f"{seed}/{number}"
    draws = Stream(f"arms/{name}")
    n = draws.choice((1, 2, 2, 3, 3, 3, 4, 4, 5, 6, 7))
    is_open = draws.integer_below(3) == 0
    joints = tuple(_joint(draws, i, is_open, oblique=draws.integer_below(4) == 0) for i in range(1, n + 1))
    tool = None
    if draws.integer_below(4) == 0:
        tool = Point(draws.choice(range(1, n + 1)), tuple(_length(draws, is_open, "b") for _ in range(3)))
    base = Base(yaw=sp.pi / 6, tilt=draws.choice((sp.S.Zero, sp.pi / 2))) if draws.integer_below(5) == 0 else Base()
    chain = Chain(name, joints, ("vx",), base, tool, name)
    return Robot(chain.with_task(*_task(chain, draws)))


def _joint(draws: Stream, i: int, is_open: bool, oblique: bool) -> Joint:
    alpha = draws.choice(OBLIQUE if oblique and draws.integer_below(2) else (0, 0, 90, -90, 90, 180)) * sp.pi / 180
    own, a, other = draws.integer_below(4) == 0, _length(draws, is_open, "a"), _length(draws, is_open, "d")
    offset = draws.choice((0, 0, 0, 90, 180, 30)) * sp.pi / 180
    if own:
        theta = draws.choice((0, 0, 90, 45 if oblique else 0)) * sp.pi / 180
        return Joint("P", theta, sp.Symbol(f"d{i}") + draws.choice((0, 0, sp.Rational(1, 10))), a, alpha)
    return Joint("R", sp.Symbol(f"theta{i}") + offset, other, a, alpha)


def _length(draws: Stream, is_open: bool, letter: str) -> sp.Expr:
    if draws.integer_below(5) < 2:
        return sp.S.Zero
    if is_open and draws.integer_below(3):
        return sp.Symbol(f"{letter if letter != 'd' else 'h'}{1 + draws.integer_below(3)}")
    return sp.Rational(draws.choice(LENGTHS)) * draws.choice((1, 1, 1, -1))


def _task(chain: Chain, draws: Stream) -> tuple[str, ...]:
    usual = default_task(chain)
    if draws.integer_below(3) or len(usual) == 1:
        return usual
    return tuple(row for row in VELOCITY_NAMES if row in usual and draws.integer_below(4)) or usual


# --- what is false ---


@dataclass(frozen=True)
class Outcome:
    """What became of an arm: what is false of it, what is missing, and how long it took."""

    false: tuple[str, ...]
    missing: tuple[str, ...]
    seconds: float


def outcome(robot: Robot, seconds: float) -> Outcome:
    """Solve an arm, and look for what is false."""
    said: list[str] = []
    before = time.process_time()
    write_solution(robot, "json", seconds, said.append, lambda _: nullcontext())
    took = time.process_time() - before
    content = json.loads("".join(said))
    missing = tuple(content.get("missing", ()))
    singular = () if missing else solve(robot.chain).singular or ()
    false = [*_false(robot.chain, content, missing), *_false_words(robot.chain, singular, content)]
    if took > seconds + SLACK:
        false.append(f"it took {took:.1f} s, and had {seconds:g}")
    if missing and "All results given here are complete." not in content["note"]:
        false.append("something is missing, and that is not said")
    return Outcome(tuple(false), missing, took)


def _false(chain: Chain, content: Mapping[str, Any], missing: Sequence[str]) -> Iterator[str]:
    draws = Stream(f"looked at/{chain.name}")
    for _ in range(3):
        values = {s.name: 0.3 + draws.integer_below(900) / 1000 for s in chain.parameters}
        joints = {q.name: draws.uniform(-3, 3) for q in chain.q}
        arm, q = NumericChain(chain, values), np.array([joints[s.name] for s in chain.q])
        known = {**values, **joints}
        jacobian = arm.jacobian(q)
        yield from _differs("the position", content["position"], arm.point(q), known)
        yield from _differs("the Jacobian of the point", content["jacobian"], jacobian[:3], known)
        yield from _differs("the geometric Jacobian", content["geometric_jacobian"], jacobian, known)
        rows = [VELOCITY_NAMES.index(row) for row in chain.task]
        if content["determinant"] is not None:
            yield from _differs("det J", content["determinant"], np.linalg.det(jacobian[rows]), known)
    if "singular" not in missing:
        yield from _false_of_set(chain, content, "tested" in missing)


def _differs(what: str, told: Any, right: Any, values: Mapping[str, float]) -> Iterator[str]:
    if told is not None and not np.allclose(_numbers(told, values), right, atol=1e-9):
        yield f"{what} is another: {_numbers(told, values)} and not {right}"


def _numbers(told: Any, values: Mapping[str, float]) -> Any:
    if isinstance(told, list):
        return np.array([_numbers(entry, values) for entry in told])
    return complex(sp.N(_read(told).xreplace({sp.Symbol(k): sp.Float(v, 20) for k, v in values.items()}))).real


def _read(text: str) -> sp.Expr:
    return to_sympy(parse_formula(text))


def _false_of_set(chain: Chain, content: Mapping[str, Any], untested: bool) -> Iterator[str]:
    """Yield what is false of a singular set; where its own test is missing, it can't tell what that would find."""
    note = content.get("note", "")
    if content["singular"] is None:
        if "every configuration" in note and not _is_low_everywhere(chain):
            yield "the rank is told to be low in every configuration, and is not"
        return
    parts = content["singular"]
    ways = [[_read(text) for text in part["conditions"]] for part in parts]
    out = check_rank_loss(chain, ways, STARTS)
    for k in out.full_rank_branches:
        yield f"J keeps its rank where {parts[k]['condition']} = 0"
    for k, part in enumerate(parts):
        # For other lengths there may be some.
        is_told = untested or "No configuration was found" in note
        if not out.samples[k] and not chain.parameters and not is_told:
            yield f"no configuration was found in which {part['condition']} = 0"
        yield from _false_solutions(chain, part, ways[k])
    if out.unexplained_configurations and "is not complete" not in note:
        yield (
            f"{len(out.unexplained_configurations)} of {out.search_count} searches ended elsewhere, as at "
            f"{out.unexplained_configurations[0].round(5)}"
        )


def _false_words(chain: Chain, singular: Sequence[SingularComponent], content: Mapping[str, Any]) -> Iterator[str]:
    """Yield what configurations are said to look like, or to be, and do not, or are not; at finds of a search."""
    for one in singular:
        yield from _false_of_looks(chain, one.conditions, one.kind)
        for values, kind in one.cases:
            at = [equation for joint, value in values for equation in _equations(joint, value)]
            yield from _false_of_looks(chain, at, kind)
    for special in content.get("special_lengths", ()):
        length, value = map(_read, special["lengths"].split(" = "))
        for part in special["singular"]:
            kind = Classification(part["type"] or "", bool(part["uniform"]), part["meaning"] or "")
            there = substitute_arm_lengths(chain, {length: value})
            for false in _false_of_looks(there, [_read(text) for text in part["conditions"]], kind):
                yield f"for {special['lengths']}: {false}"


def _equations(joint: sp.Symbol, value: sp.Expr) -> list[sp.Expr]:
    turn = joint - value
    return [sp.sin(turn), sp.cos(turn) - 1] if joint.name.startswith("theta") else [turn]


def _false_of_looks(chain: Chain, conditions: Sequence[sp.Expr], kind: Classification) -> Iterator[str]:
    out = check_rank_loss(chain, [conditions], STARTS, seed="looks")
    samples = [Sample(out.arms[arm], q) for arm, q in out.samples[0]]
    where = " and ".join(f"{condition} = 0" for condition in conditions)
    false = [sample for sample in samples if kind.meaning and not statement_holds(chain, kind.meaning, sample)]
    if false:
        yield f"{kind.meaning}, is said where {where}, and is not so at {false[0].q.round(5)}, nor at {len(false) - 1}"
    others = [sample for sample in samples if not all_have_kind(chain, kind, [sample])]
    if len(others) > len(samples) // 25:  # some are next to where a condition more holds, and taken for that
        yield f"{kind.kind}, is said where {where}, and there are others"


def _is_low_everywhere(chain: Chain) -> bool:
    draws = Stream(f"everywhere/{chain.name}")
    rows = [VELOCITY_NAMES.index(row) for row in chain.task]
    arm = NumericChain(chain, {s.name: draws.uniform(0.3, 1.2) for s in chain.parameters})
    q = np.array([[draws.uniform(-3, 3) for _ in chain.q] for _ in range(5)])
    return bool(np.all(np.linalg.matrix_rank(arm.jacobian(q)[:, rows], tol=1e-9) < min(len(rows), chain.n)))


def _false_solutions(chain: Chain, part: Mapping[str, Any], conditions: Sequence[sp.Expr]) -> Iterator[str]:
    """Yield joint values that don't satisfy the conditions; those that are complex for some lengths are left out."""
    if part["solutions"] is None:
        return
    lengths = {s: sp.Rational(37 + 11 * i, 100) for i, s in enumerate(chain.parameters)}
    names, values = zip(*part["solutions"].items(), strict=True)
    for chosen in product(*values):
        at = {
            sp.Symbol(name): sp.N(_read(text).xreplace(lengths), 30) for name, text in zip(names, chosen, strict=True)
        }
        if any(abs(sp.im(value)) > 1e-12 for value in at.values()):
            continue
        rest = [abs(complex(sp.N(c.xreplace(lengths).xreplace(at), 20))) for c in conditions]
        if max(rest) > 1e-9:
            yield f"{dict(zip(names, chosen, strict=True))} is told of {part['condition']} = 0, and is no solution"


# --- the program ---


def every_arm(count: int, seed: str, seeds: int) -> Iterator[tuple[str, Robot]]:
    """Yield what is looked at, with a name for each."""
    yield from ((robot.chain.name, robot) for robot in arms(count, seed))
    yield from of_families(seeds)


def of_families(seeds: int) -> Iterator[tuple[str, Robot]]:
    """Yield the arms of problems of random families, by the names of the problems."""
    for family, seed in product(FAMILIES, range(seeds)):
        yield f"{family}/{seed}", Robot(sample_chain(ProblemId(family, seed, variation="full")))


def main() -> int:
    """Print what is false of each arm; return 1 if anything is."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--seeds", type=int, default=60, help="problems of each family random-2 to -4")
    parser.add_argument("--seed", default="a")
    parser.add_argument("--seconds", type=float, default=20)
    options = parser.parse_args()
    false = 0
    for name, robot in every_arm(options.count, options.seed, options.seeds):
        result = outcome(robot, options.seconds)
        missing = f", without {', '.join(result.missing)}" if result.missing else ""
        print(f"{name}: {result.seconds:.1f} s{missing}", flush=True)
        if result.false:
            false += 1
            print(*result.false, robot_text(robot, "dh"), sep="\n  ", flush=True)
    print(f"{false} arms have false statements")
    return 1 if false else 0


if __name__ == "__main__":
    sys.exit(main())
