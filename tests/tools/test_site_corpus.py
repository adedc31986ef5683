"""The files with Python's results for the site's tests are up to date."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.suites import select_for_suite
from tests.tools.fuzz import SYMBOL_SETS
from tests.tools.readers import judge_answer, make_stored_query, tree_text
from tests.tools.site_arms import TARGET as ARMS
from tests.tools.site_arms import arms_text
from tests.tools.site_corpus import (
    FORMS,
    NOTEBOOK,
    READINGS,
    SLIPS,
    TARGET,
    corpus_case,
    forms_text,
    notebook_text,
    records,
    slips_text,
)

STEP = select_for_suite(9, 1)
"""One of this many cases is checked."""
REWRITE_HINT = "run: python -m tests.tools.site_corpus"


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    cases = json.loads(TARGET.read_text(encoding="utf-8"))
    assert len(cases) == len(records()), REWRITE_HINT
    for case, record in list(zip(cases, records(), strict=True))[::STEP]:
        assert case == corpus_case(record), REWRITE_HINT


def test_trees_and_verdicts_for_the_site_are_up_to_date() -> None:
    stored, query = json.loads(READINGS.read_text(encoding="utf-8")), make_stored_query()
    assert [[text, k] for text, k, _ in stored["readings"]] == [list(item) for item in query.readings], REWRITE_HINT
    assert [answer[:3] for answer in stored["answers"]] == [list(item) for item in query.answers], REWRITE_HINT
    for text, k, tree in stored["readings"][::STEP]:
        assert tree == tree_text(text, SYMBOL_SETS[k]), REWRITE_HINT
    for problem, name, text, *outcome in stored["answers"][::STEP]:
        assert outcome == list(judge_answer(problem, name, text)), REWRITE_HINT


@pytest.mark.parametrize(
    ("path", "make_text"),
    [
        (NOTEBOOK, notebook_text),
        pytest.param(FORMS, forms_text, marks=pytest.mark.whole),
        pytest.param(SLIPS, slips_text, marks=pytest.mark.whole),
    ],
)
def test_a_file_for_the_site_is_up_to_date(path: Path, make_text: Callable[[], str]) -> None:
    assert path.read_text(encoding="utf-8") == make_text(), REWRITE_HINT


@pytest.mark.whole
def test_arms_for_the_site_are_up_to_date() -> None:
    stored, current = (json.loads(text) for text in (ARMS.read_text(encoding="utf-8"), arms_text()))
    numbers = ("jacobian", "det", "sigma")  # the last digit depends on the machine
    assert [_without(case, numbers) for case in stored] == [_without(case, numbers) for case in current]
    for before, after in zip(stored, current, strict=True):
        np.testing.assert_allclose(before["jacobian"], after["jacobian"], rtol=0, atol=1e-12)


def _without(case: dict[str, object], names: tuple[str, ...]) -> dict[str, object]:
    return {name: value for name, value in case.items() if name not in names}
