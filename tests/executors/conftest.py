"""A cluster that all tests of executors share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.executors.clusters import cluster


@pytest.fixture(scope="session")
def address() -> Iterator[str]:
    """The scheduler of two workers, which are started again when a test kills them."""
    with cluster({}, {}) as found:
        yield found
