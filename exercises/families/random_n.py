"""random-2, random-3, random-4: arms whose very structure is drawn, from all clean structures there are.

A class of structures that are the same problem is drawn with equal chances, then a structure of that class, then
what leaves the problem what it is: mirror images, zeros of the joints, whether the table or the point of interest has
the last length, a place for the base and how it is turned, the rows of the task going with it. One length that no
condition depends on stays open, if there is one; the others are numbers for which every condition of the singular set
can hold.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache, partial
from itertools import combinations, zip_longest

import numpy as np
import sympy as sp

from exercises.arm.chain import TASK_ROWS, Base, Chain, Joint
from exercises.arm.kinematics import rot_x, rot_z
from exercises.arm.singularity import singular_set
from exercises.difficulty import HARDEST, in_words, step
from exercises.errors import QdotError
from exercises.families.base import Family, on_the_floor, sign, standing_in_plane, turned, with_point
from exercises.families.base import centimetres as cm
from exercises.families.structures import Structure, chain_of, clean_classes, is_clean
from exercises.formula.expression import read
from exercises.formula.program import Program, compile_program, evaluate
from exercises.stream import Stream

Band = tuple[int, int]
Accepts = Callable[[Chain], bool]
Values = dict[sp.Symbol, sp.Rational]

TRIES, ROUNDS, NUMBERS = 400, 4, 60
"""Arms drawn in all, arms of one structure, and draws of numbers for one arm, before there is said to be none."""
APART = sp.Rational(5, 100)
POSES, CLEARLY = 400, 0.02
"""A condition can hold if it takes both signs at so many poses, on either side by that part of its largest value."""


def _sample(n: int, rng: Stream, band: Band | None = None, accepts: Accepts | None = None) -> Chain:
    low, high = band or (0, HARDEST)
    classes = [near for alike in clean_classes(n) if (near := _near(alike, low, high))]
    refused: set[Structure] = set()
    in_band = False
    for structure in (_order(classes, rng) * ROUNDS)[:TRIES]:
        chain = None if structure in refused else _arm(structure, rng)
        if chain is None or not low <= step(chain) <= high:
            continue
        in_band = True
        if accepts is None or accepts(chain):
            return chain
        refused.add(structure)
    which = f"of difficulty {in_words(low, high)}" if band else "of any difficulty"
    if in_band:
        raise QdotError(f"random-{n} has no arm {which} that can be asked all of these questions")
    steps = [structure.step for alike in clean_classes(n) for structure in alike]
    range_of_steps = in_words(min(steps), max(steps))
    raise QdotError(f"random-{n} has no arm {which}; its arms are of difficulty {range_of_steps}")


def _order(classes: list[tuple[Structure, ...]], rng: Stream) -> list[Structure]:
    """Return all structures in random order, one of every class before the second of any."""
    rounds = zip_longest(*(rng.shuffled(alike) for alike in rng.shuffled(classes)))
    return [structure for in_round in rounds for structure in in_round if structure is not None]


def _near(alike: tuple[Structure, ...], low: int, high: int) -> tuple[Structure, ...]:
    """Return the structures whose arms may be in the band: a slide's zero adds terms, equal numbers take some away."""
    return tuple(structure for structure in alike if low - 1 <= structure.step <= high + 1)


def _arm(structure: Structure, rng: Stream) -> Chain | None:
    """Return an arm of a structure; None where no numbers drawn let every condition hold."""
    senses = tuple(sign(rng) for _ in structure.rows)
    plain = chain_of(structure.rows, structure.task, f"random-{len(structure.rows)}", senses)
    components = singular_set(plain) or ()
    conditions = tuple(condition for component in components for condition in component.conditions)
    free = [s for s in plain.parameters if not any(condition.has(s) for condition in conditions)]
    kept = rng.choice(free) if free else None
    values = _lengths(plain, kept, conditions, rng)
    if values is None:
        return None
    zeros = [
        turned(rng, 30 if i == 1 else 90) if joint.kind == "R" else sign(rng) * cm(rng, 10, 90)
        for i, joint in enumerate(plain.joints, 1)
    ]
    chain = _placed(_filled(plain, values, zeros), rng)
    if not is_clean(chain):  # a slide's zero adds too many terms
        angles = [sp.S.Zero if joint.kind == "P" else zero for joint, zero in zip(plain.joints, zeros, strict=True)]
        chain = replace(chain, joints=_filled(plain, values, angles).joints)
    joints, point = with_point(rng, chain.joints)
    return replace(chain, joints=joints, tool=point)


