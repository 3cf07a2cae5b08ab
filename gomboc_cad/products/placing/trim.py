"""Trim: standard masses in drilled holes, and pockets, that help to place the centre of mass."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from bd_warehouse.fastener import SetScrew
from build123d import Cylinder as CylinderSolid
from build123d import Plane, RegularPolygon, Solid, extrude

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.errors import SpecError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.common_spec import TrimSpec
from gomboc_cad.products.materials import load_material
from gomboc_cad.solid.hollow import Cylinder

# fmt: off
BALL_DIAMETERS_MM = (
    1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5, 6.0, 6.5, 7.0, 7.5, 8.0, 8.5, 9.0, 10.0, 11.0, 12.0,
    13.0, 14.0, 15.0, 16.0, 17.0, 18.0, 20.0, 22.0, 24.0, 25.0, 26.0, 28.0, 30.0, 35.0, 40.0, 45.0, 50.0,
    60.0,
)
# fmt: on
"""Nominal diameters in mm of ISO 3290-1 and DIN 5401, without those of the inch series."""

_PITCH_DIAMETER = 0.75 * math.sqrt(3.0) / 2.0
"""Basic pitch diameter of an ISO thread: d₂ = d − 2·(3/8)·H with H = (√3/2)·P (ISO 68-1, ISO 724)."""

_GRADE = 1.2
"""Ratio of the volumes of set screws from one grade to the next."""

_COLOR = (0.45, 0.47, 0.50)


@dataclass(frozen=True)
class TrimSite:
    """A place for a trim mass or a pocket: a straight hole that is drilled only if it is used.

    The hole ends where the mass in it ends: a ball is pressed and a set screw turned in to the bottom, and
    the depth is free up to the length of the site. A pocket is as deep as it has to be.

    Attributes:
        name: What reports call it.
        base_mm: Middle of the mouth; of a site that moves with the core, before the core's shift.
        axis: From the mouth into the material.
        length_mm: Greatest depth of the hole.
        max_diameter_mm: Its greatest diameter.
        moves_with_core: Whether it is part of the core.
        solid: Whether the shell's material is there, so that a hole takes mass away; if not, the site is a
            space that is empty already.
    """

    name: str
    base_mm: Vector
    axis: Vector
    length_mm: float
    max_diameter_mm: float
    moves_with_core: bool = True
    solid: bool = True

    @property
    def direction(self) -> Array:
        """Unit vector along the axis, shape (3,)."""
        axis = np.array(self.axis, dtype=float)
        result: Array = axis / np.linalg.norm(axis)
        return result


@dataclass(frozen=True)
class TrimItem:
    """A standard mass that fits in a hole.

    Attributes:
        kind: What it is.
        standard: Standard and size.
        diameter_mm: Diameter of the hole it fills; of a thread the pitch diameter, at which its ridges and
            grooves are of equal volume.
        length_mm: Length along the hole.
        socket_mm: Width across flats and depth of a set screw's socket; zero for a ball.
        volume_mm3: Volume.
        com_below_middle_mm: Distance of the centre of mass from the middle, away from the mouth.
    """

    kind: str
    standard: str
    diameter_mm: float
    length_mm: float
    socket_mm: tuple[float, float]
    volume_mm3: float
    com_below_middle_mm: float

    def solid(self) -> Solid:
        """The mass with its middle at the origin, its mouth's side towards −z."""
        radius = 0.5 * self.diameter_mm
        if self.kind == "ball":
            return Solid.make_sphere(radius)
        across_flats, depth = self.socket_mm
        hexagon = Plane.XY.offset(-0.5 * self.length_mm) * RegularPolygon(
            0.5 * across_flats, 6, major_radius=False
        )
        return (CylinderSolid(radius, self.length_mm) - extrude(hexagon, depth, dir=(0.0, 0.0, 1.0))).solid()


@dataclass(frozen=True)
class PlacedTrim:
    """A trim mass, or a pocket, in its place.

    Attributes:
        site: Where it is.
        name: Name of the part; of a pocket, what the report calls it.
        item: The standard mass; None for a pocket.
        standard: Standard and size; empty for a pocket.
        material: Material of the mass, as in `materials.toml`; empty for a pocket.
        mass_g: Mass, without the hole; negative for a pocket.
        position_mm: Centre of mass in the body's frame, after the core's shift.
        middle_mm: Middle of its length.
        diameter_mm: Diameter of the hole.
        length_mm: Length of the mass along the hole; depth of a pocket.
        depth_mm: From the mouth of the hole to the nearer end of the mass; zero for a pocket.
    """

    site: TrimSite
    name: str
    item: TrimItem | None
    standard: str
    material: str
    mass_g: float
    position_mm: Vector
    middle_mm: Vector
    diameter_mm: float
    length_mm: float
    depth_mm: float

    @property
    def hole(self) -> Cylinder:
        """The hole it needs; of a site that moves with the core, before the core's shift."""
        length = self.depth_mm + self.length_mm
        return Cylinder(self.site.base_mm, self.site.axis, 0.5 * self.diameter_mm, length)


