"""Interference fits of ISO 286."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from gomboc_cad.errors import SpecError
from gomboc_cad.products.toml_model import Number, TomlModel, parse_model, read_toml


@dataclass(frozen=True)
class Interference:
    """Interference of the diameters of a fit.

    Attributes:
        least_um: Widest hole, thinnest shaft.
        most_um: Narrowest hole, thickest shaft.
    """

    least_um: float
    most_um: float

    @property
    def mean_um(self) -> float:
        """Middle of both tolerance fields."""
        return 0.5 * (self.least_um + self.most_um)


class _Range(TomlModel):
    to_mm: Number
    hole: Number
    shaft: Number
    lower: dict[str, Number]


class _Fits(TomlModel):
    range: tuple[_Range, ...]


def iso_fit(fit: str, diameter_mm: float) -> Interference:
    """Interference of an ISO 286 fit such as `H7/p6`.

    Raises:
        SpecError: If the fit or the diameter is not in the table.
    """
    path = Path(str(resources.files(__package__) / "fits.toml"))
    ranges = parse_model(_Fits, read_toml(path), path.name).range
    known = [f"H7/{shaft}" for shaft in ranges[0].lower]
    if fit not in known:
        raise SpecError(
            f"closure.fit = {fit!r} is no interference fit that is known here; take one of "
            f"{', '.join(known)}, or give closure.interference_um."
        )
    row = next((row for row in ranges if diameter_mm <= row.to_mm), None)
    if row is None:
        raise SpecError(
            f"closure.fit = {fit!r} is known here up to {ranges[-1].to_mm:g} mm, and the diameter is "
            f"{diameter_mm:.4g} mm; give closure.interference_um."
        )
    lower = row.lower[fit.removeprefix("H7/")]
    return Interference(lower - row.hole, lower + row.shaft)
