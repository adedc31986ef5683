"""Pages of docs/ that are made from the registries of outlets and reports, and from what the packages offer.

`python -m grader.docs` writes them; a test says when they are out of date.
"""

import inspect
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import exercises
import grader
from exercises.console import say
from exercises.exports.registry import OUTLETS
from exercises.files import write_atomically
from exercises.render import render
from grader.reports.formats import FORMATS


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    return {"outlets.md": outlets_page(), "library.md": library_page()}


def outlets_page() -> str:
    """Return the page: what is written, which program reads it, and what in our tests reads it as that would."""
    return render("docs/outlets.md.j2", outlets=OUTLETS.values(), formats=FORMATS.values())


# --- the library ---


@dataclass(frozen=True)
class Offered:
    """A name that a package offers: how it is called, what its docstring says, an example, and what it has."""

    name: str
    call: str
    says: str
    example: str
    members: tuple[tuple[str, str], ...]


def library_page() -> str:
    """Return the reference of what `exercises` and `grader` offer, from their docstrings."""
    packages = [(package.__name__, list(_offered(package))) for package in (exercises, grader)]
    return render("docs/library.md.j2", packages=packages)


def _offered(package: ModuleType) -> Iterator[Offered]:
    for name in sorted(package.__all__, key=str.casefold):
        what = getattr(package, name)
        if inspect.isclass(what) or inspect.isroutine(what):
            yield Offered(name, name + _signature(what), *_parted(inspect.getdoc(what) or ""), tuple(_members(what)))
        else:
            keys = f" Its keys: {', '.join(f'`{key}`' for key in what)}." if isinstance(what, dict) else ""
            yield Offered(name, name, _comment(package, name) + keys, "", ())


def _comment(package: ModuleType, name: str) -> str:
    """Return what stands in quotes under a constant, in the module that it comes from."""
    home = next(home for home, names in package._HOMES.items() if name in names)
    source = inspect.getsource(import_module(f"{package.__name__}.{home}"))
    match = re.search(rf'^{name}\b[^"]*(?:"[^"\n]*"[^"]*)*?\n"""([^"]+)"""', source, re.MULTILINE)
    assert match, name
    return match[1]


def _signature(what: Any) -> str:
    """Return how it is called, types by their own names."""
    if inspect.isclass(what) and (what.__init__ is object.__init__ or issubclass(what, (Exception, str))):
        return ""
    shown = str(inspect.signature(what)).replace("typing.", "")
    shown = re.sub(r"<factory>", "…", re.sub(r"<function (\w+) at \w+>", r"\1", shown))
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", shown).removesuffix(" -> None")


def _parted(text: str) -> tuple[str, str]:
    """Return what a docstring says, and its example."""
    lines = text.split("\n")
    begin = next((k for k, line in enumerate(lines) if line.startswith(">>>")), len(lines))
    return "\n".join(lines[:begin]).strip(), "\n".join(lines[begin:]).strip()


def _members(what: Any) -> Iterator[tuple[str, str]]:
    """Yield the methods and properties of a class, each with the first sentence of what is said of it."""
    for name, member in vars(what).items() if inspect.isclass(what) else ():
        called = inspect.isfunction(member) or isinstance(member, staticmethod)
        if not name.startswith("_") and (called or isinstance(member, (property, cached_property))):
            yield f"{name}(…)" if called else name, (inspect.getdoc(member) or "").split("\n\n")[0].replace("\n", " ")


if __name__ == "__main__":
    for page, text in pages().items():
        write_atomically(Path(__file__).parents[1] / "docs" / page, text)
        say(f"wrote {page}")
