"""Find the links whose contributions are missing in the columns of the Jacobian J or in the position of the point P.

This search is used if no mistake of the catalogue gives the wrong answer. The residual is the correct answer minus the
student's answer. Each column of the residual is compared with sums of the links' contributions, so different columns
may lack different links.
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from qdot.exercises.derivation.graph import StageResults, list_links_to_point
from qdot.exercises.mistakes.base import join_words
from qdot.exercises.short_questions import question_of
from qdot.grader.diagnosis.evaluated_answer import EvaluatedAnswer
from qdot.grader.diagnosis.numbers import RELATIVE_TOLERANCE
from qdot.grader.judging.verdict import Diagnosis

MAX_LINKS = 8
"""Only sums of fewer links than this are tried, because the number of sums doubles with each link."""


def explain_missing_links(answer: EvaluatedAnswer) -> Diagnosis | None:
    """Return the diagnosis that an answer of the expected shape lacks the contributions of some links, or None."""
    stages, correct_values, question = answer.correct_stages, answer.correct_values, question_of(answer.part)
    rows_with_axes, residual = question.find_link_sum_rows(stages.chain), correct_values - answer.numeric.values
    if not rows_with_axes or residual.shape[1] > stages.n:
        return None
    answer_rows, axes = map(list, zip(*rows_with_axes, strict=True))
    if question.link_sums == "links":  # each entry is a sum over the links, as in a position
        links = np.stack([stages.arithmetic.drop_derivatives(link) for link in stages["link vectors"]])[:, axes]
        return _explain_position(stages, links, residual[:, 0])
    size = float(np.abs(correct_values).max())
    other_residual = np.delete(residual, answer_rows, axis=0)  # of the rows that are no sums over links
    if np.isnan(residual).any() or np.abs(other_residual).max(initial=0.0) > RELATIVE_TOLERANCE * size:
        return None
    missing_by_column: dict[int, tuple[int, ...]] = {}
    for column in range(residual.shape[1]):
        column_residual = residual[answer_rows, column]
        if np.abs(column_residual).max() <= RELATIVE_TOLERANCE * size:
            continue
        missing_links = _find_links_with_sum(stages, stages["link derivatives"][column][:, axes], column_residual, size)
        if missing_links is None:
            return None
        missing_by_column[column + 1] = missing_links
    if not missing_by_column:
        return None
    clauses = [
        f"{_describe_links(stages, missing_links)} to column {column}"
        for column, missing_links in missing_by_column.items()
    ]
    message = f"You seem to have left out {', and '.join(clauses)}. A joint moves every link after it."
    return Diagnosis(("chain-rule",), message, signature=(f"chain-rule {missing_by_column}",))


def _explain_position(stages: StageResults, links: np.ndarray, residual: np.ndarray) -> Diagnosis | None:
    """Return the diagnosis that the position of P lacks the vectors of some links, or None."""
    missing_links = _find_links_with_sum(stages, links, residual, float(np.abs(links).max()))
    if missing_links is None:
        return None
    links_in_words = _describe_links(stages, missing_links)
    message = f"Your position seems to lack {links_in_words}. Add all links from the base to P. See (6.1)."
    return Diagnosis(("link-left-out",), message, signature=(f"link-left-out {missing_links}",))


def _find_links_with_sum(
    stages: StageResults, contributions: np.ndarray, residual: np.ndarray, scale: float
) -> tuple[int, ...] | None:
    """Return the smallest set of links, but not all of them, whose contributions add up to a residual, or None."""
    tolerance = RELATIVE_TOLERANCE * scale
    if np.isnan(residual).any() or not np.abs(residual).max() > tolerance:
        return None
    links = [k for k in list_links_to_point(stages.chain) if np.abs(contributions[k]).max() > tolerance]
    subsets = (subset for count in range(1, min(len(links), MAX_LINKS)) for subset in combinations(links, count))
    for subset in subsets:
        if np.abs(residual - contributions[list(subset)].sum(axis=0)).max() <= tolerance:
            return subset
    return None


def _describe_links(stages: StageResults, links: Sequence[int]) -> str:
    """Return the contributions of links in words; index n stands for the vector from the last frame's origin to P."""
    link_names = ["the offset of P" if k == stages.n else f"link {k + 1}" for k in links]
    return f"the contribution{'s' if len(link_names) > 1 else ''} of {join_words(link_names)}"
