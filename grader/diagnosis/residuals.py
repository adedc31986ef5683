"""Find the links that are missing in columns or in P, if no mistake of the catalogue gives a wrong answer.

The difference between the reference and the student's answer is compared with sums of the links' contributions, column
by column. Different columns may lack different links.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from qdot.exercises.arm.derivation_graph import Working, links_to_point
from qdot.exercises.problem.problem import Part
from qdot.exercises.questions import QUESTIONS
from qdot.grader.judging.verdict import Diagnosis

SAME = 1e-9
MOST_LINKS = 8
"""Maximum number of links whose sums are all tried."""


def missing_links(w: Working, part: Part, right: np.ndarray, answer: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that an answer lacks the contributions of some links, or None.

    `right` is the reference, (rows, columns, N), and `answer` has the same shape.
    """
    question = QUESTIONS[part.kind]
    linear = question.linear_rows(w.chain)
    if not linear or (right - answer).shape[1] > w.n:
        return None
    answer_rows, axes = zip(*linear, strict=True)
    if question.adds_up == "links":
        links = np.stack([w.arithmetic.value(link) for link in w["links"]])[:, list(axes)]
        return _of_position(w, links, (right - answer)[:, 0])
    residual, size = right - answer, float(np.abs(right).max())
    other_rows = [row for row in range(len(right)) if row not in answer_rows]
    if np.isnan(answer).any() or (other_rows and np.abs(residual[other_rows]).max() > SAME * size):
        return None
    clauses = []
    for column in range(right.shape[1]):
        column_residual = residual[list(answer_rows), column]
        if np.abs(column_residual).max() <= SAME * size:
            continue
        contributions = w["effects"][column][:, list(axes)]
        missing = _sum_of(
            contributions,
            column_residual,
            [k for k in links_to_point(w.chain) if np.abs(contributions[k]).max() > SAME * size],
            size,
        )
        if missing is None:
            return None
        clauses.append(f"column {column + 1} seems to lack {_parts(w, missing)}")
    if not clauses:
        return None
    text = "; ".join(clauses)
    return Diagnosis(
        ("chain-rule",),
        f"{text[0].upper()}{text[1:]}. A joint moves every link behind it, with all that they carry. See (6.3).",
        known_by=(f"chain-rule {text}",),
    )


def _of_position(w: Working, links: np.ndarray, residual: np.ndarray) -> Diagnosis | None:
    size = float(np.abs(links).max())
    candidate_links = [k for k in links_to_point(w.chain) if np.abs(links[k]).max() > SAME * size]
    missing = _sum_of(links, residual, candidate_links, size)
    if missing is None:
        return None
    message = f"The position seems to lack {_parts(w, missing)}: every link from the base to P is added. See (6.1)."
    return Diagnosis(("link-left-out",), message, known_by=(f"link-left-out {missing}",))


def _sum_of(parts: np.ndarray, residual: np.ndarray, counted: Sequence[int], size: float) -> tuple[int, ...] | None:
    """Return the smallest set of links, but not all of them, whose contributions add up to a residual, or None."""
    if np.isnan(residual).any() or not np.abs(residual).max() > SAME * size:
        return None
    for subset in _subsets(counted):
        if np.abs(residual - parts[list(subset)].sum(axis=0)).max() <= SAME * size:
            return subset
    return None


def _subsets(counted: Sequence[int]) -> Iterator[tuple[int, ...]]:
    for count in range(1, min(len(counted), MOST_LINKS)):
        yield from combinations(counted, count)


def _parts(w: Working, links: Sequence[int]) -> str:
    """Return the contributions of links in words; index n stands for the vector to P in its own frame."""
    link_names = ["the offset of P" if k == w.n else f"link {k + 1}" for k in links]
    link_words = link_names[0] if len(link_names) == 1 else f"{', '.join(link_names[:-1])} and {link_names[-1]}"
    return f"the part that {link_words} {'adds' if len(link_names) == 1 else 'add'}"
