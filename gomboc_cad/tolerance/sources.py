"""What makes one product differ from the next: the figures of its process and of its spec as sources.

A figure with a mean counts with the root of the sum of its squared mean and scatter: that is the size of a
source, which a factor scales as a whole, so that a factor of zero leaves the design.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.products.process import Process, form_amplitudes_mm, known_tolerances
from gomboc_cad.products.process_tolerances import Figure, ProcessTolerances
from gomboc_cad.tolerance.com_model import Role, WeighedPart
from gomboc_cad.tolerance.contributors import Contributor
from gomboc_cad.tolerance.model import Source
from gomboc_cad.tolerance.weighing import GlueLine

if TYPE_CHECKING:
    from gomboc_cad.products.loads import UncertainLoad

_LEAST_DEGREE = 2
_AXES = np.arange(3)


def process_sources(
    process: Process, parts: Sequence[WeighedPart], size_mm: float, degree: int
) -> tuple[Contributor, ...]:
    """What a process makes vary in any set of parts.

    Args:
        process: The process.
        parts: The parts, in the order of the mass model.
        size_mm: Size of the outer shape: its diameter.
        degree: Highest degree of the form error.

    Raises:
        SpecError: If the process has no tolerances.
    """
    tolerances = known_tolerances(process)
    found = [
        _form_error(process, size_mm, degree),
        _shrinkage(tolerances),
        _density_gradient(tolerances, parts),
    ]
    # The density of the only part decides nothing.
    if len(parts) > 1:
        found += [_density(tolerances, parts), _core_shift(tolerances, parts)]
        found += _masses(tolerances, parts) + _places(tolerances, parts)
    return tuple(found)


def seam_sources(process: Process, axes: Array) -> tuple[Contributor, ...]:
    """Step and gap of the seam.

    Args:
        process: The process.
        axes: Two unit vectors in the seam and that towards the upper part as rows, shape (3, 3).
    """
    seam = known_tolerances(process).seam
    step, gap, mean = seam.step_scatter_mm, seam.gap_scatter_mm, seam.gap_mean_mm
    step_source = _source("seam_step", "step of the seam", "mm sd per axis", 2, step)
    gap_source = _source("seam_gap", "gap of the seam, mean and scatter", "mm rms", 1, gap, mean)
    return (
        Contributor(step_source, "normal", "upper_shift_mm", _AXES, step.value * axes[:2]),
        Contributor(
            gap_source, "normal", "upper_shift_mm", _AXES, gap.value * axes[2:], mean.value * axes[2]
        ),
    )


def glue_sources(process: Process, glue: int, line: GlueLine) -> tuple[Contributor, ...]:
    """Amount and unevenness of the glue along the seam.

    Args:
        process: The process.
        glue: Where the glue is among the parts; it is designed without mass.
        line: The line of glue.
    """
    mass = known_tolerances(process).mass
    grams_per_figure = 1e-3 * line.length_mm
    share, uneven = 0.01 * mass.glue_scatter_percent.value, mass.glue_unevenness_percent
    mean_g = grams_per_figure * mass.glue_mean_mg_per_mm.value
    amount = _source(
        "glue_mass",
        "glue on the seam, mean and scatter",
        "g rms",
        1,
        mass.glue_mean_mg_per_mm,
        unit_size=grams_per_figure * math.hypot(1.0, share),
    )
    sides = _source("glue_unevenness", "glue more on one side", "% sd per axis", 2, uneven)
    effect = 0.01 * uneven.value * line.first_moments_mm
    return (
        Contributor(amount, "normal", "mass_g", np.array([glue]), np.array([share * mean_g]), mean_g),
        Contributor(sides, "normal", "place_mm", _place_entries([glue]), effect),
    )


def load_sources(
    loads: Sequence[UncertainLoad], parts: Sequence[WeighedPart], axes: Array
) -> tuple[Contributor, ...]:
    """Mass and place of what is known with tolerances of its own.

    Args:
        loads: Those parts.
        parts: All parts, in the order of the mass model.
        axes: The axes along which the places are off, as rows, shape (3, 3).
    """
    index = {part.name: number for number, part in enumerate(parts)}
    basis = "the spec of the product"
    found = []
    for load in loads:
        name, at = load.part.replace("-", "_"), index[load.part]
        grams, reach = load.mass_tolerance_g, load.com_tolerance_mm
        mass = Source(f"mass_of_{name}", f"mass of the {load.part}", grams, "± g", 1, basis)
        place = Source(f"place_of_{name}", f"centre of mass of the {load.part}", reach, "± mm", 3, basis)
        found += [
            Contributor(mass, "uniform", "mass_g", np.array([at]), np.array([grams])),
            Contributor(place, "uniform", "place_mm", _place_entries([at]), reach * axes),
        ]
    return tuple(found)


def com_error_source(half_width_mm: float, axes: Array, basis: str) -> Contributor:
    """Whatever else moves the centre of mass of the whole.

    Args:
        half_width_mm: How far along each axis.
        axes: The axes as rows, shape (3, 3).
        basis: Who says so.
    """
    source = Source("com_error", "other errors of the centre of mass", half_width_mm, "± mm", 3, basis)
    return Contributor(source, "uniform", "com_mm", _AXES, half_width_mm * axes)


def _source(
    name: str, text: str, unit: str, dimensions: int, *figures: Figure, unit_size: float = 1.0
) -> Source:
    """A source of the size of its figures, scatter first and then mean, in units of `unit_size`."""
    size = math.hypot(*(figure.value for figure in figures))
    best = math.hypot(*(_nearest_to_zero(figure) for figure in figures))
    return Source(name, text, unit_size * size, unit, dimensions, figures[0].source, unit_size * best)


def _nearest_to_zero(figure: Figure) -> float:
    low, high = figure.range
    return max(0.0, low, -high)


def _form_error(process: Process, size_mm: float, degree: int) -> Contributor:
    """Each coefficient of degree l has the standard deviation `aₗ / √(2l + 1)`, aₗ the rms of that degree."""
    degrees = np.arange(_LEAST_DEGREE, degree + 1)
    rms = form_amplitudes_mm(process, size_mm, degrees)
    orders = 2 * degrees + 1
    deviation = np.repeat(rms / np.sqrt(orders), orders)
    form, size = known_tolerances(process).form, float(np.linalg.norm(rms))
    low, high = int(form.lowest_order.value), min(degree, int(form.highest_order.value))
    best_mm = max(form.fixed_mm.range[0], 0.01 * form.proportional_percent.range[0] * size_mm)
    source = Source(
        "form_error",
        f"form error, {low} to {high} undulations per revolution",
        size,
        "mm rms",
        len(deviation),
        form.fixed_mm.source,
        best=size * best_mm / form.tolerance_mm(size_mm) if size > 0.0 else 0.0,
    )
    return Contributor(source, "normal", "form_mm", np.arange(len(deviation)), deviation)


def _shrinkage(tolerances: ProcessTolerances) -> Contributor:
    given = tolerances.shrinkage
    means = given.mean_x_percent, given.mean_y_percent, given.mean_build_percent
    scatters = given.scatter_x_percent, given.scatter_y_percent, given.scatter_build_percent
    text, unit = "shrinkage left along x, y and build, mean and scatter", "% rms on the worst axis"
    axes = [_source("shrinkage", text, unit, 3, *pair) for pair in zip(scatters, means, strict=True)]
    effect, mean = (0.01 * np.array([each.value for each in figures]) for figures in (scatters, means))
    source = max(axes, key=lambda axis: axis.size)
    return Contributor(source, "normal", "shrinkage", _AXES, effect, mean)


def _density(tolerances: ProcessTolerances, parts: Sequence[WeighedPart]) -> Contributor:
    scatter = tolerances.density.scatter_percent
    made = [number for number, part in enumerate(parts) if part.made]
    effect = 0.01 * scatter.value * np.array([parts[number].mass_g for number in made])
    source = _source("shell_density", "density of each made part", "% sd", len(made), scatter)
    return Contributor(source, "normal", "mass_g", np.array(made), effect)


def _density_gradient(tolerances: ProcessTolerances, parts: Sequence[WeighedPart]) -> Contributor:
    """The density of a part of height H changes by γ along b: its centre moves by `C b γ/H`."""
    mean, scatter = tolerances.density.gradient_mean_percent, tolerances.density.gradient_scatter_percent
    made = [number for number, part in enumerate(parts) if part.made]
    # A row for each part, which moves that part alone.
    moved = np.zeros((len(made), len(made), 3))
    for row, number in enumerate(made):
        part = parts[number]
        assert part.spread_mm2 is not None  # it is made
        moved[row, row] = part.spread_mm2 @ np.array(part.build_up) / part.height_mm
    effect = moved.reshape(len(made), -1)
    text = "change of density over each made part's height, mean and scatter"
    source = _source("density_gradient", text, "% rms", len(made), scatter, mean)
    by_scatter, by_mean = 0.01 * scatter.value * effect, 0.01 * mean.value * effect.sum(axis=0)
    return Contributor(source, "normal", "place_mm", _place_entries(made), by_scatter, by_mean)


def _core_shift(tolerances: ProcessTolerances, parts: Sequence[WeighedPart]) -> Contributor:
    """The core of each shell is displaced, with all that sits on it."""
    scatter = tolerances.placement.core_scatter_mm
    shells = [part for part in parts if part.role == "shell"]
    moved = np.zeros((len(shells), 3, len(parts), 3))
    for row, shell in enumerate(shells):
        for number, part in enumerate(parts):
            if part is shell:
                moved[row, _AXES, number, _AXES] = -part.void_share
            elif part.carrier == shell.name:
                moved[row, _AXES, number, _AXES] = 1.0
    text = "cavity against the outer surface, in each shell"
    source = _source("core_shift", text, "mm sd per axis", 3 * len(shells), scatter)
    effect = scatter.value * moved.reshape(3 * len(shells), -1)
    return Contributor(source, "normal", "place_mm", _place_entries(range(len(parts))), effect)


def _masses(tolerances: ProcessTolerances, parts: Sequence[WeighedPart]) -> list[Contributor]:
    """Masses of what is bought without a tolerance of its own."""
    scatter = tolerances.mass.bought_scatter_percent
    chosen_roles: tuple[tuple[Role, str], ...] = (
        ("fastener", "mass of each fastener and other standard part"),
        ("trim", "mass of each trim"),
    )
    found = []
    for role, text in chosen_roles:
        chosen = _of_role(parts, role)
        effect = 0.01 * scatter.value * np.array([parts[number].mass_g for number in chosen])
        source = _source(f"{role}_mass", text, "% sd", len(chosen), scatter)
        found.append(Contributor(source, "normal", "mass_g", np.array(chosen, dtype=np.int64), effect))
    return found


def _places(tolerances: ProcessTolerances, parts: Sequence[WeighedPart]) -> list[Contributor]:
    """Places of what is put in."""
    given = tolerances.placement
    chosen_roles: tuple[tuple[Role, str, Figure], ...] = (
        ("payload", "place of each payload on its seat", given.payload_scatter_mm),
        ("fastener", "place of each fastener and other standard part", given.insert_scatter_mm),
        ("trim", "place of each trim", given.insert_scatter_mm),
    )
    found = []
    for role, text, scatter in chosen_roles:
        entries = _place_entries(_of_role(parts, role))
        source = _source(f"{role}_place", text, "mm sd per axis", len(entries), scatter)
        effect = np.full(len(entries), scatter.value)
        found.append(Contributor(source, "normal", "place_mm", entries, effect))
    return found


def _of_role(parts: Sequence[WeighedPart], role: Role) -> list[int]:
    return [number for number, part in enumerate(parts) if part.role == role]


def _place_entries(parts: Sequence[int]) -> IntArray:
    """Where the coordinates of some parts are among those of all, shape (3·len(parts),)."""
    entries: IntArray = (3 * np.array(parts, dtype=np.int64)[:, None] + _AXES).ravel()
    return entries
