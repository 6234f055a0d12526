"""Loads the file of a plugin as a Python module."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Mapping
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

from oitbench.errors import DeclarationError, locate


class _SourceLoader(SourceFileLoader):
    """Compiles a file each time that it is loaded.

    Python takes stored bytecode for that of a file if size and second of its last change agree, as
    they may when a program writes a file twice. Its fingerprint would then be that of other code.
    """

    def path_stats(self, path: str) -> Mapping[str, Any]:
        raise OSError("bytecode is neither read nor stored")


def load_module(path: Path) -> ModuleType:
    """Load a plugin's file under a private name that no other module has.

    Raises
    ------
    DeclarationError
        Its code fails. The message names file and line.
    """
    # Signs become their code points, so that `my-method` and `my_method` stay two modules.
    name = "oitbench_plugin_" + "_".join(
        "".join(c if c.isalnum() else f"_{ord(c):x}_" for c in part)
        for part in path.with_suffix("").parts[1:]
    )
    loader = _SourceLoader(name, str(path))
    specification = importlib.util.spec_from_loader(name, loader)
    assert specification is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise DeclarationError(locate(error, path)) from error
    return module
