"""Which code and plugins a machine has, and how two machines differ."""

from __future__ import annotations

from pathlib import Path

from oitbench.executors import inventory
from oitbench.places import PluginFiles, own_folder


def test_a_changed_file_of_a_further_collection_is_named(tmp_path: Path) -> None:
    scene = tmp_path / "scenes" / "mine.py"
    scene.parent.mkdir()
    scene.write_text("parameters = {}\n")
    plugins = PluginFiles([own_folder(), tmp_path])
    before = inventory.take(plugins, own_folder())
    assert {"oitbench/errors.py", "scenes/layer_stack.py", str(scene), "numpy"} <= before.keys()
    assert inventory.difference(before, before) == ""
    scene.write_text("parameters = {}  # changed\n")
    after = inventory.take(plugins, own_folder())
    assert inventory.difference(before, after) == (
        f"its {scene} differs from this machine's; bring both to the same state"
    )
    scene.unlink()
    assert inventory.difference(before, inventory.take(plugins, own_folder())) == (
        f"it lacks {scene}; put this machine's files at the same paths"
    )
    # A version explains more than the files that differ with it.
    other = {**after, "numpy": "1.0"}
    assert "it has numpy 1.0" in inventory.difference(before, other)


def test_the_suite_may_be_installed_elsewhere(tmp_path: Path) -> None:
    home = Path("/elsewhere/collection")
    there = PluginFiles(
        [home, tmp_path], [tmp_path / "a.glb"], {"a": home / "methods" / "a" / "method.py"}
    )
    here = PluginFiles(
        [own_folder(), tmp_path],
        [tmp_path / "a.glb"],
        {"a": own_folder() / "methods" / "a" / "method.py"},
    )
    assert inventory.relocated(there, home) == here
    assert inventory.take(there, home) == inventory.take(here, own_folder())
