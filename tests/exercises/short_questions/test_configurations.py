"""Poses of short questions: clearly regular, or singular, whatever the shape of the Jacobian."""

import pytest
import sympy as sp

from qdot.exercises.arm.chain import Chain, Joint
from qdot.exercises.short_questions.configurations import make_regular_configuration

LONG = Chain("3R", tuple(Joint("R", sp.Symbol(f"theta{i}"), 0, 1, 0) for i in (1, 2, 3)), ("vx", "vy"))
SQUARE = Chain("2R", LONG.joints[:2], ("vx", "vy"))
HIGH = Chain("2R", LONG.joints[:2], ("vx", "vy", "wz"))


@pytest.mark.parametrize("chain", [LONG, SQUARE, HIGH], ids=["more joints", "square", "more rows"])
def test_a_bent_arm_is_regular_and_a_stretched_one_is_not(chain: Chain) -> None:
    bent = dict.fromkeys(chain.q, sp.pi / 3)
    assert make_regular_configuration(chain, bent) is not None
    stretched = {q: sp.Integer(0) for q in chain.q}
    by_angular_velocity = chain is HIGH
    assert (make_regular_configuration(chain, stretched) is None) != by_angular_velocity
    assert make_regular_configuration(chain, {**bent, chain.q[0]: sp.Symbol("x")}) is None
