"""The potential energy of a floating part over its orientation, with its exact derivatives.

At heave equilibrium the energy of part and water is the weight times the height of the COM over the centre
of buoyancy, `E(u) = (c − b(u))·u` with u pointing up. The centres of buoyancy form a convex surface whose
tangent plane is parallel to the waterplane and whose principal radii of curvature are those of
Bouguer's metacentres, `BM = J / V` (Dupin's theorems; Bouguer, Traité du navire, 1746), so

    ∇E = (c − b)_T        the righting arm,
    ∇²E = J / V − E I     the metacentric heights.

Hence floating on water is resting on a table with the surface of buoyancy for an outer surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, geodesic_triangulation, lengths, unit
from gomboc_cad.equilibria.records import Kind
from gomboc_cad.hydrostatics.immersion import Immersion, immerse
from gomboc_cad.hydrostatics.surface import WettedSurface

# A generic orientation keeps the samples off the symmetry planes of the part.
_TURN = np.linalg.qr(np.array([[0.61, -0.35, 0.71], [0.23, 0.93, 0.29], [-0.76, 0.02, 0.64]]))[0]

_NEWTON_STEPS = 20
_CONVERGED = 1e-10
_SETTLED = 1e-7
_STRAY = 4.0
"""A Newton run that ends farther from its start, in units of its longest step, belongs to another place."""


class EnergyJet(NamedTuple):
    """Energy per weight in mm (k,), its gradient (k, 2) and Hessian (k, 2, 2) in the waterplane's axes."""

    height_mm: Array
    gradient_mm: Array
    hessian_mm: Array
    immersion: Immersion

    def rows(self, chosen: BoolArray) -> EnergyJet:
        """The same at some of the orientations only."""
        immersion = Immersion(*(field[chosen] for field in self.immersion))
        return EnergyJet(self.height_mm[chosen], self.gradient_mm[chosen], self.hessian_mm[chosen], immersion)


@dataclass(frozen=True, eq=False)
class FloatingLandscape:
    """The energy over the sphere of body directions that point up.

    Attributes:
        surface: The outer surface.
        com_mm: Centre of mass, less the pivot of the surface, shape (3,).
        volume_mm3: Displaced volume.
    """

    surface: WettedSurface
    com_mm: Array
    volume_mm3: float

    def jet(self, ups: Array, guess_mm: Array | None = None) -> EnergyJet:
        """Energy and derivatives at unit directions (k, 3); levels of the waterplane (k,) may be guessed."""
        at = immerse(self.surface, ups, self.volume_mm3, guess_mm)
        arm = self.com_mm - at.buoyancy_mm
        height = np.einsum("kx,kx->k", arm, ups)
        gradient = np.einsum("kax,kx->ka", at.frame, arm)
        hessian = at.second_mm4 / self.volume_mm3
        hessian[:, [0, 1], [0, 1]] -= height[:, None]
        return EnergyJet(height, gradient, hessian, at)


class Samples(NamedTuple):
    """The landscape on a geodesic triangulation.

    Attributes:
        ups: Directions, shape (n, 3).
        triangles: Shape (t, 3).
        jet: Energy and derivatives there.
    """

    ups: Array
    triangles: IntArray
    jet: EnergyJet


def sample(landscape: FloatingLandscape, level: int) -> Samples:
    """Compute the landscape on an icosahedron that is subdivided `level` times.

    The coarser levels come first: to first order a waterplane turns about its centroid (Euler), which
    predicts the next ones.
    """
    vertices, triangles = geodesic_triangulation(level)
    ups = vertices @ _TURN.T
    known = 12
    jets = [landscape.jet(ups[:known])]
    flotation = jets[0].immersion.flotation_mm
    while known < len(ups):
        fresh = ups[known : 4 * known - 6]
        nearest = cKDTree(ups[:known]).query(fresh)[1]
        jets.append(landscape.jet(fresh, np.einsum("kx,kx->k", flotation[nearest], fresh)))
        flotation = np.concatenate([flotation, jets[-1].immersion.flotation_mm])
        known += len(fresh)
    height, gradient, hessian = (np.concatenate([jet[k] for jet in jets]) for k in range(3))
    immersion = Immersion(
        *(np.concatenate(field) for field in zip(*(j.immersion for j in jets), strict=True))
    )
    return Samples(ups, triangles, EnergyJet(height, gradient, hessian, immersion))


def newton_steps(jet: EnergyJet, softest: float = 0.0) -> Array:
    """Newton steps to the critical points, shape (k, 2), along axes that are not too soft.

    Args:
        jet: Energy and derivatives.
        softest: Smaller eigenvalue over larger one, in modulus, up to which an axis is left out.
    """
    values, vectors = np.linalg.eigh(jet.hessian_mm)
    size = np.abs(values)
    usable = size > np.maximum(softest * size.max(axis=1, keepdims=True), 1e-300)
    slopes = np.einsum("kab,ka->kb", vectors, jet.gradient_mm)
    along = np.where(usable, -slopes / np.where(usable, values, 1.0), 0.0)
    result: Array = np.einsum("kab,kb->ka", vectors, along)
    return result


def refine(
    landscape: FloatingLandscape, starts: Array, reach: float, softest: float = 0.0
) -> tuple[Array, BoolArray]:
    """Follow Newton's method on the exact energy.

    Args:
        landscape: The landscape.
        starts: Unit directions, shape (k, 3).
        reach: Longest step in radians.
        softest: As in `newton_steps`.

    Returns:
        Where the runs end, shape (k, 3), and which of them settled near their starts.
    """
    ups = starts.copy()
    size = np.full(len(ups), np.inf)
    guess = np.full(len(ups), np.nan)
    active = np.arange(len(ups))
    for _ in range(_NEWTON_STEPS):
        if not len(active):
            break
        jet = landscape.jet(ups[active], guess[active])
        step = newton_steps(jet, softest)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, reach / np.maximum(length, 1e-300))[:, None]
        ups[active] = unit(ups[active] + np.einsum("ka,kax->kx", step, jet.immersion.frame))
        guess[active] = np.einsum("kx,kx->k", jet.immersion.flotation_mm, ups[active])
        size[active] = length
        strayed = lengths(ups[active] - starts[active]) > _STRAY * reach
        active = active[(length > _CONVERGED) & ~strayed]
    settled: BoolArray = (size < _SETTLED) & (lengths(ups - starts) <= _STRAY * reach)
    return ups, settled


def kinds(jet: EnergyJet) -> list[Kind]:
    """Type critical points by their Hessians."""
    values = np.linalg.eigvalsh(jet.hessian_mm)
    names: list[Kind] = ["unstable", "saddle", "stable"]
    return [names[count] for count in (values > 0.0).sum(axis=1).tolist()]
