"""What is kept: of a class when its notebooks are made, and of templates: the same as if it were made anew."""

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
def made(tmp_path_factory: pytest.TempPathFactory) -> Assignment:
    folder = tmp_path_factory.mktemp("class") / "homework"
    init_assignment(folder, "Homework", "hw", STUDENTS, "a secret that is long enough")
    file = folder / "assignment.toml"
    file.write_text(file.read_text("utf-8").split("\n[[problem]]")[0] + SLOTS, encoding="utf-8")
    assignment = load_assignment(folder)
    release_notebooks(assignment, CERTIFIER, 1, lambda _: None)
    return assignment


def file_of(assignment: Assignment, student: str) -> Path:
    return store.store_path(assignment.folder, student)


def test_problems_and_figures_are_kept_and_the_same(made: Assignment) -> None:
    for student in STUDENTS:
        assert file_of(made, student.id).is_file()
        kept, anew = store.load_stored_problems(made, student.id), made.generate_problems(student.id)
        assert kept.pieces_by_slot
        for (slot, problem), (_, other) in zip(kept.problems, anew, strict=True):
            assert compute_digests(problem) == compute_digests(other)
            assert problem == other
            pieces = kept.pieces_of(slot)
            assert pieces["figure"] == draw_figure_svg(other.chain, slot)
            for part in other.parts:
                assert pieces[f"{part.name} figure"] == draw_part_svg(other.chain, part, f"{slot}-{part.name}")


def test_nothing_is_derived_again(made: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Assignment, "generate_problems", lambda *_: pytest.fail("the problems were worked out again"))
    assert [slot for slot, _ in store.load_stored_problems(made, "ada").problems] == ["p1", "p2"]


def is_made_anew(assignment: Assignment, student: str) -> bool:
    found = store.load_stored_problems(assignment, student)
    assert [problem.id for _, problem in found.problems] == [p.id for _, p in assignment.generate_problems(student)]
    return not found.pieces_by_slot


def test_what_was_kept_of_another_is_not_taken(made: Assignment, monkeypatch: pytest.MonkeyPatch) -> None:
    assert not is_made_anew(made, "ada")
    changes: list[dict[str, object]] = [{"secret": "another secret, long enough"}, {"title": "Another"}]
    for change in (*changes, {"slots": made.slots[:1]}):
        assert is_made_anew(replace(made, **change), "ada")  # type: ignore[arg-type]
    assert is_made_anew(made, "eve")
    monkeypatch.setattr(store, "compute_package_digest", lambda: "another")
    assert is_made_anew(made, "ada")


class Bomb:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return pytest.fail, ("what nobody signed was unpickled",)


@pytest.mark.parametrize("damage", ["cut", "empty", "turned", "swapped", "bomb", "gone", "folder", "binary"])
def test_what_is_damaged_or_forged_is_not_looked_into(made: Assignment, damage: str) -> None:
    path = file_of(made, "ada")
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
                "swapped": file_of(made, "bob").read_text("ascii"), "bomb": f"{signature}\n{forged}\n",
            }[damage])  # fmt: skip
        assert is_made_anew(made, "ada")
    finally:
        if path.is_dir():
            path.rmdir()
        path.write_text(text, "ascii")


def test_a_place_that_can_not_be_written_stops_nothing(made: Assignment, tmp_path: Path) -> None:
    (tmp_path / ".qdot").write_text("a file where a folder should be")
    store.store_problems(replace(made, folder=tmp_path), "ada", made.generate_problems("ada"))


def test_what_is_kept_is_read_as_it_was_and_not_worked_out_again() -> None:
    x, y = sp.symbols("x y")
    expressions = [sp.Add(x, x, evaluate=False), sp.Mul(2, sp.Add(x, y), evaluate=False), (x + 1) ** -2, sp.sqrt(2) * y]
    back = pickle.loads(store._pickle_content(expressions))
    assert [sp.srepr(one) for one in back] == [sp.srepr(one) for one in expressions]
    assert all(one.is_commutative for one in back)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "greeting.j2").write_text("hello {{ name }}")
    return tmp_path


def greeted(folder: Path) -> str:
    """Return what a new environment makes of the template."""
    made = jinja2.Environment(loader=jinja2.FileSystemLoader(folder), bytecode_cache=TemplateCache(folder))
    return made.get_template("greeting.j2").render(name="Ada")


def kept(folder: Path) -> list[Path]:
    return list((folder / "__pycache__").iterdir())


def test_a_template_is_compiled_once_and_anew_when_it_changed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert greeted(folder) == "hello Ada"
    assert len(kept(folder)) == 1
    with monkeypatch.context() as patched:
        patched.setattr(jinja2.Environment, "_parse", None)  # called, it fails
        assert greeted(folder) == "hello Ada"
    (folder / "greeting.j2").write_text("good night, {{ name }}")
    assert greeted(folder) == "good night, Ada"


@pytest.mark.parametrize("damage", [b"", b"nothing", "half"])
def test_what_is_damaged_is_made_anew(folder: Path, damage: bytes | str) -> None:
    greeted(folder)
    (file,) = kept(folder)
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if isinstance(damage, str) else damage)
    assert greeted(folder) == "hello Ada"
    assert file.read_bytes() == whole


def test_where_nothing_is_or_can_be_kept_a_template_is_compiled(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert greeted(folder) == "hello Ada"
    assert not (folder / "__pycache__").exists()
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (folder / "__pycache__").write_text("a file in its place")
    assert greeted(folder) == "hello Ada"
