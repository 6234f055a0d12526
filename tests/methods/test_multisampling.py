"""Four samples per pixel: each sample is a picture of its place, and the methods that have none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from oitbench.errors import DeclarationError
from oitbench.gl.device import Device
from oitbench.gl.frame import Image
from oitbench.measure.accounting import memory, traffic
from oitbench.method.declaration import MSAA, Method
from oitbench.method.passes import Gather
from oitbench.modeling.mesh import box, quad
from oitbench.scene import WHITE, Camera, Floats, Material, Medium, Mesh, Object, Scene, Texture
from oitbench.stability.cases import cases
from oitbench.stability.check import Check
from oitbench.stability.result import DOES_NOT_APPLY
from tests.helpers import (
    BACKGROUND,
    BLUE,
    GREEN,
    RED,
    collection,
    foreign_method,
    method,
    offered,
    opened,
    random_lists,
    render,
    rounding,
    run_checks,
    scene_of,
    takes_any_order,
    write_method,
)

SIDE, HEIGHT = 32, 2.0
"""Pixels and meters of a picture: sample places are exact in floats."""
LIGHT = (0.2, 0.8)
"""Least and greatest radiance of slivers."""
AT_SAMPLES = (
    "a_buffer",
    "adaptive[node=precise]",
    "adaptive[memory=fixed]",
    "alpha_blend[precision=float]",
    "depth_layered[precision=float]",
    "depth_layered[layers=8]",
    "fourier_map[memory=fixed]",
    "hybrid",
    "hybrid[node=16f,transmittance=exact]",
    "k_buffer[k=4,node=32f]",
    "moments",
    "multilayer_alpha[k=2,node=32f]",
    "multilayer_alpha_buckets[k=2,node=32f]",
    "opacity_map[memory=fixed]",
    "phenomenological[precision=float]",
    "phenomenological",
    "sorted_over[precision=float]",
    "sorted_two_pass[precision=float]",
    "wavelet",
    "weighted_average[count=r32f,precision=float]",
    "weighted_sum[precision=float]",
)
"""Variants that shade samples or ignore depth."""
SENSITIVE = ("moments[basis=trigonometric,depth=linear]", "moments[storage=unorm16]")
"""Variants that shade samples, and magnify the last bit of a depth."""
MASKED = ("fourier_map[node=precise]", "opacity_map[node=precise]")
"""Variants whose curves are made of depths in lists, which lose four bits to masks."""
LOST = 1e-4
"""Largest error that the lost bits cause."""
AT_CENTERS = (*MASKED, "weighted_blended[precision=float]")
"""Variants in which a fragment has the depth of the pixel's center at all samples."""
ALL = (*AT_SAMPLES, *SENSITIVE, *AT_CENTERS)
IN_LISTS = ("a_buffer", "adaptive[node=precise]", *MASKED)
"""Variants whose records only grow at edges."""
NOISY = {"alpha_to_coverage", "stochastic"}
"""Their random or driver-chosen samples have tests of their own."""


def with_samples(label: str, count: int) -> Method:
    chosen = method(label)
    return type(chosen)(**{**chosen.values, "msaa": count})


def on_grid(places: Floats) -> Floats:
    """Return places in meters on a grid of a 16th of a pixel, where GPUs snap no vertex.

    Places of samples lie on it, too. So all views have the same vertices.
    """
    step = HEIGHT / SIDE / 16
    return np.asarray(np.round(places / step) * step)


def slanted(tilt: float = 0.0, material: Material | None = None) -> Scene:
    """Return panes with slanted edges, two opaque walls among them, in an orthographic view.

    Parameters
    ----------
    tilt : float
        Slope of the panes in depth; they then intersect.
    material : Material, optional
        Of every other pane. Default: colored glass.
    """
    random = np.random.default_rng(3)
    # At even distances, rounding would decide in which slice of an opacity map a pane lies.
    spread = np.random.default_rng(6).uniform(0, 0.3, 7)
    objects = []
    for index in range(7):
        (x, y), angle = on_grid(random.uniform(-1, 1, 2)), random.uniform(0, math.pi)
        along = random.uniform(0.7, 1.4) * np.array([math.cos(angle), math.sin(angle), tilt])
        across = random.uniform(0.5, 1.2) * np.array([-math.sin(angle), math.cos(angle), -tilt])
        along[:2], across[:2] = on_grid(along[:2]), on_grid(across[:2])
        tint, light = ((r, g, b) for r, g, b in random.uniform(0, 1, (2, 3)).tolist())
        glass = Material(random.uniform(0.3, 0.8), transmission=tint, emission=light)
        pane = quad((x, y, -3 - 0.5 * index - spread[index]), tuple(along), tuple(across))
        objects.append(Object(f"pane {index}", pane, material if material and index % 2 else glass))
    for name, z, color in (("near wall", -4.7, GREEN), ("far wall", -9.0, RED)):
        wall = quad((0.5, 0.2, z), (0.7, 0.3, 0), (-0.3, 0.7, 0))
        objects.append(Object(name, wall, Material(emission=color)))
    camera = Camera((0, 0, 0), (0, 0, -1), height=HEIGHT, near=0.5)
    return Scene("slanted", camera, tuple(objects), background=BACKGROUND)


