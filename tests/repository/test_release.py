"""A release, rehearsed: the workflow's own commands, on a copy of the checkout that is given a version and a tag."""

import json
import os
import re
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from collections.abc import Iterator
from email.parser import Parser
from pathlib import Path

import pytest

from tests.support import ROOT
from tests.support.ci import Machine, git, read_yaml, site_of
from tests.support.programs import GIT, needs
from tests.support.runner import Runner
from tests.tools import release

WORKFLOW = ROOT / ".github" / "workflows" / "release.yml"
JOBS = read_yaml(WORKFLOW)["jobs"]
TOOLS = ROOT / ".venvs" / "release"
TAG = "github.ref_type == 'tag' && github.ref_name || ''"


def copied(folder: Path) -> Path:
    """Copy what is, or is to be, committed: also what is not yet."""
    needs("git", GIT)
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
    """What of a checkout a release looks at."""
    for name in (*release.PLACES, "CHANGELOG.md"):
        shutil.copy(ROOT / name, tmp_path / name)
    return tmp_path


def test_the_version_stands_in_one_place_and_is_repeated_for_citations_only(checkout: Path) -> None:
    version = release.version_of(ROOT)
    assert release.objections(ROOT, "") == []
    found = [
        name
        for name in ("site/package.json", "README.md", "exercises/__init__.py")
        if version in (ROOT / name).read_text()
    ]
    assert found == []


