"""The standard (distal) Denavit-Hartenberg tables: frame i is at the end of link i, on the axis of joint i + 1."""

from qdot.exercises.arm.conventions.base import Convention


class StandardDh(Convention):
    """A standard table, with rows Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i); all results are derived from it."""

    name, title = "dh", "standard"
    aliases = ("standard", "standard-dh", "distal", "denavit-hartenberg")
    specific_mistakes = frozenset({"modified-dh"})
