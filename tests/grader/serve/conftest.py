"""A service with an empty database for each test."""

from collections.abc import Iterator

import pytest

pytest.importorskip("django")

from tests.support.serving import Service, find_folder, serve_class

find_folder()  # configures Django before any test module imports its tables


@pytest.fixture
def service() -> Iterator[Service]:
    with serve_class() as service:
        yield service
