"""random-2, random-3, random-4: arms whose very structure is drawn, from all clean structures there are.

A structure is drawn with equal chances from the table of `structures`, then joint offsets, numbers for lengths, and a
place for the base. One length that no condition depends on stays open, if there is one; the others are numbers,
drawn until every condition of the singular set can hold.
"""

from collections.abc import Callable
from functools import partial
from itertools import combinations

import sympy as sp

from exercises.arm.chain import Base, Chain, Joint
from exercises.arm.classification import samples_on
from exercises.arm.singularity import Component, singular_set
from exercises.difficulty import step
from exercises.errors import QdotError
from exercises.families.base import Family, centimetres, on_the_floor, sign, turned
from exercises.families.structures import Structure, chain_of, clean_structures
from exercises.stream import Stream

Band = tuple[int, int]
Accepts = Callable[[Chain], bool]

TRIES = 400
APART = sp.Rational(5, 100)


def _sample(n: int, rng: Stream, band: Band | None = None, accepts: Accepts | None = None) -> Chain:
    low, high = band or (0, 9)
    wanted = [structure for structure in clean_structures()[n] if low - 1 <= structure.step <= high + 1]
    refused: set[Structure] = set()
    for _ in range(TRIES if wanted else 0):
        structure = rng.choice(wanted)
        if structure in refused:
            continue
        chain = _arm(structure, rng)
        if chain is None or not low <= step(chain) <= high:
            continue
        if accepts is None or accepts(chain):
            return chain
        refused.add(structure)
    which = f"of difficulty {low} to {high}" if band else "of any difficulty"
    raise QdotError(f"random-{n} has no arm {which} that can be asked all of these questions")


def _arm(structure: Structure, rng: Stream) -> Chain | None:
    """Return an arm of a structure; None where no numbers drawn let every condition hold."""
    plain = chain_of(structure.rows, structure.task, f"random-{len(structure.rows)}")
    components = singular_set(plain) or ()
    depended = {symbol for component in components for c in component.conditions for symbol in c.free_symbols}
    free = [symbol for symbol in plain.parameters if symbol not in depended]
    kept = rng.choice(free) if free else None
    offsets = [
        turned(rng, 30 if i == 1 else 90) if joint.kind == "R" else sign(rng) * centimetres(rng, 10, 90)
        for i, joint in enumerate(plain.joints, 1)
    ]
    for _ in range(20):
        values = {symbol: centimetres(rng, 10, 95) for symbol in plain.parameters if symbol != kept}
        if any(abs(a - b) < APART for a, b in combinations(values.values(), 2)):
            continue
        chain = _filled(plain, values, offsets, on_the_floor(rng))
        found = singular_set(chain)
        if found is not None and len(found) == len(components) and all(_can_hold(chain, part) for part in found):
            return chain
    return None


def _filled(plain: Chain, values: dict[sp.Symbol, sp.Rational], offsets: list[sp.Expr], base: Base) -> Chain:
    joints = []
    for joint, q, offset in zip(plain.joints, plain.q, offsets, strict=True):
        a, d, theta = (entry.xreplace(values) for entry in (joint.a, joint.d, joint.theta))
        revolute = joint.kind == "R"
        own = (theta + offset, d) if revolute else (theta, q + offset)
        joints.append(Joint(joint.kind, *own, a, joint.alpha))
    return Chain(plain.name, tuple(joints), plain.task, base, None, plain.title)


def _can_hold(chain: Chain, component: Component) -> bool:
    """Tell whether there are configurations on every piece of a component."""
    if component.solutions is not None:
        return all(value.is_real is not False for _, values in component.solutions for value in values)
    return all(samples_on(chain, piece, "random", arms=1, each=1) for piece in component.pieces())


RANDOM = tuple(
    Family(f"random-{n}", f"Random arm of {word} joints", "equations 6.1 to 6.12", partial(_sample, n), varied=True)
    for n, word in ((2, "two"), (3, "three"), (4, "four"))
)
