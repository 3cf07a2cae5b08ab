"""The seam between the two parts of a body: a plane, with a step where one part reaches into the other."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.hollow.tools import Box, Tool


@dataclass(frozen=True)
class Seam:
    """A plane that cuts a solid into a lower and an upper part, flat or stepped.

    Attributes:
        origin_mm: A point of the plane.
        normal: Its normal, from the lower part to the upper one, of any length but zero.
        tongue: Where material below the plane belongs to the upper part. The tools should reach through
            the plane, so that no skin is left between the tongue and the rest of its part.
        groove: What the lower part lacks to take the tongue, above the plane or below it: usually the
            tongue with its clearance. The tongue itself where nothing is given.

    Raises:
        GeometryError: If the plane has no place or direction.
    """

    origin_mm: Vector
    normal: Vector
    tongue: tuple[Tool, ...] = ()
    groove: tuple[Tool, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what is no plane."""
        if not (np.all(np.isfinite([*self.origin_mm, *self.normal])) and math.hypot(*self.normal) > 0.0):
            raise GeometryError(
                f"A seam needs a point and a normal, not {self.origin_mm!r} and {self.normal!r}."
            )

    @property
    def up(self) -> Array:
        """Unit normal, shape (3,)."""
        return np.array(self.normal) / math.hypot(*self.normal)

    @property
    def is_flat(self) -> bool:
        """Whether the plane is all there is."""
        return not (self.tongue or self.groove)

    @property
    def taken_below(self) -> tuple[Tool, ...]:
        """What the lower part lacks besides everything above the plane."""
        return self.groove or self.tongue

    def half_spaces(self, size_mm: float) -> tuple[Box, Box]:
        """Boxes below and above the plane that hold whatever of a part of this size is there.

        Args:
            size_mm: Largest extent of a part that lies around the origin or around a point of the plane.
        """
        reach_mm = 2.0 * size_mm + float(np.linalg.norm(self.origin_mm))
        across = as_vector(np.linalg.svd(self.up[None])[2][1])
        size = (2.0 * reach_mm, 2.0 * reach_mm, reach_mm)
        below, above = (
            Box(as_vector(self.origin_mm + side * reach_mm * self.up), across, as_vector(self.up), size)
            for side in (-0.5, 0.5)
        )
        return below, above
