"""The plan of a frame, which needs no OpenGL."""

from __future__ import annotations

import pytest

from oitbench.effects import Effect
from oitbench.errors import DeclarationError
from oitbench.gl.capabilities import FETCH, INTERLOCK, SPIN_LOCK
from oitbench.gl.plan import FramePlan
from oitbench.method.blending import ADD, COUNT, PROGRAMMABLE, REPLACE, Blend
from oitbench.method.declaration import Method, Plan, Request
from oitbench.method.passes import OPAQUE_DEPTH, Gather, Loop, Resolve, Step
from oitbench.method.storage import Buffer, Items, Target
from tests.helpers import collection

SIZE = (33, 17)
EVERYTHING = ~Effect.NONE


def planned(
    *steps: Step,
    targets: dict[str, Target] | None = None,
    buffers: dict[str, Buffer] | None = None,
    samples: int = 1,
    mechanism: str = FETCH,
    size: tuple[int, int] = SIZE,
) -> FramePlan:
    """Return the plan of a method with these steps."""

    class Made(Method):
        name = "made"
        sample_count = samples

        def plan(self, request: Request) -> Plan:
            return Plan(targets or {}, steps, buffers or {})

    return FramePlan.of(Made(), size, mechanism=mechanism)


def test_a_plan_without_targets_has_the_image_in_half_floats() -> None:
    plan = planned()
    assert plan.targets == {}
    assert plan.color == Target("rgba16f")
    assert plan.target_bytes() == []
    assert set(plan.declared) == {"color", "opaque_color", "opaque_depth"}


def test_the_image_can_have_another_format_and_is_not_counted() -> None:
    plan = planned(targets={"color": Target("rgba32f"), "sum": Target("rg16f")})
    assert plan.color == Target("rgba32f")
    assert plan.declared["opaque_color"] == Target("rgba32f")
    assert plan.target_bytes() == [("sum", 33 * 17 * 4)]


def test_a_downsampled_target_covers_partial_blocks() -> None:
    plan = planned(targets={"small": Target("r32f", subsample=4)})
    assert plan.declared["small"].size(SIZE) == (9, 5)
    assert plan.target_bytes() == [("small", 9 * 5 * 4)]
    assert plan.subsamples == {1, 4}


def test_samples_multiply_targets_that_are_not_single() -> None:
    targets = {"four": Target("r32f"), "one": Target("r32f", single=True)}
    plan = planned(targets=targets, samples=4)
    assert dict(plan.target_bytes()) == {"four": 33 * 17 * 16, "one": 33 * 17 * 4}


@pytest.mark.parametrize(
    ("blend", "samples", "needed"), [(ADD, 4, True), (ADD, 1, False), (COUNT, 4, False)]
)
def test_fragments_at_pixel_centers_need_their_depth(
    blend: Blend, samples: int, needed: bool
) -> None:
    step = Gather("draw.glsl", writes={"one": blend})
    plan = planned(step, targets={"one": Target("r32ui", single=True)}, samples=samples)
    assert plan.needs_depth_at_centers == needed


@pytest.mark.parametrize(("mechanism", "locked"), [(FETCH, 0), (INTERLOCK, 0), (SPIN_LOCK, 1)])
def test_a_spin_lock_needs_a_word_per_pixel(mechanism: str, locked: int) -> None:
    step = Gather("draw.glsl", writes={"sum": PROGRAMMABLE})
    plan = planned(step, targets={"sum": Target("r32f")}, mechanism=mechanism)
    assert plan.mechanism == mechanism
    assert sum(size for name, size in plan.target_bytes() if name == "lock") == locked * 33 * 17 * 4


@pytest.mark.parametrize("mechanism", [FETCH, INTERLOCK, SPIN_LOCK])
def test_a_counter_needs_no_lock(mechanism: str) -> None:
    step = Gather("draw.glsl", writes={"number": COUNT})
    plan = planned(step, targets={"number": Target("r32ui")}, mechanism=mechanism)
    assert plan.mechanism == mechanism
    assert plan.target_bytes() == [("number", 33 * 17 * 4)]


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (Gather("draw.glsl", writes={"sum": COUNT}), "sum counts, so it must be r32ui"),
        (Gather("draw.glsl", writes={"number": COUNT, "sum": ADD}), "the only target"),
        (Resolve("show.glsl", writes={"number": COUNT}), "counts fragments, not pixels"),
    ],
)
def test_a_counter_is_one_word_and_alone(step: Step, message: str) -> None:
    targets = {"number": Target("r32ui"), "sum": Target("r32f")}
    with pytest.raises(DeclarationError, match=message):
        planned(step, targets=targets)


