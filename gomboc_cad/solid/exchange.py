"""Solids handed to CadQuery and back; both libraries wrap the same kernel, so nothing is converted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from build123d import Solid

from gomboc_cad.errors import GeometryError, GombocError

if TYPE_CHECKING:
    import cadquery


def to_cadquery(solid: Solid) -> cadquery.Workplane:
    """Put a solid on a CadQuery workplane; both share one and the same shape.

    Raises:
        GombocError: If CadQuery is not installed.
    """
    try:
        import cadquery
    except ImportError as error:
        raise GombocError(
            "Handing a solid to CadQuery needs CadQuery; install it with: pip install 'gomboc-cad[cadquery]'."
        ) from error
    return cadquery.Workplane("XY").newObject([cadquery.Shape.cast(solid.wrapped)])


def from_cadquery(workplane: cadquery.Workplane) -> Solid:
    """Take the one solid of a CadQuery workplane.

    Raises:
        GeometryError: If there is not exactly one.
    """
    import cadquery

    shapes = [value for value in workplane.vals() if isinstance(value, cadquery.Shape)]
    solids = [solid for shape in shapes for solid in shape.Solids()]
    if len(solids) != 1:
        raise GeometryError(
            f"The workplane holds {len(solids)} solids where one is needed; combine or select them."
        )
    return Solid(solids[0].wrapped)
