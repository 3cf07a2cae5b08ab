"""The subject of a study: a finished product or a bare body, with all that its process and spec make vary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from gomboc_cad.body import Body, mass_properties
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria import convexity, find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GombocError, NotConvexError
from gomboc_cad.products.process import Process, known_tolerances
from gomboc_cad.tolerance.com_model import Deviations, MassModel, WeighedPart
from gomboc_cad.tolerance.contributors import Contributor
from gomboc_cad.tolerance.fast_census import judge
from gomboc_cad.tolerance.model import Source
from gomboc_cad.tolerance.sources import (
    com_error_source,
    glue_sources,
    load_sources,
    process_sources,
    seam_sources,
)
from gomboc_cad.tolerance.variants import Nominal, Outcomes, SeamPlane, Variants
from gomboc_cad.tolerance.weighing import build_direction, glue_line, machine_axes, whole_body

if TYPE_CHECKING:
    from gomboc_cad.products.design import ProductDesign

_LARGEST_DEGREE = 16
"""Highest degree of the form error, where the spectrum of the process goes further and none is asked for."""


@dataclass(frozen=True, eq=False)
class ProductStudy:
    """A study model (`StudyModel`) of a product or a bare body.

    Attributes:
        subject: What is studied.
        process: Name of the process.
        nominal: The design.
        masses: Masses and places of its parts.
        machine: Unit vectors along the machine's x, y and build direction as rows, shape (3, 3). They are
            those of the lower part; of a part that is made otherwise, the step of the seam has to tell.
        upper_shift_mm: Displacement of the upper part by design.
        contributors: All that varies.
    """

    subject: str
    process: str
    nominal: Nominal
    masses: MassModel
    machine: Array
    upper_shift_mm: Vector
    contributors: tuple[Contributor, ...]

    @property
    def sources(self) -> tuple[Source, ...]:
        """What varies; the columns of the quantiles are those of the sources, one after the other."""
        return tuple(contributor.source for contributor in self.contributors)

    @property
    def dimensions(self) -> int:
        """Number of columns of the quantiles."""
        return sum(source.dimensions for source in self.sources)

    def deviations(self, quantiles: Array) -> Deviations:
        """How the products that rows of quantiles (n, D) stand for differ from the design."""
        if quantiles.ndim != 2 or quantiles.shape[1] != self.dimensions:
            raise ValueError(f"the quantiles have the shape {quantiles.shape}, not (n, {self.dimensions})")
        count, parts = len(quantiles), len(self.masses.mass_g)
        widths = {
            "form_mm": len(self.masses.skin_g_per_mm),
            "shrinkage": 3,
            "upper_shift_mm": 3,
            "mass_g": parts,
            "place_mm": 3 * parts,
            "com_mm": 3,
        }
        found = {target: np.zeros((count, width)) for target, width in widths.items()}
        start = 0
        for contributor in self.contributors:
            columns = slice(start, start + contributor.source.dimensions)
            found[contributor.target][:, contributor.entries] += contributor.values(quantiles[:, columns])
            start = columns.stop
        return Deviations(
            form_mm=found["form_mm"],
            stretch=self._stretch(found["shrinkage"]),
            upper_shift_mm=found["upper_shift_mm"],
            mass_g=found["mass_g"],
            place_mm=found["place_mm"].reshape(count, parts, 3),
            com_mm=found["com_mm"],
        )

    def variants(self, quantiles: Array) -> Variants:
        """The products that rows of quantiles (n, D) in (0, 1) stand for; each row is computed by itself."""
        deviations = self.deviations(quantiles)
        return Variants(
            com_mm=self.masses.com_mm(deviations),
            stretch=deviations.stretch,
            form_mm=deviations.form_mm,
            upper_shift_mm=deviations.upper_shift_mm + self.upper_shift_mm,
        )

    def judge(self, variants: Variants) -> Outcomes:
        """How each of them rests."""
        return judge(self.nominal, variants)

    def scaled(self, factors: Mapping[str, float]) -> Self:
        """The same with the sizes of some sources, by name, times a factor.

        Raises:
            GombocError: If there is no such source.
        """
        self._check_known(factors)
        contributors = tuple(each.scaled(factors.get(each.source.name, 1.0)) for each in self.contributors)
        return replace(self, contributors=contributors)

    def only(self, *names: str) -> Self:
        """The same with only some sources, by name.

        Raises:
            GombocError: If there is no such source.
        """
        self._check_known(names)
        return replace(self, contributors=tuple(c for c in self.contributors if c.source.name in names))

    def with_com_shift(self, shift_mm: Vector) -> Self:
        """The same with its centre of mass placed elsewhere, by a vector of the body's frame."""
        nominal = replace(self.nominal, com_mm=as_vector(np.add(self.nominal.com_mm, shift_mm)))
        masses = replace(self.masses, shift_mm=as_vector(np.add(self.masses.shift_mm, shift_mm)))
        return replace(self, nominal=nominal, masses=masses)

    def describe(self) -> dict[str, Any]:
        """What is studied and what varies, for a JSON document."""
        return {
            "subject": self.subject,
            "process": self.process,
            "com_mm": list(self.nominal.com_mm),
            "machine_axes": self.machine.tolist(),
            "sources": [asdict(source) for source in self.sources],
        }

    def _stretch(self, shrinkage: Array) -> Array:
        """`S = I − Σ sₖ qₖ qₖᵀ` with the shrinkage s along the machine's axes q, shape (n, 3, 3)."""
        dyads = self.machine[:, :, None] * self.machine[:, None, :]
        result: Array = np.eye(3) - sum(
            s[:, None, None] * dyad for s, dyad in zip(shrinkage.T, dyads, strict=True)
        )
        return result

    def _check_known(self, names: Sequence[str] | Mapping[str, float]) -> None:
        known = [source.name for source in self.sources]
        unknown = [name for name in names if name not in known]
        if unknown:
            raise GombocError(f"There is no source {unknown[0]!r}; choose of {', '.join(known)}.")


