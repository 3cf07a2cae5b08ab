"""Eye bolts and screw plugs of the buoy: what recess they need, and their solids."""

from __future__ import annotations

import math
from typing import Annotated

from build123d import Align, Cylinder, Location, Rotation, Solid, Torus
from pydantic import Field

from gomboc_cad.products.toml_model import Number, TomlModel, parse_model, read_toml
from gomboc_cad.resources import template_folder

Size = Annotated[Number, Field(gt=0.0, le=500.0)]

_FILE = "buoy-hardware.toml"
_SUNK_MM = 1.0
"""How far bought parts stay inside the outer surface."""

_UP = (Align.CENTER, Align.CENTER, Align.MIN)
_DOWN = (Align.CENTER, Align.CENTER, Align.MAX)


class EyeBolt(TomlModel):
    """A collar eye bolt to DIN 580.

    Attributes:
        ring_inside_mm: Inner diameter of the ring (d2).
        ring_outside_mm: Outer diameter of the ring (d3).
        collar_mm: Diameter of the collar (d4).
        height_mm: Height over the seat (h).
        thread_length_mm: Length of the thread under the collar (l).
        mass_g: Mass.
        tap_drill_mm: Diameter of the core hole.
    """

    ring_inside_mm: Size
    ring_outside_mm: Size
    collar_mm: Size
    height_mm: Size
    thread_length_mm: Size
    mass_g: Size
    tap_drill_mm: Size

    def recess_depth_mm(self, recess_radius_mm: float, radius_of_curvature_mm: float) -> float:
        """Depth of a recess at its middle that keeps the whole ring under the recess's rim."""
        rim = recess_radius_mm**2 / (2.0 * radius_of_curvature_mm)
        return self.height_mm + _SUNK_MM + 1.5 * rim

    def solid(self) -> Solid:
        """The bolt, its seat at z = 0, the ring downwards; the thread, as wide as its core hole, upwards."""
        wire = 0.25 * (self.ring_outside_mm - self.ring_inside_mm)
        middle = 0.25 * (self.ring_outside_mm + self.ring_inside_mm)
        ring = Torus(middle, wire).moved(
            Location((0.0, 0.0, 0.5 * self.ring_outside_mm - self.height_mm)) * Rotation(90.0, 0.0, 0.0)
        )
        # The collar runs into the ring's wire, but not across its opening.
        neck = self.height_mm - 0.5 * (self.ring_outside_mm + self.ring_inside_mm)
        collar = Cylinder(0.5 * self.collar_mm, neck, align=_DOWN)
        shank = Cylinder(0.5 * self.tap_drill_mm, self.thread_length_mm, align=_UP)
        return (collar + shank + ring).solid()


class ScrewPlug(TomlModel):
    """A screw plug with collar and hexagon socket to DIN 908, and its seal ring to DIN 7603 form A.

    Attributes:
        collar_mm: Diameter of the collar.
        collar_height_mm: Height of the collar.
        thread_length_mm: Length under the collar.
        hexagon_mm: Width across the flats of the socket.
        socket_mm: Depth of the socket.
        tap_drill_mm: Diameter of the core hole.
        seal_mm: Inner and outer diameter and thickness of the seal ring.
    """

    collar_mm: Size
    collar_height_mm: Size
    thread_length_mm: Size
    hexagon_mm: Size
    socket_mm: Size
    tap_drill_mm: Size
    seal_mm: tuple[Size, Size, Size]

    @property
    def recess_radius_mm(self) -> float:
        """Radius of the counterbore, with room for the collar and the seal ring."""
        return 0.5 * max(self.collar_mm, self.seal_mm[1]) + 0.5

    def recess_depth_mm(self, radius_of_curvature_mm: float) -> float:
        """Depth of the counterbore at its middle that keeps the collar under the rim."""
        rim = self.recess_radius_mm**2 / (2.0 * radius_of_curvature_mm)
        return self.seal_mm[2] + self.collar_height_mm + _SUNK_MM + 2.0 * rim

    def solid(self) -> Solid:
        """The plug, the underside of its collar at z = 0; the thread, as wide as its core hole, downwards."""
        collar = Cylinder(0.5 * self.collar_mm, self.collar_height_mm, align=_UP)
        shank = Cylinder(0.5 * self.tap_drill_mm, self.thread_length_mm, align=_DOWN)
        # A round socket of the hexagon's area.
        radius = self.hexagon_mm * math.sqrt(math.sqrt(3.0) / (2.0 * math.pi))
        socket = Cylinder(radius, self.socket_mm, align=_DOWN)
        return (collar + shank - socket.moved(Location((0.0, 0.0, self.collar_height_mm)))).solid()

    def seal_solid(self) -> Solid:
        """The seal ring on z = 0."""
        inner, outer, thickness = self.seal_mm
        ring = Cylinder(0.5 * outer, thickness, align=_UP) - Cylinder(0.5 * inner, 3.0 * thickness)
        return ring.solid()


def load_eye_bolt(thread: str) -> EyeBolt:
    """The eye bolt of a thread: M6, M8 or M10."""
    table = read_toml(template_folder() / _FILE)["eye_bolts"]
    return parse_model(EyeBolt, table[thread], f"{_FILE}, eye bolt {thread}")


def load_screw_plug(thread: str) -> ScrewPlug:
    """The screw plug of a thread, such as G1/8."""
    table = read_toml(template_folder() / _FILE)["screw_plugs"]
    return parse_model(ScrewPlug, table[thread], f"{_FILE}, screw plug {thread}")
