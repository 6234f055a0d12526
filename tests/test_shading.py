"""Settings of shared shading: their notation, and the cells that they select."""

from __future__ import annotations

from pathlib import Path

import pytest

from oitbench.errors import UsageError
from oitbench.matrix.plan import plan_matrix
from oitbench.shading import DEFAULT, PARAMETERS, ShadingSettings, parse_shading, read_shading


def test_every_setting_has_a_parameter_with_its_default() -> None:
    assert {name: item.default for name, item in PARAMETERS.items()} == DEFAULT.values
    assert all(item.help for item in PARAMETERS.values())


def test_texts_select_all_combinations() -> None:
    found = parse_shading(["shadow_map=512,4096", "translucent=published"])
    assert [one.label for one in found] == [
        "translucent=published,shadow_map=512",
        "translucent=published,shadow_map=4096",
    ]
    assert found == parse_shading(["shadow_map=512,4096,translucent=published"])
    assert parse_shading([]) == (DEFAULT,)
    assert parse_shading([f"shadow_map={DEFAULT.shadow_map}"]) == (DEFAULT,)


def test_a_label_names_its_settings() -> None:
    settings = ShadingSettings("occluders", 2048, 2, 32, 3)
    assert read_shading(settings.label) == settings
    assert (DEFAULT.label, read_shading("")) == ("", DEFAULT)
    with pytest.raises(UsageError, match="selects 2 settings"):
        read_shading("slices=8,16")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("shadow=1", "did you mean shadow_map"),
        ("translucent=best", "choose from published, occluders, slices"),
        ("shadow_map=8", "at least 16"),
        ("shadow_map=1022", "multiple of downsampling"),
        ("slices=many", "takes int"),
        ("4096", "before the first"),
    ],
)
def test_wrong_settings_are_refused_in_one_line(text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words) as caught:
        parse_shading([text])
    assert "\n" not in str(caught.value)


def test_each_setting_has_its_own_cells(tmp_path: Path) -> None:
    matrix = plan_matrix(
        ["glass_bars"], ["alpha_blend"], out=tmp_path, shading=["shadow_map=512,1024"]
    )
    assert [cell.shading for cell in matrix.cells] == ["shadow_map=512", ""]
    assert len({cell.key for cell in matrix.cells}) == 2
    assert [cell.settings.shadow_map for cell in matrix.cells] == [512, 1024]
    assert matrix.cells[0].record("skipped").key == matrix.cells[0].key
