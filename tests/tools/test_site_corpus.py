"""What the site's own grader is held against is what the grader says today."""

import json

import numpy as np

from tests.tools.site_arms import TARGET as ARMS
from tests.tools.site_arms import arms_text
from tests.tools.site_corpus import FORMS, READINGS, SLIPS, TARGET, corpus_text, forms_text, readings_text
from tests.tools.site_slips import slips_text


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert TARGET.read_text(encoding="utf-8") == corpus_text()


def test_trees_and_verdicts_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert READINGS.read_text(encoding="utf-8") == readings_text()


def test_forms_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert FORMS.read_text(encoding="utf-8") == forms_text()


def test_slips_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert SLIPS.read_text(encoding="utf-8") == slips_text()


def test_arms_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_arms"""
    kept, now = (json.loads(text) for text in (ARMS.read_text(encoding="utf-8"), arms_text()))
    numbers = ("jacobian", "det", "sigma")  # their last digit is another on another machine
    assert [_without(case, numbers) for case in kept] == [_without(case, numbers) for case in now]
    for before, after in zip(kept, now, strict=True):
        np.testing.assert_allclose(before["jacobian"], after["jacobian"], rtol=0, atol=1e-12)


def _without(case: dict[str, object], names: tuple[str, ...]) -> dict[str, object]:
    return {name: value for name, value in case.items() if name not in names}
