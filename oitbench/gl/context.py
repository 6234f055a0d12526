"""How a headless OpenGL context is created on each platform, and what it needs to be installed."""

from __future__ import annotations

import shutil
import sys
from typing import Any

import glcontext

from oitbench.errors import CapabilityError

OPENGL = 450
PACKAGES = {
    "apt": "apt install libegl1 libgl1 libgl1-mesa-dri",
    "dnf": "dnf install libglvnd-egl libglvnd-glx mesa-libEGL mesa-dri-drivers",
    "pacman": "pacman -S libglvnd mesa",
    "apk": "apk add mesa-egl mesa-gl mesa-dri-gallium",
}
"""Commands that install EGL, OpenGL and the drivers of Mesa, by package manager."""


def create() -> Any:
    """Return a context as glcontext makes it: through EGL, and elsewhere by the platform's own way.

    Raises
    ------
    CapabilityError
        There is no driver, or OpenGL is older than 4.5.
    """
    egl = sys.platform.startswith("linux")
    try:
        if egl:
            # Names, since finding libraries needs a compiler or root's cache on some systems.
            libraries = {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}
            make = glcontext.get_backend_by_name("egl")
            return make(mode="standalone", glversion=OPENGL, **libraries)
        return glcontext.default_backend()(mode="standalone", glversion=OPENGL)
    except Exception as error:
        way, fix = ("through EGL ", install()) if egl else ("", "install a driver of OpenGL 4.5")
        raise CapabilityError(f"no OpenGL 4.5 context {way}({error}); {fix}") from error


def install() -> str:
    """Return the command that installs what is missing, for the package manager of this machine.

    Without a known one, those of all are returned.
    """
    here = [command for manager, command in PACKAGES.items() if shutil.which(manager)]
    return (here or ["; ".join(PACKAGES.values())])[0]
