"""Templates are compiled once: their code is kept beside them, and is never another template's or an older one's."""

import sys
from pathlib import Path

import jinja2
import pytest

from exercises.render import CompiledBeside


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "greeting.j2").write_text("hello {{ name }}")
    return tmp_path


def greeted(folder: Path) -> str:
    """Return what a new environment makes of the template."""
    made = jinja2.Environment(loader=jinja2.FileSystemLoader(folder), bytecode_cache=CompiledBeside(folder))
    return made.get_template("greeting.j2").render(name="Ada")


def kept(folder: Path) -> list[Path]:
    return list((folder / "__pycache__").iterdir())


def test_a_template_is_compiled_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert greeted(folder) == "hello Ada"
    assert len(kept(folder)) == 1

    def never(*_: object, **__: object) -> None:
        raise AssertionError

    monkeypatch.setattr(jinja2.Environment, "_parse", never)
    assert greeted(folder) == "hello Ada"


def test_a_changed_template_is_compiled_anew(folder: Path) -> None:
    greeted(folder)
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


def test_nothing_is_kept_where_python_keeps_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert greeted(folder) == "hello Ada"
    assert not (folder / "__pycache__").exists()


def test_a_folder_that_cannot_be_written_is_no_obstacle(folder: Path) -> None:
    (folder / "__pycache__").write_text("a file in its place")
    assert greeted(folder) == "hello Ada"
