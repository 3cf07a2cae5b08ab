"""The centre of mass of a product as made: every mass and every place varied.

A product is a set of parts with masses mᵢ and centres pᵢ, `c = Σ mᵢ pᵢ / Σ mᵢ`. As made:

* Shrinkage is a linear map `x' = S x` of all that is made; at the density of the material the mass of a made
  part goes with its volume, det S. What is bought keeps its mass, and its place p becomes S p as well.
* A core that is displaced by d against the outer surface moves a void of volume V₀ in a part of volume V, and
  so the part's centre by `−d V₀/V`, and what sits on that core by d.
* A density `ρ (1 + g·(x − p))` leaves the mass and moves the centre by `C g`, `C = ∫ (x−p)(x−p)ᵀ dV / V`.
* An upper part that is displaced takes along all that sits in it.
* A form error δ of the outer surface adds the mass `ρ ∫ δ dA` and the moment `ρ ∫ x δ dA`, to first order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gomboc_cad.body import Body, MassProperties
from gomboc_cad.body.mass import sphere_quadrature
from gomboc_cad.body.sphere import Array, BoolArray, tangent_frame
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.tolerance.harmonics import harmonic_jets

Role = Literal["shell", "plug", "payload", "trim", "fastener", "glue"]

_SKIN_ORDER = 48
"""Order of the quadrature over the outer surface; harmonics of degree 16 on a smooth body need 30."""


@dataclass(frozen=True, eq=False)
class WeighedPart:
    """A part as far as its mass is concerned.

    Attributes:
        name: Its name.
        role: `shell`: made, with outer surface and void; `plug`: made besides; `payload`: with a tolerance of
            its own; `trim`; `fastener`: bought besides; `glue`.
        mass_g: Mass as designed.
        com_mm: Centre of mass as designed.
        upper: Whether it goes with the upper part.
        carrier: Name of the shell on whose core it sits; None if it does not move with a core.
        build_up: Direction that points up where it is made; None if it is bought.
        height_mm: Its extent along that.
        spread_mm2: Second moment about its centre over its volume, shape (3, 3); None if it is bought.
        volume_mm3: Its volume, if it is made.
        void_share: Volume of the void in it over its own volume.
    """

    name: str
    role: Role
    mass_g: float
    com_mm: Vector
    upper: bool = False
    carrier: str | None = None
    build_up: Vector | None = None
    height_mm: float = 0.0
    spread_mm2: Array | None = None
    volume_mm3: float = 0.0
    void_share: float = 0.0

    @property
    def made(self) -> bool:
        """Whether it shrinks and has the density of the process."""
        return self.build_up is not None


def spread_mm2(mass: MassProperties) -> Array:
    """Second moment about the centre over the volume, `C = tr(I)/2 − I` over V, shape (3, 3)."""
    inertia = np.array(mass.inertia_mm5)
    result: Array = (0.5 * np.trace(inertia) * np.eye(3) - inertia) / mass.volume_mm3
    return result


@dataclass(frozen=True, eq=False)
class Deviations:
    """How n products differ from their design.

    Attributes:
        form_mm: Coefficients of the form error, shape (n, K).
        stretch: Symmetric maps S, shape (n, 3, 3).
        upper_shift_mm: Displacement of the upper part, on top of that of the design, shape (n, 3).
        mass_g: What each part is heavier, shape (n, p).
        place_mm: How its centre of mass is off in its own part, shape (n, p, 3).
        com_mm: What moves the centre of mass of the whole besides, shape (n, 3).
    """

    form_mm: Array
    stretch: Array
    upper_shift_mm: Array
    mass_g: Array
    place_mm: Array
    com_mm: Array


@dataclass(frozen=True, eq=False)
class MassModel:
    """Masses and places as numbers, without solids.

    Attributes:
        mass_g: Masses as designed, shape (p,).
        place_mm: Centres of mass as designed, shape (p, 3).
        made: Which are made, shape (p,).
        upper: Which go with the upper part, shape (p,).
        skin_g_per_mm: Mass that a unit of each coefficient of the form error adds, shape (K,).
        skin_moment_g: Its first moment, shape (K, 3).
        shift_mm: By how much the centre of mass is meant to be elsewhere than the parts put it.
    """

    mass_g: Array
    place_mm: Array
    made: BoolArray
    upper: BoolArray
    skin_g_per_mm: Array
    skin_moment_g: Array
    shift_mm: Vector = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, parts: Sequence[WeighedPart], body: Body, degree: int) -> MassModel:
        """Put parts together.

        Args:
            parts: The parts.
            body: The outer shape, of the material of the shells.
            degree: Highest degree of the form error.
        """
        shells = [part for part in parts if part.role == "shell"]
        density = sum(part.mass_g for part in shells) / sum(part.volume_mm3 for part in shells)
        skin_mm2, moment_mm3 = skin_moments(body, degree)
        return cls(
            mass_g=np.array([part.mass_g for part in parts]),
            place_mm=np.array([part.com_mm for part in parts]),
            made=np.array([part.made for part in parts]),
            upper=np.array([part.upper for part in parts]),
            skin_g_per_mm=density * skin_mm2,
            skin_moment_g=density * moment_mm3,
        )

    def no_deviations(self) -> Deviations:
        """One product that is exactly as designed."""
        parts, coefficients = len(self.mass_g), len(self.skin_g_per_mm)
        return Deviations(
            form_mm=np.zeros((1, coefficients)),
            stretch=np.eye(3)[None],
            upper_shift_mm=np.zeros((1, 3)),
            mass_g=np.zeros((1, parts)),
            place_mm=np.zeros((1, parts, 3)),
            com_mm=np.zeros((1, 3)),
        )

    def com_mm(self, deviations: Deviations) -> Array:
        """Centres of mass of n products as made, shape (n, 3), in the frame of the body.

        The form error counts to first order; everything else is exact. Each row is computed by itself, so
        that it is the same in any batch.
        """
        stretch, growth = deviations.stretch, np.linalg.det(deviations.stretch)[:, None]
        # A scatter of the amount of glue may ask for less than none.
        mass = np.maximum(self.mass_g + deviations.mass_g, 0.0)
        mass[:, self.made] *= growth
        place = (self.place_mm + deviations.place_mm) @ stretch
        place[:, self.upper] += deviations.upper_shift_mm[:, None]
        skin = growth[:, 0] * _row_sums(deviations.form_mm, self.skin_g_per_mm)
        skin_moment = [_row_sums(deviations.form_mm, column) for column in self.skin_moment_g.T]
        moment = (mass[..., None] * place).sum(axis=1)
        moment += growth * (np.stack(skin_moment, axis=1)[:, None] @ stretch)[:, 0]
        com: Array = moment / (mass.sum(axis=1) + skin)[:, None] + deviations.com_mm + self.shift_mm
        return com


def _row_sums(rows: Array, weights: Array) -> Array:
    """Weighted sum of each row, in an order that does not depend on how many rows there are."""
    result: Array = (rows * weights).sum(axis=1)
    return result


def skin_moments(body: Body, degree: int) -> tuple[Array, Array]:
    """Volume `∫ Y dA` and first moment `∫ x Y dA` of a skin as thick as each harmonic of the outward normal.

    The surface element at the direction u is `dA = r² dω / (u·n)`.

    Args:
        body: A strictly convex body.
        degree: Highest degree.

    Returns:
        Shapes (K,) in mm² and (K, 3) in mm³.
    """
    directions, weights = sphere_quadrature(_SKIN_ORDER)
    surface = body.surface(directions)
    facing = np.einsum("nx,nx->n", directions, surface.normal)
    area = weights * np.einsum("nx,nx->n", surface.position_mm, surface.position_mm) / facing
    frame = np.stack(tangent_frame(surface.normal), axis=1)
    weighted = area * harmonic_jets(surface.normal, frame, degree)[0]
    return weighted.sum(axis=1), weighted @ surface.position_mm
