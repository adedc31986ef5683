"""Standard (distal) Denavit-Hartenberg tables: frame i is at the end of link i, on the axis of joint i + 1."""

from qdot.exercises.arm.conventions.base import Convention


class StandardDh(Convention):
    """A row is Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i), as in the base class; results are derived from this table."""

    name, title = "dh", "standard"
    aliases = ("standard", "standard-dh", "distal", "denavit-hartenberg")
    misreadings = frozenset({"modified-dh"})
