"""Answers as students type them, right and wrong, with what STACK and Moodle must do with them.

The formulas and sets are those of TEXTBOOK, the planar arm with two links. A number is typed in each of the forms in
`write_numbers`.
"""

import re

from qdot.exercises.exports.platform_markup import format_decimal

RIGHT, WRONG, INVALID = "right = full", "wrong < full", "not read = not marked"
"""The checks as which the answers are counted. An invalid answer is not an attempt, and STACK says what to type."""

POSITIONS: tuple[tuple[str, tuple[str, str]], ...] = (
    (RIGHT, ("a1*c1 + a2*c12", "a1*s1 + a2*s12")),
    (RIGHT, ("a_1*cos(theta_1) + a_2*cos(theta_1 + theta_2)", "a_1*sin(theta_1) + a_2*sin(theta_1 + theta_2)")),
    (RIGHT, ("a1*cos(t1) + a2*cos(q1 + q2)", "a1*S1 + a2*sin(th12)")),
    (RIGHT, ("cos(θ1)*(a1 + a2*c_2) - a2*s_1*s_2", "a1*s1 + a2*(s1*c2 + c1*s2)")),
    (WRONG, ("a1*c1 + a2*c2", "a1*s1 + a2*s2")),
    (WRONG, ("a1*c1 + a2*c12", "a1*s1 - a2*s12")),
    (INVALID, ("l1*c1 + l2*c12", "l1*s1 + l2*s12")),
    (INVALID, ("x = a1*c1 + a2*c12", "y = a1*s1 + a2*s12")),
    (INVALID, ("a1*c1 + a2*c12", "")),
)
DETERMINANTS: tuple[tuple[str, str], ...] = (
    (RIGHT, "a1*a2*sin(theta2)"), (RIGHT, "a_1*a_2*sin(theta_2)"), (RIGHT, "a1*a2*s2"),
    (RIGHT, "a1*a2*(c1*s12 - s1*c12)"), (RIGHT, "a1*a2*cos(π/2 - θ2)"), (RIGHT, "a1*a2*sin(2*t2)/(2*cos(t2))"),
    (WRONG, "-a1*a2*sin(theta2)"), (WRONG, "a1*a2"), (WRONG, "a1*a2*cos(theta2)"),
    (INVALID, "a1*a2*sin(x)"), (INVALID, "det = a1*a2*s2"), (RIGHT, "a1a2*sin(theta2)"),
    (INVALID, "a1*a2*sin theta2"), (INVALID, "{a1*a2*s2}"),
)  # fmt: skip
SETS: tuple[tuple[str, str], ...] = (
    (RIGHT, "{theta2 = 0, theta2 = pi}"), (RIGHT, "{theta2 = k*pi}"), (RIGHT, "theta_2 = n*π"), (RIGHT, "{t2 = 0, pi}"),
    (RIGHT, "theta2 = 0 or theta2 = -pi"), (RIGHT, "q2 = [0, pi]"), (RIGHT, "sin(theta2) = 0"),
    (RIGHT, "{theta2 = pi/2 +- pi/2}"), (RIGHT, "2*theta2 = 2*pi*k"), (RIGHT, "{0 = θ2, 3*pi = θ2}"),
    (WRONG, "theta2 = +-pi"), (WRONG, "{theta2 = 0}"), (WRONG, "{theta2 = pi/2}"), (WRONG, "{theta2 = k*pi/2}"),
    (WRONG, "{theta2 = 0, theta2 = 180}"), (WRONG, "{theta1 = 0, theta1 = pi}"),
    (INVALID, "{0, pi}"), (INVALID, "theta2 = ±pi"), (INVALID, "{theta2 = 0, theta2 = 3.14159}"),
    (INVALID, "theta2 = 0, theta2 = pi"), (INVALID, "{theta3 = 0}"), (INVALID, "theta2 = 0 and theta2 = pi"),
)  # fmt: skip


def write_numbers(value: float) -> dict[str, str]:
    """Return a number in several forms, each with its description."""
    rounded, (mantissa, power) = format_decimal(value, 3), f"{value:.2e}".split("e")
    return {
        "three digits": rounded, "all digits": format_decimal(value), "zeros at the end": f"{value:.6f}",
        "no zero before the point": re.sub(r"^(-?)0\.", r"\1.", rounded), "spaces": f"  {rounded} ",
        "exponent": f"{mantissa}e{int(power)}", "power of ten": f"{mantissa}*10^{int(power)}",
        "fraction": f"{round(value * 10000)}/10000", "unit": f"{rounded} m", "comma": rounded.replace(".", ","),
        "negative": format_decimal(-value, 3), "zero": "0", "doubled": format_decimal(2 * value, 3),
        "thousandth": format_decimal(value / 1000, 3), "name": f"v = {rounded}",
    }  # fmt: skip


WRONG_NUMBERS = {"negative", "zero", "doubled", "thousandth"}
STACK_CHECKS = dict.fromkeys(WRONG_NUMBERS, WRONG) | dict.fromkeys(("unit", "comma", "name"), INVALID)
"""The checks of a single number in STACK, by form; numbers in other forms are right."""
NUMBERS_READ_BY_MOODLE = ("exponent", "power of ten", "no zero before the point", "spaces", "unit")
"""Forms of numbers that Moodle reads. In English, it does not read fractions and a decimal comma."""
