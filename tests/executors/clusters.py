"""Dask clusters of this machine for tests."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import pytest


@contextmanager
def cluster(*environments: Mapping[str, str]) -> Iterator[str]:
    """Yield the address of a scheduler with one worker in each environment.

    A worker process that is killed is started again at another address.
    """
    distributed = pytest.importorskip("distributed")
    workers = {
        number: {"cls": distributed.Nanny, "options": {"nthreads": 1, "env": dict(environment)}}
        for number, environment in enumerate(environments)
    }
    scheduler = {"cls": distributed.Scheduler, "options": {"port": 0, "dashboard": False}}
    with distributed.SpecCluster(workers=workers, scheduler=scheduler) as found:
        yield found.scheduler_address
