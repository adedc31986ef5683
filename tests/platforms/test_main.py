"""Test `make platforms`: which copy of a program it uses, and that one failure does not stop the others."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

import tests.platforms.__main__ as command
from tests.platforms import INSTALLED, PLATFORMS
from tests.platforms.records import Count, Record
from tests.support import ROOT


def test_a_platform_that_cannot_be_run_keeps_no_other_from_its_run_and_no_record(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names, kept = ("broken", "short", "sound"), list[str]()

    def run(name: str, software: Path, work: Path) -> Record:
        if name == "broken":
            raise RuntimeError("no database here")
        assert software == tmp_path and work.is_dir()
        return Record("moodle", name, "2026-01-01", {"shown": Count(1, 1 + (name == "short"))})

    for name in names:
        module = ModuleType(f"tests.platforms.{name}")
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(module, "run", lambda software, work, name=name: run(name, software, work), raising=False)
    monkeypatch.setattr(command, "PLATFORMS", dict.fromkeys((*names, "absent"), "SOME_SOFTWARE") | {"absent": "NONE"})
    monkeypatch.setattr(Record, "keep", lambda _, name: kept.append(name))
    monkeypatch.setenv("SOME_SOFTWARE", str(tmp_path))
    monkeypatch.delenv("NONE", raising=False)
    assert command.main([]) == 1
    said = capsys.readouterr().out
    assert kept == ["short", "sound"]
    assert "absent: left out" in said and "no database here" in said and "fell short: broken, short" in said


def test_a_copy_that_is_named_goes_before_the_one_that_is_installed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(command, "ROOT", tmp_path)
    monkeypatch.delenv("OTTER", raising=False)
    assert command.software_of("OTTER") is None
    (tmp_path / INSTALLED["OTTER"]).mkdir(parents=True)
    assert command.software_of("OTTER") == tmp_path / INSTALLED["OTTER"]
    monkeypatch.setenv("OTTER", "/elsewhere")
    assert command.software_of("OTTER") == Path("/elsewhere")


def test_what_is_installed_is_what_the_makefile_installs_for_a_platform() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    rule = makefile.split(".venvs/platforms/.installed: ")[1].split("\n\n")[0]
    for variable, path in INSTALLED.items():
        assert variable in PLATFORMS.values()
        folder, _, name = path.rpartition("/")
        assert folder.startswith("site/") or f"install {name} " in rule or f" {name}@" in rule or path in rule, path
