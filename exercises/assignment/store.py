"""Store problems, figures and texts when notebooks are made, so that grading need not derive and draw them again.

The files in DIR/.qdot may be deleted at any time, because everything in them can be regenerated from the assignment.
Each file is signed with the assignment's secret. A file is ignored if another version of qdot, of the assignment or of
the student's problems wrote it.
"""

import base64
import hashlib
import hmac
import io
import pickle
import sys
import zlib
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import sympy as sp

from qdot.exercises.assignment.assignment import Assignment
from qdot.exercises.common.errors import QdotError
from qdot.exercises.common.files import write_atomically
from qdot.exercises.derivation.derivation import derive, register_minors
from qdot.exercises.figure.arm_figure import draw_figure_svg, draw_part_svg
from qdot.exercises.formula.sympy_text import format_expression, store_texts
from qdot.exercises.problem.problem import Problem
from qdot.exercises.writing.markup import to_html
from qdot.exercises.writing.problem_texts import write_prompt, write_statement
from qdot.exercises.writing.render import find_template_folder

STORE_FOLDER = ".qdot"


@dataclass(frozen=True)
class StoredProblems:
    """The problems of a student with their slots, and the contents of feedback pages by slot (see `pieces_of`)."""

    problems: list[tuple[str, Problem]]
    pieces_by_slot: dict[str, dict[str, str]] = field(default_factory=dict)

    def pieces_of(self, slot: str) -> dict[str, str]:
        """Return the figures (SVG) and texts (HTML) of a problem for feedback pages; make them if they are not stored.

        The keys are "figure" and "statement" and, for a part such as jacobian, "jacobian prompt" and "jacobian figure".
        """
        if slot not in self.pieces_by_slot:
            self.pieces_by_slot[slot] = _make_pieces(slot, dict(self.problems)[slot])
        return self.pieces_by_slot[slot]


def _make_pieces(slot: str, problem: Problem) -> dict[str, str]:
    statement = to_html(write_statement(problem, "", explains_typing=False))
    pieces = {"figure": draw_figure_svg(problem.chain, slot), "statement": statement}
    for part in problem.parts:
        pieces[f"{part.name} prompt"] = to_html(write_prompt(problem, part))
        pieces[f"{part.name} figure"] = draw_part_svg(problem.chain, part, f"{slot}-{part.name}")
    return pieces


def store_problems(assignment: Assignment, student: str, problems: list[tuple[str, Problem]]) -> None:
    """Store the problems of a student with their figures and texts; do nothing if the disk is full or read-only."""
    pieces = {slot: _make_pieces(slot, problem) for slot, problem in problems}
    answers = [part.answer for _, problem in problems for part in problem.parts]
    entry_texts = [(entry, format_expression(entry)) for answer in answers for entry in answer.list_entries()]
    pickled_minors = [_pickle_minors(problem) for _, problem in problems]
    payload = zlib.compress(_pickle_content((problems, pieces, entry_texts, pickled_minors)), level=1)
    text = f"{_compute_signature(assignment, student, payload)}\n{base64.b64encode(payload).decode()}\n"
    try:
        write_atomically(make_store_path(assignment.folder, student), text, mode=0o600, is_synced=False)
    except QdotError:
        return


class _Pickler(pickle.Pickler):
    """Pickles sums, products and powers so that they load unchanged; SymPy would evaluate each expression again."""

    def reducer_override(self, value: object) -> Any:
        if isinstance(value, (sp.Add, sp.Mul)):
            return _load_sum_or_product, (type(value), value.args)
        return (_load_power, value.args) if isinstance(value, sp.Pow) else NotImplemented


def _load_sum_or_product(kind: type[sp.Add | sp.Mul], args: tuple[sp.Expr, ...]) -> sp.Expr:
    return kind._from_args(args)


def _load_power(base: sp.Expr, exponent: sp.Expr) -> sp.Expr:
    power = sp.Expr.__new__(sp.Pow, base, exponent)
    power.is_commutative = base.is_commutative and exponent.is_commutative
    return power


def _pickle_minors(problem: Problem) -> bytes:
    """Return the pickled minors of J, b"" if they were not computed. Only the diagnosis of mistakes unpickles them."""
    derivation = derive(problem.chain)
    return _pickle_content(derivation.symbolic_minors) if "symbolic_minors" in vars(derivation) else b""


def _pickle_content(content: object) -> bytes:
    buffer = io.BytesIO()
    _Pickler(buffer, protocol=5).dump(content)
    return buffer.getvalue()


def load_stored_problems(assignment: Assignment, student: str) -> StoredProblems:
    """Return a student's stored problems; generate them if they are missing, outdated or damaged."""
    try:
        text = make_store_path(assignment.folder, student).read_text(encoding="ascii")
        signature, encoded_payload = text.split("\n")[:2]
        payload = base64.b64decode(encoded_payload, validate=True)
        if hmac.compare_digest(signature, _compute_signature(assignment, student, payload)):
            problems, pieces, entry_texts, all_minors = pickle.loads(zlib.decompress(payload))  # noqa: S301 - signed
            store_texts(entry_texts)
            for (_, problem), minors in zip(problems, all_minors, strict=True):
                if minors:
                    register_minors(problem.chain, partial(pickle.loads, minors))
            return StoredProblems(problems, pieces)
    except (OSError, ValueError):
        pass  # the file is missing or damaged
    return StoredProblems(assignment.generate_problems(student))


def make_store_path(folder: Path, student: str) -> Path:
    """Return the path of a student's stored problems in an assignment's folder."""
    return folder / STORE_FOLDER / "problems" / hashlib.sha256(student.encode()).hexdigest()[:24]


def _compute_signature(assignment: Assignment, student: str, payload: bytes) -> str:
    signed_data = repr(
        (compute_package_digest(), assignment.notebook_digest_of(student), assignment.marking_digest, student)
    ).encode()
    return hmac.new(assignment.secret.encode(), signed_data + b"\0" + payload, hashlib.sha256).hexdigest()


@cache
def compute_package_digest() -> str:
    """Return a digest of the code and the library versions that determine problems and figures."""
    digest = hashlib.sha256(repr((sys.version_info[:2], sp.__version__, np.__version__)).encode())
    package_folder = Path(__file__).resolve().parents[1]
    sources = [path for kind in ("py", "txt", "json", "toml") for path in package_folder.rglob(f"*.{kind}")]
    for path in sorted([*sources, *find_template_folder().rglob("*.svg.j2")]):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()
