"""Define the convention of standard (distal) Denavit-Hartenberg tables: z_i is the axis of joint i + 1."""

from qdot.exercises.arm.conventions.base import Convention


class StandardDh(Convention):
    """A standard table, with rows Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i); all results are derived from this table."""

    name, title = "dh", "standard"
    aliases = ("standard", "standard-dh", "distal", "denavit-hartenberg")
    specific_mistakes = frozenset({"modified-dh"})
