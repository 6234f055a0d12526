"""Share of small faults in shaders and in shading code that the guard notices.

    python -m tests.benchmarks.mutations [--count N] [--seed N] [--jobs N] [--only TEXT]

Each mutant changes one place in a copy of the tree: a number with a fraction grows by a hundredth,
an integer by one, a comparison or the sign of a term turns round, `min` and `max` change places.
Two of three change a number. The guard then checks the pictures of the cells that include the
changed shader, or of all cells after a change in Python, and stops at the first difference.

Mutants that do not compile or that raise an error are replaced by others. Those of `EQUIVALENT`
are listed, but not counted. The last line is the share of the rest that the guard notices.
"""

from __future__ import annotations

import argparse
import ast
import io
import itertools
import os
import random
import re
import shutil
import subprocess
import sys
import tokenize
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from queue import Queue
from tempfile import TemporaryDirectory

from oitbench.places import own_folder
from oitbench.plugins import Collection
from tests.pictures.cells import cells
from tests.pictures.render import pictures

FOLDERS = ("oitbench", "methods", "scenes", "reference", "reports", "tests")
SHADERS = ("oitbench/gl/shaders/*.glsl", "oitbench/method/kits/*/*.glsl", "methods/*/*.glsl")
CODE = (
    "oitbench/gl/view.py", "oitbench/gl/geometry.py", "oitbench/gl/shading/*.py",
    "oitbench/scene/texturing.py", "oitbench/scene/lights.py",
    "oitbench/method/kits/*/__init__.py", "methods/*/method.py",
)  # fmt: skip
"""Python that computes what shaders read, and plans."""
NO_SHADING = {
    "Parameter", "require", "loop_steps", "record_step", "STEPS", "RECORD_STEPS", "traversals",
    "memory", "measure", "__post_init__", "lookup", "_bilinear", "level_of_detail",
}  # fmt: skip
"""Calls, functions and constants in it that change no picture of OpenGL: bounds, counts, error
messages, lookups of the path tracer."""
EQUIVALENT: Mapping[str, str] = {
    r": color(_factor)? = vec4\(.*, «[01]\.0»\);$": "nobody reads the picture's alpha",
    r"max\(.*, «1e-(12|20)»\)": "no value but zero is below the guard of a division",
    r"upsample\.glsl: ivec2 (first|last) =.*TENT «[-+]» 0.5": "weights beyond the tent are zero",
    r"absorbance/.*«1e38»": "any number beyond all distances",
    r"phenomenological/resolve\.glsl: if \(all\(.*blur == «": "a shortcut to the same color",
    r"phenomenological/method\.py: \"distance\".*clear=\(«": "drivers clamp depths to one",
    r"geometry\.py: vertices\[\"in_position\"\].*«3»": "a larger triangle covers the frame, too",
    r"lists\.frag\.glsl: fragment\.(normal|incidence|entering)": "read by refraction only",
    r"/occlusion\.glsl: if \(depth >= «1\.0»": "nobody reads the openness of the background",
    r"lighting\.glsl: float longitude = .*«==»": "drivers give 0 straight up and down, too",
}
"""Why no picture can change, by a pattern of file and code, with the place in guillemets."""
UNDRAWN = ("oitbench/gl/shaders/probe.glsl",)
"""Shaders that no picture uses; tests of their own guard them."""
SWAPS = {
    "<": ">", ">": "<", "<=": ">=", ">=": "<=", "==": "!=", "!=": "==", "+": "-", "-": "+",
    "min": "max", "max": "min",
}  # fmt: skip
_NUMBER = r"(?<![\w.])(?:\d+\.\d*|\.\d+|\d+)(?:e[-+]?\d+)?(?=u?(?![\w.]))"
_OPERATOR = r"(?<= )(?:<=|>=|==|!=|<|>|\+|-)(?= )|\b(?:min|max)(?=\()"
COUNTED = ("noticed", "survived")
_TIMEOUT = 900.0


@dataclass(frozen=True)
class Mutant:
    """A change of one place: the characters from `start` to `end` of a file become `text`."""

    file: str
    line: int
    start: int
    end: int
    old: str
    text: str
    code: str

    @classmethod
    def at(cls, file: str, source: str, start: int, end: int) -> Mutant:
        """Return the mutant of one place."""
        first = source.rfind("\n", 0, start) + 1
        last = source.find("\n", end)
        marked = f"{source[first:start]}«{source[start:end]}»{source[end:last]}".strip()
        old = source[start:end]
        return cls(file, source.count("\n", 0, start) + 1, start, end, old, changed(old), marked)

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.old} -> {self.text} in {self.code}"

    @property
    def equivalent(self) -> str | None:
        """Why no picture can change, or None."""
        line = f"{self.file}: {self.code.partition(' //')[0].strip()}"
        return next((why for found, why in EQUIVALENT.items() if re.search(found, line)), None)


def changed(token: str) -> str:
    """Return the text that takes the place of a number or an operator."""
    if token in SWAPS:
        return SWAPS[token]
    if any(letter in token for letter in ".e"):
        return repr(1.01 * float(token) if float(token) else 0.01)
    return str(int(token) + 1)


def mutants(root: Path) -> Iterator[Mutant]:
    """Yield all mutants of all files."""
    for pattern in (*SHADERS, *CODE):
        for path in sorted(root.glob(pattern)):
            text = path.read_text(encoding="utf-8")
            places = _in_glsl(text) if path.suffix == ".glsl" else _in_python(text)
            file = path.relative_to(root).as_posix()
            if file in UNDRAWN:
                continue
            yield from (Mutant.at(file, text, start, end) for start, end in places)


