"""Prepare and check a release: change the version, and check that tag, version and changelog agree.

    python -m tests.tools.release prepare 1.0.0     change the version, and turn "Unreleased" into a section
    python -m tests.tools.release check [v1.0.0]    check that a tag agrees with version and changelog
    python -m tests.tools.release notes             print the section of the version, or of "Unreleased"

The version is in pyproject.toml and repeated in CITATION.cff. docs/releasing.md lists the steps. This program needs
only Python, because the workflow runs it with nothing installed.
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
"""The folder with an archived class for each version."""
VERSION_PATTERNS = {"pyproject.toml": r'(?m)^version = "(.*)"$', "CITATION.cff": r"(?m)^version: (.*)$"}
"""The files that contain the version, with its pattern."""


def read_version(root: Path) -> str:
    version: str = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    return version


def find_section(changelog: str, version: str) -> str:
    """Return the section of a version in a changelog, without the heading, or "" if there is none.

    >>> find_section("# C\\n\\n## Unreleased\\n\\n## 1.0.0 - 2026-12-01\\n\\n- New.\\n\\n## 0.9.0 - 2026-1-1", "1.0.0")
    '- New.'
    """
    date_pattern = "" if version == UNRELEASED else r" - \d{4}-\d\d-\d\d"
    match = re.search(rf"(?ms)^## {re.escape(version)}{date_pattern}\n(.*?)(?=^## |\Z)", changelog)
    return match[1].strip() if match else ""


def find_objections(root: Path, tag: str) -> list[str]:
    """Return the reasons against releasing a checkout, with a tag if one is given."""
    version, changelog = read_version(root), (root / "CHANGELOG.md").read_text(encoding="utf-8")
    objections = []
    if not VERSION.fullmatch(version):
        objections.append(f"pyproject.toml: version = {version!r} is no version like 1.0.0 or 1.0.0rc1")
    for name, pattern in VERSION_PATTERNS.items():
        versions = re.findall(pattern, (root / name).read_text(encoding="utf-8"))
        if versions != [version]:
            found_versions = ", ".join(versions) or "missing"
            objections.append(f"{name}: the version is {found_versions}, and {version} in pyproject.toml")
    if not tag:
        return objections
    if tag != f"v{version}":
        objections.append(f"the tag is {tag}, but pyproject.toml has version {version}")
    if not (root / ARCHIVES / version).is_dir():
        objections.append(f"{ARCHIVES}/{version} is missing: python -m tests.tools.archive {version}")
    if not find_section(changelog, version):
        objections.append(f"CHANGELOG.md: there is no text under a heading '## {version} - YYYY-MM-DD'")
    elif find_section(changelog, UNRELEASED):
        objection = f"CHANGELOG.md: '## {UNRELEASED}' is not empty, although its changes are part of this release"
        objections.append(objection)
    return objections


def prepare_files(root: Path, version: str, day: str) -> dict[str, str]:
    changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    if not VERSION.fullmatch(version):
        raise ValueError(f"{version!r} is no version; write one like 1.0.0 or 1.0.0rc1")
    if find_section(changelog, version):
        raise ValueError(f"CHANGELOG.md already has a section for {version}")
    if not find_section(changelog, UNRELEASED):
        raise ValueError(f"CHANGELOG.md: the section '## {UNRELEASED}' is empty")
    heading = f"## {UNRELEASED}\n"
    files = {"CHANGELOG.md": changelog.replace(heading, f"{heading}\n## {version} - {day}\n", 1)}
    for name, pattern in VERSION_PATTERNS.items():
        text = (root / name).read_text(encoding="utf-8")
        files[name], changes = re.subn(pattern, lambda match: match[0].replace(match[1], version), text)
        if changes != 1:
            raise ValueError(f"{name}: the version stands in {changes} lines; it should be one")
    return files


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.tools.release")
    commands = parser.add_subparsers(dest="command", required=True)
    prepare = commands.add_parser("prepare", help="change the version, and give the changelog its section")
    prepare.add_argument("version")
    prepare.add_argument("--on", default=datetime.datetime.now(datetime.UTC).date().isoformat(), help="YYYY-MM-DD")
    check = commands.add_parser("check", help="see whether tag, version and changelog agree")
    check.add_argument("tag", nargs="?", default="")
    commands.add_parser("notes", help="print the version's section of the changelog")
    options = parser.parse_args(arguments)
    if options.command == "prepare":
        try:
            files = prepare_files(root, options.version, options.on)
        except ValueError as error:
            print(error, file=sys.stderr)
            return 2
        for name, text in files.items():
            (root / name).write_text(text, encoding="utf-8")
        archive = f"python -m tests.tools.archive {options.version}"
        print(f"changed {', '.join(files)}; look at them, then: {archive}; commit, and: git tag v{options.version}")
        return 0
    if options.command == "notes":
        changelog = (root / "CHANGELOG.md").read_text(encoding="utf-8")
        print(find_section(changelog, read_version(root)) or find_section(changelog, UNRELEASED))
        return 0
    reasons = find_objections(root, options.tag)
    for reason in reasons:
        print(reason, file=sys.stderr)
    return 2 if reasons else 0


if __name__ == "__main__":
    sys.exit(main())
