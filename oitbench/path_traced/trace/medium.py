"""The participating medium of a scene: free paths, transmittance and Henyey & Greenstein's phase.

The box is met analytically, so a camera may stand in it, and its walls are no surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oitbench.scene import Medium


@dataclass(frozen=True, eq=False)
class Fog:
    """A medium, for drjit arrays.

    Parameters
    ----------
    mitsuba, drjit : module
    medium : Medium
    majorant : Float
        Largest extinction anywhere, m⁻¹.
    density : Texture3f or None
        Relative to where it is largest; None for one everywhere.
    """

    mitsuba: Any
    drjit: Any
    medium: Medium
    majorant: Any
    density: Any

    @classmethod
    def build(cls, mitsuba: Any, drjit: Any, medium: Medium) -> Fog:
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
        """Λ, Color3f."""
        return self.mitsuba.Color3f(*map(float, self.medium.albedo))

    def free_path(self, o: Any, d: Any, start: Any, end: Any, rng: Any, active: Any) -> Any:
        """Return the distance along `d` of the next collision, infinite if it is beyond `end`.

        A varying density is followed by delta tracking (Woodcock et al. 1965).
        """
        near, far = self.within(o, d, start, end)
        hit, at, rng = self._collide(o, d, near, far, rng, active)
        return self.drjit.select(hit, at, self.drjit.inf), rng

    def transmittance(self, o: Any, d: Any, start: Any, end: Any, rng: Any, active: Any) -> Any:
        """Return the part of light that passes, or an estimate of it where density varies.

        The estimate is ratio tracking (Novák et al. 2014).
        """
        drjit, mitsuba = self.drjit, self.mitsuba
        near, far = self.within(o, d, start, end)
        if self.density is None:
            return drjit.exp(-self.majorant * drjit.maximum(far - near, 0)), rng

        def step(at: Any, part: Any, rng: Any, active: Any) -> tuple[Any, ...]:
            at = at - drjit.log(1 - rng.next_float32(active)) / self.majorant
            active = active & (at < far)
            part = drjit.select(active, part * (1 - self._relative(o + d * at, active)), part)
            return at, part, rng, active & (part > 0)

        state = (near, mitsuba.Float(1), rng, active & (near < far) & (self.majorant > 0))
        _, part, rng, _ = drjit.while_loop(state, lambda *v: v[3], step)
        return part, rng

    def phase(self, cosine: Any) -> Any:
        """Return p(θ), sr⁻¹; `cosine` is that between a path's directions before and after."""
        g = float(self.medium.anisotropy)
        base = self.drjit.maximum(1 + g * g - 2 * g * cosine, 1e-12)
        return (1 - g * g) / (4 * np.pi) / (base * self.drjit.sqrt(base))

    def scattered(self, d: Any, two: Any) -> Any:
        """Return a direction of the distribution `phase` round the direction `d`."""
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
        """Rate at which light from within surely becomes fainter, m⁻¹."""
        return self.majorant if self.density is None else self.mitsuba.Float(0)

    def extinction(self, p: Any, active: Any) -> Any:
        """Return σ_t at a point of the box, m⁻¹."""
        return self.majorant if self.density is None else self.majorant * self._relative(p, active)

    def within(self, o: Any, d: Any, start: Any, end: Any) -> tuple[Any, Any]:
        """Return where the line from `start` to `end` enters and leaves the box."""
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
        low, high = np.asarray(self.medium.low), np.asarray(self.medium.high)
        scale = self.mitsuba.Vector3f(*map(float, 1 / (high - low)))
        place = (p - self.mitsuba.Point3f(*map(float, low))) * scale
        return self.density.eval(place, active)[0]
