"""Signs that are right: floating point where it is sure, exact rational arithmetic where it is not.

Two signs decide every equilibrium of a polyhedron about a COM c. Both are polynomials in the
coordinates, so rational arithmetic gives them exactly. An exact zero is a tie; it is broken as if the
COM were moved by an infinitesimal in a fixed direction (simulation of simplicity, Edelsbrunner and
Mücke, ACM Trans. Graphics 9 (1990) 66), the same for all ties, so that the counts stay those of a real body.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from gomboc_cad.body.sphere import Array, BoolArray, IntArray, cross, lengths

Triple = tuple[Fraction, Fraction, Fraction]

_EPSILON = 2.0**-52
_SAFETY = 32.0
_NUDGES = (
    (Fraction(61, 97), Fraction(-53, 89), Fraction(47, 101)),
    (Fraction(-31, 83), Fraction(43, 79), Fraction(59, 73)),
    (Fraction(37, 71), Fraction(41, 67), Fraction(-29, 61)),
)
"""Directions of the infinitesimal move, the later ones for ties of the earlier; linearly independent."""


class Signs(NamedTuple):
    """Signs of an expression, ties broken.

    Attributes:
        positive: Whether each is positive, shape (n,).
        tied: Whether each was exactly zero before ties were broken.
    """

    positive: BoolArray
    tied: BoolArray


def foot_ahead_of_end(points: Array, com: Array, end: IntArray, other: IntArray) -> Signs:
    """Whether the foot of the perpendicular from c on the line of an edge lies on the inner side of an end.

    The sign of `(c − a)·(b − a)`, a the end and b the other one.

    Args:
        points: Shape (n, 3).
        com: Shape (3,).
        end: Indices of a, shape (m,).
        other: Indices of b.
    """
    along, arm = points[other] - points[end], com - points[end]
    value = np.einsum("nx,nx->n", along, arm)
    size = lengths(along) * lengths(arm)
    coordinate = float(max(np.abs(points).max(), np.abs(com).max()))
    error = _SAFETY * _EPSILON * (size + coordinate * (lengths(along) + lengths(arm)))

    def exact(i: int, center: Triple) -> Fraction:
        a, b = _exact(points[end[i]]), _exact(points[other[i]])
        return _dot(_minus(b, a), _minus(center, a))

    def slope(i: int, direction: Triple) -> Fraction:
        return _dot(_minus(_exact(points[other[i]]), _exact(points[end[i]])), direction)

    return _decide(value, error, com, exact, slope)


def foot_inside_of_edge(
    points: Array, com: Array, corners: IntArray, face: IntArray, start: IntArray, end: IntArray
) -> Signs:
    """Whether the foot of the perpendicular from c on the plane of a face lies on the inner side of an edge.

    The sign of `det(N, b − a, c − a)`, N the normal of the face from three of its corners, and a, b
    the ends of the edge, counter-clockwise around the face.

    Args:
        points: Shape (n, 3).
        com: Shape (3,).
        corners: Indices of three corners of each face, counter-clockwise, shape (f, 3).
        face: Index of the face of each edge, shape (m,).
        start: Indices of a, shape (m,).
        end: Indices of b.
    """
    p, q, r = (points[corners[:, k]] for k in range(3))
    one, two = q - p, r - p
    normal, sides = cross(one, two), lengths(one) + lengths(two)
    size = (lengths(one) * lengths(two))[face]
    along, arm = points[end] - points[start], com - points[start]
    value = np.einsum("nx,nx->n", normal[face], cross(along, arm))
    coordinate = float(max(np.abs(points).max(), np.abs(com).max()))
    width, reach = lengths(along), lengths(arm)
    rounding = width * reach * sides[face] + size * (width + reach)
    error = _SAFETY * _EPSILON * (size * width * reach + coordinate * rounding)

    def inward(i: int) -> tuple[Triple, Triple]:
        p, q, r = (_exact(points[k]) for k in corners[face[i]])
        a, b = _exact(points[start[i]]), _exact(points[end[i]])
        return a, _cross(_cross(_minus(q, p), _minus(r, p)), _minus(b, a))

    def exact(i: int, center: Triple) -> Fraction:
        a, across = inward(i)
        return _dot(across, _minus(center, a))

    def slope(i: int, direction: Triple) -> Fraction:
        return _dot(inward(i)[1], direction)

    return _decide(value, error, com, exact, slope)


def _decide(
    value: Array,
    error: Array,
    com: Array,
    exact: Callable[[int, Triple], Fraction],
    slope: Callable[[int, Triple], Fraction],
) -> Signs:
    """Keep the signs that rounding cannot have changed and compute the others exactly."""
    positive, tied = value > 0.0, np.zeros(len(value), dtype=bool)
    center = _exact(com)
    for i in np.flatnonzero(~(np.abs(value) > error)).tolist():
        true = exact(i, center)
        tied[i] = true == 0
        if tied[i]:
            true = next((s for s in (slope(i, nudge) for nudge in _NUDGES) if s != 0), Fraction(1))
        positive[i] = true > 0
    return Signs(positive, tied)


def _exact(point: Array) -> Triple:
    x, y, z = (Fraction(float(c)) for c in point)
    return x, y, z


def _minus(a: Triple, b: Triple) -> Triple:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _dot(a: Triple, b: Triple) -> Fraction:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Triple, b: Triple) -> Triple:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
