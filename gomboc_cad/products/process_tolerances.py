"""What a process makes of a part: every figure with its range and its source."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, Field, model_validator
from scipy.special import ndtri

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.products.toml_model import Number, Point, TomlModel

Source = Annotated[str, Field(strict=True, min_length=1, max_length=800)]

LEAST_ORDER = 2
"""Degree 1 is a translation, degree 0 a change of size: neither is an error of form."""


class Figure(TomlModel):
    """A figure, how far it may be from that elsewhere, and who says so. The unit is in the name of its key.

    Attributes:
        value: What is reckoned with.
        range: From the best shops, machines or materials to the worst that is still usual.
        source: Where value and range come from; `estimate: ...` with the reason where nobody has measured it.
    """

    value: Number
    range: tuple[Number, Number]
    source: Source

    @model_validator(mode="before")
    @classmethod
    def _written_out(cls, data: Any) -> Any:
        if not isinstance(data, dict | cls):
            raise ValueError('a figure is written { value = ..., range = [low, high], source = "..." }')
        return data

    @model_validator(mode="after")
    def _within_range(self) -> Figure:
        low, high = self.range
        if low > high:
            raise ValueError(f"range = [{low:g}, {high:g}] is the wrong way round")
        if not low <= self.value <= high:
            raise ValueError(f"value = {self.value:g} is outside of its own range, {low:g} to {high:g}")
        return self


def _sensible(least: float, most: float) -> AfterValidator:
    """Refuse figures that are most likely in another unit."""

    def check(figure: Figure) -> Figure:
        wrong = next((each for each in (figure.value, *figure.range) if not least <= each <= most), None)
        if wrong is not None:
            raise ValueError(
                f"{wrong:g} is not allowed (allowed: {least:g} to {most:g}), in the unit of the key's name"
            )
        return figure

    return AfterValidator(check)


def _whole(figure: Figure) -> Figure:
    if not figure.value.is_integer():
        raise ValueError(f"value = {figure.value:g} is not a whole number")
    return figure


Length = Annotated[Figure, _sensible(0.0, 10.0)]
Percent = Annotated[Figure, _sensible(0.0, 50.0)]
SignedPercent = Annotated[Figure, _sensible(-20.0, 20.0)]
Order = Annotated[Figure, _sensible(LEAST_ORDER, 500), AfterValidator(_whole)]


class FormError(TomlModel):
    """How far the surface is off, apart from size and place.

    The tolerance of a part is the greater of `fixed_mm` and `proportional_percent` of its size, as makers
    state it. It is a half-width that holds the share `coverage_percent` of a normal distribution.

    Attributes:
        measure: What it bounds: the `dimension` between two opposite points of the surface, as calipers
            measure it; or the `surface` itself along its normal after the best fit, as a scan shows it.
        fixed_mm: The tolerance of small parts, ±.
        proportional_percent: That of large parts, ± in percent of the size.
        coverage_percent: The share of all deviations within it.
        decay: Exponent p of the spectrum: the rms of undulations of order n falls as n⁻ᵖ.
        lowest_order: The first order of the spectrum, in undulations per revolution.
        highest_order: The last; what is shorter counts as waviness and roughness.
    """

    measure: Literal["dimension", "surface"]
    fixed_mm: Length
    proportional_percent: Annotated[Figure, _sensible(0.0, 10.0)]
    coverage_percent: Annotated[Figure, _sensible(50.0, 99.999)]
    decay: Annotated[Figure, _sensible(0.0, 5.0)]
    lowest_order: Order
    highest_order: Order

    @model_validator(mode="after")
    def _ordered(self) -> FormError:
        low, high = self.lowest_order.value, self.highest_order.value
        if low > high:
            raise ValueError(f"lowest_order = {low:g} is more than highest_order = {high:g}")
        if self.measure == "dimension" and low == high and low % 2:
            # Such a part has the same width all round, as a Reuleaux triangle has.
            raise ValueError(f'no dimension shows the odd order {low:g} alone; use measure = "surface"')
        return self

    def tolerance_mm(self, size_mm: float) -> float:
        """The stated half-width for a part of a size, its largest dimension."""
        return max(self.fixed_mm.value, 0.01 * self.proportional_percent.value * size_mm)

    def rms_mm(self, size_mm: float) -> float:
        """Root mean square of the surface's deviation over all orders.

        A normal distribution has the share P within `z((1 + P)/2)` standard deviations. The distance between
        two opposite points is off by `δ(v) + δ(−v)`: odd orders cancel and even ones count twice, so that its
        standard deviation is `2 √(Σ aₙ², n even)`.
        """
        deviation = self.tolerance_mm(size_mm) / float(ndtri(0.5 + 0.005 * self.coverage_percent.value))
        if self.measure == "surface":
            return deviation
        orders, shares = self._shares()
        return float(0.5 * deviation / np.sqrt(shares[orders % 2 == 0].sum()))

    def amplitudes_mm(self, size_mm: float, orders: IntArray) -> Array:
        """Root mean square of each order (whole numbers), 0 outside of the spectrum; same shape."""
        band, shares = self._shares()
        by_order = np.zeros(band[-1] + 1)
        by_order[band] = self.rms_mm(size_mm) * np.sqrt(shares)
        asked = np.asarray(orders, dtype=int)
        inside = (asked >= 0) & (asked < len(by_order))
        return np.where(inside, by_order[np.where(inside, asked, 0)], 0.0)

    def _shares(self) -> tuple[IntArray, Array]:
        """All orders of the spectrum, and the share of each in the mean square, `n⁻²ᵖ / Σ n⁻²ᵖ`."""
        orders = np.arange(int(self.lowest_order.value), int(self.highest_order.value) + 1)
        powers = orders ** (-2.0 * self.decay.value)
        return orders, powers / powers.sum()


class Shrinkage(TomlModel):
    """What is left of the shrinkage along the machine's axes after machine or mould have allowed for it.

    Positive is smaller: lengths along an axis come out times `1 − percent/100`. Only the difference between
    the axes matters to the equilibria.

    Attributes:
        mean_x_percent: Mean along x of the machine; of a moulding, along the flow.
        mean_y_percent: Mean along y; of a moulding, across the flow.
        mean_build_percent: Mean along the build direction; of a moulding or a milled part, along the parting
            direction or the spindle.
        scatter_x_percent: Standard deviation from part to part along x.
        scatter_y_percent: Along y.
        scatter_build_percent: Along the build direction.
    """

    mean_x_percent: SignedPercent
    mean_y_percent: SignedPercent
    mean_build_percent: SignedPercent
    scatter_x_percent: Annotated[Figure, _sensible(0.0, 5.0)]
    scatter_y_percent: Annotated[Figure, _sensible(0.0, 5.0)]
    scatter_build_percent: Annotated[Figure, _sensible(0.0, 5.0)]


class Layers(TomlModel):
    """The steps of a print.

    Attributes:
        height_mm: Height of a layer.
        direction: `print_up`: each part is built along its own printing direction; or a direction of the
            body's frame for all of them.
    """

    height_mm: Annotated[Figure, _sensible(0.001, 2.0)]
    direction: Literal["print_up"] | Point = "print_up"

    @model_validator(mode="after")
    def _directed(self) -> Layers:
        if self.direction != "print_up" and not any(self.direction):
            raise ValueError("direction = [0, 0, 0] points nowhere")
        return self


class Roughness(TomlModel):
    """The surface as the process leaves it.

    Attributes:
        ra_um: Arithmetical mean deviation Ra of the profile (ISO 21920-2).
    """

    ra_um: Annotated[Figure, _sensible(0.001, 200.0)]


class SeamError(TomlModel):
    """How well the upper part comes to sit on the lower one, on top of `split` of the spec.

    Attributes:
        step_scatter_mm: Standard deviation of the step across the seam, along each of two axes.
        gap_mean_mm: Mean distance by which the seam does not close, as with a layer of glue.
        gap_scatter_mm: Its standard deviation.
    """

    step_scatter_mm: Length
    gap_mean_mm: Length
    gap_scatter_mm: Length


class DensityError(TomlModel):
    """How the material of made parts differs from its nominal density.

    Attributes:
        scatter_percent: Standard deviation of the mean density from part to part.
        gradient_mean_percent: Change of density from the lowest to the highest point of a part along the
            build direction; positive is denser at the top.
        gradient_scatter_percent: Standard deviation of that change.
    """

    scatter_percent: Percent
    gradient_mean_percent: SignedPercent
    gradient_scatter_percent: Percent


class PlacementError(TomlModel):
    """Where things end up inside; standard deviations along each axis.

    Attributes:
        insert_scatter_mm: Inserts, pins and screws.
        payload_scatter_mm: The payload on its seat.
        core_scatter_mm: The cavity against the outer surface: shift of a core, of a second clamping.
    """

    insert_scatter_mm: Length
    payload_scatter_mm: Length
    core_scatter_mm: Length


class MassError(TomlModel):
    """Masses that are not made by the process but come with it.

    Attributes:
        bought_scatter_percent: Standard deviation of the mass of each bought part and trim mass whose own
            tolerance is not known.
        glue_mean_mg_per_mm: Mass of glue on each millimetre of a glued seam.
        glue_scatter_percent: Standard deviation of the amount.
        glue_unevenness_percent: Standard deviation of u₁ and u₂ where the glue along the seam is
            `m (1 + u₁ cos φ + u₂ sin φ)`.
    """

    bought_scatter_percent: Percent
    glue_mean_mg_per_mm: Annotated[Figure, _sensible(0.0, 50.0)]
    glue_scatter_percent: Annotated[Figure, _sensible(0.0, 100.0)]
    glue_unevenness_percent: Annotated[Figure, _sensible(0.0, 100.0)]


class ProcessTolerances(TomlModel):
    """All that a study of tolerances needs to know of a process.

    Every key with `scatter` in its name is one standard deviation of a normal distribution.

    Attributes:
        form: Error of form and its spectrum.
        shrinkage: What is left of it along each axis of the machine.
        layers: Steps of a print; None where nothing is built in layers.
        roughness: Roughness of the surface.
        seam: Step and gap.
        density: Scatter and gradient of the density.
        placement: Positions inside.
        mass: Bought parts and glue.
    """

    form: FormError
    shrinkage: Shrinkage
    layers: Layers | None = None
    roughness: Roughness
    seam: SeamError
    density: DensityError
    placement: PlacementError
    mass: MassError
