"""The choice of an LLVM library for drjit."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.path_traced import llvm


@pytest.mark.parametrize(
    ("name", "version"),
    [
        ("libLLVM-15.so.1", 15),
        ("libLLVM.so.19.1", 19),
        ("libLLVM-17.so", 17),
        ("libLLVM.so.18.1", 18),
        ("libLLVM-20.1.8.so", 20),
    ],
)
def test_the_version_of_llvm_is_read_from_its_name(tmp_path: Path, name: str, version: int) -> None:
    (tmp_path / name).touch()
    link = tmp_path / "libLLVM.so"
    link.symlink_to(tmp_path / name)
    for path in (tmp_path / name, link):
        library = llvm.inspect(path)
        assert library is not None
        assert library.version == version


def test_the_newest_usable_llvm_is_chosen_and_an_unusable_request_is_explained(
    tmp_path: Path,
) -> None:
    installed = [llvm.Library(f"lib{v}", v) for v in (14, 15, 17, 19, 23)]
    library, reason = llvm.choose({}, installed)
    assert library == installed[3]
    bad = tmp_path / "libLLVM-15.so"
    bad.touch()
    library, reason = llvm.choose({llvm.PATH_VARIABLE: str(bad)}, installed)
    assert library == installed[3]
    assert "is LLVM 15" in reason
    good = tmp_path / "libLLVM-18.so"
    good.touch()
    library, reason = llvm.choose({llvm.PATH_VARIABLE: str(good)}, installed)
    assert library is not None
    assert library.path == str(good)
    library, reason = llvm.choose({}, installed[:2])
    assert library is None
    assert "found 14, 15" in reason
    assert llvm.INSTALL in reason
