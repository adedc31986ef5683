"""`make mutants`: which changes are made, that each is one, and that the module is as before after it."""

from tests.support import ROOT
from tests.tools.mutants import MODULES, mutants, path_of

TEXT = """
LIMIT = 3

def small(x: int, *, last: int = 1) -> int:
    '''Say it.'''
    if x < LIMIT and not last:
        x += 1
    return min(x, last)[1:]
"""


def test_every_place_is_changed_once_at_a_time() -> None:
    found = [mutant.change for mutant in mutants(TEXT)]
    for change in (
        "3 -> 4", "1 -> 0", "x < LIMIT -> x <= LIMIT", "x < LIMIT -> x > LIMIT", "not last -> last",
        "x < LIMIT and (not last) -> x < LIMIT or not last", "x < LIMIT and (not last) -> not last", "x += 1 -> x -= 1",
        "x += 1 -> pass", "return min(x, last)[1:] -> return None", "min -> max", "1: -> :",
    ):  # fmt: skip
        assert change in found
    assert not any("Say it" in change or "int ->" in change for change in found)


def test_a_mutant_does_what_it_says_and_no_more() -> None:
    for mutant in mutants("def f(x):\n    return x + 2\n"):
        space: dict[str, object] = {}
        exec(mutant.code, space)
        due = {"x + 2 -> x - 2": 3, "2 -> 3": 8, "2 -> 1": 6}.get(mutant.change)
        assert space["f"](5) == due, mutant.change  # type: ignore[operator]


def test_the_modules_have_mutants_with_their_lines() -> None:
    assert all((ROOT / path_of(module)).exists() for module in MODULES)
    source = (ROOT / path_of("constants")).read_text(encoding="utf-8")
    found = list(mutants(source))
    assert len(found) > 80
    assert [mutant.number for mutant in found] == list(range(len(found)))
    assert all(0 < mutant.line <= source.count("\n") for mutant in found)
