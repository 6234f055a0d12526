"""The matrix of a frozen suite, which only a checkout that agrees with it may run."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from oitbench.catalog.catalog import Catalog
from oitbench.errors import UsageError
from oitbench.matrix.plan import Matrix, Preset, plan_matrix
from oitbench.suites.describing import differences
from oitbench.suites.description import read_suite

FIXED = ("preset", "scenes", "size", "effects", "ssaa", "seed", "truths", "shading", "views")
"""Arguments of `plan_matrix` that a suite fixes."""
_SHOWN = 3


def plan_suite(
    name: str,
    methods: Sequence[str] = (),
    collections: Iterable[Path | str] = (),
    **options: Any,
) -> Matrix:
    """Return the matrix of some methods in the scenes of a suite.

    Parameters
    ----------
    name : str
        Of the suite, or its file.
    methods : sequence of str
        Default: all, with default parameters.
    collections : iterable of path
        Folders of further collections.
    **options
        Further arguments of `plan_matrix`, except `FIXED` ones.

    Raises
    ------
    UsageError
        The suite is unknown, a scene, a reference or a metric of this checkout is not the one that
        was frozen, or an option is wrong.
    """
    suite = read_suite(name)
    extra = list(collections)
    with Catalog(extra) as catalog:
        folders = catalog.places.folders
    found = list(differences(suite, folders))
    if found:
        more = f", and {len(found) - _SHOWN} more" if len(found) > _SHOWN else ""
        raise UsageError(
            f"this checkout differs from the suite {suite.name}: {'; '.join(found[:_SHOWN])}{more};"
            f" use one in which they are as in {suite.name}, or run without a suite"
        )
    preset = Preset(
        suite.size, grid="default", rounds=suite.rounds, budget=suite.budget,
        permutations=suite.permutations, truths=tuple(suite.truths), grids=(suite.ssaa,),
    )  # fmt: skip
    return plan_matrix(
        list(dict.fromkeys(scene.scene for scene in suite.scenes)),
        methods,
        preset,
        effects=(suite.effects,),
        seed=suite.seed,
        shading=suite.shading_texts,
        views=suite.views,
        collections=extra,
        **options,
    )


def refuse_fixed(name: str, given: Iterable[str]) -> None:
    """Raise `UsageError` if arguments by their names are among those that a suite fixes."""
    both = [argument for argument in FIXED if argument in set(given)]
    if both:
        raise UsageError(f"the suite {name} fixes {' and '.join(both)}; leave them out")
