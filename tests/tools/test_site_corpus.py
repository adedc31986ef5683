"""What the site's own grader is held against is what the grader says today."""

from tests.tools.site_corpus import FORMS, READINGS, TARGET, corpus_text, forms_text, readings_text


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert TARGET.read_text(encoding="utf-8") == corpus_text()


def test_trees_and_verdicts_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert READINGS.read_text(encoding="utf-8") == readings_text()


def test_forms_for_the_site_are_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert FORMS.read_text(encoding="utf-8") == forms_text()