def test_a_release_is_prepared_by_one_command(checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert release.main(["prepare", "7.0.0", "--on", "2026-12-01"], checkout) == 0
    assert release.version_of(checkout) == "7.0.0"
    assert "then: python -m tests.tools.archive 7.0.0;" in capsys.readouterr().out
    assert release.main(["check", "v7.0.0"], checkout) == 2
    assert capsys.readouterr().err == "tests/data/archives/7.0.0 is missing: python -m tests.tools.archive 7.0.0\n"
    (checkout / "tests" / "data" / "archives" / "7.0.0").mkdir(parents=True)
    assert release.main(["check", "v7.0.0"], checkout) == 0
    assert release.main(["notes"], checkout) == 0
    assert capsys.readouterr().out.strip() == release.section(before, "Unreleased")
    changelog = (checkout / "CHANGELOG.md").read_text(encoding="utf-8")
    assert "## Unreleased\n\n## 7.0.0 - 2026-12-01\n\n###" in changelog
    assert release.main(["prepare", "7.0.0"], checkout) == 2
    assert release.main(["prepare", "7.1.0"], checkout) == 2
    told = capsys.readouterr().err.splitlines()
    assert told == ["CHANGELOG.md has a section of 7.0.0 already", "CHANGELOG.md: nothing stands under '## Unreleased'"]


@pytest.mark.parametrize("version", ["1", "v1.0.0", "1.0", "1.0.0.post1", "01.0.0", "1.0.0\n"])
def test_what_is_no_version_is_refused(version: str, checkout: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert release.main(["prepare", version], checkout) == 2
    assert "write one like 1.0.0" in capsys.readouterr().err


def test_a_tag_that_is_not_of_the_version_or_has_no_section_is_refused(
    checkout: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    version = release.version_of(checkout)
    assert release.main(["check", "v9.9.9"], checkout) == 2
    assert capsys.readouterr().err.splitlines() == [
        f"the tag is v9.9.9, and v{version} is that of pyproject.toml",
        f"tests/data/archives/{version} is missing: python -m tests.tools.archive {version}",
        f"CHANGELOG.md: nothing stands under a heading '## {version} - YYYY-MM-DD'",
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
        "CHANGELOG.md: something stands under '## Unreleased' that is in this release, too",
    ]


# --- the same bytes ---


def built(source: Path, folder: Path, **environment: str) -> dict[str, bytes]:
    """Build both from a folder, by who lets nobody else read what is written."""
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(folder), str(source)]
    given = {**os.environ, "SOURCE_DATE_EPOCH": "1700000000", **environment}
    done = subprocess.run(command, env=given, umask=int(environment["UMASK"], 8), capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.integration
def test_the_same_source_gives_the_same_bytes(tmp_path: Path) -> None:
    """In another folder, at another time, in another time zone, by somebody with other rights and another language."""
    one, other = copied(tmp_path / "one"), copied(tmp_path / "far" / "away" / "two")
    for number, path in enumerate(sorted(other.rglob("*"), reverse=True)):
        os.utime(path, (1_000_000_000 + number, 1_000_000_000 + number))
        path.chmod(0o700 if path.is_dir() else 0o600)
    first = built(one, tmp_path / "first", UMASK="022", TZ="UTC", LC_ALL="C.UTF-8", PYTHONHASHSEED="1")
    again = built(other, tmp_path / "again", UMASK="077", TZ="Asia/Tokyo", LC_ALL="C", PYTHONHASHSEED="2")
    assert len(first) == 2
    assert first.keys() == again.keys()
    assert {name for name in first if first[name] != again[name]} == set()


# --- the workflow ---


def test_what_publishes_has_the_rights_that_it_needs_and_no_other_job_has() -> None:
    workflow = read_yaml(WORKFLOW)
    assert workflow["permissions"] == {}
    rights = {
        name: {right for right, what in job["permissions"].items() if what == "write"} for name, job in JOBS.items()
    }
    assert {name: found for name, found in rights.items() if found} == {
        "publish": {"id-token"}, "pages": {"pages", "id-token"}, "release": {"contents", "id-token", "attestations"},
    }  # fmt: skip
    text = WORKFLOW.read_text(encoding="utf-8")
    assert "secrets." not in text and "cache: pip" not in text
    assert JOBS["publish"]["if"] == "github.event_name == 'push'" and JOBS["publish"]["needs"] == ["test", "site"]
    assert all(JOBS[name]["needs"] == "publish" for name in ("release", "pages"))


def test_it_is_tried_on_every_python_that_the_project_names() -> None:
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', project)
    assert JOBS["test"]["strategy"]["matrix"] == {"python": named, "form": ["whl", "tar.gz"]}


@pytest.fixture(scope="module")
def rehearsal(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Runner]:
    """A machine with a copy of the checkout that is tagged, and all that `make` would install there."""
    if not (TOOLS / "bin" / "cyclonedx-py").exists():
        pytest.skip("cyclonedx-bom is not installed: make .venvs/release/.installed")
    needs("npm", "install Node 20.19 or later", in_ci=False)
    asked = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--dest"]
    place = tmp_path_factory.mktemp("release")
    if subprocess.run([*asked, str(place / "asked"), "hatchling"], capture_output=True).returncode:
        pytest.skip("the index of Python's packages can't be reached, which a clean environment asks")
    machine = Machine(place / "machine")
    machine.lend()
    for name in ("PIP_NO_DEPS", "PIP_NO_INDEX"):
        del machine.variables[name]
    machine.variables |= {name: value for name, value in os.environ.items() if name in ("PIP_CERT", "SSL_CERT_FILE")}
    clone = copied(place / "clone")
    assert release.main(["prepare", "7.0.0", "--on", "2026-12-01"], clone) == 0
    subprocess.run([sys.executable, "-m", "tests.tools.archive", "7.0.0"], cwd=clone, check=True)
    git("init", "--quiet", clone)
    git("add", "--all", cwd=clone)
    git("commit", "--quiet", "--message", "7.0.0", cwd=clone)
    venv.create(clone / ".venv", with_pip=True, symlinks=True)
    libraries = [path for path in sys.path if Path(path).name == "site-packages"]
    (site_of(clone / ".venv") / "lent.pth").write_text("".join(f"{path}\n" for path in libraries))
    (clone / ".venv" / ".dev").touch()
    (clone / ".venvs").mkdir()
    (clone / ".venvs" / "release").symlink_to(TOOLS)
    known = {TAG: "v7.0.0", "github.ref_name": "v7.0.0", "github.token": "t", "github.repository": "o/qdot"}
    known |= {"matrix.python": "3", "matrix.form": "whl"}
    yield Runner(machine, clone, place, {}, known)


@pytest.fixture(scope="module")
def made(rehearsal: Runner) -> Path:
    """What the job that builds has kept."""
    assert rehearsal.job(WORKFLOW, "build"), "".join(rehearsal.said)
    return rehearsal.place / "kept"


@pytest.mark.integration
def test_a_release_has_an_archive_as_its_own_commit_writes_it(made: Path, rehearsal: Runner) -> None:
    def archived(*arguments: str) -> tuple[int, str]:
        command = [sys.executable, "-m", "tests.tools.archive", *arguments]
        done = subprocess.run(command, cwd=rehearsal.clone, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    assert "7.0.0 is archived\n" in "".join(rehearsal.said)
    assert archived("7.0.0")[0] == 1, "what is released is never written again"
    assert archived("8.0.0") == (1, "this is version 7.0.0, and no other can be archived\n")
    results = rehearsal.clone / release.ARCHIVES / "7.0.0" / "graded" / "results.jsonl"
    results.write_text(results.read_text(encoding="utf-8").replace('"score":', '"score": 1', 1), encoding="utf-8")
    said = f"{release.ARCHIVES}/7.0.0 is not as this version writes it: graded/results.jsonl\n"
    assert archived("--check", "v7.0.0") == (1, said)
    assert archived("--check", "") == (0, "a class of this version can be archived\n")


@pytest.mark.integration
def test_what_is_built_is_of_the_tag_and_has_the_sites_scripts(made: Path) -> None:
    wheel, source = made / "dist" / "qdot_robotics-7.0.0-py3-none-any.whl", made / "dist" / "qdot_robotics-7.0.0.tar.gz"
    assert sorted((made / "dist").iterdir()) == sorted((wheel, source))
    with zipfile.ZipFile(wheel) as archive:
        about = Parser().parsestr(archive.read("qdot_robotics-7.0.0.dist-info/METADATA").decode())
        assert about["Version"] == "7.0.0" and "exercises/site_dist/.vite/manifest.json" in archive.namelist()
    with tarfile.open(source) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    assert {"Containerfile", "CHANGELOG.md", "site/dist/.vite/manifest.json", "LICENSE"} <= names
    assert not [name for name in names if name.startswith((".venv", "site/node_modules"))]
    assert (made / "about" / "notes.md").read_text().strip() == release.section(
        (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), "Unreleased"
    )


@pytest.mark.integration
def test_what_it_is_made_of_is_described(made: Path) -> None:
    told = json.loads((made / "about" / "qdot.cdx.json").read_text())
    assert told["bomFormat"] == "CycloneDX" and told["metadata"]["component"]["name"] == "qdot-robotics"
    parts = {each["name"].lower(): each["version"] for each in told["components"]}
    pins = dict(re.findall(r"(?m)^([\w.-]+)==([^ ;\\]+)", (ROOT / "constraints.txt").read_text()))
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    (listed,) = re.findall(r"(?ms)^dependencies = \[\n(.*?)^\]", project)
    for name in re.findall(r'"([\w.-]+)>=', listed):
        assert parts[name] == pins[name]
    assert not {"pytest", "mypy", "hatchling"} & parts.keys()
    site = json.loads((made / "about" / "site.cdx.json").read_text())
    assert site["bomFormat"] == "CycloneDX" and {"mathjs", "three"} <= {each["name"] for each in site["components"]}


@pytest.mark.integration
@pytest.mark.parametrize("form", ["whl", "tar.gz"])
def test_both_are_tried_in_a_clean_environment(form: str, made: Path, rehearsal: Runner, tmp_path: Path) -> None:
    known = {**rehearsal.known, "matrix.form": form}
    job = Runner(rehearsal.machine, tmp_path, rehearsal.place, {}, known)
    assert job.job(WORKFLOW, "test"), "".join(job.said)
    assert "qdot 7.0.0" in "".join(job.said)


@pytest.mark.integration
def test_the_release_has_its_notes_its_files_and_attestations(made: Path, rehearsal: Runner, tmp_path: Path) -> None:
    """GitHub's own command is a stand-in that writes down what it was given."""
    gh = rehearsal.machine.home / "python" / "bin" / "gh"
    gh.write_text('#!/bin/sh\nprintf "%s\\n" "$@" > told\n')
    gh.chmod(0o755)
    job = Runner(rehearsal.machine, tmp_path, rehearsal.place, {}, rehearsal.known)
    assert all(job.job(WORKFLOW, name) for name in ("publish", "release", "pages")), job.said
    told = (tmp_path / "told").read_text().split("\n")
    assert told[:8] == [
        "release",
        "create",
        "v7.0.0",
        "--verify-tag",
        "--title",
        "qdot 7.0.0",
        "--notes-file",
        "about/notes.md",
    ]
    assert [Path(name).suffix for name in told[8:]] == [".whl", ".gz", ".json", ".json", ""]
    assert all((tmp_path / name).is_file() for name in told[8:-1])
    names = [name for name, _ in job.noted]
    assert names == ["pypa/gh-action-pypi-publish", "actions/attest", "actions/attest", "actions/deploy-pages"]
    assert job.noted[0][1]["attestations"] == "true"