@pytest.mark.parametrize(("within", "samples"), [("other", 1), ("left", 4)])
def test_a_loop_is_within_a_target_of_its_passes(within: str, samples: int) -> None:
    targets = {"left": Target("r8", subsample=16), "other": Target("r8", subsample=16)}
    mark = Resolve("mark.glsl", writes={"left": REPLACE})
    planned(Loop((mark,), times=2, within="left"), targets=targets)
    with pytest.raises(DeclarationError, match=f"mark.glsl: the loop is within '{within}'"):
        planned(Loop((mark,), times=2, within=within), targets=targets, samples=samples)


def test_fixed_blending_needs_no_mechanism() -> None:
    def refuse(samples: int) -> str:
        raise AssertionError(f"no mechanism is needed at {samples} samples")

    class Made(Method):
        name = "made"

        def plan(self, request: Request) -> Plan:
            return Plan({"sum": Target("r32f")}, (Gather("draw.glsl", writes={"sum": ADD}),))

    assert FramePlan.of(Made(), SIZE, mechanism=refuse).mechanism is None


def test_passes_of_loops_are_listed_in_order() -> None:
    gather = Gather("draw.glsl", writes={"color": ADD})
    resolve = Resolve("show.glsl", writes={"color": REPLACE})
    plan = planned(Loop((gather, resolve), times=3), resolve)
    assert [item.name for item in plan.passes] == ["draw", "show", "show"]


def test_lists_are_the_buffers_of_fragments() -> None:
    buffers = {
        "heads": Buffer({"first": "uint"}, Items.PIXELS),
        "records": Buffer({"next": "uint"}, Items.FRAGMENTS),
    }
    step = Gather("draw.glsl", buffers=tuple(buffers))
    assert planned(step, buffers=buffers).listed == ["records"]


def test_the_tested_depth_is_copied_for_passes_that_read_it() -> None:
    reads = Gather("draw.glsl", reads=(OPAQUE_DEPTH,), writes={"color": ADD})
    assert planned(reads).copies_depth
    assert not planned(Resolve("show.glsl", (OPAQUE_DEPTH,), {"color": ADD})).copies_depth


@pytest.mark.parametrize(
    ("step", "message"),
    [
        (Gather("draw.glsl", writes={"sum": ADD}), "sum"),
        (Gather("draw.glsl", reads=("sum",), writes={"color": ADD}), "sum"),
        (Gather("draw.glsl", buffers=("records",)), "records"),
        (Gather("draw.glsl", writes={"color": ADD}, depth=OPAQUE_DEPTH), "cannot be written"),
    ],
)
def test_undeclared_names_and_the_opaque_depth_are_refused(step: Step, message: str) -> None:
    with pytest.raises(DeclarationError, match=message) as caught:
        planned(step)
    assert "draw.glsl" in str(caught.value)


@pytest.mark.parametrize("name", list(collection().methods))
@pytest.mark.parametrize("mechanism", [FETCH, INTERLOCK, SPIN_LOCK])
def test_every_method_can_be_planned_for_every_effect(name: str, mechanism: str) -> None:
    method = collection().methods[name]()
    for effects in (Effect.NONE, method.shows, EVERYTHING & method.shows):
        for particles in (False, True):
            plan = FramePlan.of(method, SIZE, effects, particles=particles, mechanism=mechanism)
            assert "color" not in plan.targets
            assert plan.passes


def test_alpha_to_coverage_needs_samples_and_an_alpha() -> None:
    masked = Gather("made.glsl", writes={"color": REPLACE}, masked_by_alpha=True)
    assert planned(masked, samples=4).passes == (masked,)
    with pytest.raises(DeclarationError, match="set msaa"):
        planned(masked)
    gray = Gather("made.glsl", writes={"gray": REPLACE}, masked_by_alpha=True)
    with pytest.raises(DeclarationError, match="first target with an alpha"):
        planned(gray, targets={"gray": Target("r16f")}, samples=4)