def slivers(opaque: bool) -> Scene:
    """Return narrow triangles that recede from the eye, with the radiance of `LIGHT`."""
    random = np.random.default_rng(4)
    z = random.uniform(0.2, 50, (300, 3, 1))
    angle, radius = random.uniform(0, 2 * math.pi, 300), random.uniform(0, 0.5, 300)
    middle = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    on_screen = middle[:, None] + random.normal(0, 0.004, (300, 3, 2))
    positions = np.concatenate([on_screen * z, -z], axis=2).reshape(-1, 3)
    radiance = random.uniform(*LIGHT, (900, 3)).astype(np.float32)
    corners = np.arange(900, dtype=np.uint32).reshape(-1, 3)
    mesh = Mesh(positions, corners, radiance=radiance)
    material = Material(1.0 if opaque else 0.5, emission=WHITE)
    gray = (sum(LIGHT) / 2,) * 3
    camera = Camera((0, 0, 0), (0, 0, -1))
    return Scene("slivers", camera, (Object("slivers", mesh, material),), background=gray)


def seen_from(scene: Scene, place: tuple[float, float]) -> Scene:
    """Return the scene with a camera that has pixel centers where the samples at `place` were."""
    right, up = ((float(part) - 0.5) * HEIGHT / SIDE for part in place)
    camera = replace(scene.camera, position=(right, up, 0), target=(right, up, -1))
    return replace(scene, camera=camera)


@pytest.fixture(autouse=True)
def _offered(request: pytest.FixtureRequest, device: Device) -> None:
    """Skip a test of a method that blends samples in its shader where the driver cannot."""
    call = getattr(request.node, "callspec", None)
    label = call and call.params.get("label")
    if label and not offered(device, with_samples(label, 4)):
        pytest.skip(f"{device.renderer} cannot blend four samples in shaders")


@pytest.fixture(scope="module")
def places(device: Device, tmp_path_factory: pytest.TempPathFactory) -> list[tuple[float, float]]:
    """Places of the samples within a pixel, from its lower left corner, in pixels."""
    lines = (f"s{i} = gl_SampleID == {i} ? 4.0 * gl_SamplePosition : vec2(0.0);" for i in range(4))
    folder = write_method(
        tmp_path_factory.mktemp("methods") / "places",
        '(Resolve("place.glsl", writes={f"s{i}": REPLACE for i in range(4)}),)',
        '{f"s{i}": Target("rg32f") for i in range(4)}',
        members="sample_count = 4",
        place=f"void resolve() {{ {' '.join(lines)} }}",
    )
    with device.context, opened(device, slanted(), foreign_method(folder), (4, 4)) as frame:
        frame.render()
        found = [frame.read(f"s{i}")[1, 1] for i in range(4)]
    assert len({tuple(place) for place in found}) == 4
    return [(float(x), float(y)) for x, y in found]


def mean_of_places(
    device: Device, scene: Scene, label: str, places: list[tuple[float, float]]
) -> Image:
    """Return the mean of the method's own pictures of one sample at each place."""
    size = (SIDE, SIDE)
    pictures = [render(device, seen_from(scene, place), label, size=size) for place in places]
    mean: Image = np.mean(pictures, axis=0)
    return mean


def test_every_method_has_samples_or_a_reason() -> None:
    tested = {method(label).name for label in ALL} | NOISY
    for name, kind in collection().methods.items():
        assert ("msaa" in kind.parameters) == (kind.no_msaa == ""), name
        assert ("msaa" in kind.parameters) == (name in tested), name


