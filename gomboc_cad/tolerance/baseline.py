"""The honest baseline: a plain sphere with ballast, made by the same process with the same errors.

A sphere whose COM is lowered by d has one rest, the S-margin d and the stiffness d in all directions. So any
design can be said in its terms: how far would the COM of a sphere of the same volume have to be lowered to do
as well? Against that stands how far the design's own COM lies below the centroid of its outer shape: if that
is more, its loads alone would have done better in a plain sphere than in this shape.

The sphere is judged on the same rows: same errors of the COM, same shrinkage, form error and seam. Holes are
left out, for a sphere rests where it likes and needs none in the same places.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

import numpy as np

from gomboc_cad.body import Body, Harmonic, mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.acceptance import (
    Effort,
    Target,
    design_outcome,
    good_rows,
    largest_accepted,
)
from gomboc_cad.tolerance.fast_census import judge
from gomboc_cad.tolerance.judging import RowArray
from gomboc_cad.tolerance.model import Source, StudyModel
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.running import Job, run_batches
from gomboc_cad.tolerance.statistics import Interval, clopper_pearson
from gomboc_cad.tolerance.variants import MONOSTABLE, Nominal, Outcomes, Variants

_EFFORT = Effort()
_LEAST, _MOST = 1e-5, 0.9
"""Lowerings that are searched, in units of the sphere's radius."""

_ACCURACY = 0.02
_NO_REST_DEG = 180.0
"""Tilt of a part that has not one rest."""


@dataclass(frozen=True, eq=False)
class BallastedSphere:
    """A study of a sphere with lowered COM that has the errors of another study.

    Attributes:
        study: The study whose errors they are.
        nominal: The sphere.
    """

    study: StudyModel
    nominal: Nominal

    @property
    def sources(self) -> tuple[Source, ...]:
        """Those of the other study."""
        return self.study.sources

    def variants(self, quantiles: Array) -> Variants:
        """Spheres with the errors of the rows; shrinkage moves the COM of each body by its own part."""
        made = self.study.variants(quantiles)
        arm = np.array(self.nominal.com_mm) - np.array(self.study.nominal.com_mm)
        return replace(made, com_mm=made.com_mm + made.stretch @ arm)

    def judge(self, variants: Variants) -> Outcomes:
        """How each of them rests."""
        return judge(self.nominal, variants)

    def scaled(self, factors: Mapping[str, float]) -> Self:
        """The same with the sizes of some sources, by name, times a factor."""
        return replace(self, study=self.study.scaled(factors))

    def with_com_shift(self, shift_mm: Vector) -> Self:
        """The same with the nominal COM elsewhere."""
        com = as_vector(np.array(self.nominal.com_mm) + np.array(shift_mm))
        return replace(self, nominal=replace(self.nominal, com_mm=com))

    def describe(self) -> dict[str, Any]:
        """What is studied."""
        return {"sphere_com_mm": list(self.nominal.com_mm), "errors_of": self.study.describe()}


def concentric_sphere(study: StudyModel) -> BallastedSphere:
    """The sphere of the same volume about the origin, its COM in its centre, with the same seam."""
    volume = mass_properties(study.nominal.body).volume_mm3
    sphere = Body("sphere", Harmonic(()), float((0.75 * volume / np.pi) ** (1.0 / 3.0)))
    return BallastedSphere(study, Nominal(sphere, (0.0, 0.0, 0.0), study.nominal.seam))


