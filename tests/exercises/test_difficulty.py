"""The difficulty of an arm counts terms as they are multiplied out, which is seldom done to count them."""

import sympy as sp

from exercises.arm.derivation import derive
from exercises.difficulty import _is_multiplied_out, _terms
from tests.support.problems import drawn
from tests.support.suites import several


def test_terms_are_counted_as_if_all_were_multiplied_out(family: str) -> None:
    for seed in range(several(1, 4)):
        chain = drawn(family, seed, "full").chain
        entries = [sp.expand(entry) for entry in derive(chain).jacobian]
        assert _terms(chain) == sum(len(sp.Add.make_args(entry)) for entry in entries if entry != 0)


def test_a_bracket_is_multiplied_out_before_its_terms_are_counted() -> None:
    x, y = sp.symbols("theta1 a1")
    assert _is_multiplied_out(2 * y * sp.sin(x + sp.pi / 3) - sp.cos(x)) and not _is_multiplied_out(y * (y + sp.sin(x)))
    assert not _is_multiplied_out(sp.sin(x * (x + y))) and not _is_multiplied_out(sp.sin(x) ** 2)
