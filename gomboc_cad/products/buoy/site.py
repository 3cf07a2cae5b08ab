"""The vertical over the resting point, along which everything in the buoy is stacked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gomboc_cad.body import Body, depth_mm
from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria import convexity, find_equilibria
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.batteries import Battery
from gomboc_cad.products.buoy.spec import BuoySpec
from gomboc_cad.products.openings.sites import OpeningRequest, PlacedOpening, place_openings
from gomboc_cad.products.placement import RestFrame, cavity_floor_mm
from gomboc_cad.solid.hollow import Cylinder

_AROUND = 36


class BuoySite:
    """What the layout of a buoy starts from; heights are along the vertical, over the body's origin.

    Attributes:
        spec: What is asked for.
        body: The outer shape.
        battery: The battery.
        target_mm: Where the centre of mass is to be, which decides the resting direction.
        frame: Frame of the resting pose.
        stack_mm: The vertical through target and resting point, across the frame.
        seam_mm: Height of the seam.
        below_mm: A height far below the body: bosses start there, as only what is in the cavity counts.
        tube_bore_mm: Inner radius of the tube that holds battery and electronics.
        tube_mm: Its outer radius.
    """

    def __init__(self, spec: BuoySpec, body: Body, battery: Battery, target_mm: Vector) -> None:
        self.spec, self.body, self.battery, self.target_mm = spec, body, battery, target_mm
        down = find_equilibria(body, np.array(target_mm))[0].direction
        self.frame = RestFrame.from_rest(down)
        first, second, _ = self.frame.matrix() @ np.array(target_mm)
        self.stack_mm = float(first), float(second)
        self.seam_mm = spec.split.height_mm
        self.below_mm = -1.5 * body.radius_mm
        self.tube_bore_mm = battery.outline_radius_mm + spec.battery.clearance_mm
        self.tube_mm = self.tube_bore_mm + spec.battery.tube_wall_mm

    def upright(self, low_mm: float, high_mm: float, radius_mm: float, bore_mm: float = 0.0) -> Cylinder:
        """A cylinder or tube along the vertical over the resting point."""
        base = as_vector(self.frame.point(*self.stack_mm, low_mm))
        return Cylinder(base, self.frame.up, radius_mm, high_mm - low_mm, bore_mm)

    def centred(self, low_mm: float, high_mm: float, radius_mm: float, bore_mm: float = 0.0) -> Cylinder:
        """A cylinder or tube along the vertical over the body's origin, where the closure is."""
        base = as_vector(self.frame.point(0.0, 0.0, low_mm))
        return Cylinder(base, self.frame.up, radius_mm, high_mm - low_mm, bore_mm)

    def height_mm(self, point_mm: Vector) -> float:
        """Height of a point."""
        return float(np.dot(self.frame.up, point_mm))

    def beside_mm(self, points_mm: Array) -> Array:
        """Distances of points (n, 3) from the vertical over the resting point, shape (n,)."""
        across = (points_mm @ self.frame.matrix().T)[:, :2] - self.stack_mm
        result: Array = np.linalg.norm(across, axis=1)
        return result

    def room_mm(self, height_mm: float, radius_mm: float) -> float:
        """Least distance from the cavity's wall of a level circle about the vertical, negative beyond it."""
        angle = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
        across = np.array(self.stack_mm) + radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        circle = np.column_stack([across, np.full(_AROUND, height_mm)]) @ self.frame.matrix()
        return float(depth_mm(self.body, circle).min()) - self.spec.shell.wall_mm

    def level_floor_mm(self, radius_mm: float) -> float:
        """Height of a level floor of a radius that is nowhere under the cavity's own floor at its edge."""
        angle = 2.0 * np.pi * np.arange(_AROUND) / _AROUND
        edge = np.array(self.stack_mm) + radius_mm * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        wall = self.spec.shell.wall_mm
        return max(
            cavity_floor_mm(self.body, self.frame, wall, first, second) for first, second in edge.tolist()
        )

    def smallest_radius_mm(self) -> float:
        """Smallest radius of curvature, which bounds how far a rim lies under the middle of its recess."""
        return convexity(self.body).min_radius_of_curvature_mm

    def placed(
        self,
        request: OpeningRequest,
        wall_mm: float,
        keep_out: Sequence[Cylinder] = (),
        others: Sequence[PlacedOpening] = (),
    ) -> PlacedOpening:
        """Place an opening by the drill map."""
        (opening,) = place_openings(
            self.body,
            self.target_mm,
            (request,),
            frame=self.frame,
            wall_mm=wall_mm,
            seam_height_mm=self.seam_mm,
            keep_out=keep_out,
            others=others,
        )
        return opening
