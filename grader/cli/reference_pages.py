"""Pages of docs/ that are made from the registries of outlets and reports, the schemas, and what the packages offer.

`python -m qdot.grader.cli.reference_pages` writes them; a test says when they are out of date.
"""

import inspect
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any

import sympy as sp

import qdot
from qdot.exercises.common.console import say
from qdot.exercises.common.files import write_atomically
from qdot.exercises.docs.dependencies import dependencies_page, with_install_words
from qdot.exercises.exports.registry import EXPORT_FORMATS
from qdot.exercises.generation import generate
from qdot.exercises.problem.problem import ENGINE, Problem, ProblemId
from qdot.exercises.writing.render import render
from qdot.grader.grading.marking import share_earned
from qdot.grader.reports.formats import FORMATS

ROOT = Path(__file__).resolve().parents[2]
RUNS = ROOT / "tests" / "platforms"
SCHEMAS = ROOT / "docs" / "schemas"


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    return {
        "outlets.md": outlets_page(), "library.md": library_page(), "partial-credit.md": credit_page(),
        "compatibility.md": compatibility_page(), "dependencies.md": dependencies_page(),
    }  # fmt: skip


def outlets_page() -> str:
    """Return the page: what is written, which program reads it, and what in our tests reads it as that would."""
    order = ["generate", *EXPORT_FORMATS]  # students' notebooks have rows, too
    records = sorted(_records(), key=lambda record: (order.index(record["outlet"]), record["software"]))
    return render("docs/outlets.md.j2", outlets=EXPORT_FORMATS.values(), formats=FORMATS.values(), records=records)


def _records() -> Iterator[dict[str, str]]:
    """Yield what is kept of the runs in the real programs (tests/platforms), with their counts in words."""
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
    read = [(path.stem, json.loads(path.read_text(encoding="utf-8"))) for path in sorted(SCHEMAS.glob("*.json"))]
    schemas = [{"name": name, "id": one["$id"], "version": one["version"], "title": one["title"]} for name, one in read]
    return render("docs/compatibility.md.j2", schemas=schemas, engine=ENGINE)


# --- partial credit ---

ELBOW = ProblemId(
    "elbow-3r",
    1,
    ("position", "joint-axes", "position-vectors", "jacobian", "inverse-jacobian", "determinant", "singular-angles"),
    variation="chapter",
)
SHOULDER = "a1 + a2*cos(theta2) + a3*cos(theta2 + theta3)"
SETS = {
    "θ3 = 0, without π": f"theta3 = 0, {SHOULDER} = 0",
    "θ3 = 0, π, without the shoulder": "theta3 = 0, theta3 = pi",
    "θ3 = 0, π and θ2 = 0, π": "theta3 = 0, theta3 = pi, theta2 = 0, theta2 = pi",
    "everything, and θ1 = 0": f"theta3 = 0, theta3 = pi, {SHOULDER} = 0, theta1 = 0",
    "everything, and θ1 = 0, π": f"theta3 = 0, theta3 = pi, {SHOULDER} = 0, theta1 = 0, theta1 = pi",
    "all joints 0 or π": ", ".join(f"theta{k} = {value}" for k in (1, 2, 3) for value in ("0", "pi")),
}
"""Wrong sets of singular configurations of the elbow arm."""


@dataclass(frozen=True)
class Example:
    """A wrong answer to a question, in words, and what it earns."""

    question: str
    mistake: str
    share: str


def credit_page() -> str:
    """Return the page on what is right in part, its examples marked by the grader."""
    problem = generate(ELBOW)
    examples = [
        Example(part, mistake, str(share_earned(problem, problem[part], answer).limit_denominator(100)))
        for part, mistake, answer in _wrong_answers(problem)
    ]
    return render("docs/partial-credit.md.j2", examples=examples)


def _wrong_answers(problem: Problem) -> Iterator[tuple[str, str, str]]:
    """Yield questions, each with a mistake in words and the answer that it gives."""
    position, axes, vectors, jacobian, inverse, (det,) = (
        problem[name].answer.as_matrix() for name in ELBOW.questions[:-1]
    )
    theta3 = problem.chain.q[2]
    first = jacobian.as_mutable()
    first[0, 0] = 0
    for name, mistake, answer in (
        ("joint-axes", "z1 and z2 negated", axes * sp.diag(1, -1, -1)),
        ("position-vectors", "p* reversed", -vectors),
        ("jacobian", "the sign and a factor 2 wrong", -2 * jacobian),
        ("jacobian", "one entry zero", first),
        ("jacobian", "transposed", jacobian.T),
        ("inverse-jacobian", "the adjugate, without 1/det J", inverse * det),
        ("position", "d1 left out", position.subs("d1", 0)),
        ("position", "θ3 for θ2 + θ3", position.subs(sp.Add(*problem.chain.q[1:]), theta3)),
    ):
        yield name, mistake, str(list(answer) if answer.cols == 1 else answer.tolist())
    for mistake, formula in (
        ("without a2 a3", f"({det})/(a2*a3)"),
        ("without sin θ3", f"({det})/sin(theta3)"),
        ("cos θ3 for sin θ3", f"{det}".replace("*sin(theta3)", "*cos(theta3)")),
        ("invented, with sin θ3 in it", "a1*a2*a3*sin(theta1)*sin(theta2)*sin(theta3)"),
    ):
        yield "determinant", mistake, formula
    for mistake, claims in SETS.items():
        yield "singular-angles", mistake, f"[{claims}]"


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
    """Return the reference of what `qdot` offers, from docstrings."""
    homes = {name: home for home, names in qdot._HOMES.items() for name in names}
    kinds = (("What is asked", "exercises"), ("What is handed in", "grader"))
    packages = [(title, list(_offered(package, homes))) for title, package in kinds]
    return render("docs/library.md.j2", packages=packages)


def _offered(package: str, homes: Mapping[str, str]) -> Iterator[Offered]:
    for name in sorted((name for name, home in homes.items() if home.startswith(package)), key=str.casefold):
        what = getattr(qdot, name)
        if inspect.isclass(what) or inspect.isroutine(what):
            yield Offered(name, name + _signature(what), *_parted(inspect.getdoc(what) or ""), tuple(_members(what)))
        else:
            keys = f" Its keys: {', '.join(f'`{key}`' for key in what)}." if isinstance(what, dict) else ""
            yield Offered(name, name, _comment(homes[name], name) + keys, "", ())


def _comment(home: str, name: str) -> str:
    """Return what stands in quotes under a constant, in the module that it comes from."""
    source = inspect.getsource(import_module(f"qdot.{home}"))
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


def worded() -> dict[Path, str]:
    """Return the README and every page of docs/ with the words by which qdot is installed as they hold now."""
    paths = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return {path: with_install_words(path.read_text(encoding="utf-8")) for path in paths}


if __name__ == "__main__":
    for page, text in pages().items():
        write_atomically(ROOT / "docs" / page, text)
        say(f"wrote {page}")
    for path, text in worded().items():
        write_atomically(path, text)
