"""What a study of tolerances needs to know of its subject: what varies, by how much, and how to judge it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, Self

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector

if TYPE_CHECKING:
    from gomboc_cad.tolerance.variants import Nominal, Outcomes, Variants


@dataclass(frozen=True)
class Source:
    """Something that differs from one product to the next: an entry of the table of contributions.

    Attributes:
        name: Its key, such as `seam_step`.
        text: What it is, for a table.
        size: How large it is; the effect of a source is proportional to it.
        unit: Unit of the size, and whether it is a standard deviation (`mm sd`) or a half-width (`± mm`).
        dimensions: How many independent numbers describe it: its columns among the quantiles.
        basis: Where the figure is from.
        best: The size at the best end of the range of its figures, what the best makers reach; None where no
            range is known.
    """

    name: str
    text: str
    size: float
    unit: str
    dimensions: int
    basis: str
    best: float | None = None


class StudyModel(Protocol):
    """A product or a body with all that varies.

    It can be pickled, and gives the same numbers for the same rows wherever and in whatever batch it runs.
    """

    @property
    def sources(self) -> tuple[Source, ...]:
        """What varies; the columns of the quantiles are those of the sources, one after the other."""

    @property
    def nominal(self) -> Nominal:
        """The design that the variants differ from."""

    def variants(self, quantiles: Array) -> Variants:
        """The products that rows of quantiles (n, D) in (0, 1) stand for."""

    def judge(self, variants: Variants) -> Outcomes:
        """How each of them rests."""

    def scaled(self, factors: Mapping[str, float]) -> Self:
        """The same with the sizes of some sources, by name, times a factor."""

    def with_com_shift(self, shift_mm: Vector) -> Self:
        """The same with its centre of mass placed elsewhere, by a vector of the body's frame."""

    def describe(self) -> dict[str, Any]:
        """What is studied and what varies, for a JSON document."""
