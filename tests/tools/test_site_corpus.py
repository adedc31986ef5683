"""What the site's own grader is held against is what the grader says today."""

from tests.tools.site_corpus import TARGET, corpus_text


def test_the_corpus_of_the_site_is_up_to_date() -> None:
    """Where this fails, run: python -m tests.tools.site_corpus"""
    assert TARGET.read_text(encoding="utf-8") == corpus_text()
