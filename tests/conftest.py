"""Fixtures that all tests share."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from oitbench.gl.device import Device
from oitbench.stability import overview
from tests.helpers import collection
from tests.plugins import misbehaving


@pytest.fixture(scope="session")
def device() -> Iterator[Device]:
    """The OpenGL context that all tests share. It takes half a second, and caches programs."""
    device = Device()
    yield device
    device.release()


@pytest.fixture(autouse=True)
def _current_context(request: pytest.FixtureRequest) -> Iterator[None]:
    """Make the shared context current again; an earlier test may have created another one."""
    if "device" not in request.fixturenames:
        yield
        return
    device: Device = request.getfixturevalue("device")
    with device.context:
        yield


@pytest.fixture(scope="session")
def overviews(device: Device) -> dict[str, overview.Overview]:
    """The overviews of all methods with default parameters, by name; they take some seconds."""
    methods = collection().expand_methods(list(collection().methods))
    with device.context:
        return {row.method: row for row in overview.measure(device, methods)}


@pytest.fixture(scope="session")
def plugins(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A collection of plugins that fail; tests must not change it."""
    return misbehaving(tmp_path_factory.mktemp("plugins"))
