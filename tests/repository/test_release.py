"""A release: its version and changelog, reproducible builds, and the permissions of its workflow."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support import ROOT
from tests.support.ci import read_yaml
from tests.support.programs import GIT, require_program
from tests.tools import release

WORKFLOW = ROOT / ".github" / "workflows" / "release.yml"
JOBS = read_yaml(WORKFLOW)["jobs"]


def copy_checkout(folder: Path) -> Path:
    """Copy all files that Git tracks or does not ignore."""
    require_program("git", GIT)
    listed = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(listed, cwd=ROOT, capture_output=True, text=True, check=True).stdout.split("\0")
    for name in filter(None, names):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    return folder


# --- the version ---


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """Return a folder with the files of a checkout that a release reads."""
    for name in (*release.VERSION_PATTERNS, "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_the_version_is_in_one_place_and_in_the_citation(checkout: Path) -> None:
    version = release.read_version(ROOT)
    assert release.find_objections(ROOT, "") == []
    repetitions = [
        name
        for name in ("site/package.json", "README.md", "exercises/__init__.py")
        if version in (ROOT / name).read_text()
    ]
    assert repetitions == []


def test_a_release_is_prepared_by_one_command(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert release.main(["prepare", "7.0.0", "--on", "2026-12-01"], checkout) == 0
    assert release.read_version(checkout) == "7.0.0"
    assert "then: python -m tests.tools.archive 7.0.0;" in capsys.readouterr().out
    assert release.main(["check", "v7.0.0"], checkout) == 2
    assert capsys.readouterr().err == "tests/data/archives/7.0.0 is missing: python -m tests.tools.archive 7.0.0\n"
    (checkout / "tests" / "data" / "archives" / "7.0.0").mkdir(parents=True)
    assert release.main(["check", "v7.0.0"], checkout) == 0
    assert release.main(["notes"], checkout) == 0
    assert capsys.readouterr().out.strip() == release.find_section(before, "Unreleased")
    changelog = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "## Unreleased\n\n## 7.0.0 - 2026-12-01\n\n###" in changelog
    assert release.main(["prepare", "7.0.0"], checkout) == 2
    assert release.main(["prepare", "7.1.0"], checkout) == 2
    errors = capsys.readouterr().err.splitlines()
    assert errors == [
        "CHANGELOG.md already has a section for 7.0.0",
        "CHANGELOG.md: the section '## Unreleased' is empty",
    ]


@pytest.mark.parametrize("version", ["1", "v1.0.0", "1.0", "1.0.0.post1", "01.0.0", "1.0.0\n"])
def test_an_invalid_version_is_refused(version: str, checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert release.main(["prepare", version], checkout) == 2
    assert "write one like 1.0.0" in capsys.readouterr().err


def test_a_tag_must_match_version_archive_and_changelog(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    version = release.read_version(checkout)
    assert release.main(["check", "v9.9.9"], checkout) == 2
    assert capsys.readouterr().err.splitlines() == [
        f"the tag is v9.9.9, but pyproject.toml has version {version}",
        f"tests/data/archives/{version} is missing: python -m tests.tools.archive {version}",
        f"CHANGELOG.md: there is no text under a heading '## {version} - YYYY-MM-DD'",
    ]
    release.main(["prepare", "7.0.0"], checkout)
    (checkout / "tests" / "data" / "archives" / "7.0.0").mkdir(parents=True)
    citation = checkout / "CITATION.cff"
    citation.write_text(citation.read_text().replace("version: 7.0.0", "version: 6.0.0"))
    changelog = (checkout / "CHANGELOG.md").read_text()
    (checkout / "CHANGELOG.md").write_text(changelog.replace("## Unreleased\n", "## Unreleased\n\n- Late.\n", 1))
    capsys.readouterr()
    assert release.main(["check", "v7.0.0"], checkout) == 2
    assert capsys.readouterr().err.splitlines() == [
        "CITATION.cff: the version is 6.0.0, and 7.0.0 in pyproject.toml",
        "CHANGELOG.md: '## Unreleased' is not empty, although its changes are part of this release",
    ]


# --- the same bytes ---


def build(source: Path, folder: Path, **environment: str) -> dict[str, bytes]:
    """Build both distributions from a folder in the given environment."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(source)]
    given = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000", "HATCH_BUILD_NO_HOOKS": "true", **environment}
    done = subprocess.run(command, env=given, umask=int(environment["UMASK"], 8), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.integration
def test_the_same_source_gives_the_same_bytes(tmp_path: Path) -> None:
    """Build twice; the folder, time stamps, time zone, umask, locale and hash seed differ."""
    one, other = copy_checkout(tmp_path / "one"), copy_checkout(tmp_path / "far" / "away" / "two")
    for number, path in enumerate(sorted(other.rglob("*"), reverse=True)):
        os.utime(path, (1_000_000_000 + number, 1_000_000_000 + number))
        path.chmod(0o700 if path.is_dir() else 0o600)
    first = build(one, tmp_path / "first", UMASK="022", TZ="UTC", LC_ALL="C.UTF-8", PYTHONHASHSEED="1")
    again = build(other, tmp_path / "again", UMASK="077", TZ="Asia/Tokyo", LC_ALL="C", PYTHONHASHSEED="2")
    assert len(first) == 2
    assert first.keys() == again.keys()
    assert {name for name in first if first[name] != again[name]} == set()


# --- the workflow ---


def test_only_publishing_jobs_have_write_permissions() -> None:
    workflow = read_yaml(WORKFLOW)
    assert workflow["permissions"] == {}
    permissions = {
        name: {scope for scope, access in job["permissions"].items() if access == "write"} for name, job in JOBS.items()
    }
    assert {name: granted for name, granted in permissions.items() if granted} == {
        "publish": {"id-token"}, "pages": {"pages", "id-token"}, "release": {"contents", "id-token", "attestations"},
    }  # fmt: skip
    text = WORKFLOW.read_text(encoding="utf-8")
    assert "secrets." not in text and "cache: pip" not in text
    assert JOBS["publish"]["if"] == "github.event_name == 'push'" and JOBS["publish"]["needs"] == ["test", "site"]
    assert all(JOBS[name]["needs"] == "publish" for name in ("release", "pages"))


def test_releases_are_tested_on_every_declared_python() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', project)
    assert JOBS["test"]["strategy"]["matrix"] == {"python": named, "form": ["whl", "tar.gz"]}