def _in_glsl(text: str) -> Iterator[tuple[int, int]]:
    """Yield the places outside comments, directives and declarations of bindings."""
    for match in re.finditer(r"[^\n]+", text):
        line = match[0].partition("//")[0]
        if not line.lstrip().startswith(("#", "layout")):
            for token in re.finditer(f"{_NUMBER}|{_OPERATOR}", line):
                yield match.start() + token.start(), match.start() + token.end()


def _in_python(text: str) -> Iterator[tuple[int, int]]:
    """Yield the places outside strings and outside what changes no picture."""
    left_out: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        names = {getattr(node, "name", "")}
        if isinstance(node, ast.Call):
            names = {getattr(node.func, "attr", ""), getattr(node.func, "id", "")}
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names = {getattr(target, "id", "") for target in targets}
        if names & NO_SHADING and isinstance(node, ast.expr | ast.stmt):
            left_out |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        row, column = token.start
        digits = token.type == tokenize.NUMBER and re.fullmatch(_NUMBER, token.string)
        operator = token.type == tokenize.OP and token.string in SWAPS
        spaced = token.line[column - 1 : column] == " " == token.line[token.end[1] :][:1]
        if row not in left_out and (digits or (operator and spaced)):
            yield starts[row - 1] + column, starts[row - 1] + token.end[1]


def chosen(every: Sequence[Mutant], seed: int) -> Iterator[Mutant]:
    """Yield mutants in random order: two of numbers, one of operators, and so on."""
    mixed = random.Random(seed).sample(list(every), len(every))
    numbers = [item for item in mixed if item.old not in SWAPS]
    operators = [item for item in mixed if item.old in SWAPS]
    while numbers or operators:
        yield from (numbers.pop() for _ in range(min(2, len(numbers))))
        if operators:
            yield operators.pop()


def judge(mutant: Mutant, tree: Path, names: Sequence[str]) -> str:
    """Return "noticed", "survived", "equivalent" or "broken" for a mutant in a copy of the tree."""
    path = tree / mutant.file
    text = path.read_text(encoding="utf-8")
    path.write_text(text[: mutant.start] + mutant.text + text[mutant.end :], encoding="utf-8")
    # Stale byte code would hide a change; threads of the driver cost more than they save here.
    environment = {"PYTHONDONTWRITEBYTECODE": "1", "LP_NUM_THREADS": "1"}
    listed = tree / "cells.txt"
    listed.write_text("\n".join(names), encoding="utf-8")
    try:
        done = subprocess.run(
            [sys.executable, "-m", "tests.guard", "check", str(listed)],
            cwd=tree,
            env=os.environ | environment | {"PYTHONPATH": str(tree)},
            capture_output=True,
            text=True,
            timeout=_TIMEOUT,
        )
    except subprocess.TimeoutExpired:
        return "noticed"  # nobody commits a guard that never ends
    finally:
        path.write_text(text, encoding="utf-8")
    if done.returncode not in (0, 1) or "Traceback" in done.stderr:
        return "broken"
    if done.returncode:
        return "noticed"
    return "equivalent" if mutant.equivalent else "survived"


def in_turn(names: Iterable[str]) -> list[str]:
    """Return names of cells, one of each scene after another, so that a check soon ends."""
    seen: Counter[str] = Counter()
    ranks = {}
    for name in names:
        scene = name.partition(" ")[0]
        ranks[name] = seen[scene]
        seen[scene] += 1
    return sorted(ranks, key=ranks.__getitem__)


def copies(root: Path, folder: Path, count: int) -> Queue[Path]:
    """Return copies of the tree, one for each job."""
    trees: Queue[Path] = Queue()
    for number in range(count):
        tree = folder / str(number)
        for name in FOLDERS:
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(root / name, tree / name, ignore=ignored)
        shutil.copy(root / "pyproject.toml", tree)
        trees.put(tree)
    return trees


def judged(
    waiting: Iterator[Mutant], users: Callable[[str], Sequence[str]], trees: Queue[Path], count: int
) -> Iterator[tuple[Mutant, str]]:
    """Yield mutants and results, until `count` of them count.

    Parameters
    ----------
    waiting : iterator of Mutant
    users : callable
        Returns the names of the cells that a change of a file can affect.
    trees : Queue of Path
    count : int
    """

    def work(mutant: Mutant) -> tuple[Mutant, str]:
        tree = trees.get()
        try:
            return mutant, judge(mutant, tree, users(mutant.file))
        finally:
            trees.put(tree)

    with ThreadPoolExecutor(trees.qsize()) as pool:
        while count > 0 and (batch := list(itertools.islice(waiting, count))):
            for done in as_completed([pool.submit(work, item) for item in batch]):
                mutant, result = done.result()
                count -= result in COUNTED
                yield mutant, result


def main() -> None:
    """Judge mutants and print the share that the guard notices."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=80, help="mutants to judge")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only", default="", help="text that the file's path contains")
    options = parser.parse_args()
    root = own_folder()
    every = [item for item in mutants(root) if options.only in item.file]
    print(f"{len(every)} places")
    found = pictures(cells(Collection.load()))
    names = in_turn(found.means)

    def users(file: str) -> list[str]:
        shader = file.endswith(".glsl")
        return [name for name in names if not shader or file in found.files[name]]

    results: Counter[str] = Counter()
    with TemporaryDirectory() as folder:
        trees = copies(root, Path(folder), options.jobs)
        waiting = chosen(every, options.seed)
        for mutant, result in judged(waiting, users, trees, options.count):
            results[result] += 1
            print(f"{result}: {mutant}", mutant.equivalent or "", flush=True)
    print(dict(results))
    counted = sum(results[name] for name in COUNTED)
    if counted:
        print(f"{100 * results['noticed'] / counted:.0f} % of {counted} mutants noticed")


if __name__ == "__main__":
    main()