def body_study(
    body: Body,
    process: Process,
    *,
    com_mm: Vector | None = None,
    build_up: Vector | None = None,
    com_error_mm: float = 0.0,
    degree: int | None = None,
) -> ProductStudy:
    """A massive body made in one piece.

    Args:
        body: A strictly convex body.
        process: How it is made.
        com_mm: Its centre of mass; that of a homogeneous body if not given.
        build_up: Direction that points up where it is made; if not given, that of the process, or upwards at
            rest.
        com_error_mm: How far its centre of mass may be off along each axis besides.
        degree: Highest degree of the form error; if not given, that of the process up to 16.

    Raises:
        SpecError: If the process has no tolerances.
        NotConvexError: If the body is not strictly convex.
    """
    degree = _highest_degree(process) if degree is None else degree
    com = mass_properties(body).com_mm if com_mm is None else com_mm
    if build_up is None:
        rest = find_equilibria(body, np.array(com))[0].direction
        build_up = build_direction(process, as_vector(np.negative(rest)))
    parts = (whole_body(body, com, build_up),)
    machine = machine_axes(build_up)
    contributors = (
        *process_sources(process, parts, body.diameter_mm, degree),
        com_error_source(com_error_mm, machine, "given with the body"),
    )
    return _study(body.name, process, body, parts, contributors, degree)


def product_study(design: ProductDesign, process: Process, degree: int | None = None) -> ProductStudy:
    """A finished product.

    Args:
        design: Its design.
        process: How its made parts are made, which need not be the process of the spec.
        degree: Highest degree of the form error; if not given, that of the process up to 16.

    Raises:
        SpecError: If the process has no tolerances.
        NotConvexError: If the outer shape is not strictly convex.
    """
    # The kernel is loaded only for what needs it.
    from gomboc_cad.tolerance.product_parts import com_error_mm, is_glued, weighed_parts

    degree = _highest_degree(process) if degree is None else degree
    parts = weighed_parts(design, process)
    axes, parting = design.frame.matrix(), design.parting
    contributors = [
        *process_sources(process, parts, design.body.diameter_mm, degree),
        *load_sources(design.loads, parts, axes),
        com_error_source(com_error_mm(design), axes, "the spec of the product"),
    ]
    if parting is not None:
        contributors += seam_sources(process, axes)
        if is_glued(design):
            line = glue_line(design.body, parting, 0.5 * design.spec.shell.wall_mm)
            contributors += glue_sources(process, len(parts), line)
            parts = (*parts, WeighedPart("glue", "glue", 0.0, as_vector(line.center_mm)))
    study = _study(design.assembly.name, process, design.body, parts, contributors, degree)
    if parting is None:
        return replace(study, nominal=replace(study.nominal, openings=design.openings))
    seam = SeamPlane(as_vector(parting.height_mm * np.array(parting.up)), parting.up)
    nominal = replace(study.nominal, seam=seam, openings=design.openings)
    return replace(study, nominal=nominal, upper_shift_mm=parting.shift_mm)


def _highest_degree(process: Process) -> int:
    return min(_LARGEST_DEGREE, int(known_tolerances(process).form.highest_order.value))


def _study(
    subject: str,
    process: Process,
    body: Body,
    parts: Sequence[WeighedPart],
    contributors: Sequence[Contributor],
    degree: int,
) -> ProductStudy:
    """Put a study of something in one piece together, without the sources that do nothing."""
    if not convexity(body).strictly_convex:
        raise NotConvexError(
            f"The outer shape {body.name!r} is not strictly convex, and a study follows its support "
            "function: choose a smaller beta or another body."
        )
    masses = MassModel.of(parts, body, degree)
    com = masses.com_mm(masses.no_deviations())[0]
    build_up = next(part.build_up for part in parts if part.role == "shell" and not part.upper)
    assert build_up is not None  # a shell is made
    return ProductStudy(
        subject=subject,
        process=process.name,
        nominal=Nominal(body, as_vector(com)),
        masses=masses,
        machine=machine_axes(build_up),
        upper_shift_mm=(0.0, 0.0, 0.0),
        contributors=tuple(c for c in contributors if c.source.size > 0.0 and c.source.dimensions > 0),
    )
