"""An arm without what its singularities do not hang on: from where joints are counted, and where the base stands.

Many arms of a class have the same bare one. What is established of it, as whether a singularity is at the boundary,
holds for all of them, and is established once.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Base, Chain
from qdot.exercises.arm.singularity import Component, principal


@lru_cache(maxsize=1024)
def bare(chain: Chain) -> Chain:
    """Return the arm with joints counted from the zeros of its table, its base in the world's origin, untitled.

    What joint 1 turns starts in its foot. The base keeps its turn and tilt: the task counts directions of the world.
    """
    joints = [
        replace(joint, theta=q) if joint.kind == "R" else replace(joint, d=q)
        for joint, q in zip(chain.joints, chain.q, strict=True)
    ]
    if joints[0].kind == "R":
        joints[0] = replace(joints[0], d=sp.S.Zero)
    base = Base(yaw=chain.base.yaw, tilt=chain.base.tilt)
    return Chain("bare", tuple(joints), chain.task, base, chain.point)


def bare_pieces(chain: Chain, component: Component) -> list[str]:
    """Return a component of an arm's singular set as conditions of the bare arm, in an order that no zero changes."""
    offsets = dict(zip(chain.q, chain.offsets, strict=True))
    if component.solutions is None:
        back = {q: q - offset for q, offset in offsets.items() if offset != 0}
        conditions = (sp.expand(condition.xreplace(back)) for condition in component.conditions)
        return Component(tuple(conditions), None).pieces()
    solutions = tuple(
        (joint, tuple(sorted((_moved(value, offsets[joint], joint) for value in values), key=sp.default_sort_key)))
        for joint, values in component.solutions
    )
    return Component(component.conditions, solutions).pieces()


def turns_all(chain: Chain) -> bool:
    """Tell whether joint 1 moves the arm as a whole, and the task counts as much after it as before.

    So it is for a slide, and for a turn about an axis with which the rows of the task turn into each other.
    """
    if chain.joints[0].kind == "P":
        return True
    rows = {kind: {row[1] for row in chain.task if row[0] == kind} for kind in "vw"}
    upright = chain.base.tilt in (0, sp.pi)
    return all(len(names) in (0, 3) or (upright and names in ({"x", "y"}, {"z"})) for names in rows.values())


def bare_values(chain: Chain, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, ...]:
    """Return joint values of an arm, in the order of its joints, as values of the bare arm."""
    return tuple(_moved(values[q], offset, q) for q, offset in zip(chain.q, chain.offsets, strict=True))


def _moved(value: sp.Expr, offset: sp.Expr, joint: sp.Symbol) -> sp.Expr:
    return principal(value + offset) if joint.name.startswith("theta") else sp.expand(value + offset)
