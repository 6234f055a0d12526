"""Fixtures that all tests share."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from oitbench.gl.device import Device


@pytest.fixture(scope="session")
def device() -> Iterator[Device]:
    """The one OpenGL context of all tests: a context costs half a second, and keeps programs."""
    device = Device()
    yield device
    device.release()


@pytest.fixture(autouse=True)
def _current_context(request: pytest.FixtureRequest) -> Iterator[None]:
    """Make the shared context current again, should a test before have made another one."""
    if "device" not in request.fixturenames:
        yield
        return
    device: Device = request.getfixturevalue("device")
    with device.context:
        yield
