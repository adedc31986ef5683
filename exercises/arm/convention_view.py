"""An arm's table, base and point as its convention tells them, and which frame stands on the axis of a joint.

    dh            frame i - 1 stands on the axis of joint i; a row is Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i)
    modified-dh   frame i stands on it; a row is Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(theta_i) Tz(d_i) (Craig)
    screws        the axes are told where they are at home, in the world frame; no frames stand on the links; twists
                  are (omega, v), or (v, omega) if that is the arm's `twist_order`

Rx and Tx of a modified row commute and join the row before it, so that both tables hold the same numbers: `alpha` and
`a` of row i are those of row i + 1 of the other. What the last standard row has of them places P in the last frame.
"""

import re
from dataclasses import replace

import sympy as sp

from qdot.exercises.arm.chain import TASK_ROWS, TWIST_ORDERS, Base, Chain, Joint, Point


def is_modified(chain: Chain) -> bool:
    """Whether an arm is told by a modified table."""
    return chain.convention == "modified-dh"


def frame_on_axis(chain: Chain, joint: int) -> int:
    """Return the number of the frame whose z axis is that of a joint, from 1."""
    return joint if is_modified(chain) else joint - 1


def modified_rows(chain: Chain) -> tuple[Base, list[Joint]]:
    """Return the modified table of an arm, alpha and a of each row standing before its joint, and what is left of its
    base: the first row takes what turns about x and slides along it.
    """
    base = chain.base
    if base.yaw != 0 or any(base.position[1:]):
        left, before = Base(base.position, base.yaw), (sp.S.Zero, base.tilt)
    else:
        left, before = Base(), (base.position[0], base.tilt)
    links = [before, *((joint.a, joint.alpha) for joint in chain.joints[:-1])]
    return left, [replace(joint, a=a, alpha=alpha) for joint, (a, alpha) in zip(chain.joints, links, strict=True)]


def modified_point(chain: Chain) -> Point:
    """Return the point of interest as it is told in a frame of the modified table."""
    point, (_, rows) = chain.point, modified_rows(chain)
    link = chain.joints[point.frame - 1] if point.frame else rows[0]
    c, s, (x, y, z) = sp.cos(link.alpha), sp.sin(link.alpha), point.offset
    return Point(point.frame, (link.a + x, c * y - s * z, s * y + c * z))


def told_base(chain: Chain) -> Base:
    """Return where frame O_0 stands in the world, as the convention tells it."""
    return modified_rows(chain)[0] if is_modified(chain) else chain.base


def told_rows(chain: Chain) -> list[Joint]:
    """Return the rows of the table, of which `a` and `alpha` stand before the joint if it is a modified one."""
    return modified_rows(chain)[1] if is_modified(chain) else list(chain.joints)


def told_point(chain: Chain) -> Point:
    """Return the point of interest in the frame that the convention puts on its link."""
    return modified_point(chain) if is_modified(chain) else chain.point


def up_to_frame(chain: Chain, frame: int) -> Chain:
    """Return the first joints of an arm, with the origin of the frame behind them as the point of interest."""
    joints = list(chain.joints[:frame])
    if is_modified(chain) and frame:  # the frame stands before the length and the twist of its link
        joints[-1] = replace(joints[-1], a=sp.S.Zero, alpha=sp.S.Zero)
    return replace(chain, joints=tuple(joints), tool=None)


def place_name(chain: Chain, frame: int) -> str | None:
    """Return what an arm's convention calls the place where the origin of a standard frame is, as in "O_2" or "P".

    None where no frame of a modified table has its origin there, or the arm is told by its axes.
    """
    if chain.convention == "dh":
        return f"O_{frame}"
    if chain.convention == "screws":
        return None
    if frame < chain.n and (chain.joints[frame].kind, chain.joints[frame].d) == ("R", 0):
        return f"O_{frame + 1}"
    if frame == chain.point.frame and chain.point.is_origin:
        return "P"
    length = chain.joints[frame - 1].a if frame else told_rows(chain)[0].a
    return f"O_{frame}" if length == 0 else None


_ORIGIN = re.compile(r"the origin O(\d+)")