def trim_items(spec: TrimSpec, site: TrimSite) -> tuple[TrimItem, ...]:
    """The standard masses that fit a site, graded by volume; none where none fits, and for pockets.

    Args:
        spec: What kind of trim is wanted, and up to which size.
        site: The site.
    """
    limit = min(spec.max_diameter_mm, site.max_diameter_mm)
    if spec.kind == "balls":
        fitting = [d for d in BALL_DIAMETERS_MM if d <= min(limit, site.length_mm)]
        return tuple(ball(diameter) for diameter in fitting)
    if spec.kind == "set-screws":
        screws = [
            set_screw(size, length)
            for size in SetScrew.sizes("iso4026")
            if thread_mm(size)[0] <= limit
            for length in set_screw_lengths_mm(size)
            if length <= site.length_mm
        ]
        return _graded(screws)
    return ()


def _graded(items: list[TrimItem]) -> tuple[TrimItem, ...]:
    """Of items of nearly the same volume only the shortest, which leaves the most way to shift it."""
    grade = {item: round(math.log(item.volume_mm3) / math.log(_GRADE)) for item in items}
    shortest: dict[int, TrimItem] = {}
    for item in sorted(items, key=lambda item: (item.length_mm, -item.volume_mm3)):
        shortest.setdefault(grade[item], item)
    return tuple(shortest[key] for key in sorted(shortest))


def ball(diameter_mm: float) -> TrimItem:
    """A ball of ISO 3290-1."""
    volume = math.pi * diameter_mm**3 / 6.0
    standard = f"ISO 3290-1 ball {diameter_mm:g}"
    return TrimItem("ball", standard, diameter_mm, diameter_mm, (0.0, 0.0), volume, 0.0)


def set_screw(size: str, length_mm: float) -> TrimItem:
    """A hexagon socket set screw with flat point of ISO 4026.

    Args:
        size: Thread in bd_warehouse's spelling, as `M5-0.8`.
        length_mm: A length of the standard.

    Raises:
        SpecError: If the standard has no such screw.
    """
    if size not in SetScrew.sizes("iso4026") or length_mm not in set_screw_lengths_mm(size):
        raise SpecError(f"ISO 4026 has no set screw {size} x {length_mm:g}; choose another size.")
    major, pitch = thread_mm(size)
    diameter = major - _PITCH_DIAMETER * pitch
    data = SetScrew.fastener_data[size]
    across_flats, depth = float(data["iso4026:s"]), float(data["iso4026:t"])
    socket = 0.5 * math.sqrt(3.0) * across_flats**2 * depth
    volume = 0.25 * math.pi * diameter**2 * length_mm - socket
    below = socket * 0.5 * (length_mm - depth) / volume
    standard = f"ISO 4026 M{major:g} x {length_mm:g}"
    return TrimItem("screw", standard, diameter, length_mm, (across_flats, depth), volume, below)


def thread_mm(size: str) -> tuple[float, float]:
    """Nominal diameter and pitch of a thread in bd_warehouse's spelling, as `M5-0.8`."""
    major, pitch = size.removeprefix("M").split("-")
    return float(major), float(pitch)


def set_screw_lengths_mm(size: str) -> tuple[float, ...]:
    """Lengths that ISO 4026 gives for a thread, from bd_warehouse's tables."""
    data = SetScrew.fastener_data[size]
    low, high = float(data["iso4026:short"]), float(data["iso4026:long"])
    return tuple(float(x) for x in SetScrew.nominal_length_range["iso4026"] if low <= x <= high)


def trim_parts(trims: Iterable[PlacedTrim]) -> tuple[Part, ...]:
    """Placed masses as bought parts; pockets are passed over."""
    parts = []
    for trim in trims:
        if trim.item is not None:
            plane = Plane(origin=trim.middle_mm, z_dir=as_vector(trim.site.direction))
            solid = trim.item.solid().moved(plane.location)
            material = load_material(trim.material)
            parts.append(Part.homogeneous(trim.name, solid, material, _COLOR, trim.standard))
    return tuple(parts)
