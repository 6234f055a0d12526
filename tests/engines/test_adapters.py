"""The adapters of the suite, where their engines are installed."""

from __future__ import annotations

import numpy as np
import pytest

from oitbench.engines.adapter import Content
from oitbench.engines.adapters.pygfx_engine import Pygfx
from oitbench.engines.adapters.vtk_engine import Vtk
from oitbench.engines.content import unlit
from oitbench.engines.known import choose, entries, load
from oitbench.errors import CapabilityError
from oitbench.image.files import Image
from tests.helpers import collection

SIZE = (24, 16)
COUNT = 5


@pytest.fixture(scope="module")
def content() -> Content:
    scene = collection().build_scene(f"layer_stack[count={COUNT},alpha=0.3]")
    return unlit(scene, SIZE[1], 1.0)


def blended(content: Content, *, far_first: bool) -> np.ndarray:
    """Return the color of blending all planes, by distance or in order of submission."""
    surfaces = list(content.surfaces)
    if far_first:
        surfaces.sort(key=lambda surface: float(surface.positions[0, 2]))
    color = np.array(content.background)
    for surface in surfaces:
        color = surface.opacity[0] * surface.color[0] + (1 - surface.opacity[0]) * color
    return np.asarray(color)


def averaged(content: Content) -> np.ndarray:
    """Return the mean color, weighted by opacity, before the background."""
    opacity = np.array([surface.opacity[0] for surface in content.surfaces])
    color = np.array([surface.color[0] for surface in content.surfaces])
    passed = float(np.prod(1 - opacity))
    mean = opacity @ color / opacity.sum()
    return np.asarray((1 - passed) * mean + passed * np.array(content.background))


def drawn(engine: Vtk | Pygfx, content: Content, algorithm: str) -> Image:
    drawing = engine.open(content, algorithm, SIZE)
    drawing.draw()
    image = drawing.image()
    drawing.release()
    assert image.shape == (SIZE[1], SIZE[0], 3)
    return image


def test_all_adapters_are_known() -> None:
    assert {"vtk", "pygfx"} <= entries().keys()
    assert choose(["vtk,pygfx", "vtk"]) == ["vtk", "pygfx"]
    assert all(load(name).algorithms for name in ("vtk", "pygfx"))


@pytest.mark.parametrize("name", ["vtk", "pygfx"])
def test_their_peers_are_methods(name: str) -> None:
    for algorithm in load(name).algorithms.values():
        assert len(collection().expand_methods([algorithm.peer])) == 1


@pytest.mark.parametrize(("kind", "module"), [(Vtk, "vtkmodules"), (Pygfx, "pygfx")])
def test_an_engine_that_is_missing_is_named(
    kind: type[Vtk | Pygfx], module: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(CapabilityError, match=r"cannot be imported .*oitbench\[engines\]"):
        kind()


def test_vtk_agrees_with_closed_forms(content: Content) -> None:
    pytest.importorskip("vtkmodules")
    engine = Vtk()
    # Each layer is rounded to 8 bits.
    for algorithm, expected in {
        "unsorted": blended(content, far_first=False),
        "dual_depth_peeling": blended(content, far_first=True),
        "order_independent": averaged(content),
    }.items():
        image = drawn(engine, content, algorithm)
        np.testing.assert_allclose(
            image, np.broadcast_to(expected, image.shape), atol=(COUNT + 1) / 255, err_msg=algorithm
        )
    assert engine.renderer
    assert engine.renderer != "unknown renderer"


def test_pygfx_agrees_with_closed_forms(content: Content) -> None:
    pytest.importorskip("pygfx")
    try:
        engine = Pygfx()
    except CapabilityError as error:
        pytest.skip(str(error))
    image = drawn(engine, content, "weighted_blended")
    expected = np.broadcast_to(averaged(content), image.shape)
    np.testing.assert_allclose(image, expected, atol=(COUNT + 1) / 255)
    image = drawn(engine, content, "dither")
    colors = np.array([*(surface.color[0] for surface in content.surfaces), content.background])
    # Each pixel shows one of the surfaces.
    distance = np.abs(image[:, :, None] - colors).max(axis=-1).min(axis=-1)
    assert distance.max() < 0.01
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 1
