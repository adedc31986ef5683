"""What was worked out when notebooks were made, kept so that grading need not derive and draw it again.

A file of DIR/.qdot can be deleted at any time: everything in it is made anew from the assignment and its secret. It is
signed with the secret and belongs to this very code, assignment and student; any other is not looked into.
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
from qdot.exercises.figure import figure_svg, part_svg
from qdot.exercises.formula.text import know_texts, text_of
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.render import template_folder
from qdot.exercises.writing.statement import prompt, statement

FOLDER = ".qdot"


@dataclass(frozen=True)
class Kept:
    """The problems of a student, each with its slot, and by slot or slot-part figures (SVG) and what is given or asked.

    There are none where these were not drawn and written.
    """

    problems: list[tuple[str, Problem]]
    figures: Mapping[str, str] = field(default_factory=dict)
    wording: Mapping[str, str] = field(default_factory=dict)

    def figure(self, slot: str, problem: Problem) -> str:
        """Return the figure of a problem's arm."""
        return self.figures[slot] if slot in self.figures else figure_svg(problem.chain, slot)

    def given(self, slot: str, problem: Problem) -> str:
        """Return what is given of a problem's arm, as HTML."""
        return self.wording[slot] if slot in self.wording else given_html(problem)

    def asked(self, slot: str, problem: Problem, part: str) -> str:
        """Return what is asked in a part, as HTML."""
        name = f"{slot}-{part}"
        return self.wording[name] if name in self.wording else to_html(prompt(problem, problem[part]))

    def part_figure(self, slot: str, problem: Problem, part: str) -> str:
        """Return the figure of a part, empty where it has none."""
        name = f"{slot}-{part}"
        if slot in self.figures:  # what has no figure of its own is not kept
            return self.figures.get(name, "")
        return part_svg(problem.chain, next(one for one in problem.parts if one.name == part), name)


def given_html(problem: Problem) -> str:
    """Return the table of an arm and what else is given, as HTML."""
    return to_html(statement(problem, "", typed=False))


def keep(assignment: Assignment, student: str, problems: list[tuple[str, Problem]]) -> None:
    """Keep the problems of a student with their figures; a disk that is full or read-only is no reason to stop."""
    figures, wording = {}, {}
    for slot, problem in problems:
        wording[slot] = given_html(problem)
        wording.update({f"{slot}-{part.name}": to_html(prompt(problem, part)) for part in problem.parts})
        figures[slot] = figure_svg(problem.chain, slot)
        drawn = {f"{slot}-{part.name}": part_svg(problem.chain, part, f"{slot}-{part.name}") for part in problem.parts}
        figures.update({name: svg for name, svg in drawn.items() if svg})
    answers = [part.answer for _, problem in problems for part in problem.parts]
    texts = [(entry, text_of(entry)) for answer in answers for entry in answer.entries()]
    minors = [_minors(problem) for _, problem in problems]
    payload = zlib.compress(_pickled((problems, figures, wording, texts, minors)), 1)
    text = f"{_signature(assignment, student, payload)}\n{base64.b64encode(payload).decode()}\n"
    try:
        write_atomically(store_path(assignment, student), text, mode=0o600, lasting=False)
    except QdotError:
        return


class _Pickler(pickle.Pickler):
    """Keeps sums, products and powers as they are: SymPy's own way is to work each out again when it is read."""

    def reducer_override(self, value: object) -> Any:
        if isinstance(value, (sp.Add, sp.Mul)):
            return _sum_or_product, (type(value), value.args)
        return (_power, value.args) if isinstance(value, sp.Pow) else NotImplemented


def _sum_or_product(kind: type[sp.Add | sp.Mul], args: tuple[sp.Expr, ...]) -> sp.Expr:
    return kind._from_args(args)


def _power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    made = sp.Expr.__new__(sp.Pow, base, exponent)
    made.is_commutative = base.is_commutative and exponent.is_commutative
    return made


def _minors(problem: Problem) -> bytes:
    """Return the minors of J, if they were worked out, to be read where a mistake is looked for and nowhere else."""
    derived = derive(problem.chain)
    return _pickled(derived.generic_minors) if "generic_minors" in vars(derived) else b""


def _pickled(content: object) -> bytes:
    pickled = io.BytesIO()
    _Pickler(pickled, protocol=5).dump(content)
    return pickled.getvalue()


def kept_text(assignment: Assignment, student: str) -> str:
    """Return what was kept of a student as it stands in its file, to be sent elsewhere; empty where nothing is."""
    try:
        return store_path(assignment, student).read_text(encoding="ascii")
    except (OSError, ValueError):
        return ""


def kept(assignment: Assignment, student: str, text: str | None = None) -> Kept:
    """Return what was kept of a student, or the problems worked out anew; with `text`, no file is read."""
    try:
        signature, encoded = (kept_text(assignment, student) if text is None else text).split("\n")[:2]
        payload = base64.b64decode(encoded, validate=True)
        if hmac.compare_digest(signature, _signature(assignment, student, payload)):
            problems, figures, wording, texts, minors = pickle.loads(zlib.decompress(payload))  # noqa: S301 - signed with the secret
            know_texts(texts)
            for (_, problem), kept_minors in zip(problems, minors, strict=True):
                if kept_minors:
                    store_minors(problem.chain, partial(pickle.loads, kept_minors))
            return Kept(problems, figures, wording)
    except ValueError:
        pass  # nothing kept, or damaged
    return Kept(assignment.problems(student))


def store_path(assignment: Assignment, student: str) -> Path:
    """Return where what was worked out for a student is kept."""
    return assignment.folder / FOLDER / "problems" / hashlib.sha256(student.encode()).hexdigest()[:24]


def _signature(assignment: Assignment, student: str, payload: bytes) -> str:
    about = repr((code(), assignment.edition_of(student), assignment.marking, student)).encode()
    return hmac.new(assignment.secret.encode(), about + b"\0" + payload, hashlib.sha256).hexdigest()


@cache
def code() -> str:
    """Return a digest of the code and the versions by which problems are worked out and drawn."""
    digest = hashlib.sha256(repr((sys.version_info[:2], sp.__version__, np.__version__)).encode())
    here = Path(__file__).resolve().parents[1]
    own = [path for kind in ("py", "txt", "json") for path in here.rglob(f"*.{kind}")]
    for path in sorted([*own, *template_folder().rglob("*.svg.j2")]):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
