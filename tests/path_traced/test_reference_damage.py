"""References: damaged files, full disks and labels that look like paths."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import msgspec
import numpy as np
import pytest

from oitbench.errors import StorageError, UsageError
from oitbench.image import stored
from oitbench.path_traced.references import lookup, storage
from oitbench.truths import FULL
from tests.damage import cut, flip_bit, largest_file
from tests.path_traced.agreement import needs_mitsuba
from tests.path_traced.stored import KEY, SIZE, make_reference, make_scene, read_back, wanted


def test_a_damaged_reference_costs_no_other_and_names_the_fix(tmp_path: Path) -> None:
    folder = tmp_path / "reference"
    storage.save(folder, make_reference(make_scene()))
    path = folder / storage.MANIFEST
    whole = json.loads(path.read_text())
    del whole["references"][KEY]["rendering"]["spp"]
    path.write_text(json.dumps(whole))
    pattern = r"manifest\.json: entry window\[seed=2\]@12x8\.full is damaged; restore it, or run"
    with pytest.raises(UsageError, match=pattern):
        storage.read(folder, KEY)
    assert storage.read_manifest(folder) == {}
    found = lookup.find(wanted(make_scene()), [tmp_path])
    assert found.reference is None
    assert "is damaged" in found.message
    # The advice works: rendering it again repairs the entry.
    storage.save(folder, make_reference(make_scene()))
    assert lookup.find(wanted(make_scene()), [tmp_path]).message == ""


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "damaged; restore it, or delete it"),
        ("[]", "damaged; restore it, or delete it"),
        ("[" * 100_000, "damaged; restore it, or delete it"),
        ('{"version": 99, "references": {}}', "is of version 99"),
    ],
)
def test_a_damaged_manifest_is_reported_with_the_fix(
    text: str, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "reference" / storage.MANIFEST
    storage.save(path.parent, make_reference(make_scene()))
    path.write_text(text)
    with pytest.raises(UsageError, match=message):
        storage.read_manifest(path.parent)
    assert message in lookup.find(wanted(make_scene()), [tmp_path]).message
    # A damaged manifest is never replaced: it may hold entries that somebody can restore.
    with pytest.raises(UsageError, match=message):
        storage.save(path.parent, make_reference(make_scene()))
    assert path.read_text() == text


def test_every_flipped_bit_of_a_manifest_is_noticed(tmp_path: Path) -> None:
    reference = make_reference(make_scene())
    storage.save(tmp_path, reference)
    path = tmp_path / storage.MANIFEST
    whole = path.read_bytes()
    for number in range(0, 8 * len(whole), 7):
        flip_bit(path, number)
        try:
            found = storage.read(tmp_path, KEY)
        except UsageError:
            found = None
        # A flipped bit may still leave the same values, as in a blank.
        assert found is None or (found.rendering, found.noise_floor) == (
            reference.rendering,
            reference.noise_floor,
        )
        path.write_bytes(whole)


def _flip_middle(path: Path) -> None:
    flip_bit(path, 4 * path.stat().st_size)


def _cut_end(path: Path) -> None:
    cut(path, 1)


def test_damaged_and_missing_images_are_errors(tmp_path: Path) -> None:
    storage.save(tmp_path, make_reference(make_scene()))
    (info,) = storage.read_manifest(tmp_path).values()
    for image in info.images:
        path = tmp_path / image.path
        whole = path.read_bytes()
        for damage in (_flip_middle, _cut_end):
            damage(path)
            with pytest.raises(UsageError, match=r"exr is damaged; restore it, or run 'oitbench"):
                read_back(tmp_path)
            path.write_bytes(whole)
        path.unlink()
        with pytest.raises(UsageError, match=r"exr cannot be read .*; restore it, or run"):
            read_back(tmp_path)
        path.write_bytes(whole)
    assert read_back(tmp_path).noise_floor == info.noise_floor


def test_paths_that_leave_the_folder_are_damage(tmp_path: Path) -> None:
    storage.save(tmp_path / "reference", make_reference(make_scene()))
    path = tmp_path / "reference" / storage.MANIFEST
    content = json.loads(path.read_text())
    (info,) = storage.read_manifest(path.parent).values()
    for wrong in ("../a.exr", "/etc/a.exr", "a/../../b.exr"):
        moved = msgspec.structs.replace(info, parts=[stored.StoredImage(wrong, "0" * 64, 1)])
        content["references"][KEY] = storage._entry(moved)
        path.write_text(json.dumps(content))
        with pytest.raises(UsageError, match="is damaged"):
            storage.read(path.parent, KEY)


def test_a_label_with_a_path_stays_in_its_folder(tmp_path: Path) -> None:
    label = "text[path=../../x/y]"
    made = make_reference(make_scene())
    named = msgspec.structs.replace(made.rendering, scene=label)
    storage.save(tmp_path / "reference", dataclasses.replace(made, rendering=named))
    assert [path.name for path in tmp_path.iterdir()] == ["reference"]
    assert all(path.is_file() for path in (tmp_path / "reference").iterdir())
    assert (
        storage.read(tmp_path / "reference", storage.reference_key(label, SIZE, FULL)) is not None
    )


def test_a_full_disk_keeps_the_old_reference_whole(tmp_path: Path) -> None:
    old, new = make_reference(make_scene()), make_reference(make_scene(coverage=0.4), seed=8)
    storage.save(tmp_path, old)
    whole = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    sizes = sorted(len(content) for content in whole.values())
    for limit in (0, *(size - 1 for size in sizes)):
        with largest_file(limit), pytest.raises(StorageError, match="free some space"):
            storage.save(tmp_path, new)
        back = read_back(tmp_path)
        assert back.rendering == old.rendering
        assert old.variance is not None
        np.testing.assert_array_equal(back.variance, old.variance)
    storage.save(tmp_path, new)
    assert read_back(tmp_path).rendering == new.rendering
    names = {path.name for path in tmp_path.iterdir()}
    assert len(names) == 3
    assert names & whole.keys() == {storage.MANIFEST}


@needs_mitsuba
def test_a_damaged_reference_of_the_cache_is_rendered_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first, _ = lookup.find_or_render(wanted(make_scene()), [])
    for path in sorted(tmp_path.rglob("*.*")):
        whole = path.read_bytes()
        for damage in (_flip_middle, Path.unlink):
            damage(path)
            again, message = lookup.find_or_render(wanted(make_scene()), [])
            assert message == ""
            np.testing.assert_array_equal(again.mean, first.mean)
            # The manifest tells how long the rendering took.
            assert path.name == storage.MANIFEST or path.read_bytes() == whole
