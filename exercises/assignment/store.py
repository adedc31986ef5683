"""Store problems, figures and texts when notebooks are made, so that grading need not derive and draw them again.

The files of DIR/.qdot can be deleted at any time: everything in them can be regenerated from the assignment and its
secret. A file is signed with the secret, and is ignored unless it belongs to this code, assignment and student.
"""

import base64
import hashlib
import hmac
import io
import pickle
import sys
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.arm.derivation import derive, store_minors
from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.figure.arm_figure import figure_svg, part_svg
from qdot.exercises.formula.sympy_text import expression_text, store_texts
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import prompt, statement
from qdot.exercises.writing.render import template_folder

STORE_FOLDER = ".qdot"


@dataclass(frozen=True)
class StoredProblems:
    """The problems of a student with their slots, and the figures (SVG) and texts (HTML) that are stored.

    The keys of figures and texts are the slot ("p1") for the problem, and slot and part ("p1-jacobian") for a part.
    Figures and texts that are not stored are made again.
    """

    problems: list[tuple[str, Problem]]
    figures: Mapping[str, str] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)

    def figure(self, slot: str, problem: Problem) -> str:
        """Return the figure of a problem's arm."""
        return self.figures[slot] if slot in self.figures else figure_svg(problem.chain, slot)

    def statement(self, slot: str, problem: Problem) -> str:
        """Return the statement of a problem as HTML."""
        return self.texts[slot] if slot in self.texts else statement_html(problem)

    def prompt(self, slot: str, problem: Problem, part: str) -> str:
        """Return the prompt of a part as HTML."""
        name = f"{slot}-{part}"
        return self.texts[name] if name in self.texts else to_html(prompt(problem, problem[part]))

    def part_figure(self, slot: str, problem: Problem, part: str) -> str:
        """Return the figure of a part, "" if it has none."""
        name = f"{slot}-{part}"
        if slot in self.figures:  # parts without a figure are not stored
            return self.figures.get(name, "")
        return part_svg(problem.chain, next(candidate for candidate in problem.parts if candidate.name == part), name)


def statement_html(problem: Problem) -> str:
    """Return the statement of a problem as HTML: the table of its arm and other given values."""
    return to_html(statement(problem, "", explains_typing=False))


def store_problems(assignment: Assignment, student: str, problems: list[tuple[str, Problem]]) -> None:
    """Store the problems of a student with their figures; do nothing if the disk is full or read-only."""
    figures, wording = {}, {}
    for slot, problem in problems:
        wording[slot] = statement_html(problem)
        wording.update({f"{slot}-{part.name}": to_html(prompt(problem, part)) for part in problem.parts})
        figures[slot] = figure_svg(problem.chain, slot)
        part_figures = {
            f"{slot}-{part.name}": part_svg(problem.chain, part, f"{slot}-{part.name}") for part in problem.parts
        }
        figures.update({name: svg for name, svg in part_figures.items() if svg})
    answers = [part.answer for _, problem in problems for part in problem.parts]
    texts = [(entry, expression_text(entry)) for answer in answers for entry in answer.list_entries()]
    minors = [_minors(problem) for _, problem in problems]
    payload = zlib.compress(_pickle_content((problems, figures, wording, texts, minors)), 1)
    text = f"{_signature(assignment, student, payload)}\n{base64.b64encode(payload).decode()}\n"
    try:
        write_atomically(store_path(assignment, student), text, mode=0o600, is_synced=False)
    except QdotError:
        return


class _Pickler(pickle.Pickler):
    """Pickles sums, products and powers so that they load unchanged; SymPy would evaluate each one again."""

    def reducer_override(self, value: object) -> Any:
        if isinstance(value, (sp.Add, sp.Mul)):
            return _sum_or_product, (type(value), value.args)
        return (_power, value.args) if isinstance(value, sp.Pow) else NotImplemented


def _sum_or_product(kind: type[sp.Add | sp.Mul], args: tuple[sp.Expr, ...]) -> sp.Expr:
    return kind._from_args(args)


def _power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    power = sp.Expr.__new__(sp.Pow, base, exponent)
    power.is_commutative = base.is_commutative and exponent.is_commutative
    return power


def _minors(problem: Problem) -> bytes:
    """Return the pickled minors of J if they were computed; they are loaded only for the diagnosis of mistakes."""
    derivation = derive(problem.chain)
    return _pickle_content(derivation.generic_minors) if "generic_minors" in vars(derivation) else b""


def _pickle_content(content: object) -> bytes:
    pickled = io.BytesIO()
    _Pickler(pickled, protocol=5).dump(content)
    return pickled.getvalue()


def load_stored_problems(assignment: Assignment, student: str) -> StoredProblems:
    """Return a student's stored problems; generate them if they are missing, outdated or damaged."""
    try:
        signature, encoded = store_path(assignment, student).read_text(encoding="ascii").split("\n")[:2]
        payload = base64.b64decode(encoded, validate=True)
        if hmac.compare_digest(signature, _signature(assignment, student, payload)):
            problems, figures, wording, texts, minors = pickle.loads(zlib.decompress(payload))  # noqa: S301 - signed with the secret
            store_texts(texts)
            for (_, problem), pickled_minors in zip(problems, minors, strict=True):
                if pickled_minors:
                    store_minors(problem.chain, partial(pickle.loads, pickled_minors))
            return StoredProblems(problems, figures, wording)
    except (OSError, ValueError):
        pass  # nothing is stored, or it is damaged
    return StoredProblems(assignment.problems(student))


def store_path(assignment: Assignment, student: str) -> Path:
    """Return the path of a student's stored problems."""
    return assignment.folder / STORE_FOLDER / "problems" / hashlib.sha256(student.encode()).hexdigest()[:24]


def _signature(assignment: Assignment, student: str, payload: bytes) -> str:
    signed_data = repr((code_digest(), assignment.edition_of(student), assignment.marking_digest, student)).encode()
    return hmac.new(assignment.secret.encode(), signed_data + b"\0" + payload, hashlib.sha256).hexdigest()


@cache
def code_digest() -> str:
    """Return a digest of the code and the library versions that determine problems and figures."""
    digest = hashlib.sha256(repr((sys.version_info[:2], sp.__version__, np.__version__)).encode())
    package_folder = Path(__file__).resolve().parents[1]
    sources = [path for kind in ("py", "txt", "json", "toml") for path in package_folder.rglob(f"*.{kind}")]
    for path in sorted([*sources, *template_folder().rglob("*.svg.j2")]):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
