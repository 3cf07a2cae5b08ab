"""A port for a cable gland: a tapped hole in a boss, its mouth recessed below the outer surface.

A gland that sticks out would be a new rest, so the port is for use on the bench: the gland comes out with its
cable before the part is dropped, and what is left is a recess that the drill map allows, or that is plugged.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.products.imu_housing.spec import CableSpec
from gomboc_cad.products.openings.sites import OpeningRequest, PlacedOpening
from gomboc_cad.solid.hollow import Cylinder

PORT_NAME = "cable port"

_RECESS_MM = 2.0
_RADIAL_ROOM_MM = 0.25
_PLUG_GAP_MM = 0.1
_BREAKTHROUGH_MM = 1.0


@dataclass(frozen=True)
class CablePort:
    """Sizes of a port.

    Attributes:
        major_mm: Nominal diameter of the thread.
        pitch_mm: Its pitch.
        thread_length_mm: Length of thread.
        boss_wall_mm: Material around the thread, whatever the core's shift.
    """

    major_mm: float
    pitch_mm: float
    thread_length_mm: float
    boss_wall_mm: float

    @classmethod
    def of(cls, spec: CableSpec, largest_shift_mm: float) -> CablePort:
        """Sizes for a thread such as `M12x1.5`.

        Args:
            spec: A spec whose thread is not `none`.
            largest_shift_mm: How far the core, and the boss with it, may move past the hole.
        """
        major, pitch = (float(size) for size in spec.thread.removeprefix("M").split("x"))
        return cls(major, pitch, spec.thread_length_mm, spec.boss_wall_mm + largest_shift_mm)

    @property
    def core_hole_mm(self) -> float:
        """Diameter to drill before tapping: major diameter less pitch (ISO 2306)."""
        return self.major_mm - self.pitch_mm

    def request(self, spec: CableSpec) -> OpeningRequest:
        """The recess in the outer surface."""
        return OpeningRequest(
            PORT_NAME,
            0.5 * self.major_mm + _RADIAL_ROOM_MM,
            _RECESS_MM,
            direction=spec.direction,
            plug=spec.plug,
        )

    def boss(self, recess: PlacedOpening) -> Cylinder:
        """Material around the thread, from outside the body to the end of the thread."""
        outside = 2.0 * recess.tool.length_mm
        return self._behind(recess, 0.5 * self.major_mm + self.boss_wall_mm, self.thread_length_mm, outside)

    def core_hole(self, recess: PlacedOpening, largest_shift_mm: float) -> Cylinder:
        """The hole to be tapped, from the recess through the boss or the wall into the cavity.

        Args:
            recess: The recess in its place.
            largest_shift_mm: How far the boss may end beyond the end of the thread.
        """
        depth = self.thread_length_mm + largest_shift_mm + _BREAKTHROUGH_MM
        return self._behind(recess, 0.5 * self.core_hole_mm, depth, 0.5 * _RECESS_MM)

    def plug(self, recess: PlacedOpening) -> Cylinder:
        """What is cut out of the body's own material to close the recess flush."""
        tool = recess.tool
        return Cylinder(tool.base_mm, tool.axis, tool.radius_mm - _PLUG_GAP_MM, tool.length_mm)

    def note(self, spec: CableSpec) -> str:
        """What a user has to do."""
        closed = "glue in the flush plug" if spec.plug else "leave the hole open"
        return (
            f"Tap the cable port {spec.thread}; before the part is dropped, take the cable and its gland out "
            f"and {closed}: a gland that sticks out is another rest, and a cable holds the part."
        )

    def _behind(self, recess: PlacedOpening, radius: float, depth: float, overrun: float) -> Cylinder:
        """A cylinder from a depth below the recess, its axis that of the recess."""
        axis = np.array(recess.tool.direction)
        base = np.array(recess.tool.base_mm) - depth * axis
        return Cylinder(as_vector(base), recess.tool.axis, radius, depth + overrun)
