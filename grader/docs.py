"""Pages of docs/ that are made from the registries of outlets and reports, the schemas, and what the packages offer.

`python -m grader.docs` writes them; a test says when they are out of date.
"""

import inspect
import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import exercises
import grader
from exercises.answers import ConditionSet
from exercises.console import say
from exercises.docs.dependencies import dependencies_page, with_install_words
from exercises.exports.registry import OUTLETS
from exercises.files import write_atomically
from exercises.generation import generate
from exercises.problem import ENGINE, Problem, ProblemId
from exercises.render import render
from grader.marking import mark
from grader.reports.formats import FORMATS

ROOT = Path(__file__).parents[1]
RUNS = ROOT / "tests" / "platforms"
SCHEMAS = ROOT / "docs" / "schemas"


def pages() -> dict[str, str]:
    """Return the pages by their names."""
    return {
        "outlets.md": outlets_page(), "library.md": library_page(), "partial-credit.md": credit_page(),
        "promises.md": promises_page(), "dependencies.md": dependencies_page(),
    }  # fmt: skip


def outlets_page() -> str:
    """Return the page: what is written, which program reads it, and what in our tests reads it as that would."""
    order = ["generate", *OUTLETS]  # students' notebooks have rows, too
    records = sorted(_records(), key=lambda record: (order.index(record["outlet"]), record["software"]))
    return render("docs/outlets.md.j2", outlets=OUTLETS.values(), formats=FORMATS.values(), records=records)


def _records() -> Iterator[dict[str, str]]:
    """Yield what is kept of the runs in the real programs (tests/platforms), with their counts in words."""
    for path in RUNS.glob("*.json"):
        run = json.loads(path.read_text(encoding="utf-8"))
        counts = (
            f"{what}: {count['passed']} of {count['of']}" + (f" ({count['but']})" if count["but"] else "")
            for what, count in run["counts"].items()
        )
        yield {**run, "told": "; ".join(counts)}


# --- promises ---


def promises_page() -> str:
    """Return the page on what stays as it is, with the version of each schema."""
    read = [(path.stem, json.loads(path.read_text(encoding="utf-8"))) for path in sorted(SCHEMAS.glob("*.json"))]
    schemas = [{"name": name, "id": one["$id"], "version": one["version"], "title": one["title"]} for name, one in read]
    return render("docs/promises.md.j2", schemas=schemas, engine=ENGINE)


# --- partial credit ---

ARMS = {"planar-2r": "theta2", "elbow-3r": "theta3", "ur-6r": "theta3"}
"""Arms as the chapter draws them, on which mistakes are made; the joint whose sine is a factor of det J."""
ROWS = "[[{}], [a1*cos(theta1) + a2*cos(theta1 + theta2), {}]]"
FIRST = "-a1*sin(theta1) - a2*sin(theta1 + theta2), {}"
OF_JACOBIAN = {
    "one entry wrong": ROWS.format(FIRST.format("-a2*sin(theta2)"), "a2*cos(theta1 + theta2)"),
    "the second column upside down": ROWS.format(FIRST.format("a2*cos(theta1 + theta2)"), "-a2*sin(theta1 + theta2)"),
    "everything negated": (
        "[[a1*sin(theta1) + a2*sin(theta1 + theta2), a2*sin(theta1 + theta2)], "
        "[-a1*cos(theta1) - a2*cos(theta1 + theta2), -a2*cos(theta1 + theta2)]]"
    ),
    "zeros": "[[0, 0], [0, 0]]",
}
"""Wrong answers for the planar 2R."""
TURNED = "[[cos(theta1 + theta2), -sin(theta1 + theta2), 0, {}], [sin(theta1 + theta2), cos(theta1 + theta2), 0, {}], "
OF_POSE = {
    "M on the left": (
        f"{TURNED}[0, 0, 1, 0], [0, 0, 0, 1]]".format(
            "a1 + a2 + a1*cos(theta1) - a1*cos(theta1 + theta2)", "a1*sin(theta1) - a1*sin(theta1 + theta2)"
        )
    ),
}
"""The same for its pose by exponentials."""


@dataclass(frozen=True)
class Example:
    """A mistake made for an arm, as it was typed, with what it earns and what is said of it."""

    mistake: str
    arm: str
    answer: str
    share: str
    reason: str


def credit_page() -> str:
    """Return the page on what is right in part, its examples marked by the grader."""
    of_jacobian = [_example("jacobian", mistake, "planar-2r", answer) for mistake, answer in OF_JACOBIAN.items()]
    examples = [
        ("Determinants", list(_of_determinants())),
        ("A Jacobian", of_jacobian),
        ("A pose", [_example("body-pose", mistake, "planar-2r@screws", pose) for mistake, pose in OF_POSE.items()]),
        ("Singular configurations", list(_of_sets())),
    ]
    return render("docs/partial-credit.md.j2", examples=examples)


def _of_determinants() -> Iterator[Example]:
    elbow = r"\*sin(\(theta[23]\))(?=\*|$)"
    made = {
        "the sign": (r"^", "-"),
        "a length lost": (r"a2\*", ""),
        "a length lost, and the sign": (r"^(.*?)a2\*", r"-\1"),
        "the sine of the elbow lost": (elbow, ""),
        "a cosine for the sine of the elbow": (elbow, r"*cos\1"),
        "a factor too many": (r"$", "*sin(theta1)"),
    }
    for mistake, (pattern, instead) in made.items():
        for arm in ARMS:
            right = _problem(arm, "determinant").parts[0].answer.as_typed()
            yield _example("determinant", mistake, arm, re.sub(pattern, instead, right, count=1))


def _of_sets() -> Iterator[Example]:
    made = (
        ("one of two values forgotten", ("{0} = 0",), 1),
        ("a wrong value for it", ("{0} = 0", "{0} = pi/2"), 1),
        ("a claim too many", ("{0} = 0", "{0} = pi", "theta1 = 0"), 1),
        ("a condition forgotten", (), 2),
        ("guesses", ("{0} = 0", "{0} = pi", "theta1 = 0", "theta1 = pi"), 1),
    )
    for mistake, claims, least in made:
        for arm, joint in list(ARMS.items())[: 1 if mistake == "guesses" else None]:
            answer = _problem(arm, "singular-angles").parts[0].of(ConditionSet)
            if len(answer.components) >= least:
                others = [piece for piece in answer.pieces() if not piece.startswith(f"{joint} =")]
                typed = [*(claim.format(joint) for claim in claims), *others]
                yield _example("singular-angles", mistake, arm, f"[{', '.join(typed)}]")


def _problem(arm: str, question: str) -> Problem:
    family, _, convention = arm.partition("@")
    return generate(ProblemId(family, 1, (question,), variation="chapter", convention=convention))


def _example(question: str, mistake: str, arm: str, answer: str) -> Example:
    (marked,) = mark(_problem(arm, question), {question: answer}, secret="docs")  # noqa: S106 - points of examples
    share = Fraction(marked.judgement.share).limit_denominator(100)
    said = marked.judgement.reason.split(";")[0] if share else "—"
    return Example(mistake, arm, answer, str(share), said)


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
