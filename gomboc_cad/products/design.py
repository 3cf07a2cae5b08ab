"""A finished product before it is written: what every recipe gives to the build."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from gomboc_cad.body import Body
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.products.assembly import Assembly
from gomboc_cad.products.common_spec import ProductSpec
from gomboc_cad.products.openings.sites import PlacedOpening
from gomboc_cad.products.placement import Parting, RestFrame
from gomboc_cad.products.placing.com_placement import ComPlacement
from gomboc_cad.products.verdict import Verdict

if TYPE_CHECKING:
    from gomboc_cad.products.loads import UncertainLoad


@dataclass(frozen=True)
class Uncertainty:
    """Something that is not exactly known and moves the centre of mass.

    Attributes:
        source: What may be off, as the beginning of a sentence: `an error of 0.5 g in the mass of the board`.
        com_error_mm: How that moves the centre of mass, a vector of the body's frame.
        remedy: What to do where that is too much: `weigh it and give the mass with a smaller tolerance`.
    """

    source: str
    com_error_mm: Vector
    remedy: str


def no_documents(verdict: Verdict) -> Mapping[str, dict[str, Any]]:
    """For products without documents of their own."""
    return {}


@dataclass(frozen=True)
class ProductDesign:
    """A finished product, not yet written.

    Attributes:
        spec: What was asked for.
        body: The outer shape.
        frame: Frame of the resting pose.
        assembly: All parts in place; made parts have their mesh, boundary and printing direction.
        placement: How the centre of mass was brought to its target, and what that cost.
        openings: Everything that opens the outer surface.
        uncertainties: What moves the centre of mass.
        loads: Contents with tolerances of mass and place.
        upper_parts: Names of the parts that go with the upper half where the seam displaces it.
        parting_direction: Direction in which a mould or the seam opens.
        parting: The seam of the outer surface; None where there is none but around plugs.
        documents: Further JSON documents by file name, such as `calibration.json`, from the verdict.
        summary: Keys of `verdict.json` that only this product has.
        problems: What is wrong with it, one sentence each; any makes the verdict FAIL.
        notes: What a user should know, one sentence each.
    """

    spec: ProductSpec
    body: Body
    frame: RestFrame
    assembly: Assembly
    placement: ComPlacement
    openings: tuple[PlacedOpening, ...]
    uncertainties: tuple[Uncertainty, ...]
    loads: tuple[UncertainLoad, ...]
    upper_parts: frozenset[str]
    parting_direction: Vector
    parting: Parting | None = None
    documents: Callable[[Verdict], Mapping[str, dict[str, Any]]] = no_documents
    summary: Mapping[str, Any] = field(default_factory=dict)
    problems: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
