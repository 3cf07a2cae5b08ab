"""Transfer of the census from the analytic body to the solid that was exported.

The equilibria of a strictly convex body are the critical points, of the same kind, of half the squared
distance from the centre of mass, `D = |x − c|²/2`, on its surface. Let D' be the same of the solid, carried
over to the body's surface along the rays from the origin, and δ = D' − D. On the way from D to D + δ the
critical points of a patch keep their number and kind, unless one becomes degenerate or crosses an edge of
the patch. In the metric of the body `∇D` is ∇h, h the support function about c, and at a principal radius
of curvature ρ the Hessian is `1 − h/ρ = λ/(h + λ)`, λ an eigenvalue of ∇²h. The margin m says
`|∇h|² + λ² ≥ m²` everywhere, so with h ≤ reach nothing changes while

    |∇δ|² + (reach ‖∇²δ‖ / (1 − ‖∇²δ‖))² < (m − |δc|)²,

δc being the difference of the two centres of mass. The half squared distance is compared and not h itself,
because the Hessian of h is a radius of curvature: where the body is almost flat, and nothing can happen, its
deviation is huge.

The patches are joined with a slight kink, where the solid has no Hessian. An equilibrium on a kink of angle
ε, or on the hull over a concave one, needs |∇h| of the order of ε times the largest radius of curvature, so
there the gradient alone is compared.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from build123d import Shape
from scipy.spatial import cKDTree

from gomboc_cad.body import Body
from gomboc_cad.body.catalogue import Status
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria.convexity import as_point, require_strictly_convex
from gomboc_cad.equilibria.records import Convexity
from gomboc_cad.errors import GeometryError
from gomboc_cad.solid.spans import (
    LEBESGUE,
    NODES,
    OVERSHOOT,
    SplineFace,
    least_modulus,
    refined,
    spline_faces,
    truncation,
)

_OUTER = 2e-3
"""A face stands for the outer surface when half of it is nearer than this, in units of R₀."""

_SAME_PLACE = 1e-7
"""Largest gap between two patches along their common edge, in units of R₀."""

_OPEN = (
    "The faces of the solid are not the patches that gomboc-cad draws the whole surface of {name!r} with, so "
    "its equilibria cannot be compared with those of the body; give all parts that carry the outer surface."
)


@dataclass(frozen=True)
class Transfer:
    """Whether the exported solid has the census of the analytic body, and what that rests on.

    Attributes:
        gradient_deviation_mm: Bound on the deviation of the gradient of the height.
        hessian_deviation_mm: Bound on that of its Hessian, as the change of stiffness that it may stand for.
        com_deviation_mm: Distance between the centre of mass of the census and that of the solid.
        bound_mm: What the margin must exceed: the root of the squares of the first two, plus the third.
        margin_mm: How far the centre of mass may move before the census changes.
        min_curvature_per_mm: Lower bound on the principal curvatures of the solid between its kinks.
        seam_kink_deg: Bound on the angle between two patches along their common edge.
        seam_gradient_mm: Lower bound on the gradient of the height along the edges.
        seam_demand_mm: What that has to exceed.
        holds: Whether the solid has the same equilibria.
        reason: One sentence for that, which says what to do if it does not hold.
    """

    gradient_deviation_mm: float
    hessian_deviation_mm: float
    com_deviation_mm: float
    bound_mm: float
    margin_mm: float
    min_curvature_per_mm: float
    seam_kink_deg: float
    seam_gradient_mm: float
    seam_demand_mm: float
    holds: bool
    reason: str


class _Deviation(NamedTuple):
    """Bounds on the deviation of a face: of ∇D in mm, of its Hessian, and of the curvature per mm."""

    gradient_mm: float
    hessian: float
    curvature_per_mm: float


class _Seams(NamedTuple):
    """Bounds along the edges of the patches: on their angle in radians, and from below on |∇h|."""

    kink: float
    gradient_mm: float


def transfer(
    solids: Iterable[Shape],
    body: Body,
    com_mm: Sequence[float] | Array,
    exported_com_mm: Sequence[float] | Array,
    margin_mm: float,
    status: Status = "computed",
) -> Transfer:
    """Compare the outer surface of solids with the analytic body, and the deviation with the margin.

    The whole surfaces under the faces are compared, so the halves of a split body count as the body; what
    holes and planes cut away from it is not looked at.

    Args:
        solids: The solid, or the parts that make up the outer surface, as read back from their files.
        body: The analytic body, strictly convex.
        com_mm: Centre of mass of the census, shape (3,).
        exported_com_mm: Centre of mass of what was exported, shape (3,).
        margin_mm: Radius of the ball about `com_mm` in which the census does not change.
        status: How the census of the body is known.

    Raises:
        GeometryError: If the solids do not hold the patches that close the surface of the body.
        NotConvexError: If the body is not strictly convex.
        CensusError: If a centre of mass is not three finite numbers.
    """
    convexity = require_strictly_convex(body)
    center = as_point(exported_com_mm)
    com_deviation = float(np.linalg.norm(center - as_point(com_mm)))
    faces = [face for face in spline_faces(solids) if _is_outer(face, body)]
    seams = _seams(faces, body, center)
    deviation = _Deviation(*np.max([_deviation(face, body, center) for face in faces], axis=0).tolist())
    reach = max(float(np.linalg.norm(face.poles_mm - center, axis=2).max()) for face in faces)
    # From one half on the quotient exceeds the reach, and so any margin.
    stiffness = reach * deviation.hessian / (1.0 - min(deviation.hessian, 0.5))
    found = Transfer(
        gradient_deviation_mm=deviation.gradient_mm,
        hessian_deviation_mm=stiffness,
        com_deviation_mm=com_deviation,
        bound_mm=math.hypot(deviation.gradient_mm, stiffness) + com_deviation,
        margin_mm=margin_mm,
        min_curvature_per_mm=convexity.min_curvature_per_mm - deviation.curvature_per_mm,
        seam_kink_deg=math.degrees(seams.kink),
        seam_gradient_mm=seams.gradient_mm,
        seam_demand_mm=deviation.gradient_mm + _kink_reach_mm(seams.kink, reach, convexity),
        holds=False,
        reason="",
    )
    obstacle = _obstacle(found, convexity)
    return replace(found, holds=not obstacle, reason=obstacle or _confirmation(found, status))


def _kink_reach_mm(kink: float, reach_mm: float, convexity: Convexity) -> float:
    """Largest |∇h| on an edge of the patches that a kink can turn into an equilibrium.

    On a convex kink the table may tilt by the kink itself. A concave kink is spanned by the hull; along a
    section the surface turns back within the bridge what the kink turned away, so with at most two kinks on
    the way and at least half of the body's least curvature the bridge is no longer than
    `2 · kink / (κ/2)`, and so long ∇h may be, and change from the bridge to the edge at the rate |1 − h κ|.
    """
    bridge = 4.0 * kink / convexity.min_curvature_per_mm
    rate = max(1.0, reach_mm / convexity.min_radius_of_curvature_mm - 1.0)
    return reach_mm * kink + (1.0 + rate) * bridge


def _obstacle(found: Transfer, convexity: Convexity) -> str:
    """Why the census is not shown to carry over; empty if it is."""
    finer = "draw the body with a smaller deviation, which takes finer patches"
    said = "It is not shown that the exported solid has the census of the body: "
    if found.min_curvature_per_mm < 0.5 * convexity.min_curvature_per_mm:
        return (
            f"{said}it may be flatter than half of the body's least curvature of "
            f"{convexity.min_curvature_per_mm:.3g} per mm, or dented; {finer}."
        )
    if found.bound_mm >= found.margin_mm:
        return (
            f"{said}it may deviate by {found.bound_mm:.3g} mm in gradient and stiffness, and the margin is "
            f"{found.margin_mm:.3g} mm; {finer}."
        )
    if found.seam_gradient_mm <= found.seam_demand_mm:
        return (
            f"{said}an equilibrium on or next to an edge between two patches cannot be ruled out: the "
            f"gradient of the height falls to {found.seam_gradient_mm:.3g} mm there and more than "
            f"{found.seam_demand_mm:.3g} mm are needed; {finer}, or move the centre of mass."
        )
    return ""


def _confirmation(found: Transfer, status: Status) -> str:
    inherited = "proof" if status == "proven" else "computed census"
    return (
        f"The exported solid inherits the {inherited}: it deviates from the analytic body by at most "
        f"{found.bound_mm:.2g} mm in gradient and stiffness, and the margin is {found.margin_mm:.3g} mm."
    )


def _is_outer(face: SplineFace, body: Body) -> bool:
    """Whether a face follows the surface of the body, however small bumps it has."""
    points = face.edges()[0].reshape(-1, 3)
    gap = np.linalg.norm(points, axis=1) - body.radius_at(unit(points))
    return bool(np.median(np.abs(gap)) < _OUTER * body.radius_mm)


def _deviation(face: SplineFace, body: Body, center_mm: Array) -> _Deviation:
    """Bound the deviation of a face in the metric of the body's surface y over the same rays.

    With w = ∇δ as a vector in space the covariant Hessian is `δ_ab − y_ab·w`.
    """
    x = face.nodes_mm()
    distance = np.linalg.norm(x, axis=-1)
    rays = x / distance[..., None]
    radius = body.radius_at(rays.reshape(-1, 3)).reshape(distance.shape)
    y = radius[..., None] * rays
    delta = (distance - radius) * (0.5 * (distance + radius) - rays @ center_mm)

    to_frame, tangents, normal, second = _geometry(face, y)
    _, _, own_normal, own_second = _geometry(face, x)
    slope = np.stack(face.derivatives(delta), axis=-1)
    gradient = np.einsum("...ab,...b->...a", to_frame, slope)
    in_space = np.einsum("...a,...ax->...x", gradient, tangents)
    bend = _second_derivatives(face, delta) - np.einsum("...abx,...x->...ab", second, in_space)
    form = np.einsum("...abx,...x->...ab", second, normal)
    own_form = np.einsum("...abx,...x->...ab", own_second, own_normal)

    rest_slope, rest_bend = _left_out(face, to_frame)
    rest = truncation(delta)
    return _Deviation(
        _largest(gradient) + rest_slope * rest,
        _largest(_in_frame(to_frame, bend)) + rest_bend * rest,
        _largest(_in_frame(to_frame, own_form - form)) + rest_bend * truncation(y),
    )


def _geometry(face: SplineFace, points: Array) -> tuple[Array, Array, Array, Array]:
    """Differentiate a surface that is given on the grid.

    Returns:
        The matrix that takes parameter derivatives to an orthonormal tangent frame (…, 2, 2), that frame
        (…, 2, 3), the unit normal (…, 3), and the second derivatives (…, 2, 2, 3).
    """
    first, second = face.derivatives(points)
    length = np.linalg.norm(first, axis=-1)
    cross = np.cross(first, second)
    area = np.linalg.norm(cross, axis=-1)
    # Gram–Schmidt: the second vector less its part along the first.
    to_frame = np.zeros((*length.shape, 2, 2))
    to_frame[..., 0, 0] = 1.0 / length
    to_frame[..., 1, 0] = -np.einsum("...x,...x->...", first, second) / (length * area)
    to_frame[..., 1, 1] = length / area
    tangents = to_frame @ np.stack([first, second], axis=-2)
    return to_frame, tangents, cross / area[..., None], _second_derivatives(face, points)


def _second_derivatives(face: SplineFace, values: Array) -> Array:
    """Second parameter derivatives of a scalar (…, 2, 2) or of a vector (…, 2, 2, 3) on the grid."""
    first, second = face.derivatives(values)
    uu, uv = face.derivatives(first)
    _, vv = face.derivatives(second)
    result: Array = np.stack([np.stack([uu, uv], axis=4), np.stack([uv, vv], axis=4)], axis=4)
    return result


def _in_frame(to_frame: Array, form: Array) -> Array:
    result: Array = to_frame @ form @ to_frame.swapaxes(-1, -2)
    return result


def _largest(field: Array) -> float:
    """Upper bound of the length of a vector field or of the norm of a symmetric one."""
    coarse = _size(field).max(axis=(2, 3))
    # Elsewhere even the interpolating polynomial stays below the largest value at a node.
    contenders = coarse * LEBESGUE**2 >= coarse.max()
    return float(OVERSHOOT**2 * _size(refined(field[contenders])).max())


def _size(field: Array) -> Array:
    """Length of vectors (…, 2), or spectral norm of symmetric matrices (…, 2, 2), on the grid of spans."""
    if field.shape[-2:] != (2, 2):
        length: Array = np.linalg.norm(field, axis=-1)
        return length
    mean, half = 0.5 * (field[..., 0, 0] + field[..., 1, 1]), 0.5 * (field[..., 0, 0] - field[..., 1, 1])
    norm: Array = np.abs(mean) + np.hypot(half, field[..., 0, 1])
    return norm


def _left_out(face: SplineFace, to_frame: Array) -> tuple[float, float]:
    """How much of a truncated series' last coefficient its gradient and Hessian may show.

    By the Markov inequality: |T'| ≤ N² and |T''| ≤ N² (N² − 1)/3 on [−1, 1].
    """
    per_mm = max(2.0 / np.diff(b).min() for b in face.breaks) * np.linalg.norm(to_frame, axis=(-2, -1)).max()
    square = float(NODES - 1) ** 2
    return float(per_mm * square), float(per_mm**2 * square * (square - 1.0) / 3.0)


def _seams(faces: Sequence[SplineFace], body: Body, center_mm: Array) -> _Seams:
    """Match the edges of the patches with each other and measure along them.

    Raises:
        GeometryError: If an edge has no partner, so that the patches do not close.
    """
    if not faces:
        raise GeometryError(_OPEN.format(name=body.name))
    edges = [face.edges() for face in faces]
    points, normals = (np.concatenate(arrays) for arrays in zip(*edges, strict=True))
    owner = np.repeat(np.arange(len(faces)), [pts.shape[0] * pts.shape[1] for pts, _ in edges])
    pairs = cKDTree(points.reshape(-1, 3)).query_pairs(_SAME_PLACE * body.radius_mm, output_type="ndarray")
    pairs = pairs[owner[pairs[:, 0]] != owner[pairs[:, 1]]]
    if len(np.unique(pairs)) < len(owner):
        raise GeometryError(_OPEN.format(name=body.name))
    outwards = normals * np.sign(np.einsum("kmx,kmx->km", points, normals))[..., None]
    first, second = (outwards.reshape(-1, 3)[column] for column in pairs.T)
    kink = 2.0 * np.arcsin(0.5 * np.linalg.norm(first - second, axis=1).max())

    here = body.surface(unit(points.reshape(-1, 3)))
    arm = here.position_mm - center_mm
    across = arm - np.einsum("nx,nx->n", arm, here.normal)[:, None] * here.normal
    return _Seams(float(OVERSHOOT * kink), least_modulus(across.reshape(points.shape)))
