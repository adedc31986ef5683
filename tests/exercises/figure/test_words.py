"""The description of a figure in words: all of the table is in it."""

import pytest
import sympy as sp

from exercises.arm.chain import Chain, Joint
from exercises.figure import alt_text

D2, A2 = sp.symbols("d2 a2")


@pytest.mark.parametrize(("turned", "said"), [(sp.pi / 2, True), (0, False)])
def test_the_angle_in_the_row_of_a_slide_is_told_where_there_is_one(turned: sp.Expr, said: bool) -> None:
    chain = Chain("arm", (Joint("R", sp.Symbol("theta1"), 0, 1, 0), Joint("P", turned, D2, A2, 0)), ("vx", "vz"))
    text = alt_text(chain)
    assert "Joint 2 is prismatic" in text
    assert ("x2 is turned by 90" in text) == said
    assert ("x2 is turned" in text) == said
    assert "x1 is turned" not in text
