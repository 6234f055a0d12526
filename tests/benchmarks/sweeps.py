"""Run the sweeps of the near plane, of shadow maps and of phenomenological transparency.

    python -m tests.benchmarks.sweeps [--size 128x128] [--out results/sweeps] [NAME ...]

`oitbench report` draws the results in its section of sweeps. Each NAME is one of `SWEEPS`; default:
all. Equation 5 of McGuire & Mara 2017 weighs layers by window depth, which depends on the near
plane. Its sweep goes up to the near plane of each scene, just in front of the content, and compares
the equation with the weight of the authors' engine, under the effects that exact compositing draws.
The others vary each parameter in a scene where it acts, against matched tracing.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import oitbench
from oitbench.cli.options import parse_size
from oitbench.method.ablation import REQUESTED
from oitbench.truths import EXACT, MATCHED

COMPOSITING = "-refraction,-diffusion,-volume"


@dataclass(frozen=True)
class Sweep:
    """Scenes, methods and settings of shading with lists of values, and the effects that run."""

    scenes: tuple[str, ...]
    methods: tuple[str, ...]
    effects: str = REQUESTED
    shading: tuple[str, ...] = ()


def _one(scene: str, parameters: str) -> Sweep:
    return Sweep((scene,), (f"phenomenological[{parameters}]",))


_SHADOWED = ("bottles", "shadow_trio")
SWEEPS = {
    "near": Sweep(
        (
            "bottles[near=0.01,0.03,0.1,0.2,0.4,0.7]",
            "chess[near=0.003,0.01,0.03,0.1,0.27]",
            "tumblers[near=0.003,0.01,0.03,0.1,0.36]",
            "smoke_and_glass[near=0.03,0.1,0.3,1,3]",
        ),
        ("phenomenological[depth_weight=eq5,g3d]",),
        COMPOSITING,
    ),
    "k0": _one("frosted_door", "k0=0.1,0.25,0.375,0.5,0.7,0.9,precision=half,kernel=disk,gaussian"),
    "k1": _one("frosted_door", "k1=0.05,0.2,0.5,1,2,precision=half"),
    "radius": _one("frosted_door", "radius=0.03,0.0625,0.125,0.25,0.5,precision=half"),
    "dz": _one("tumblers", "reach=fixed,dz=0.02,0.05,0.1,0.3,1,2,precision=half"),
    "subsample": _one("foggy_street", "subsample=1,2,4,precision=paper,half"),
    "shadow_map": Sweep(_SHADOWED, ("a_buffer",), shading=("shadow_map=256,512,1024,2048,4096",)),
    "downsampling": Sweep(_SHADOWED, ("a_buffer",), shading=("downsampling=1,2,4,8",)),
}


def main() -> None:
    """Run, and say which command draws the report."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", metavar="NAME", choices=[[], *SWEEPS])
    parser.add_argument("--size", default="128x128", type=parse_size)
    parser.add_argument("--out", default="results/sweeps")
    options = parser.parse_args()
    for name in options.names or SWEEPS:
        sweep = SWEEPS[name]
        truth = EXACT if sweep.effects == COMPOSITING else MATCHED
        outcome = oitbench.run(
            sweep.scenes, sweep.methods, "guard", options.size, options.out,
            effects=[sweep.effects], truths=[truth], shading=sweep.shading,
        )  # fmt: skip
        print(f"{name}: {outcome}", flush=True)
    print(f"next: oitbench report {options.out}")


if __name__ == "__main__":
    main()