def told_words(chain: Chain, words: str) -> str:
    """Return words on an arm with the names that its convention has for the origins of standard frames.

    Of a modified table that is another origin, or P; of an arm told by its axes the point on the axis that it is.

    >>> from qdot.exercises.arm.chain import Joint
    >>> turns = (Joint("R", f"theta{i}", 0, f"a{i}", 0) for i in (1, 2))
    >>> arm, words = Chain("arm", tuple(turns), ("vx",)), "the origin O1 lies on the axis of joint 2"
    >>> [told_words(replace(arm, convention=name), words)[:15] for name in ("dh", "modified-dh", "screws")]
    ['the origin O1 l', 'the origin O2 l', "q2' lies on the"]
    """
    names = {match[0]: _origin(chain, int(match[1])) for match in _ORIGIN.finditer(words)}
    if None in names.values():
        return true_of_all(chain)
    return _ORIGIN.sub(lambda match: str(names[match[0]]), words)


def _origin(chain: Chain, frame: int) -> str | None:
    if is_by_axes(chain):
        return f"q{frame + 1}'" if frame < chain.n and chain.joints[frame].kind == "R" else None
    name = place_name(chain, frame)
    return "the point" if name == "P" else name and f"the origin {name.replace('_', '')}"


def true_of_all(chain: Chain) -> str:
    """Return what is true of every singular configuration of an arm."""
    return f"the {'rows' if chain.n > len(chain.task) else 'columns'} of J are linearly dependent"


OMEGA = r"\omega"


def axis_symbol(chain: Chain, joint: int | None = None, at_home: bool = False) -> str:
    r"""Return what the axis of a joint is called, as LaTeX; of joint i, a revolute one, where none is named.

    Of an arm that is told by its axes, what is told has no prime, and what the joints before it have moved has one.

    >>> from qdot.exercises.arm.chain import Joint
    >>> arm = Chain("arm", (Joint("R", "theta1", 0, "a1", 0),), ("vx",), convention="modified-dh")
    >>> axis_symbol(arm), axis_symbol(arm, 1)
    ('z_{i}', 'z_{1}')
    >>> by_axes = replace(arm, convention="screws")
    >>> axis_symbol(by_axes, 1), axis_symbol(by_axes, 1, at_home=True)
    ("\\omega_{1}'", '\\omega_{1}')
    """
    if is_by_axes(chain):
        slides = joint is not None and chain.joints[joint - 1].kind == "P"
        return f"{'v' if slides else OMEGA}_{{{joint or 'i'}}}{'' if at_home else chr(39)}"
    return f"z_{{{_index(chain, joint)}}}"


def slide_symbol(chain: Chain) -> str:
    """Return what the axis of joint i is called if it is prismatic."""
    return "v_{i}'" if is_by_axes(chain) else axis_symbol(chain)


def vector_symbol(chain: Chain, joint: int | None = None) -> str:
    """Return what the vector from the axis of a joint to the point of interest is called, as LaTeX."""
    if chain.convention == "screws":
        return f"p_{{{joint or 'i'}}}"
    return f"p^*_{{{_index(chain, joint)}}}"


def is_omega_first(chain: Chain) -> bool:
    """Whether the angular velocity comes first in what an arm is asked about: by its axes, in their usual order."""
    return is_by_axes(chain) and chain.twist_order == TWIST_ORDERS[0]


def twist_rows(chain: Chain) -> tuple[str, ...]:
    """Return the components of a velocity in the order in which an arm is asked about."""
    return (*TASK_ROWS[3:], *TASK_ROWS[:3]) if is_omega_first(chain) else TASK_ROWS


def in_twist_order(chain: Chain, rows: sp.Matrix) -> sp.Matrix:
    """Return six rows, linear first, in that order; and, as it is its own inverse, the other way."""
    return rows[3:, :].col_join(rows[:3, :]) if is_omega_first(chain) else rows


def rows_of_twist(chain: Chain) -> list[int]:
    """Return where the components that are told stand in a twist (omega, v), in which screws are worked out.

    As it is its own inverse, it leads back, too.
    """
    return [0, 1, 2, 3, 4, 5] if is_omega_first(chain) else [3, 4, 5, 0, 1, 2]


def twist_told(chain: Chain, twists: sp.Matrix) -> sp.Matrix:
    """Return twists (omega, v), 6 x n, in the order in which they are told."""
    return twists.extract(rows_of_twist(chain), list(range(twists.cols)))


def adjoint_told(chain: Chain, adjoint: sp.Matrix) -> sp.Matrix:
    """Return a 6 x 6 matrix for twists (omega, v) as one for twists in the order in which they are told."""
    return adjoint.extract(rows_of_twist(chain), rows_of_twist(chain))


def _index(chain: Chain, joint: int | None) -> str:
    if joint is None:
        return "i" if is_modified(chain) else "i-1"
    return str(frame_on_axis(chain, joint))


def is_by_axes(chain: Chain) -> bool:
    """Whether an arm is told by its axes at home, so that no frames stand on its links."""
    return chain.convention == "screws"
