"""Records of the study: what is varied, the bodies as made, and what became of each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector

if TYPE_CHECKING:
    from gomboc_cad.products.openings.placed_opening import PlacedOpening

MONOSTABLE = 0
MULTISTABLE = 1
UNDECIDED = 2


@dataclass(frozen=True)
class SeamPlane:
    """Plane at which the outer surface parts; what lies above it is the upper part.

    Attributes:
        origin_mm: A point of the plane.
        normal: Unit vector towards the upper part.
    """

    origin_mm: Vector
    normal: Vector


@dataclass(frozen=True, eq=False)
class Nominal:
    """What is varied.

    Attributes:
        body: Strictly convex outer shape, as designed.
        com_mm: Nominal COM of the assembly, in the body's frame.
        seam: Outer parting of the two halves; None for a body in one piece.
        openings: Holes in the outer surface.
    """

    body: Body
    com_mm: Vector
    seam: SeamPlane | None = None
    openings: tuple[PlacedOpening, ...] = ()


@dataclass(frozen=True, eq=False)
class Variants:
    """Bodies as made, in the body's frame of the lower part; one row per variant.

    Attributes:
        com_mm: True COM of the finished assembly, after everything, shape (n, 3).
        stretch: Symmetric S, as made `x' = S x`, shape (n, 3, 3).
        form_mm: Coefficients of the form error `δ(v) = Σ form_mm[k] Y_k(v)`, which is added to the support
            function of the outward normal v before S, shape (n, K); the Y_k are those of `harmonics`.
        upper_shift_mm: Displacement of the upper part, step and gap, shape (n, 3).
    """

    com_mm: Array
    stretch: Array
    form_mm: Array
    upper_shift_mm: Array

    def __len__(self) -> int:
        """Number of variants."""
        return len(self.com_mm)

    def rows(self, index: slice | NDArray[np.int64]) -> Variants:
        """Some of the variants."""
        return Variants(
            self.com_mm[index], self.stretch[index], self.form_mm[index], self.upper_shift_mm[index]
        )


@dataclass(frozen=True, eq=False)
class Outcomes:
    """What became of the variants, column by column.

    Attributes:
        verdict: 0 monostable, 1 multistable, 2 undecided, int8, shape (n,). Undecided is a variant whose
            surface with form error is no longer convex, or that is so near to a change of its census that
            rounding decides.
        stable: Rests known, shape (n,).
        rest_direction: The deepest rest known, as the outward normal that points down, shape (n, 3); NaN if
            none is known.
        tilt_deg: Angle between that rest and the nominal one, shape (n,).
        s_margin_mm: How far the COM may still move before another stable rest appears, 0 where there are
            several, shape (n,).
        stiffness_mm: Stiffness (soft, stiff) at the rest, shape (n, 2).
    """

    verdict: NDArray[np.int8]
    stable: NDArray[np.int64]
    rest_direction: Array
    tilt_deg: Array
    s_margin_mm: Array
    stiffness_mm: Array
