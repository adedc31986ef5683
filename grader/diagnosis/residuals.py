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

RELATIVE_TOLERANCE = 1e-9
MAX_LINKS = 8
"""Maximum number of links whose sums are all tried."""


def explain_missing_links(w: Working, part: Part, correct_values: np.ndarray, answer: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that an answer lacks the contributions of some links, or None.

    `correct_values` is the reference, (rows, columns, N), and `answer` has the same shape.
    """
    question = QUESTIONS[part.kind]
    linear = question.link_sum_rows(w.chain)
    if not linear or (correct_values - answer).shape[1] > w.n:
        return None
    answer_rows, axes = zip(*linear, strict=True)
    if question.link_sums == "links":
        links = np.stack([w.arithmetic.drop_derivatives(link) for link in w["links"]])[:, list(axes)]
        return _explain_position(w, links, (correct_values - answer)[:, 0])
    residual, size = correct_values - answer, float(np.abs(correct_values).max())
    other_rows = [row for row in range(len(correct_values)) if row not in answer_rows]
    if np.isnan(answer).any() or (other_rows and np.abs(residual[other_rows]).max() > RELATIVE_TOLERANCE * size):
        return None
    clauses = []
    for column in range(correct_values.shape[1]):
        column_residual = residual[list(answer_rows), column]
        if np.abs(column_residual).max() <= RELATIVE_TOLERANCE * size:
            continue
        contributions = w["effects"][column][:, list(axes)]
        missing = _find_links_with_sum(
            contributions,
            column_residual,
            [k for k in links_to_point(w.chain) if np.abs(contributions[k]).max() > RELATIVE_TOLERANCE * size],
            size,
        )
        if missing is None:
            return None
        clauses.append(f"column {column + 1} seems to lack {_describe_links(w, missing)}")
    if not clauses:
        return None
    text = "; ".join(clauses)
    return Diagnosis(
        ("chain-rule",),
        f"{text[0].upper()}{text[1:]}. A joint moves every link behind it, with all that they carry. See (6.3).",
        signature=(f"chain-rule {text}",),
    )


def _explain_position(w: Working, links: np.ndarray, residual: np.ndarray) -> Diagnosis | None:
    size = float(np.abs(links).max())
    candidate_links = [k for k in links_to_point(w.chain) if np.abs(links[k]).max() > RELATIVE_TOLERANCE * size]
    missing = _find_links_with_sum(links, residual, candidate_links, size)
    if missing is None:
        return None
    message = (
        f"The position seems to lack {_describe_links(w, missing)}: every link from the base to P is added. See (6.1)."
    )
    return Diagnosis(("link-left-out",), message, signature=(f"link-left-out {missing}",))


def _find_links_with_sum(
    contributions: np.ndarray, residual: np.ndarray, candidate_links: Sequence[int], scale: float
) -> tuple[int, ...] | None:
    """Return the smallest set of links, but not all of them, whose contributions add up to a residual, or None."""
    if np.isnan(residual).any() or not np.abs(residual).max() > RELATIVE_TOLERANCE * scale:
        return None
    for subset in _subsets(candidate_links):
        if np.abs(residual - contributions[list(subset)].sum(axis=0)).max() <= RELATIVE_TOLERANCE * scale:
            return subset
    return None


def _subsets(candidate_links: Sequence[int]) -> Iterator[tuple[int, ...]]:
    for count in range(1, min(len(candidate_links), MAX_LINKS)):
        yield from combinations(candidate_links, count)


def _describe_links(w: Working, links: Sequence[int]) -> str:
    """Return the contributions of links in words; index n stands for the vector to P in its own frame."""
    link_names = ["the offset of P" if k == w.n else f"link {k + 1}" for k in links]
    link_words = link_names[0] if len(link_names) == 1 else f"{', '.join(link_names[:-1])} and {link_names[-1]}"
    return f"the part that {link_words} {'adds' if len(link_names) == 1 else 'add'}"
