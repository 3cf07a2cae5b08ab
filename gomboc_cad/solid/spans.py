"""B-spline faces of a solid, span by span: smooth fields on them, their derivatives and their bounds.

Between two knots a spline is a polynomial, and what is derived from it and from a smooth body is analytic.
Such a field is held by its values on a Chebyshev grid of each span, which determine it to rounding;
differentiation is a matrix, and the largest value of the interpolating polynomial is bounded through a finer
grid by the theorem of Ehlich and Zeller.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from build123d import Shape
from numpy.polynomial import chebyshev
from OCP.BRep import BRep_Tool
from OCP.Geom import Geom_BSplineSurface
from scipy.interpolate import BSpline

from gomboc_cad.body.sphere import Array, unit

NODES = 12
"""Chebyshev nodes per span and direction: enough for the square of a quintic, whose degree is 10."""

FINER = 4
"""Intervals of the fine grid for each one of the coarse grid."""

OVERSHOOT = 1.0 / np.cos(np.pi / (2 * FINER))
"""How many times its largest value on the fine grid a polynomial through the nodes may reach, per direction.

With x = cos θ a polynomial of degree N is a trigonometric one in θ, and at the distance d from its largest
modulus it still has cos(N d) of it. The fine grid is π/(FINER·N) wide in θ, so d is half of that at most.

Source: Ehlich and Zeller, "Schwankung von Polynomen zwischen Gitterpunkten", Math. Z. 86 (1964).
"""

LEBESGUE = 2.0 / np.pi * np.log(NODES) + 1.0
"""How many times its largest value at the nodes a polynomial through them may reach, per direction.

