"""Single scattering in a medium: beams that it dims on their way, and the ambient term."""

from __future__ import annotations

from typing import Any

import numpy as np

from oitbench.path_traced.trace.hits import Line
from oitbench.path_traced.trace.lights import TracedBeam
from oitbench.path_traced.trace.medium import TracedMedium
from oitbench.scene import Floats

STEPS = 128
"""Steps of a march over the diagonal of the medium's box; shorter ways have fewer."""
DIMMING_STEPS = 8
"""Steps in which the optical depth of a varying density is integrated toward a light."""


class SingleScattering:
    """Marches lines of sight through the medium of a scene.

    Parameters
    ----------
    mitsuba, drjit : module
    medium : TracedMedium
    ambient : array, shape (3,)
        Radiance from all sides that is not a beam.
    """

    def __init__(self, mitsuba: Any, drjit: Any, medium: TracedMedium, ambient: Floats) -> None:
        self._mitsuba, self._drjit, self._medium = mitsuba, drjit, medium
        low, high = np.asarray(medium.medium.low), np.asarray(medium.medium.high)
        length = float(np.linalg.norm(high - low)) / STEPS
        self._step = drjit.opaque(mitsuba.Float, max(length, 1e-30))
        self._ambient = mitsuba.Color3f(drjit.opaque(mitsuba.Vector3f, ambient.tolist()))

    def transmittance(self, line: Line, end: Any, active: Any) -> Any:
        """Return the transmittance of a line up to `end` meters.

        It is exact for a constant density; otherwise, the midpoint rule integrates the density.
        """
        mitsuba, drjit, medium = self._mitsuba, self._drjit, self._medium
        near, far = medium.clip(line.o, line.d, line.along, end)
        length = drjit.maximum(far - near, 0)
        if medium.density is None:
            return drjit.exp(-medium.majorant * length)
        part = length / DIMMING_STEPS

        def step(index: Any, depth: Any, active: Any) -> tuple[Any, Any, Any]:
            p = line.o + line.d * (near + (mitsuba.Float(index) + 0.5) * part)
            depth = depth + drjit.select(active, medium.extinction(p, active) * part, 0)
            return index + 1, depth, active & (index + 1 < DIMMING_STEPS)

        state = mitsuba.UInt32(0), mitsuba.Float(0), active & (length > 0)
        return drjit.exp(-drjit.while_loop(state, lambda *v: v[2], step)[1])

    def march(
        self,
        line: Line,
        end: Any,
        beams: list[TracedBeam],
        visibility: Any,
        start: Any,
        active: Any,
    ) -> tuple[Any, Any]:
        """Return the light that scatters into a line before `end` meters, and its transmittance.

        Parameters
        ----------
        line : Line
        end : Float
        beams : list of TracedBeam
        visibility : callable
            Maps a line, its end and a mask to the part of a beam that arrives.
        start : Float
            Place within each step at which light and density are sampled, in [0, 1).
        active : Bool
        """
        mitsuba, drjit, medium = self._mitsuba, self._drjit, self._medium
        near, far = medium.clip(line.o, line.d, line.along, end)
        length = drjit.maximum(far - near, 0)
        inside = active & (length > 0)
        if not beams and medium.density is None:
            passed = drjit.select(inside, drjit.exp(-medium.majorant * length), 1)
            return (1 - passed) * medium.albedo * self._ambient, passed
        count = drjit.clip(drjit.ceil(length / self._step), 1, STEPS)
        part = length / count

        def step(index: Any, light: Any, passed: Any, active: Any) -> tuple[Any, ...]:
            at = near + (index + start) * part
            p = line.o + line.d * drjit.select(active, at, 0)
            source = mitsuba.Color3f(self._ambient)
            for beam in beams:
                toward, distance, arriving = beam.toward(p)
                leaving = line.scattered(p, toward)
                lit = active & drjit.any(arriving > 0)
                arriving = arriving * visibility(leaving, distance, lit)
                source += arriving * medium.phase(drjit.dot(toward, line.d))
            kept = drjit.exp(-medium.extinction(p, active) * part)
            found = passed * (1 - kept) * medium.albedo * source
            light = light + drjit.select(active, found, 0)
            passed = drjit.select(active, passed * kept, passed)
            return index + 1, light, passed, active & (index + 1 < count)

        state = mitsuba.Float(0), mitsuba.Color3f(0), mitsuba.Float(1), inside
        _, light, passed, _ = drjit.while_loop(state, lambda *v: v[3], step)
        return light, passed
