"""The participating medium of a scene: free paths, transmittance and the phase function.

The bounds of the medium are intersected analytically. Its box has no surfaces, so the camera may be
inside of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.scene import Medium

STEPS = 32
"""Steps by which a varying density is integrated over a line."""


@dataclass(frozen=True, eq=False)
class TracedMedium:
    """A medium for drjit arrays.

    Parameters
    ----------
    mitsuba, drjit : module
    medium : Medium
    majorant : Float
        Largest extinction anywhere, m⁻¹.
    density : Texture3f or None
        Density relative to its largest value; None if it is one everywhere.
    """

    mitsuba: Any
    drjit: Any
    medium: Medium
    majorant: Any
    density: Any

    @classmethod
    def build(cls, mitsuba: Any, drjit: Any, medium: Medium) -> TracedMedium:
        """Upload `medium`."""
        extinction, density = medium.extinction, None
        if medium.density is not None:
            largest = max(float(medium.density.max()), 1e-30)
            extinction *= largest
            cells = medium.density[..., None] / largest
            density = mitsuba.Texture3f(
                mitsuba.TensorXf(cells.astype(np.float32)),
                filter_mode=drjit.FilterMode.Linear,
                wrap_mode=drjit.WrapMode.Clamp,
                use_accel=False,
            )
        return cls(mitsuba, drjit, medium, drjit.opaque(mitsuba.Float, extinction), density)

    @property
    def albedo(self) -> Any:
        """Single-scattering albedo Λ, Color3f."""
        return self.mitsuba.Color3f(*map(float, self.medium.albedo))

    def sample_free_path(
        self, o: Any, d: Any, start: Any, end: Any, rng: Any, active: Any
    ) -> tuple[Any, Any]:
        """Sample where light that travels along a line is scattered or absorbed next.

        A varying density is sampled by delta tracking (Woodcock et al. 1965).

        Parameters
        ----------
        o, d : Point3f, Vector3f
            Origin and direction of the line.
        start, end : Float
            Ends of the line, in meters along it.
        rng : PCG32
        active : Bool

        Returns
        -------
        at : Float
            Meters along the line; infinite if the light reaches the end.
        rng : PCG32
        """
        near, far = self.clip(o, d, start, end)
        hit, at, rng = self._collide(o, d, near, far, rng, active)
        return self.drjit.select(hit, at, self.drjit.inf), rng

    def spend(
        self, o: Any, d: Any, start: Any, end: Any, reach: Any, active: Any
    ) -> tuple[Any, Any]:
        """Go along a line until an optical depth is spent.

        It is exact for a constant density; otherwise, the midpoint rule in `STEPS` steps integrates
        the density.

        Parameters
        ----------
        o, d : Point3f, Vector3f
            Origin and direction of the line.
        start, end : Float
            Ends of the line, in meters along it.
        reach : Float
            The optical depth.
        active : Bool

        Returns
        -------
        at : Float
            Meters along the line; infinite if the end comes first.
        left : Float
            What is left of `reach` at the end; negative if it is spent before.
        """
        drjit, mitsuba = self.drjit, self.mitsuba
        near, far = self.clip(o, d, start, end)
        length = drjit.maximum(far - near, 0)
        if self.density is None:
            at, left = near + reach / self.majorant, reach - self.majorant * length
            return drjit.select(active & (left < 0), at, drjit.inf), left
        part = length / STEPS

        def step(index: Any, at: Any, left: Any, active: Any) -> tuple[Any, ...]:
            middle = near + (mitsuba.Float(index) + 0.5) * part
            depth = self.extinction(o + d * middle, active) * part
            spent = active & (left < depth)
            at = drjit.select(spent, near + (mitsuba.Float(index) + left / depth) * part, at)
            left = drjit.select(active, left - depth, left)
            index = index + 1
            return index, at, left, active & ~spent & (index < STEPS)

        state = mitsuba.UInt32(0), mitsuba.Float(drjit.inf), reach, active & (length > 0)
        _, at, left, _ = drjit.while_loop(state, lambda *v: v[3], step)
        return at, left

    def transmittance(self, o: Any, d: Any, start: Any, end: Any, active: Any) -> Any:
        """Return the transmittance of a line, as exactly as `spend`."""
        drjit, mitsuba = self.drjit, self.mitsuba
        near, far = self.clip(o, d, start, end)
        length = drjit.maximum(far - near, 0)
        if self.density is None:
            return drjit.exp(-self.majorant * length)
        part = length / STEPS

        def step(index: Any, depth: Any, active: Any) -> tuple[Any, ...]:
            p = o + d * (near + (mitsuba.Float(index) + 0.5) * part)
            depth = depth + drjit.select(active, self.extinction(p, active) * part, 0)
            return index + 1, depth, active & (index + 1 < STEPS)

        state = mitsuba.UInt32(0), mitsuba.Float(0), active & (length > 0)
        return drjit.exp(-drjit.while_loop(state, lambda *v: v[2], step)[1])

    def phase(self, cosine: Any) -> Any:
        """Return the phase function of Henyey & Greenstein, sr⁻¹.

        `cosine` is that of the angle between the directions of a path before and after.
        """
        g = float(self.medium.anisotropy)
        base = self.drjit.maximum(1 + g * g - 2 * g * cosine, 1e-12)
        return (1 - g * g) / (4 * np.pi) / (base * self.drjit.sqrt(base))

    def sample_phase(self, d: Any, two: Any) -> Any:
        """Return a random direction, distributed by the phase function around `d`."""
        drjit, mitsuba, g = self.drjit, self.mitsuba, float(self.medium.anisotropy)
        if abs(g) < 1e-3:
            cosine = 1 - 2 * two.x
        else:
            part = (1 - g * g) / (1 - g + 2 * g * two.x)
            cosine = (1 + g * g - part * part) / (2 * g)
        sine = drjit.safe_sqrt(1 - cosine * cosine)
        s, c = drjit.sincos(2 * np.pi * two.y)
        return drjit.normalize(
            mitsuba.Frame3f(d).to_world(mitsuba.Vector3f(sine * c, sine * s, cosine))
        )

    @property
    def falloff(self) -> Any:
        """Largest rate, m⁻¹, at which light from within certainly falls off everywhere."""
        return self.majorant if self.density is None else self.mitsuba.Float(0)

    def extinction(self, p: Any, active: Any) -> Any:
        """Return σ_t at a point inside the box, m⁻¹."""
        return self.majorant if self.density is None else self.majorant * self._relative(p, active)

    def clip(self, o: Any, d: Any, start: Any, end: Any) -> tuple[Any, Any]:
        """Return the ends of the part of a line that is inside the box, in meters along it.

        The line does not cross the box if the second is not greater than the first.
        """
        drjit, mitsuba = self.drjit, self.mitsuba
        low, high = (
            drjit.opaque(mitsuba.Point3f, [float(x) for x in corner])
            for corner in (self.medium.low, self.medium.high)
        )
        safe = drjit.select(drjit.abs(d) < 1e-12, 1e-12, d)
        one, other = (low - o) / safe, (high - o) / safe
        near = drjit.maximum(start, drjit.max(drjit.minimum(one, other)))
        return near, drjit.minimum(end, drjit.min(drjit.maximum(one, other)))

    def _collide(
        self, o: Any, d: Any, near: Any, far: Any, rng: Any, active: Any
    ) -> tuple[Any, Any, Any]:
        drjit, mitsuba = self.drjit, self.mitsuba
        active = active & (near < far) & (self.majorant > 0)
        if self.density is None:
            at = near - drjit.log(1 - rng.next_float32(active)) / self.majorant
            return active & (at < far), at, rng

        def step(at: Any, hit: Any, rng: Any, active: Any) -> tuple[Any, ...]:
            at = at - drjit.log(1 - rng.next_float32(active)) / self.majorant
            active = active & (at < far)
            real = rng.next_float32(active) < self._relative(o + d * at, active)
            return at, hit | (active & real), rng, active & ~real

        state = (near, mitsuba.Bool(False), rng, active)
        at, hit, rng, _ = drjit.while_loop(state, lambda *v: v[3], step)
        return hit, at, rng

    def _relative(self, p: Any, active: Any) -> Any:
        """Return the density at a point, relative to its largest value."""
        low, high = np.asarray(self.medium.low), np.asarray(self.medium.high)
        scale = self.mitsuba.Vector3f(*map(float, 1 / (high - low)))
        place = (p - self.mitsuba.Point3f(*map(float, low))) * scale
        return self.density.eval(place, active)[0]
