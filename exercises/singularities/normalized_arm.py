"""Normalize an arm: remove joint offsets and the position of the base, on which singularities do not depend.

Many arms in a class of students have the same *normalized arm*. Results about the normalized arm, such as whether a
singularity is at the boundary, hold for all of these arms and are computed once.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import sympy as sp

from qdot.exercises.arm.chain import Base, Chain, is_joint_angle
from qdot.exercises.arm.trigonometry import wrap_angle
from qdot.exercises.singularities.singular_set import Component


@lru_cache(maxsize=1024)
def normalize_arm(chain: Chain) -> Chain:
    """Return the arm without joint offsets and without a title, with its base at the world's origin.

    If joint 1 is revolute, its d is set to zero. The base keeps its yaw and tilt, because the task's rows refer to
    world directions.
    """
    joints = [joint.with_variable_entry(q) for joint, q in zip(chain.joints, chain.q, strict=True)]
    if joints[0].is_revolute:
        joints[0] = replace(joints[0], d=sp.S.Zero)
    base = Base(yaw=chain.base.yaw, tilt=chain.base.tilt)
    return Chain("normalized", tuple(joints), chain.task, base, chain.point)


def normalize_conditions(chain: Chain, component: Component) -> list[str]:
    """Return a component of an arm's singular set as conditions (text) for the normalized arm.

    The order of the conditions does not depend on the joint offsets.
    """
    offsets = dict(zip(chain.q, chain.offsets, strict=True))
    if component.solutions is None:
        shifts = {q: q - offset for q, offset in offsets.items() if offset != 0}
        conditions = (sp.expand(condition.xreplace(shifts)) for condition in component.conditions)
        return Component(tuple(conditions), None).list_pieces()
    shifted_component = component.map_values(lambda joint, value: _shift_value(value, offsets[joint], joint))
    pairs = shifted_component.solutions or ()
    solutions = tuple((joint, tuple(sorted(values, key=sp.default_sort_key))) for joint, values in pairs)
    return replace(shifted_component, solutions=solutions).list_pieces()


def is_independent_of_joint_1(chain: Chain) -> bool:
    """Return whether the value of joint 1 does not affect whether the arm is singular.

    This is so if joint 1 is prismatic, or if its rotation maps the task's rows to themselves.
    """
    if chain.joints[0].is_prismatic:
        return True
    rows = {kind: {row[1] for row in chain.task if row[0] == kind} for kind in "vw"}
    is_upright = chain.base.tilt in (0, sp.pi)
    return all(len(names) in (0, 3) or (is_upright and names in ({"x", "y"}, {"z"})) for names in rows.values())


def normalize_joint_values(chain: Chain, values: Mapping[sp.Symbol, sp.Expr]) -> tuple[sp.Expr, ...]:
    """Return joint values of an arm, in the order of its joints, as values of the normalized arm."""
    return tuple(_shift_value(values[q], offset, q) for q, offset in zip(chain.q, chain.offsets, strict=True))


def _shift_value(value: sp.Expr, offset: sp.Expr, joint: sp.Symbol) -> sp.Expr:
    return wrap_angle(value + offset) if is_joint_angle(joint) else sp.expand(value + offset)