def _lengths(chain: Chain, kept: sp.Symbol | None, conditions: tuple[sp.Expr, ...], rng: Stream) -> Values | None:
    """Return a number for every length but the one kept, no two nearly equal, such that every condition can hold."""
    for _ in range(NUMBERS):
        values = {symbol: cm(rng, 10, 95) for symbol in chain.parameters if symbol != kept}
        apart = all(abs(x - y) >= APART for x, y in combinations(values.values(), 2))
        if apart and _can_hold(conditions, chain, values):
            return values
    return None


def _filled(plain: Chain, values: Values, zeros: list[sp.Expr]) -> Chain:
    joints = []
    for joint, q, zero in zip(plain.joints, plain.q, zeros, strict=True):
        a, d, theta = (entry.xreplace(values) for entry in (joint.a, joint.d, joint.theta))
        own = (theta + zero, d) if joint.kind == "R" else (theta, q + zero)
        joints.append(Joint(joint.kind, *own, a, joint.alpha))
    return replace(plain, joints=tuple(joints))


def _placed(chain: Chain, rng: Stream) -> Chain:
    """Return the arm on the floor, under the ceiling or on a wall, with the rows that its task then has."""
    yaw, tilt = turned(rng, 90), rng.choice((sp.S.Zero, sp.pi, sp.pi / 2, -sp.pi / 2))
    rotation = rot_z(yaw) * rot_x(tilt)
    names = {"xyz"[k]: "xyz"[next(i for i in range(3) if rotation[i, k] != 0)] for k in range(3)}
    rows = {row[0] + names[row[1]] for row in chain.task}
    task = tuple(row for row in TASK_ROWS if row in rows)
    turned_chain = replace(chain, task=task, base=Base(yaw=yaw, tilt=tilt))
    standing = standing_in_plane(rng) if turned_chain.is_planar else on_the_floor(rng)
    return replace(turned_chain, base=replace(turned_chain.base, position=standing.position))


# --- numbers for which conditions can hold ---


@lru_cache(maxsize=64)
def _poses(kinds: str) -> np.ndarray:
    stream, ends = Stream(f"random/{kinds}"), {"R": np.pi, "P": 2.0}
    return np.array([[stream.uniform(-ends[kind], ends[kind]) for kind in kinds] for _ in range(POSES)])


@lru_cache(maxsize=1024)
def _program(conditions: tuple[sp.Expr, ...]) -> Program:
    return compile_program([read(str(condition)) for condition in conditions])


def _can_hold(conditions: tuple[sp.Expr, ...], chain: Chain, values: Values) -> bool:
    """Tell whether each condition clearly takes both signs over the joints, so that it vanishes in between."""
    if not conditions:
        return True
    poses = _poses("".join(joint.kind for joint in chain.joints))
    known = {q.name: column for q, column in zip(chain.q, poses.T, strict=True)}
    known |= {symbol.name: np.full(POSES, float(value)) for symbol, value in values.items()}
    evaluated = evaluate(_program(conditions), known, POSES)[0].real
    least = CLEARLY * np.abs(evaluated).max(axis=1)
    return bool(np.all((evaluated.min(axis=1) < -least) & (evaluated.max(axis=1) > least)))


RANDOM = tuple(
    Family(f"random-{n}", f"Random arm of {word} joints", "equations 6.1 to 6.12", partial(_sample, n), varied=True)
    for n, word in ((2, "two"), (3, "three"), (4, "four"))
)
