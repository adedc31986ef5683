"""The command of `make platforms`: which copy of a program it uses, what failures it reports, and stored records."""

import sys
from pathlib import Path
from types import ModuleType

import pytest

import tests.platforms.__main__ as command
from qdot.exercises.exports.registry import EXPORT_FORMATS
from tests.platforms import INSTALLED, PLATFORMS
from tests.platforms.records import FOLDER, Count, Record, load_records
from tests.support import ROOT


def test_other_platforms_run_if_one_fails_and_only_completed_runs_are_recorded(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names, saved = ("broken", "failing", "passing"), list[str]()

    def run(name: str, software: Path, work: Path) -> Record:
        if name == "broken":
            raise RuntimeError("no database here")
        assert software == tmp_path and work.is_dir()
        return Record("moodle", name, "2026-01-01", {"shown": Count(1, 1 + (name == "failing"))})

    for name in names:
        module = ModuleType(f"tests.platforms.{name}")
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setattr(module, "run", lambda software, work, name=name: run(name, software, work), raising=False)
    monkeypatch.setattr(command, "PLATFORMS", dict.fromkeys((*names, "absent"), "SOME_SOFTWARE") | {"absent": "NONE"})
    monkeypatch.setattr(Record, "save", lambda _, name: saved.append(name))
    monkeypatch.setenv("SOME_SOFTWARE", str(tmp_path))
    monkeypatch.delenv("NONE", raising=False)
    assert command.main([]) == 1
    output = capsys.readouterr().out
    assert saved == ["failing", "passing"]
    assert "absent: skipped" in output and "no database here" in output and "failed: broken, failing" in output


def test_a_copy_named_by_the_environment_takes_precedence_over_the_installed_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(command, "ROOT", tmp_path)
    monkeypatch.delenv("OTTER", raising=False)
    assert command.find_software("OTTER") is None
    (tmp_path / INSTALLED["OTTER"]).mkdir(parents=True)
    assert command.find_software("OTTER") == tmp_path / INSTALLED["OTTER"]
    monkeypatch.setenv("OTTER", "/elsewhere")
    assert command.find_software("OTTER") == Path("/elsewhere")


def test_each_installed_program_belongs_to_a_platform_and_is_installed_by_the_makefile() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    rule = makefile.split(".venvs/platforms/.installed: ")[1].split("\n\n")[0]
    for variable, path in INSTALLED.items():
        assert variable in PLATFORMS.values()
        folder, _, name = path.rpartition("/")
        assert folder.startswith("site/") or f"install {name} " in rule or f" {name}@" in rule or path in rule, path


def test_each_record_belongs_to_a_platform_and_every_failed_check_is_excused() -> None:
    assert {path.stem for path in FOLDER.glob("*.py")} >= set(PLATFORMS)
    for name, record in load_records().items():
        assert name in PLATFORMS and record.export_format in {"generate", "serve", *EXPORT_FORMATS}
        assert record.software and record.counts
        assert [check for check, count in record.counts.items() if not count.all_passed_or_excused] == []
