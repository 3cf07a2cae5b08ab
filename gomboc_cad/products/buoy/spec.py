"""The typed spec of the buoy."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from gomboc_cad.products.closures.spec import ClosureSpec, ScrewsSpec
from gomboc_cad.products.common_spec import Direction, ProductSpec, SplitSpec
from gomboc_cad.products.toml_model import Coordinate, Number, Text, TomlModel

Length = Annotated[Number, Field(gt=0.0, le=2000.0)]
Gap = Annotated[Number, Field(ge=0.0, le=100.0)]
Mass = Annotated[Number, Field(ge=0.0, le=1e6)]

_SMALLEST_MM, _LARGEST_MM = 300.0, 1000.0


class WaterSpec(TomlModel):
    """What the buoy floats in.

    Attributes:
        kind: `sea`: 1.025 g/cm³; `fresh`: 0.9982 g/cm³ at 20 °C; `other`: of the density that is given.
        density_g_cm3: Density of other water.
    """

    kind: Literal["sea", "fresh", "other"] = "sea"
    density_g_cm3: Annotated[Number, Field(ge=0.5, le=2.0)] | None = None

    @model_validator(mode="after")
    def _known(self) -> WaterSpec:
        if (self.kind == "other") != (self.density_g_cm3 is not None):
            raise ValueError('density_g_cm3 goes with kind = "other", and only with it')
        return self


class FlangeSpec(TomlModel):
    """The ring of material inside the shell at the seam, and the O-ring in its lower face.

    Attributes:
        thickness_mm: Thickness on each side of the seam.
        land_mm: Least material on both sides of the groove.
        cross_section_mm: Thickness of the O-ring, one of ISO 3601-1.
        inside_diameter_mm: Inside diameter of the O-ring; `auto`: the largest of ISO 3601-1 that fits, or a
            ring vulcanised from cord where the standard ends.
        material: Material of the O-ring.
    """

    thickness_mm: Length = 10.0
    land_mm: Length = 3.0
    cross_section_mm: Annotated[Number, Field(ge=1.0, le=12.0)] = 5.33
    inside_diameter_mm: Literal["auto"] | Length = "auto"
    material: Text = "NBR"


class MooringSpec(TomlModel):
    """An eye bolt in a blind recess at the resting point; it does not open the cavity.

    Attributes:
        eye: Thread of an eye bolt to DIN 580, or `none`.
        material: Its material.
        recess_diameter_mm: Diameter of the recess; room beside the eye for a rope or a shackle.
        wall_mm: Material around and above the recess.
    """

    eye: Literal["M6", "M8", "M10", "none"] = "M8"
    material: Text = "stainless"
    recess_diameter_mm: Length = 56.0
    wall_mm: Length = 6.0


class PortSpec(TomlModel):
    """A filling and venting port: a screw plug to DIN 908 with a seal ring, sunk below the surface.

    Attributes:
        plug: Thread of the plug, or `none`.
        material: Material of the plug.
        direction: Where it goes: `auto`, where the drill map leaves most to spare, or a direction.
        side: Which part it is in.
        wall_mm: Material around its counterbore and thread.
    """

    plug: Literal["G1/8", "M10x1", "M16x1.5", "M20x1.5", "none"] = "G1/8"
    material: Text = "stainless"
    direction: Direction = "auto"
    side: Literal["lower", "upper", "any"] = "upper"
    wall_mm: Length = 5.0


class BatterySpec(TomlModel):
    """The battery, on the vertical over the mooring and the ballast.

    Attributes:
        type: Name of a battery template or path of a user's own file.
        clearance_mm: Gap around it in its tube.
        tube_wall_mm: Wall of the tube that holds battery and electronics.
    """

    type: Text = "sla-12v-7ah"
    clearance_mm: Gap = 1.0
    tube_wall_mm: Length = 3.0


class ElectronicsSpec(TomlModel):
    """The electronics bay: a round chassis in the tube, on the battery.

    Attributes:
        height_mm: Height of the bay.
        gap_mm: Height left free between battery and bay, for terminals and cables.
        mass_g: Mass of all that is in it.
        mass_tolerance_g: How far that may be off.
        com_mm: Its centre of mass from the middle of the bay, along first, second and up.
        com_tolerance_mm: How far that may be off along each axis.
    """

    height_mm: Length = 40.0
    gap_mm: Gap = 10.0
    mass_g: Mass = 450.0
    mass_tolerance_g: Mass = 20.0
    com_mm: tuple[Coordinate, Coordinate, Coordinate] = (0.0, 0.0, 0.0)
    com_tolerance_mm: Gap = 2.0


class BallastSpec(TomlModel):
    """A turned ring in the bay around the mooring's boss, bonded in.

    Attributes:
        mass_g: Its mass; `auto`: what brings the centre of mass to its target with the cavity where it is.
        mass_tolerance_g: How far the mass may be off.
        material: Its material.
        outer_diameter_mm: Its outer diameter.
        bay_height_mm: Least height of the bay; where the mooring's boss is taller, it is as tall as that.
        clearance_mm: Gap on both sides.
        wall_mm: Wall of the bay.
    """

    mass_g: Literal["auto"] | Mass = "auto"
    mass_tolerance_g: Mass = 5.0
    material: Text = "steel"
    outer_diameter_mm: Length = 120.0
    bay_height_mm: Length = 20.0
    clearance_mm: Gap = 0.5
    wall_mm: Length = 3.0


class BuoySpec(ProductSpec):
    """A two-part buoy that rights itself on a flat floor, with a verdict of its own on how it floats."""

    product: Literal["buoy"]
    split: SplitSpec = SplitSpec()
    closure: ClosureSpec = ScrewsSpec(kind="screws", count=6, screw="M5-0.8", insert="M5-0.8-9.5")
    water: WaterSpec = WaterSpec()
    flange: FlangeSpec = FlangeSpec()
    mooring: MooringSpec = MooringSpec()
    port: PortSpec = PortSpec()
    battery: BatterySpec = BatterySpec()
    electronics: ElectronicsSpec = ElectronicsSpec()
    ballast: BallastSpec = BallastSpec()

    @model_validator(mode="after")
    def _in_range(self) -> BuoySpec:
        if not _SMALLEST_MM <= self.body.diameter_mm <= _LARGEST_MM:
            raise ValueError(
                f"body.diameter_mm = {self.body.diameter_mm:g} is no size of a buoy "
                f"(allowed: from {_SMALLEST_MM:g} to {_LARGEST_MM:g})"
            )
        return self
