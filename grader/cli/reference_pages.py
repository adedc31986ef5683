"""Pages of docs/ that are made from the registries of outlets and reports, the schemas, and what the packages offer.

`python -m qdot.grader.cli.reference_pages` writes them; a test says when they are out of date.
"""

import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import qdot
from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.problem.problem import ENGINE
from qdot.exercises.writing.render import render
from qdot.grader.reports.formats import FORMATS

ROOT = Path(__file__).resolve().parents[2]
RUNS = ROOT / "tests" / "platforms"
SCHEMAS = ROOT / "docs" / "schemas"


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    return {
        "outlets.md": outlets_page(), "library.md": library_page(), "compatibility.md": compatibility_page(),
    }  # fmt: skip


def outlets_page() -> str:
    """Return the page: what is written, which program reads it, and what in our tests reads it as that would."""
    order = ["generate", *EXPORT_FORMATS]  # students' notebooks have rows, too
    records = sorted(_records(), key=lambda record: (order.index(record["outlet"]), record["software"]))
    return render("docs/outlets.md.j2", outlets=EXPORT_FORMATS.values(), formats=FORMATS.values(), records=records)


def _records() -> Iterator[dict[str, str]]:
    """Yield the records of runs in the real programs (tests/platforms), with their counts in words."""
    for path in RUNS.glob("*.json"):
        run = json.loads(path.read_text(encoding="utf-8"))
        counts = (
            f"{what}: {count['passed']} of {count['of']}" + (f" ({count['but']})" if count["but"] else "")
            for what, count in run["counts"].items()
        )
        yield {**run, "told": "; ".join(counts)}


# --- compatibility ---


def compatibility_page() -> str:
    """Return the page on what stays as it is, with the version of each schema."""
    read = [(path, json.loads(path.read_text(encoding="utf-8"))) for path in sorted(SCHEMAS.glob("*.json"))]
    schemas = [{"name": path.stem, "id": schema["$id"], **schema} for path, schema in read]
    return render("docs/compatibility.md.j2", schemas=schemas, engine=ENGINE)


# --- the library ---


@dataclass(frozen=True)
class LibraryName:
    """A name that the library offers: how it is called, what its docstring says, and an example."""

    name: str
    call: str
    description: str
    example: str


def library_page() -> str:
    """Return the reference of what `qdot` offers, from docstrings."""
    homes = {name: home for home, names in qdot._HOMES.items() for name in names}
    ordered = sorted(homes, key=str.casefold)
    packages = [
        (title, [_describe(name, homes[name]) for name in ordered if homes[name].startswith(package)])
        for title, package in (("What is asked", "exercises"), ("What is handed in", "grader"))
    ]
    return render("docs/library.md.j2", packages=packages)


def _describe(name: str, home: str) -> LibraryName:
    item = getattr(qdot, name)
    if not (inspect.isclass(item) or inspect.isroutine(item)):  # a constant, with a docstring below it
        source = inspect.getsource(import_module(f"qdot.{home}"))
        match = re.search(rf'^{name}\b[^"]*(?:"[^"\n]*"[^"]*)*?\n"""([^"]+)"""', source, re.MULTILINE)
        assert match, name
        return LibraryName(name, name, match[1], "")
    text, prompt, example = (inspect.getdoc(item) or "").partition(">>>")
    return LibraryName(name, name + _signature(item), text.strip(), prompt + example)


def _signature(item: Any) -> str:
    """Return how a function or class is called, with types by their own names."""
    if inspect.isclass(item) and (item.__init__ is object.__init__ or issubclass(item, (Exception, str))):
        return ""
    shown = str(inspect.signature(item)).replace("typing.", "")
    shown = re.sub(r"<factory>", "…", re.sub(r"<function (\w+) at \w+>", r"\1", shown))
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", shown).removesuffix(" -> None")


if __name__ == "__main__":
    for page, text in pages().items():
        write_atomically(ROOT / "docs" / page, text)
        say(f"wrote {page}")
