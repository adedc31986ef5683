"""The stores of a class's problems and of compiled templates give the same as a new computation."""

import base64
import pickle
import sys
from dataclasses import replace
from pathlib import Path

import jinja2
import pytest
import sympy as sp

from qdot.exercises.assignment import store
from qdot.exercises.assignment.assignment import Assignment, Student, load_assignment
from qdot.exercises.assignment.release import init_assignment, release_notebooks
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_part_svg
from qdot.exercises.problem.record import compute_digests
from qdot.exercises.writing.render import TemplateCache
from qdot.grader.grading.certify import CERTIFIER

STUDENTS = [Student("ada"), Student("bob")]
SLOTS = """
[[problem]]
family = "planar-2r"
questions = ["jacobian", "singular-angles", "joint-rates"]

[[problem]]
family = "polar-rp"
questions = ["singular-drawing", "joint-effect", "column-choice"]
"""


@pytest.fixture(scope="module")
def assignment(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("class") / "homework"
    init_assignment(folder, "Homework", "hw", STUDENTS, "a secret that is long enough")
    file = folder / "assignment.toml"
    file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOTS, encoding="utf-8")
    assignment = load_assignment(folder)
    release_notebooks(assignment, CERTIFIER, 1, lambda _: None)
    return assignment


def get_store_file(assignment: Assignment, student: str) -> Path:
    return store.make_store_path(assignment.folder, student)


def test_stored_problems_and_figures_equal_generated_ones(assignment: Assignment) -> None:
    for student in STUDENTS:
        assert get_store_file(assignment, student.id).is_file()
        stored, generated = store.load_stored_problems(assignment, student.id), assignment.generate_problems(student.id)
        assert stored.pieces_by_slot
        for (slot, problem), (_, expected) in zip(stored.problems, generated, strict=True):
            assert compute_digests(problem) == compute_digests(expected)
            assert problem == expected
            pieces = stored.pieces_of(slot)
            assert pieces["figure"] == draw_figure_svg(expected.chain, slot)
            for part in expected.parts:
                assert pieces[f"{part.name} figure"] == draw_part_svg(expected.chain, part, f"{slot}-{part.name}")


def test_stored_problems_are_not_generated_again(assignment: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Assignment, "generate_problems", lambda *_: pytest.fail("the problems were generated again"))
    assert [slot for slot, _ in store.load_stored_problems(assignment, "ada").problems] == ["p1", "p2"]


def is_regenerated(assignment: Assignment, student: str) -> bool:
    problems = store.load_stored_problems(assignment, student)
    assert [problem.id for _, problem in problems.problems] == [p.id for _, p in assignment.generate_problems(student)]
    return not problems.pieces_by_slot


def test_store_of_another_assignment_or_version_is_not_used(
    assignment: Assignment, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert not is_regenerated(assignment, "ada")
    changes: list[dict[str, object]] = [{"secret": "another secret, long enough"}, {"title": "Another"}]
    for change in (*changes, {"slots": assignment.slots[:1]}):
        assert is_regenerated(replace(assignment, **change), "ada")  # type: ignore[arg-type]
    assert is_regenerated(assignment, "eve")
    monkeypatch.setattr(store, "compute_package_digest", lambda: "another")
    assert is_regenerated(assignment, "ada")


class Bomb:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return pytest.fail, ("unsigned content was unpickled",)


@pytest.mark.parametrize("damage", ["cut", "empty", "turned", "swapped", "bomb", "gone", "folder", "binary"])
def test_damaged_or_forged_store_is_not_unpickled(assignment: Assignment, damage: str) -> None:
    path = get_store_file(assignment, "ada")
    text = path.read_text("ascii")
    signature, payload = text.split("\n")[:2]
    try:
        if damage in ("gone", "folder"):
            path.unlink()
        if damage == "folder":
            path.mkdir()
        elif damage == "binary":
            path.write_bytes(b"\xff\xfe\0")
        elif damage != "gone":
            forged = base64.b64encode(pickle.dumps(Bomb())).decode()
            path.write_text({
                "cut": text[: len(text) // 2], "empty": "", "turned": f"{signature}\n{payload[:40]}A{payload[41:]}\n",
                "swapped": get_store_file(assignment, "bob").read_text("ascii"), "bomb": f"{signature}\n{forged}\n",
            }[damage])  # fmt: skip
        assert is_regenerated(assignment, "ada")
    finally:
        if path.is_dir():
            path.rmdir()
        path.write_text(text, "ascii")


def test_unwritable_store_is_ignored(assignment: Assignment, tmp_path: Path) -> None:
    (tmp_path / ".qdot").write_text("a file where a folder should be")
    store.store_problems(replace(assignment, folder=tmp_path), "ada", assignment.generate_problems("ada"))


def test_pickled_expressions_are_not_reevaluated() -> None:
    x, y = sp.symbols("x y")
    expressions = [sp.Add(x, x, evaluate=False), sp.Mul(2, sp.Add(x, y), evaluate=False), (x + 1) ** -2, sp.sqrt(2) * y]
    back = pickle.loads(store._pickle_content(expressions))
    assert [sp.srepr(expression) for expression in back] == [sp.srepr(expression) for expression in expressions]
    assert all(expression.is_commutative for expression in back)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "greeting.j2").write_text("hello {{ name }}")
    return tmp_path


def render_greeting(folder: Path) -> str:
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(folder), bytecode_cache=TemplateCache(folder))
    return environment.get_template("greeting.j2").render(name="Ada")


def list_cached_files(folder: Path) -> list[Path]:
    return list((folder / "__pycache__").iterdir())


def test_template_is_recompiled_only_after_a_change(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert render_greeting(folder) == "hello Ada"
    assert len(list_cached_files(folder)) == 1
    with monkeypatch.context() as patched:
        patched.setattr(jinja2.Environment, "_parse", None)  # a call would fail
        assert render_greeting(folder) == "hello Ada"
    (folder / "greeting.j2").write_text("good night, {{ name }}")
    assert render_greeting(folder) == "good night, Ada"


@pytest.mark.parametrize("damage", [b"", b"nothing", "half"])
def test_damaged_template_cache_is_rewritten(folder: Path, damage: bytes | str) -> None:
    render_greeting(folder)
    (file,) = list_cached_files(folder)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if isinstance(damage, str) else damage)
    assert render_greeting(folder) == "hello Ada"
    assert file.read_bytes() == whole


def test_template_is_compiled_without_a_cache(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert render_greeting(folder) == "hello Ada"
    assert not (folder / "__pycache__").exists()
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (folder / "__pycache__").write_text("a file in its place")
    assert render_greeting(folder) == "hello Ada"
