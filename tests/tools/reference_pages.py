"""Write the pages of docs/ about export formats, reports, schemas and the library from the code.

`python -m tests.tools.reference_pages` writes them; a test fails if they are out of date.
"""

import inspect
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, is_dataclass
from importlib import import_module
from typing import Any

import qdot
from qdot.exercises.common.console import print_result
from qdot.exercises.common.files import write_atomically
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.problem.problem import ENGINE
from qdot.exercises.writing.render import render
from qdot.grader.reports.formats import FORMATS
from tests.support import ROOT

PLATFORM_RUNS = ROOT / "tests" / "platforms"
SCHEMAS = ROOT / "docs" / "schemas"


def make_pages() -> dict[str, str]:
    """Return the texts of the pages by file name."""
    return {
        "export-formats.md": make_export_formats_page(),
        "library.md": make_library_page(),
        "compatibility.md": make_compatibility_page(),
    }


def make_export_formats_page() -> str:
    """Return the page of export formats: which program reads each, and which tests check that it can be read."""
    order = ["generate", "serve", *EXPORT_FORMATS]  # the table of tests has rows for students' notebooks, too
    records = list(_read_platform_runs())
    records.sort(key=lambda record: (order.index(record["export_format"]), record["software"]))
    return render(
        "docs/export-formats.md.j2", export_formats=EXPORT_FORMATS.values(), formats=FORMATS.values(), records=records
    )


def _read_platform_runs() -> Iterator[dict[str, str]]:
    """Yield the records of runs in the real programs (tests/platforms), with the counts of each run as a phrase."""
    for path in PLATFORM_RUNS.glob("*.json"):
        run = json.loads(path.read_text(encoding="utf-8"))
        counts = run["counts"].values()
        passed_count, total_count = (sum(count[key] for count in counts) for key in ("passed", "of"))
        remarks = [
            f"{count['excused']} failed: {count['but']}" if count["excused"] else count["but"]
            for count in counts
            if count["but"]
        ]
        summary = f"{passed_count} of {total_count}"
        yield {**run, "result": f"{summary}. {' '.join(remarks)}" if remarks else summary}


# --- compatibility ---


def make_compatibility_page() -> str:
    """Return the page on compatibility between versions, with the version of each schema."""
    paths = sorted(SCHEMAS.glob("*.json"))
    schemas = [{"name": path.stem, **json.loads(path.read_text(encoding="utf-8"))} for path in paths]
    return render("docs/compatibility.md.j2", schemas=schemas, engine=ENGINE)


# --- the library ---


CONSTRUCTED_CLASSES = ("Base", "Chain", "Joint", "MarkingRules", "Point", "ProblemId")
"""Classes that callers construct. Objects of other classes are results, so the page lists only their attributes."""


@dataclass(frozen=True)
class LibraryName:
    """A public name of the library: its call with parameters, its docstring, an example, and a result's attributes."""

    name: str
    call: str
    description: str
    example: str
    attributes: Sequence[str] = ()


def make_library_page() -> str:
    """Return the reference of the public names of `qdot`, made from their docstrings."""
    module_by_name = {name: home for home, names in qdot._HOMES.items() for name in names}
    packages = []
    for title, package in (("The question", "exercises"), ("The answer", "grader")):
        names = sorted((name for name in module_by_name if module_by_name[name].startswith(package)), key=str.casefold)
        packages.append((title, [_describe(name, module_by_name[name]) for name in names]))
    return render("docs/library.md.j2", packages=packages)


def _describe(name: str, home: str) -> LibraryName:
    item = getattr(qdot, name)
    if not (inspect.isclass(item) or inspect.isroutine(item)):  # a constant, with a docstring below it
        source = inspect.getsource(import_module(f"qdot.{home}"))
        match = re.search(rf'^{name}\b[^"]*?(?:"[^"\n]*"[^"]*?)*?\n"""([^"]+)"""', source, re.MULTILINE)
        assert match, name
        return LibraryName(name, name, match[1], "")
    text, prompt, example = (inspect.getdoc(item) or "").partition(">>>")
    attributes = [field.name for field in fields(item)] if is_dataclass(item) and not _write_signature(item) else []
    if all(f"`{attribute}`" in text for attribute in attributes):
        attributes = []
    return LibraryName(name, name + _write_signature(item), text.strip(), prompt + example, attributes)


def _write_signature(item: Any) -> str:
    """Return the parameters of a function or class as text, with the names of types without their modules."""
    if inspect.isclass(item) and item.__name__ not in CONSTRUCTED_CLASSES:
        return ""
    signature = str(inspect.signature(item)).replace("typing.", "")
    signature = re.sub(r"<factory>", "…", re.sub(r"<function (\w+) at \w+>", r"\1", signature))
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", signature).removesuffix(" -> None")


if __name__ == "__main__":
    for page, text in make_pages().items():
        write_atomically(ROOT / "docs" / page, text)
        print_result(f"wrote {page}")
