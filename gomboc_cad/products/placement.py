"""Where things go inside the body: the frame of the resting pose, floors, bosses and clearances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from build123d import Location, Plane
from scipy.optimize import brentq

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array, BoolArray
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import SplitSpec


@dataclass(frozen=True)
class RestFrame:
    """The body's frame seen from the table: `up` is opposite to the resting direction.

    Attributes:
        up: Unit vector upwards at rest.
        first: Horizontal unit vector, along which a board's length lies.
        second: Horizontal unit vector, along which its width lies; first × second = up.
    """

    up: Vector
    first: Vector
    second: Vector

    @classmethod
    def from_rest(cls, direction: Vector) -> RestFrame:
        """Make the frame from the direction that points down at rest."""
        # Rounding in the census must not tilt everything by 1e-15.
        up = -np.round(direction, 12)
        up /= np.linalg.norm(up)
        # Of the body's own axes, the one that lies most level gives the length direction.
        seed = np.eye(3)[int(np.argmin(np.abs(np.round(up, 9)) - 1e-6 * np.array([0.0, 2.0, 1.0])))]
        first = seed - (seed @ up) * up
        first /= np.linalg.norm(first)
        second = np.cross(up, first)
        # Adding zero turns a rounded −0.0 into 0.0.
        return cls(as_vector(up + 0.0), as_vector(first + 0.0), as_vector(second + 0.0))

    def matrix(self) -> Array:
        """Rows first, second, up, shape (3, 3)."""
        return np.array([self.first, self.second, self.up])

    def point(self, first: float, second: float, up: float) -> Array:
        """Place in the body's frame of a point given along first, second and up."""
        return np.array([first, second, up]) @ self.matrix()

    def location(self, origin_mm: Array) -> Location:
        """Location at a place of the body's frame, its x along first and its z along up."""
        return Plane(origin=tuple(origin_mm), x_dir=self.first, z_dir=self.up).location


@dataclass(frozen=True)
class Parting:
    """The plane that parts a product, and where the upper part really sits on the lower one.

    Attributes:
        up: Unit vector square to the plane, towards the upper part.
        height_mm: Height of the plane over the body's origin.
        shift_mm: How the seam's step and gap displace the upper part.
    """

    up: Vector
    height_mm: float
    shift_mm: Vector

    @property
    def is_displaced(self) -> bool:
        """Whether the outer surface has a step or a gap."""
        return any(self.shift_mm)

    def above(self, points_mm: Array) -> BoolArray:
        """Which points (n, 3) of the undisplaced body belong to the upper part, shape (n,)."""
        result: BoolArray = points_mm @ np.array(self.up) > self.height_mm
        return result


def parting_of(frame: RestFrame, split: SplitSpec, core_shift_mm: Vector = (0.0, 0.0, 0.0)) -> Parting:
    """The seam of a product that is parted square to its vertical at rest; it goes with the core."""
    height = split.height_mm + float(np.dot(frame.up, core_shift_mm))
    return Parting(frame.up, height, as_vector(frame.point(*split.step_mm, split.gap_mm)))


def cavity_floor_mm(body: Body, frame: RestFrame, wall_mm: float, first: float, second: float) -> float:
    """Height of the cavity's floor at a place, along `up` from the origin.

    The floor is where the distance to the outer surface equals the wall.

    Raises:
        GeometryError: If there is no cavity over that place.
    """

    def spare(height: float) -> float:
        return float(depth_mm(body, frame.point(first, second, height))[0]) - wall_mm

    middle = 0.0
    if spare(middle) <= 0.0:
        raise GeometryError(
            f"There is no cavity over the place ({first:g}, {second:g}) mm from the vertical; use a larger "
            "diameter, a thinner wall or a smaller board."
        )
    lowest = -2.0 * body.radius_mm
    return float(brentq(spare, lowest, middle, xtol=1e-9))


def boss_radius_from_axis_mm(
    body: Body, frame: RestFrame, angle_rad: float, heights_mm: tuple[float, ...], depth_wanted_mm: float
) -> float:
    """Largest distance from the vertical at which a boss axis keeps a depth under the outer surface.

    Args:
        body: The outer body.
        frame: Frame of the resting pose.
        angle_rad: Angle about the vertical.
        heights_mm: Heights along the axis at which the depth must be kept.
        depth_wanted_mm: Least distance of the axis from the outer surface.

    Raises:
        GeometryError: If no place on that side is deep enough.
    """

    def spare(radius: float) -> float:
        across = (radius * np.cos(angle_rad), radius * np.sin(angle_rad))
        places = np.array([frame.point(*across, height) for height in heights_mm])
        return float(depth_mm(body, places).min()) - depth_wanted_mm

    if spare(0.0) <= 0.0:
        raise GeometryError(
            f"A boss that stays {depth_wanted_mm:g} mm under the surface does not fit at the seam; use "
            "shorter pins, a thinner wall or a larger diameter."
        )
    return float(brentq(spare, 0.0, 2.0 * body.radius_mm, xtol=1e-9))