def test_a_method_with_samples_gives_no_reason_against_them() -> None:
    with pytest.raises(DeclarationError, match="delete no_msaa"):

        class Both(Method):
            msaa = MSAA
            no_msaa = "it has"


@pytest.mark.parametrize(
    ("label", "tilt"),
    [(label, 0.0) for label in ALL] + [(label, 0.4) for label in AT_SAMPLES],
)
def test_the_picture_is_the_mean_of_pictures_at_the_places_of_samples(
    device: Device, places: list[tuple[float, float]], label: str, tilt: float
) -> None:
    scene = slanted(tilt)
    expected = mean_of_places(device, scene, label, places)
    four = with_samples(label, 4)
    found = render(device, scene, four, size=(SIDE, SIDE))
    allowed = rounding(four, 9, 1.0) + (LOST if label in MASKED else 0.0)
    np.testing.assert_allclose(found, expected, rtol=0, atol=allowed)
    one = render(device, scene, label, size=(SIDE, SIDE))
    assert abs(one - expected).max() > 0.15


@pytest.mark.parametrize(
    "material",
    [
        Material(transmission=WHITE, specular=0.0, collimation=0.97),
        Material(0.5, transmission=(0.9, 0.5, 0.7), index=1.5, solid=True),
    ],
    ids=["frosted", "refracting"],
)
@pytest.mark.parametrize("foggy", [False, True])
def test_samples_are_bent_blurred_and_marched_at_their_places(
    device: Device, places: list[tuple[float, float]], material: Material, foggy: bool
) -> None:
    scene = slanted(0.0, material)
    if foggy:
        fog = Medium(0.2, (-3, -3, -8), (3, 3, -2), albedo=(0.9, 0.7, 0.5), ambient=BLUE)
        scene = replace(scene, medium=fog)
    if material.solid:
        block = Object("block", box((0, 0, -3.2), (0.9, 0.8, 0.3)), material)
        scene = replace(scene, objects=(block, *slanted().objects))
    label = "phenomenological[precision=float]"
    expected = mean_of_places(device, scene, label, places)
    four = with_samples(label, 4)
    found = render(device, scene, four, size=(SIDE, SIDE))
    np.testing.assert_allclose(found, expected, rtol=0, atol=rounding(four, 9, 1.0))
    plain = render(device, slanted(), four, size=(SIDE, SIDE))
    assert abs(plain - found).max() > 0.05


@pytest.mark.parametrize("label", ["adaptive[memory=fixed]", "k_buffer[k=4,node=32f]", "moments"])
def test_samples_are_shaded_at_their_places(
    device: Device, places: list[tuple[float, float]], label: str
) -> None:
    texels = np.random.default_rng(5).random((16, 16, 4), dtype=np.float32)
    scene = slanted(0.4, Material(Texture(texels[..., 3]), emission=Texture(texels[..., :3])))
    expected = mean_of_places(device, scene, label, places)
    found = render(device, scene, with_samples(label, 4), size=(SIDE, SIDE))
    np.testing.assert_allclose(found, expected, rtol=0, atol=2e-5)


@pytest.mark.parametrize("opaque", [False, True])
@pytest.mark.parametrize("label", ["a_buffer", "alpha_blend[precision=float]", "moments"])
def test_slivers_have_the_colors_of_their_corners(device: Device, label: str, opaque: bool) -> None:
    """A pixel's center is often outside of a narrow triangle that covers samples."""
    scene = slivers(opaque)
    smooth = render(device, scene, "a_buffer", size=(192, 192))
    smooth = smooth.reshape(48, 4, 48, 4, 3).mean(axis=(1, 3))
    one, four = (
        render(device, scene, with_samples(label, count), size=(48, 48)) for count in (1, 4)
    )
    low, high = LIGHT
    assert low - 1e-5 <= four.min()
    assert four.max() <= high + 1e-5
    assert abs(four - smooth).mean() < 0.8 * abs(one - smooth).mean()


@pytest.mark.parametrize("label", ALL)
def test_pixels_that_are_covered_completely_do_not_change(device: Device, label: str) -> None:
    lists = random_lists(12, tinted=True)
    one, four = (render(device, lists, with_samples(label, count)) for count in (1, 4))
    allowed = LOST if label in MASKED else 0.0
    if takes_any_order(device, label):
        if "order_independent" not in method(label).promised:
            pytest.skip(f"{device.renderer} fills lists in any order")
        allowed += rounding(method(label), 12, 1.0)
    np.testing.assert_allclose(four, one, rtol=0, atol=allowed)


