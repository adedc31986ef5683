"""A release: the version is changed in one command, and tag, version and changelog agree before anything is built.

    python -m tests.tools.release prepare 1.0.0     the version, and a section of CHANGELOG.md out of "Unreleased"
    python -m tests.tools.release check [v1.0.0]    whether a tag is that of the version and has its section
    python -m tests.tools.release notes             the section of the version, or of what is not released yet

The version stands in pyproject.toml; CITATION.cff repeats it for those who cite. docs/releasing.md has the steps. The
workflow runs this with nothing installed: it needs Python alone.
"""

import argparse
import datetime
import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
VERSION = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)((a|b|rc)\d+)?")
UNRELEASED = "Unreleased"
ARCHIVES = "tests/data/archives"
"""Where each release has kept a class of its own, by the version's name."""
PLACES = {"pyproject.toml": r'(?m)^version = "(.*)"$', "CITATION.cff": r"(?m)^version: (.*)$"}
"""Where the version stands, and how; the first of them is asked."""


def version_of(root: Path) -> str:
    """Return the version of a checkout."""
    version: str = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return version


def section(changelog: str, version: str) -> str:
    """Return what a changelog says of a version, without the heading; nothing where it has no such section.

    >>> section("# C\\n\\n## Unreleased\\n\\n## 1.0.0 - 2026-12-01\\n\\n- New.\\n\\n## 0.9.0 - 2026-11-01\\n", "1.0.0")
    '- New.'
    """
    dated = "" if version == UNRELEASED else r" - \d{4}-\d\d-\d\d"
    found = re.search(rf"(?ms)^## {re.escape(version)}{dated}\n(.*?)(?=^## |\Z)", changelog)
    return found[1].strip() if found else ""


def objections(root: Path, tag: str) -> list[str]:
    """Return what keeps a checkout from being released by a tag, or from being released at all where none is given."""
    version, changelog = version_of(root), (root / "CHANGELOG.md").read_text(encoding="utf-8")
    said = []
    if not VERSION.fullmatch(version):
        said.append(f"pyproject.toml: version = {version!r} is no version like 1.0.0 or 1.0.0rc1")
    for name, pattern in PLACES.items():
        found = re.findall(pattern, (root / name).read_text(encoding="utf-8"))
        if found != [version]:
            said.append(f"{name}: the version is {', '.join(found) or 'missing'}, and {version} in pyproject.toml")
    if not tag:
        return said
    if tag != f"v{version}":
        said.append(f"the tag is {tag}, and v{version} is that of pyproject.toml")
    if not (root / ARCHIVES / version).is_dir():
        said.append(f"{ARCHIVES}/{version} is missing: python -m tests.tools.archive {version}")
    if not section(changelog, version):
        said.append(f"CHANGELOG.md: nothing stands under a heading '## {version} - YYYY-MM-DD'")
    elif section(changelog, UNRELEASED):
        said.append(f"CHANGELOG.md: something stands under '## {UNRELEASED}' that is in this release, too")
    return said


def prepared(root: Path, version: str, day: str) -> dict[str, str]:
    """Return the files of a checkout that a new version changes. Raises ValueError with the reason where it can't."""
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    if not VERSION.fullmatch(version):
        raise ValueError(f"{version!r} is no version; write one like 1.0.0 or 1.0.0rc1")
    if section(changelog, version):
        raise ValueError(f"CHANGELOG.md has a section of {version} already")
    if not section(changelog, UNRELEASED):
        raise ValueError(f"CHANGELOG.md: nothing stands under '## {UNRELEASED}'")
    heading = f"## {UNRELEASED}\n"
    files = {"CHANGELOG.md": changelog.replace(heading, f"{heading}\n## {version} - {day}\n", 1)}
    for name, pattern in PLACES.items():
        text = (root / name).read_text(encoding="utf-8")
        files[name], changes = re.subn(pattern, lambda found: found[0].replace(found[1], version), text)
        if changes != 1:
            raise ValueError(f"{name}: the version stands in {changes} lines; it should be one")
    return files


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    """Run the command; return its exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.tools.release")
    commands = parser.add_subparsers(dest="command", required=True)
    prepare = commands.add_parser("prepare", help="change the version, and give the changelog its section")
    prepare.add_argument("version")
    prepare.add_argument("--on", default=datetime.datetime.now(datetime.UTC).date().isoformat(), help="YYYY-MM-DD")
    check = commands.add_parser("check", help="see whether tag, version and changelog agree")
    check.add_argument("tag", nargs="?", default="")
    commands.add_parser("notes", help="print the version's section of the changelog")
    given = parser.parse_args(arguments)
    if given.command == "prepare":
        try:
            files = prepared(root, given.version, given.on)
        except ValueError as error:
            print(error, file=sys.stderr)
            return 2
        for name, text in files.items():
            (root / name).write_text(text, encoding="utf-8")
        archive = f"python -m tests.tools.archive {given.version}"
        print(f"changed {', '.join(files)}; look at them, then: {archive}; commit, and: git tag v{given.version}")
        return 0
    if given.command == "notes":
        changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
        print(section(changelog, version_of(root)) or section(changelog, UNRELEASED))
        return 0
    said = objections(root, given.tag)
    for line in said:
        print(line, file=sys.stderr)
    return 2 if said else 0


if __name__ == "__main__":
    sys.exit(main())
