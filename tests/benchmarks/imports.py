"""Measure the import of a large file, and feed many damaged ones.

    python -m tests.benchmarks.imports [--triangles 2000000] [--damaged 20000] [--seed 1]

It writes a .glb of a wavy surface with normals, texture coordinates and a texture, and prints the
seconds and the memory that a fresh process needs to import it, and where the time goes. Then it
damages small files of all formats. The exit code is 1 if one of them gives neither a scene nor one
line, or takes more than 10 s, or if this process ever holds more than 2 GB.
"""

from __future__ import annotations

import argparse
import random
import resource
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

import numpy as np

from tests.importing.files import Gltf
from tests.importing.mutations import mutated, seeds, write_all
from tests.importing.test_fuzz import attempt

_LOAD = """
import cProfile, pstats, resource, sys, time
from oitbench.importing import read_scene
start = time.perf_counter()
profile = cProfile.Profile()
if sys.argv[2] == "profile":
    profile.enable()
scene = read_scene(sys.argv[1]).scene
profile.disable()
seconds = time.perf_counter() - start
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
triangles = sum(len(item.mesh.triangles) for item in scene.objects)
print(f"{triangles:,} triangles in {seconds:.2f} s, peak memory {peak:.2f} GiB")
if sys.argv[2] == "profile":
    pstats.Stats(profile).sort_stats("cumtime").print_stats("oitbench", 12)
"""


def large(folder: Path, triangles: int) -> Path:
    """Write a file of so many triangles, half as many vertices, and a texture."""
    side = round((triangles / 2) ** 0.5)
    u, v = np.meshgrid(np.linspace(0, 1, side + 1), np.linspace(0, 1, side + 1))
    height = 0.05 * np.sin(40 * u) * np.cos(30 * v)
    positions = np.stack([u.ravel(), height.ravel(), v.ravel()], axis=1)
    slope_u, slope_v = 2 * np.cos(40 * u) * np.cos(30 * v), -1.5 * np.sin(40 * u) * np.sin(30 * v)
    normals = np.stack([-slope_u.ravel(), np.ones(u.size), -slope_v.ravel()], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    below = corner + side + 1
    faces = np.stack([corner, below, corner + 1, corner + 1, below, below + 1], axis=1)
    gltf = Gltf()
    rng = np.random.default_rng(1)
    image = gltf.picture(rng.integers(0, 256, (512, 512, 3)))
    attributes = {
        "POSITION": gltf.array(positions),
        "NORMAL": gltf.array(normals),
        "TEXCOORD_0": gltf.array(np.stack([u.ravel(), v.ravel()], axis=1)),
    }
    described = {"pbrMetallicRoughness": {"baseColorTexture": {"index": image}}}
    indices = gltf.array(faces.ravel(), "uint32")
    mesh = gltf.mesh(attributes, indices, material=gltf.add("materials", described))
    gltf.add("nodes", {"mesh": mesh})
    return gltf.write(folder, "large.glb")


def damage(count: int, seed: int) -> bool:
    """Import damaged files; print failures, and return whether there was none."""
    random_, kinds = random.Random(seed), seeds()
    bad, slowest, lines = 0, 0.0, set()
    with tempfile.TemporaryDirectory() as name:
        for number in range(count):
            kind = random_.choice(list(kinds))
            files = mutated(kind, kinds[kind], random_)
            start = time.perf_counter()
            try:
                lines.add(attempt(write_all(Path(name), files)))
            except Exception:
                bad += 1
                kept = Path(tempfile.mkdtemp(prefix=f"damaged-{kind}-{number}-"))
                print(f"{write_all(kept, files)}:")
                traceback.print_exc(limit=-3)
            slowest = max(slowest, time.perf_counter() - start)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    print(
        f"{count:,} damaged files: {bad} failures, {len(lines)} different lines, slowest"
        f" {slowest:.2f} s, peak memory {peak:.2f} GiB"
    )
    return not bad and peak < 2


def main() -> None:
    """Run both parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--triangles", type=int, default=2_000_000)
    parser.add_argument("--damaged", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    well = damage(chosen.damaged, chosen.seed) if chosen.damaged else True
    if chosen.triangles:
        with tempfile.TemporaryDirectory() as name:
            path = large(Path(name), chosen.triangles)
            print(f"{path.name}: {path.stat().st_size / 2**20:.0f} MiB")
            for how in ("plain", "profile"):
                subprocess.run([sys.executable, "-c", _LOAD, str(path), how], check=True)
    sys.exit(0 if well else 1)


if __name__ == "__main__":
    main()
