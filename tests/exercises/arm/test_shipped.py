"""What is shipped of structures: made by this very code, the same as when it is worked out, and else not looked at."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import sympy as sp

from qdot.exercises.arm import derivation, shipped, transforms
from qdot.exercises.arm.chain import Chain
from qdot.exercises.arm.derivation import structure
from qdot.exercises.arm.library import robot_path, robots
from qdot.exercises.arm.robot_file import read_robot
from qdot.exercises.arm.shipped import results_from_text, results_to_text
from qdot.exercises.arm.singularity import singular_set
from qdot.exercises.arm.trigonometry import Factored
from qdot.exercises.families import FAMILIES
from qdot.exercises.families.structures import build_arm, read_clean_structures
from qdot.exercises.generation import generate, questions_of, sample_chain
from qdot.exercises.notebook.notebook import notebook_text, solution_notebook
from qdot.exercises.problem.problem import ProblemId
from tests.support.suites import few_families, several
from tests.tools.shipped import lines, results_of

X, Y = sp.symbols("x y")
OF_STRUCTURES = [
    work for module in (derivation, transforms) for work in vars(module).values() if hasattr(work, "cache_clear")
]


def forget() -> None:
    """Let everything be found out again."""
    for work in (shipped._lines, shipped.shipped_results, singular_set, *OF_STRUCTURES):
        work.cache_clear()


@pytest.fixture
def nothing_shipped(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[], None]]:
    """Return what lets everything be worked out, until the end of the test."""

    def begin() -> None:
        forget()
        monkeypatch.setattr(shipped, "_lines", bytes)

    yield begin
    monkeypatch.undo()
    forget()


def arms(family: str) -> list[Chain]:
    if FAMILIES[family].varied:
        clean = read_clean_structures()[int(family.removeprefix("random-"))]
        every = clean[:: len(clean) // several(2, 20)]
        return [build_arm(one.rows, one.task, family) for one in every]
    return [sample_chain(ProblemId.parse(f"{family}/{name}")) for name in ("1", "1@screws", "1@full")]


@few_families
def test_it_is_what_is_worked_out(family: str, nothing_shipped: Callable[[], None]) -> None:
    """Where this fails for a new family, run: make shipped"""
    known = [shipped.shipped_results(structure(arm).chain) for arm in arms(family)]
    assert all(known)
    nothing_shipped()
    for arm, found in zip(arms(family), known, strict=True):
        anew = results_of(arm)
        assert {*found} >= {*anew}  # more, where another family has the structure, too, and is asked more
        assert sp.srepr([found[name] for name in anew]) == sp.srepr(list(anew.values()))
        assert shipped.shipped_results(structure(arm).chain) == {}


@pytest.mark.whole
def test_real_robots_are_shipped(nothing_shipped: Callable[[], None]) -> None:
    """Where this fails, run: make shipped"""
    arms = [read_robot(robot_path(name)) for name in robots()]
    known = [shipped.shipped_results(structure(arm).chain) for arm in arms]
    assert all({"_position", "_proved"} <= {*found} for found in known)
    nothing_shipped()
    for arm, found in list(zip(arms, known, strict=True))[:: several(40, 1)]:
        assert sp.srepr(list(found.values())) == sp.srepr([results_of(arm)[name] for name in found])


@few_families
def test_a_problem_has_the_same_bytes_without_it(family: str, nothing_shipped: Callable[[], None]) -> None:
    def text() -> str:
        problem = generate(ProblemId(family, 3, several(questions_of(family)[::5], ())))
        return notebook_text(solution_notebook("t", "k", "s", [("p1", problem)]))

    forget()
    taken = text()
    nothing_shipped()
    assert text() == taken


FORMS = {
    "sum": X - 2 * Y + sp.Rational(3, 7),
    "product": -(X + Y) * sp.sin(X - Y) ** 2 / 3,
    "turned": sp.Mul(2, sp.Add(X, Y), evaluate=False),
    "root": sp.sqrt(2) * sp.cos(X + sp.pi / 6) / Y,
    "matrix": sp.Matrix([[0, X], [Y, 1], [sp.pi, -X]]),
    "counted": (3, 0),
    "factored": (Factored(sp.Rational(-1, 2), ((X, 2), (sp.sin(Y), -1))), (Factored(sp.S.Zero, ()),)),
}


@pytest.mark.parametrize("name", FORMS)
def test_results_are_read_as_they_were(name: str) -> None:
    text = results_to_text({name: FORMS[name]})
    assert (
        sp.srepr(results_from_text(text)[name]) == sp.srepr(FORMS[name])
        and results_from_text(text)[name] == FORMS[name]
    )


def test_what_has_no_form_is_neither_written_nor_read() -> None:
    for strange in (sp.Dummy("x"), sp.Symbol("x", positive=True), sp.Float(0.5), sp.tan(X), "x", {X}):
        with pytest.raises(TypeError, match="has no form in"):
            results_to_text({"strange": strange})
    sums = [f'[["x",[{made}]],{{}}]' for made in ('"+",0,1', '"+",0,-1', '"eval",0')]
    for text in ("", "[]", "{}", '[["x"],{"y":1}]', *sums):
        with pytest.raises(ValueError, match=r"."):
            results_from_text(text)


def test_to_read_evaluates_nothing() -> None:
    (power,) = results_from_text('[[9,["^",0,0],["^",0,1],["^",0,2],["^",0,3]],{"p":4}]').values()
    assert power.is_Pow
    assert power.exp.exp.exp.args == (9, 9)


@pytest.mark.parametrize(
    "spoilt",
    [
        lambda text: text.replace(text[:64], "0" * 64), lambda text: text.replace("SymPy ", "SymPy 0.", 1),
        lambda text: "", lambda text: text[:64], lambda text: "\udcff" + text, None,
    ],
    ids=["other code", "other SymPy", "empty", "only its maker", "no text", "no file"],
)  # fmt: skip
def test_what_another_code_made_or_is_damaged_or_missing_is_not_looked_at(
    spoilt: Callable[[str], str] | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    arm = sample_chain(ProblemId("planar-2r", 1))
    for name in shipped.MADE_BY:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / f"{name}.py").write_bytes((shipped.FILE.parent / f"{name}.py").read_bytes())
    monkeypatch.setattr(shipped, "FILE", tmp_path / "shipped.txt")
    for text in (fresh(arm), spoilt(fresh(arm)) if spoilt else None):
        shipped.FILE.unlink(missing_ok=True)
        if text is not None:
            shipped.FILE.write_text(text, "utf-8", "surrogateescape")
        forget()
        assert bool(shipped.shipped_results(structure(arm).chain)) is (text == fresh(arm))
    monkeypatch.undo()
    forget()


def fresh(arm: Chain) -> str:
    """Return the file that the code at hand makes of an arm."""
    return "\n".join([shipped.code_digest(), *(f"{known.decode()} {line}" for known, line in lines(arm).items()), ""])


def test_a_key_says_all_that_results_depend_on() -> None:
    """Two arms that differ in anything but their names have other keys."""
    arm = structure(sample_chain(ProblemId.parse("elbow-3r/1@full"))).chain
    names = [*(f"{n}@full" for n in range(2, 40)), "1@full@screws", "1@full@modified-dh"]
    others = {structure(sample_chain(ProblemId.parse(f"elbow-3r/{name}"))).chain for name in names}
    arms = {arm, arm.with_task("vx"), *others}
    assert len({shipped.structure_key(one) for one in arms}) == len(arms)
