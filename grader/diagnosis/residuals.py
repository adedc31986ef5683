"""What is missing in a wrong answer, where no mistake of the catalogue gives it: links left out of columns or of P.

The difference between the right answer and the student's is looked for among sums of what links add: column by column,
each with links of its own.
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
"""Links of which every sum is looked at."""


def missing_links(w: Working, part: Part, right: np.ndarray, answer: np.ndarray) -> Diagnosis | None:
    """Return which links' parts an answer lacks, (rows, columns, N) as the right one, or nothing."""
    question = QUESTIONS[part.kind]
    linear = question.linear_rows(w.chain)
    if not linear or (right - answer).shape[1] > w.n:
        return None
    answer_rows, axes = zip(*linear, strict=True)
    if question.adds_up == "links":
        links = np.stack([w.arithmetic.value(link) for link in w["links"]])[:, list(axes)]
        return _of_position(w, links, (right - answer)[:, 0])
    residual, size = right - answer, float(np.abs(right).max())
    others = [row for row in range(len(right)) if row not in answer_rows]
    if np.isnan(answer).any() or (others and np.abs(residual[others]).max() > SAME * size):
        return None
    lacking_columns = []
    for column in range(right.shape[1]):
        left = residual[list(answer_rows), column]
        if np.abs(left).max() <= SAME * size:
            continue
        parts = w["effects"][column][:, list(axes)]
        lacking = _sum_of(
            parts, left, [k for k in links_to_point(w.chain) if np.abs(parts[k]).max() > SAME * size], size
        )
        if lacking is None:
            return None
        lacking_columns.append(f"column {column + 1} seems to lack {_parts(w, lacking)}")
    if not lacking_columns:
        return None
    text = "; ".join(lacking_columns)
    return Diagnosis(
        ("chain-rule",),
        f"{text[0].upper()}{text[1:]}. A joint moves every link behind it, with all that they carry. See (6.3).",
        known_by=(f"chain-rule {text}",),
    )


def _of_position(w: Working, links: np.ndarray, residual: np.ndarray) -> Diagnosis | None:
    size = float(np.abs(links).max())
    counted = [k for k in links_to_point(w.chain) if np.abs(links[k]).max() > SAME * size]
    lacking = _sum_of(links, residual, counted, size)
    if lacking is None:
        return None
    says = f"The position seems to lack {_parts(w, lacking)}: every link from the base to P is added. See (6.1)."
    return Diagnosis(("link-left-out",), says, known_by=(f"link-left-out {lacking}",))


def _sum_of(parts: np.ndarray, residual: np.ndarray, counted: Sequence[int], size: float) -> tuple[int, ...] | None:
    """Return the links whose parts add up to a residual, not all of them; fewest first."""
    if np.isnan(residual).any() or not np.abs(residual).max() > SAME * size:
        return None
    for some in _subsets(counted):
        if np.abs(residual - parts[list(some)].sum(axis=0)).max() <= SAME * size:
            return some
    return None


def _subsets(counted: Sequence[int]) -> Iterator[tuple[int, ...]]:
    for count in range(1, min(len(counted), MOST_LINKS)):
        yield from combinations(counted, count)


def _parts(w: Working, links: Sequence[int]) -> str:
    """Return the parts of links in words; the one behind all joints is P in its own frame."""
    names = ["the offset of P" if k == w.n else f"link {k + 1}" for k in links]
    joined = names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
    return f"the part that {joined} {'adds' if len(names) == 1 else 'add'}"
