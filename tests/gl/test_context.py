"""Creating a context on each platform."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from typing import Any

import glcontext
import pytest

from oitbench.errors import CapabilityError
from oitbench.gl import context


def recording(found: list[dict[str, Any]]) -> Callable[..., str]:
    def make(**given: Any) -> str:
        found.append(given)
        return "context"

    return make


def test_linux_asks_egl_and_no_window_system(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[dict[str, Any]] = []
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(
        glcontext, "get_backend_by_name", lambda name: {"egl": recording(found)}[name]
    )
    assert context.create() == "context"
    assert (found[0]["glversion"], found[0]["libegl"]) == (450, "libEGL.so.1")


def test_other_platforms_have_their_own_way(monkeypatch: pytest.MonkeyPatch) -> None:
    found: list[dict[str, Any]] = []
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(glcontext, "default_backend", lambda: recording(found))
    assert context.create() == "context"
    assert found == [{"mode": "standalone", "glversion": 450}]


@pytest.mark.parametrize("platform", ["linux", "win32"])
def test_a_missing_driver_is_one_line(platform: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(**given: Any) -> None:
        raise RuntimeError("libEGL.so.1 not loaded")

    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(glcontext, "default_backend", lambda: fail)
    monkeypatch.setattr(glcontext, "get_backend_by_name", lambda name: fail)
    with pytest.raises(CapabilityError, match=r"no OpenGL 4\.5 context.*not loaded.*install"):
        context.create()


@pytest.mark.parametrize("manager", context.PACKAGES)
def test_the_command_is_that_of_the_package_manager(
    manager: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: f"/bin/{name}" if name == manager else None)
    assert context.install() == context.PACKAGES[manager]


def test_all_commands_are_named_where_no_package_manager_is_known(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert all(command in context.install() for command in context.PACKAGES.values())
