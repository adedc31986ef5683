"""What the site's own grader is held against is what the grader says today."""

import json

import numpy as np
import pytest

from tests.support.suites import select_for_suite
from tests.tools.fuzz import KNOWN
from tests.tools.readers import kept_question, tree_text, verdict
from tests.tools.site_arms import TARGET as ARMS
from tests.tools.site_arms import arms_text
from tests.tools.site_corpus import FORMS, READINGS, SLIPS, TARGET, corpus_case, forms_text, records
from tests.tools.site_slips import slips_text

EACH = select_for_suite(9, 1)
"""Of so many cases one is checked."""
ANEW = "run: python -m tests.tools.site_corpus"


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    cases = json.loads(TARGET.read_text(encoding="utf-8"))
    assert len(cases) == len(records()), ANEW
    for case, record in list(zip(cases, records(), strict=True))[::EACH]:
        assert case == corpus_case(record), ANEW


def test_trees_and_verdicts_for_the_site_are_up_to_date() -> None:
    stored, question = json.loads(READINGS.read_text(encoding="utf-8")), kept_question()
    assert [[text, k] for text, k, _ in stored["readings"]] == [list(each) for each in question.readings], ANEW
    assert [answer[:3] for answer in stored["answers"]] == [list(each) for each in question.answers], ANEW
    for text, k, tree in stored["readings"][::EACH]:
        assert tree == tree_text(text, KNOWN[k]), ANEW
    for problem, name, text, *outcome in stored["answers"][::EACH]:
        assert outcome == list(verdict(problem, name, text)), ANEW


@pytest.mark.whole
def test_forms_for_the_site_are_up_to_date() -> None:
    assert FORMS.read_text(encoding="utf-8") == forms_text(), ANEW


@pytest.mark.whole
def test_slips_for_the_site_are_up_to_date() -> None:
    assert SLIPS.read_text(encoding="utf-8") == slips_text(), ANEW


@pytest.mark.whole
def test_arms_for_the_site_are_up_to_date() -> None:
    kept, now = (json.loads(text) for text in (ARMS.read_text(encoding="utf-8"), arms_text()))
    numbers = ("jacobian", "det", "sigma")  # their last digit is another on another machine
    assert [_without(case, numbers) for case in kept] == [_without(case, numbers) for case in now]
    for before, after in zip(kept, now, strict=True):
        np.testing.assert_allclose(before["jacobian"], after["jacobian"], rtol=0, atol=1e-12)


def _without(case: dict[str, object], names: tuple[str, ...]) -> dict[str, object]:
    return {name: value for name, value in case.items() if name not in names}