@dataclass(frozen=True)
class Baseline:
    """What a design is worth in terms of a sphere with ballast.

    Attributes:
        radius_mm: Radius of the sphere of the same volume.
        design_lowering_mm: How far the design's COM lies below the centroid of its outer shape, along the
            direction in which it rests; below 0 if it lies above.
        same_margin_mm: Lowering of the sphere's COM with the S-margin of the design: that margin.
        same_yield_mm: Smallest lowering with as many good parts; None if no sphere reaches that. Not below a
            hundred-thousandth of the radius, where it is the end of the search.
        same_tilt_mm: Smallest lowering at which 95 % of the spheres rest as near to their nominal rest as 95
            % of the parts do; None if no sphere does, or fewer of the parts have one rest.
        design_good: Share of good parts.
        sphere_good: Share of good spheres if the COM is lowered by as much as that of the design; None if it
            is not lowered.
    """

    radius_mm: float
    design_lowering_mm: float
    same_margin_mm: float
    same_yield_mm: float | None
    same_tilt_mm: float | None
    design_good: Interval
    sphere_good: Interval | None

    @property
    def shape_is_worth_it(self) -> bool:
        """Whether a plain sphere with the same lowering of its COM has fewer good parts."""
        return self.sphere_good is None or self.sphere_good.estimate < self.design_good.estimate

    @property
    def sentence(self) -> str:
        """What the user is told."""
        equal = f"The S-margin is that of a plain sphere with its COM lowered by {self.same_margin_mm:.3g} mm"
        if self.sphere_good is None:
            return f"{equal}; the COM of the design is not lowered at all: the shape alone rights it."
        own, plain = (100.0 * share.estimate for share in (self.design_good, self.sphere_good))
        better = "the shape is worth it" if self.shape_is_worth_it else "a plain sphere does no worse"
        return (
            f"{equal}; the design lowers it by {self.design_lowering_mm:.3g} mm, with which {plain:.4g} % of "
            f"plain spheres would be good, against {own:.4g} % of the parts: {better}."
        )

    def document(self) -> dict[str, Any]:
        """The baseline as the study gives it."""
        return {**asdict(self), "sentence": self.sentence}


def sphere_baseline(
    model: StudyModel,
    target: Target,
    effort: Effort = _EFFORT,
    *,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> Baseline:
    """Compare a design with a sphere of the same volume that has the same errors.

    Args:
        model: The study of the design.
        target: What counts as good, and the confidence of the intervals.
        effort: How many variants each lowering may cost.
        executor: Where to run; here if not given.
        progress: Called with the name of each stage as it begins.
    """
    requirement, rows = target.requirement, effort.search_rows
    design = design_outcome(model)
    s_margin, down = float(design.s_margin_mm[0]), design.rest_direction[0]
    centroid = np.array(mass_properties(model.nominal.body).com_mm)
    lowering = float((np.array(model.nominal.com_mm) - centroid) @ down)
    sphere = concentric_sphere(model)
    radius = sphere.nominal.body.radius_mm

    def made(study: StudyModel) -> RowArray:
        batches = run_batches(Job(study, rows.of(study), requirement), executor)
        return np.concatenate(list(batches))[: rows.count]

    def lowered(distance_mm: float) -> RowArray:
        return made(sphere.with_com_shift(as_vector(distance_mm * down)))

    def smallest(accepts: Callable[[RowArray], bool]) -> float | None:
        # The smallest distance is the largest of the reciprocals.
        start = 1.0 / min(max(s_margin, _LEAST * radius), _MOST * radius)
        ends = 1.0 / (_MOST * radius), 1.0 / (_LEAST * radius)
        found = largest_accepted(lambda inverse: accepts(lowered(1.0 / inverse)), start, *ends, _ACCURACY)
        return None if found is None else 1.0 / found

    progress("judging the design")
    parts = made(model)
    passed, tilt = _good(parts, requirement), _tilt_p95_deg(parts)
    progress("looking for the sphere that does as well")
    same_yield = smallest(lambda spheres: _good(spheres, requirement) >= passed)
    same_tilt = smallest(lambda spheres: _tilt_p95_deg(spheres) <= tilt) if tilt < _NO_REST_DEG else None
    sphere_good = None
    if lowering > _LEAST * radius:
        good = _good(lowered(lowering), requirement)
        sphere_good = clopper_pearson(good, rows.count, target.confidence)
    return Baseline(
        radius_mm=radius,
        design_lowering_mm=lowering,
        same_margin_mm=s_margin,
        same_yield_mm=same_yield,
        same_tilt_mm=same_tilt,
        design_good=clopper_pearson(passed, rows.count, target.confidence),
        sphere_good=sphere_good,
    )


def _good(rows: RowArray, requirement: Requirement) -> int:
    return int(np.count_nonzero(good_rows(rows, requirement)))


def _tilt_p95_deg(rows: RowArray) -> float:
    """Tilt that 95 % of the parts stay within, those without one rest counting as overturned."""
    tilt = np.where(rows["verdict"] == MONOSTABLE, rows["tilt_deg"], _NO_REST_DEG)
    return float(np.quantile(tilt, 0.95))
