"""Standard (distal) Denavit-Hartenberg tables: frame i stands at the end of link i, on the axis of joint i + 1."""

from qdot.exercises.arm.conventions.base import Convention


class StandardDh(Convention):
    """A row is Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i), as the base class has it: arms are worked out in this table."""

    name, title = "dh", "standard"
    aliases = ("standard", "standard-dh", "distal", "denavit-hartenberg")
    misreadings = frozenset({"modified-dh"})
