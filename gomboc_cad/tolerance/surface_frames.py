"""The surface of the nominal body as the height of its centre of mass (COM) sees it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.body import Body
from gomboc_cad.body.sphere import Array, unit


@dataclass(frozen=True, eq=False)
class SurfaceFrames:
    """The nominal body at n places, about its nominal COM.

    Attributes:
        position: Surface points in mm, shape (n, 3).
        normal: Outward normals v, shape (n, 3).
        frame: Two tangent vectors, at first the principal directions, shape (n, 2, 3).
        curvature: Shape operator in that frame as components 11, 12, 22, per mm, shape (n, 3).
        height: Height f of the COM, shape (n,).
        slope: ∇f in the frame, shape (n, 2).
    """

    position: Array
    normal: Array
    frame: Array
    curvature: Array
    height: Array
    slope: Array

    @classmethod
    def at(cls, body: Body, directions: Array, com: Array) -> SurfaceFrames:
        """The body at surface parameters w (n, 3)."""
        surface = body.surface(directions)
        arm = surface.position_mm - com
        frame = surface.principal_directions()
        k1, k2 = surface.principal_curvatures_per_mm().T
        return cls(
            surface.position_mm,
            surface.normal,
            frame,
            np.stack([k1, np.zeros_like(k1), k2], axis=1),
            np.einsum("nx,nx->n", arm, surface.normal),
            np.einsum("nax,nx->na", frame, arm),
        )

    def along(self, upward: Array) -> SurfaceFrames:
        """The same with the second tangent vector as near as may be to a vector, shape (3,)."""
        second = unit(upward - (self.normal @ upward)[:, None] * self.normal)
        first = np.cross(second, self.normal)
        frame = np.stack([first, second], axis=1)
        turn = np.einsum("nax,nbx->nab", frame, self.frame)
        shape = turn @ self._matrices() @ turn.transpose(0, 2, 1)
        curvature = np.stack([shape[:, 0, 0], shape[:, 0, 1], shape[:, 1, 1]], axis=1)
        slope = np.einsum("nab,nb->na", turn, self.slope)
        return SurfaceFrames(self.position, self.normal, frame, curvature, self.height, slope)

    @property
    def principal(self) -> Array:
        """Diagonal of the shape operator: κ₁ ≥ κ₂ in the principal frame, shape (n, 2)."""
        return self.curvature[:, [0, 2]]

    def jet(self) -> Array:
        """Slope and Hessian of f as (g₁, g₂, H₁₁, H₁₂, H₂₂), shape (5, n)."""
        k11, k12, k22 = self.curvature.T
        gauss = k11 * k22 - k12 * k12
        return np.stack([*self.slope.T, k22 / gauss - self.height, -k12 / gauss, k11 / gauss - self.height])

    def forms(self) -> tuple[Array, Array]:
        """A and the shape operator as forms in space, each of shape (n, 3, 3)."""
        shape = np.einsum("nax,nab,nby->nxy", self.frame, self._matrices(), self.frame, optimize=True)
        plane = np.einsum("nax,nay->nxy", self.frame, self.frame)
        return plane - self.height[:, None, None] * shape, shape

    def _matrices(self) -> Array:
        result: Array = self.curvature[:, [0, 1, 1, 2]].reshape(-1, 2, 2)
        return result
