"""Run the cells of the report section that compares lists, curves and blending at equal bytes.

    python -m tests.benchmarks.crossover [--out results/crossover] [--workers N] [NAME ...]

`oitbench report --section crossover` draws them. Each NAME is one of `PARTS`; default: all.
`stacks` are random stacks in pictures of 32 × 32 pixels, a grid of numbers of layers and of
coverage with three seeds. `families` are five kinds of stacks, from few strong layers to many thin
ones. `scenes` are real ones at 96 × 96; those with colored glass also have curves of three
channels. All have one sample per pixel.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import oitbench
from oitbench.truths import EXACT

_LISTS = (
    "k_buffer[k=4,8]",
    "multilayer_alpha[k=4,8]",
    "multilayer_alpha[k=8,node=16f]",
    "adaptive[nodes=4,8,12,memory=fixed]",
)
_CURVES = (
    "moments[count=4]",
    "moments[count=8,depth=linear]",
    "wavelet[rank=1,precision=half]",
    "wavelet[rank=2,3]",
    "opacity_map[slices=8,16,memory=fixed,normalized=true]",
    "fourier_map[coefficients=7,15,memory=fixed,normalized=true]",
)
_BLENDING = ("weighted_average", "weighted_blended", "phenomenological")
METHODS = (*_LISTS, *_CURVES, *_BLENDING)
COLORED = (
    "adaptive[nodes=4,8,12,memory=fixed,channels=rgb]",
    "wavelet[rank=1,precision=half,channels=rgb]",
    "wavelet[rank=2,3,channels=rgb]",
    "opacity_map[slices=8,16,memory=fixed,normalized=true,channels=rgb]",
    "fourier_map[coefficients=7,15,memory=fixed,normalized=true,channels=rgb]",
)
STACK, SIDE = "width=32,height=32", (32, 32)
"""Size of pictures of stacks: parameters, pixels."""
COVERAGE = (0.03, 0.08, 0.2, 0.5)
"""Middle of the coverage of the layers of a stack, which varies by half of it."""
GRID = tuple(
    f"fragment_lists[{STACK},layers=4,6,8,12,16,32,64,alpha_low={a / 2:g},alpha_high={1.5 * a:g},"
    "seed=1,2,3]"
    for a in COVERAGE
)
_DEPTHS = "nearest=1,farthest=30"
FAMILIES = (
    f"fragment_lists[{STACK},layers=6,20,alpha_low=0.05,alpha_high=0.6,{_DEPTHS}]",
    f"fragment_lists[{STACK},layers=8,alpha_low=0.1,alpha_high=0.9,family=glass,{_DEPTHS}]",
    f"fragment_lists[{STACK},layers=60,alpha_low=0.01,alpha_high=0.12,{_DEPTHS}]",
    f"fragment_lists[{STACK},layers=40,alpha_low=0.2,alpha_high=0.5,family=tuft,nearest=4.5,"
    "farthest=30]",
)
GRAY_SCENES = (
    "smoke_ball", "hair[detail=0.1]", "layer_stack", "foliage", "forest", "power_plant",
    "smoke_yard", "clouds", "engine",
)  # fmt: skip
COLORED_SCENES = ("glass_bars", "bottles")


@dataclass(frozen=True)
class Part:
    """Scenes with methods and the size of their pictures."""

    scenes: tuple[str, ...]
    methods: tuple[str, ...]
    size: tuple[int, int]


PARTS = {
    "stacks": [Part(GRID, METHODS, SIDE)],
    "families": [Part(FAMILIES, METHODS, SIDE)],
    "scenes": [
        Part(GRAY_SCENES, METHODS, (96, 96)),
        Part(COLORED_SCENES, (*METHODS, *COLORED), (96, 96)),
    ],
}


def main() -> None:
    """Run, and say which command draws the report."""
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", metavar="NAME", choices=[[], *PARTS])
    parser.add_argument("--out", default="results/crossover")
    parser.add_argument("--workers", type=int, default=1)
    options = parser.parse_args()
    for name in options.names or PARTS:
        for part in PARTS[name]:
            outcome = oitbench.run(
                part.scenes, part.methods, "guard", part.size, options.out,
                ssaa=1, truths=[EXACT], workers=options.workers,
            )  # fmt: skip
            print(f"{name}: {outcome}", flush=True)
    print(f"next: oitbench report {options.out} --section crossover")


if __name__ == "__main__":
    main()