Source: Trefethen, "Approximation Theory and Approximation Practice" (2013), theorem 15.2.
"""

_SAME_POLE_MM = 1e-9


class _Grid(NamedTuple):
    """Extreme points of Chebyshev polynomials on [−1, 1] and matrices that act on values there."""

    points: Array
    fine_points: Array
    derivative: Array
    refinement: Array
    coefficients: Array


@lru_cache(maxsize=1)
def chebyshev_grid() -> _Grid:
    """The grid that is used in every span, and in both directions."""
    degree = NODES - 1
    points, fine = (-np.cos(np.pi * np.arange(n + 1) / n) for n in (degree, FINER * degree))
    coefficients = np.linalg.inv(np.asarray(chebyshev.chebvander(points, degree), dtype=np.float64))
    slopes = chebyshev.chebvander(points, degree - 1) @ chebyshev.chebder(np.eye(NODES))
    return _Grid(
        points, fine, slopes @ coefficients, chebyshev.chebvander(fine, degree) @ coefficients, coefficients
    )


def refined(values: Array) -> Array:
    """Values on the fine grid of each span: (n, NODES, NODES, …) to (n, m, m, …)."""
    refinement = chebyshev_grid().refinement
    result: Array = np.einsum("ai,bj,nij...->nab...", refinement, refinement, values, optimize=True)
    return result


def truncation(values: Array) -> float:
    """Largest of the last Chebyshev coefficients: an estimate of what the interpolation leaves out."""
    coefficients = chebyshev_grid().coefficients
    series = np.abs(np.einsum("ai,bj,klij...->klab...", coefficients, coefficients, values, optimize=True))
    return float(max(series[:, :, -1].max(), series[:, :, :, -1].max()))


def least_modulus(curves: Array) -> float:
    """Lower bound of the length of vectors along curves that are given on the fine grid, (n, m, 3).

    Between two samples a curve stays within `gap² / 8` times its largest second derivative of the chord.
    """
    grid = chebyshev_grid()
    bend = np.einsum(
        "ai,nix->nax", grid.refinement @ grid.derivative @ grid.derivative, curves[:, ::FINER], optimize=True
    )
    largest = OVERSHOOT * np.linalg.norm(bend, axis=2).max()
    start, chord = curves[:, :-1], np.diff(curves, axis=1)
    foot = np.clip(-_dot(start, chord) / np.maximum(_dot(chord, chord), 1e-300), 0.0, 1.0)
    distance = np.linalg.norm(start + foot[..., None] * chord, axis=2)
    return float((distance - largest * np.diff(grid.fine_points) ** 2 / 8.0).min())


def _dot(first: Array, second: Array) -> Array:
    result: Array = np.einsum("...x,...x->...", first, second)
    return result


@dataclass(frozen=True, eq=False)
class SplineFace:
    """The whole surface under a face: a tensor-product B-spline, however the face is trimmed.

    Attributes:
        knots: Knot vectors of both parameters, with repetitions.
        degrees: Degrees in both parameters.
        poles_mm: Control points, shape (m, n, 3).
    """

    knots: tuple[Array, Array]
    degrees: tuple[int, int]
    poles_mm: Array

    @cached_property
    def breaks(self) -> tuple[Array, Array]:
        """Distinct knots in both parameters."""
        first, second = (np.unique(k) for k in self.knots)
        return first, second

    @property
    def continuity(self) -> int:
        """How many derivatives are continuous over the whole surface."""
        return min(
            degree - int(np.unique(knots[degree + 1 : -degree - 1], return_counts=True)[1].max(initial=0))
            for knots, degree in zip(self.knots, self.degrees, strict=True)
        )

    def nodes_mm(self) -> Array:
        """Points of the surface on the Chebyshev grid of every span, shape (k, l, NODES, NODES, 3)."""
        rows = (self._basis(i, self._parameters(i)) for i in (0, 1))
        return np.einsum("kai,lbj,ijx->klabx", *rows, self.poles_mm, optimize=True)

    def derivatives(self, values: Array) -> tuple[Array, Array]:
        """Differentiate a field on the grid, (k, l, NODES, NODES, …), by the first and second parameter."""
        matrix = chebyshev_grid().derivative
        rows, columns = (2.0 / np.diff(breaks) for breaks in self.breaks)
        grid = values.shape[:4]
        first = matrix @ (rows[:, None, None, None] * values.reshape(*grid[:3], -1))
        second = matrix @ (columns[:, None, None, None] * values.reshape(*grid, -1))
        return first.reshape(values.shape), second.reshape(values.shape)

    def edges(self) -> tuple[Array, Array]:
        """Points and unit normals on the fine grid of every span of the four edges, both (spans, m, 3)."""
        inside = [self._parameters(i, chebyshev_grid().fine_points) for i in (0, 1)]
        ends = [breaks[[0, -1]] for breaks in self.breaks]
        points, normals = [], []
        for subscripts, places in (
            ("kai,bj,ijx->bkax", (inside[0], ends[1])),
            ("bi,kaj,ijx->bkax", (ends[0], inside[1])),
        ):
            position, along, across = (
                np.einsum(
                    subscripts,
                    self._basis(0, places[0], d),
                    self._basis(1, places[1], e),
                    self.poles_mm,
                    optimize=True,
                )
                for d, e in ((0, 0), (1, 0), (0, 1))
            )
            points.append(position.reshape(-1, *position.shape[2:]))
            normals.append(unit(np.cross(along, across)).reshape(points[-1].shape))
        return np.concatenate(points), np.concatenate(normals)

    def same_as(self, other: SplineFace) -> bool:
        """Whether the other surface has the same control points, to 1e-9 mm."""
        return self.poles_mm.shape == other.poles_mm.shape and bool(
            np.allclose(self.poles_mm, other.poles_mm, rtol=0.0, atol=_SAME_POLE_MM)
        )

    def _parameters(self, axis: int, grid: Array | None = None) -> Array:
        """Parameters of a grid on [−1, 1] in every span, shape (spans, n)."""
        breaks = self.breaks[axis]
        places = chebyshev_grid().points if grid is None else grid
        result: Array = breaks[:-1, None] + np.diff(breaks)[:, None] * 0.5 * (places + 1.0)
        return result

    def _basis(self, axis: int, parameters: Array, order: int = 0) -> Array:
        """Basis functions, or a derivative of them, at parameters of any shape."""
        count = self.poles_mm.shape[axis]
        spline = BSpline(self.knots[axis], np.eye(count), self.degrees[axis])
        result: Array = spline(parameters, nu=order)
        return result


def spline_faces(shapes: Iterable[Shape]) -> tuple[SplineFace, ...]:
    """Read the surfaces under the faces of shapes, each surface once.

    Left out is what gomboc-cad does not draw a body with: anything but B-splines, rational ones, and those
    without two continuous derivatives.
    """
    kept: list[SplineFace] = []
    for shape in shapes:
        for face in shape.faces():
            surface = BRep_Tool.Surface_s(face.wrapped)
            if not isinstance(surface, Geom_BSplineSurface) or surface.IsURational() or surface.IsVRational():
                continue
            spline = spline_face(surface)
            if spline.continuity >= 2 and not any(spline.same_as(other) for other in kept):
                kept.append(spline)
    return tuple(kept)


def spline_face(surface: Geom_BSplineSurface) -> SplineFace:
    """Read a B-spline surface; weights are left out."""
    rows, columns = range(1, surface.NbUPoles() + 1), range(1, surface.NbVPoles() + 1)
    poles = np.array([[surface.Pole(i, j).Coord() for j in columns] for i in rows])
    knots = np.array(list(surface.UKnotSequence())), np.array(list(surface.VKnotSequence()))
    return SplineFace(knots, (surface.UDegree(), surface.VDegree()), poles)