@pytest.mark.parametrize("label", ALL)
def test_four_samples_antialias_edges(device: Device, label: str) -> None:
    mesh = quad((0, 0, -4), (0.9, 0.3, 0), (-0.3, 0.9, 0))
    pane = Object("pane", mesh, Material(0.5, emission=RED))
    scene = Scene("edges", Camera((0, 0, 0), (0, 0, -1)), (pane,), background=BLUE)
    smooth = render(device, scene, "a_buffer", size=(256, 256))
    smooth = smooth.reshape(64, 4, 64, 4, 3).mean(axis=(1, 3))
    one, four = (
        abs(render(device, scene, with_samples(label, count), size=(64, 64)) - smooth)
        for count in (1, 4)
    )
    assert four.mean() < 0.6 * one.mean()
    # Each of four samples stands for four of the sixteen.
    assert four.max() <= 0.5 * 3 / 16 + 0.01


@pytest.mark.parametrize("check", cases(), ids=lambda check: check.name)
def test_samples_make_no_hard_case_fail(device: Device, check: Check) -> None:
    """Cases that four samples break are those that one sample breaks: the known failures."""
    names = sorted({method(label).name for label in ALL})
    labels = [with_samples(name, count).label for name in names for count in (1, 4)]
    found = run_checks(device, list(map(method, labels)), [replace(check, repeat=False)])
    assert [item.method for item in found if item.failed] == []
    status = {item.method: item.status for item in found}
    for one, four in zip(labels[::2], labels[1::2], strict=True):
        if check.name == "crossing boxes":
            assert status[four] == DOES_NOT_APPLY  # its edges are smooth
        elif not offered(device, four):
            assert status[four] == DOES_NOT_APPLY
        else:
            assert status[four] == status[one], four


@pytest.mark.parametrize("label", [label for label in ALL if label not in IN_LISTS])
def test_samples_take_four_times_the_memory_and_traffic(device: Device, label: str) -> None:
    bits, moved = [], []
    for count in (1, 4):
        chosen = with_samples(label, count)
        with opened(device, scene_of(random_lists(5)), chosen, counted=True) as frame:
            frame.render()
            bits.append(memory(frame).bits_per_pixel)
            moved.append(traffic(frame, frame.measure()).bytes)
    assert bits[1] == 4 * bits[0]
    assert moved[1] == 4 * moved[0]


@pytest.mark.parametrize(
    ("label", "pixel", "fragment"),
    [
        ("alpha_blend", 0, 16),
        ("sorted_over", 0, 16),
        ("sorted_two_pass", 0, 2 * 16),
        ("weighted_sum", 8, 16),
        ("weighted_average", 10, 20),
        ("weighted_blended", 9, 18),
        ("phenomenological", 11, 22 + 4),
        ("k_buffer", 8 * 8, 16 * 8),
        ("multilayer_alpha", 8 * 4, 16 * 4),
        ("multilayer_alpha_buckets", 8 * 4 + 8, 16 * 4 + 16 + 8),
        ("hybrid", 8 * 4 + 10, 16 * 4 + 20),
        ("depth_layered", 10 * 4 + 8, 20 * 4 + 16 + 8),
        ("moments[count=8]", 4 * 9 + 16, 8 * 9 + 4 * 9 + 32),
        ("moments[depth=linear]", 4 * 7 + 16 + 8, 8 * 7 + 4 * 7 + 32 + 16 + 8 + 8),
    ],
)
def test_samples_have_the_bytes_of_the_formulas(
    device: Device, label: str, pixel: int, fragment: int
) -> None:
    """Bytes of memory a sample, and of reading and blending a fragment of a sample."""
    layers = 5
    with opened(device, scene_of(random_lists(layers)), with_samples(label, 4)) as frame:
        frame.render()
        assert memory(frame).bits_per_pixel == 4 * 8 * pixel
        gathers = {item.name for item in frame.plan.passes if isinstance(item, Gather)}
        terms = traffic(frame, frame.measure()).terms
        width, height = frame.plan.size
    moved = sum(term.bytes for term in terms if term.pass_ in gathers)
    assert moved == 4 * layers * fragment * width * height
