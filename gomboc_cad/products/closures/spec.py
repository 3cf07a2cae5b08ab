"""What a spec may say about how the two parts are closed."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from gomboc_cad.products.toml_model import Count, Number, Text, TomlModel

Length = Annotated[Number, Field(gt=0.0, le=1000.0)]
Wall = Annotated[Number, Field(ge=0.2, le=50.0)]
Angle = Annotated[Number, Field(ge=-360.0, le=360.0)]


class DowelsSpec(TomlModel):
    """Parallel pins across the seam, pressed or glued in bosses; the outer surface stays whole.

    Attributes:
        kind: `dowels`.
        count: Number of pins, evenly around the vertical.
        diameter_mm: Pin diameter.
        length_mm: Pin length, half in each part.
        boss_wall_mm: Material around the hole.
        end_gap_mm: Free length at each end of a pin.
        angle_deg: Angle of the first pin about the vertical.
        material: Material of the pins.
    """

    kind: Literal["dowels"] = "dowels"
    count: Annotated[Count, Field(ge=2, le=8)] = 3
    diameter_mm: Annotated[Number, Field(gt=0.0, le=20.0)] = 3.0
    length_mm: Annotated[Number, Field(gt=0.0, le=100.0)] = 12.0
    boss_wall_mm: Annotated[Number, Field(ge=0.5, le=20.0)] = 2.0
    end_gap_mm: Annotated[Number, Field(ge=0.0, le=5.0)] = 0.5
    angle_deg: Angle = 0.0
    material: Text = "steel"

    @property
    def boss_radius_mm(self) -> float:
        """Radius of the boss around a pin."""
        return 0.5 * self.diameter_mm + self.boss_wall_mm

    @property
    def half_hole_mm(self) -> float:
        """Depth of a pin's hole on each side of the seam."""
        return 0.5 * self.length_mm + self.end_gap_mm


class ScrewsSpec(TomlModel):
    """Screws parallel to the vertical, from outside through one part into the other.

    Attributes:
        kind: `screws`.
        count: Number of screws, evenly around the vertical.
        angle_deg: Angle of the first one about the vertical; `auto`: where the drill map spares most.
        pitch_radius_mm: Their distance from the vertical; `auto`: the largest that the drill map allows.
        screw: Thread in bd_warehouse's spelling.
        standard: Standard of the screws: pan, socket or cheese head.
        length_mm: Length under the head; `auto`: the shortest standard length that fills the thread.
        clamp_mm: Material between the head and the seam.
        thread: `insert`: heat-set inserts; `tapped`: core holes to be tapped.
        insert: Size of the inserts in bd_warehouse's spelling.
        insert_maker: Their maker in bd_warehouse's spelling.
        boss_wall_mm: Material around the widest hole of a column.
        head_in: Which part the heads are in.
        plugged: Whether the head recesses are closed by flush plugs, which allows them anywhere.
        plug_gap_mm: Gap around a plug.
        material: Material of the screws.
    """

    kind: Literal["screws"]
    count: Annotated[Count, Field(ge=1, le=12)] = 3
    angle_deg: Literal["auto"] | Angle = "auto"
    pitch_radius_mm: Literal["auto"] | Length = "auto"
    screw: Text = "M3-0.5"
    standard: Text = "iso4762"
    length_mm: Literal["auto"] | Length = "auto"
    clamp_mm: Length = 4.0
    thread: Literal["insert", "tapped"] = "insert"
    insert: Text = "M3-0.5-4"
    insert_maker: Text = "CNCKitchen"
    boss_wall_mm: Wall = 1.6
    head_in: Literal["upper", "lower"] = "upper"
    plugged: bool = False
    plug_gap_mm: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    material: Text = "steel"


class ThreadRingSpec(TomlModel):
    """Two made rings with an ISO metric thread, glued into the parts while they are screwed together.

    Attributes:
        kind: `thread-ring`.
        diameter_mm: Nominal thread diameter; `auto`: the largest that the room at the seam takes.
        pitch_mm: Thread pitch.
        length_mm: Length of thread in mesh.
        ring_wall_mm: Material of a ring beside its thread.
        shoulder_mm: Width and height of the ledge that a ring stands on.
        thread_clearance_mm: Radial allowance of the outer thread; calibrate it for the process.
        glue_gap_mm: Radial gap between a ring and its bore.
        material: Material of the rings.
    """

    kind: Literal["thread-ring"]
    diameter_mm: Literal["auto"] | Length = "auto"
    pitch_mm: Annotated[Number, Field(ge=0.5, le=6.0)] = 2.0
    length_mm: Length = 6.0
    ring_wall_mm: Wall = 1.6
    shoulder_mm: Wall = 1.2
    thread_clearance_mm: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    glue_gap_mm: Annotated[Number, Field(ge=0.0, le=1.0)] = 0.1
    material: Text = "PETG"


class SnapSpec(TomlModel):
    """An annular snap: a tongue with a bead on the upper part, a groove in the lower one.

    Attributes:
        kind: `snap`.
        diameter_mm: Outer diameter of the tongue; `auto`: the largest that leaves the wall outside of it.
        tongue_wall_mm: Thickness of the tongue.
        height_mm: How far the tongue reaches below the seam.
        undercut_mm: Height of the bead over the tongue; `auto`: what the permissible strain allows, at most
            half of the tongue's thickness.
        bead_mm: Width of the bead along the vertical.
        clearance_mm: Gap between tongue and groove all around.
        strain_limit_percent: Permissible strain of the shell's material; from the tables if not given.
    """

    kind: Literal["snap"]
    diameter_mm: Literal["auto"] | Length = "auto"
    tongue_wall_mm: Wall = 1.2
    height_mm: Length = 5.0
    undercut_mm: Literal["auto"] | Length = "auto"
    bead_mm: Length = 2.0
    clearance_mm: Annotated[Number, Field(gt=0.0, le=1.0)] = 0.1
    strain_limit_percent: Annotated[Number, Field(gt=0.0, le=50.0)] | None = None


class PressSpec(TomlModel):
    """A press fit: a tongue on the upper part, a little wider than its socket in the lower one.

    Attributes:
        kind: `press`.
        diameter_mm: Nominal diameter; `auto`: the largest that leaves the wall outside of the socket.
        tongue_wall_mm: Thickness of the tongue.
        height_mm: How far the tongue reaches below the seam.
        end_gap_mm: Gap under the tongue's end.
        fit: An ISO 286 fit such as `H7/p6`; its mean interference is made.
        interference_um: Interference of the diameters, instead of a fit.
        stress_limit_mpa: Permissible equivalent stress of the shell's material; from the tables if not given.
    """

    kind: Literal["press"]
    diameter_mm: Literal["auto"] | Length = "auto"
    tongue_wall_mm: Wall = 2.0
    height_mm: Length = 5.0
    end_gap_mm: Annotated[Number, Field(gt=0.0, le=5.0)] = 0.3
    fit: Text = "H7/p6"
    interference_um: Annotated[Number, Field(gt=0.0, le=2000.0)] | None = None
    stress_limit_mpa: Annotated[Number, Field(gt=0.0, le=5000.0)] | None = None


ClosureSpec = Annotated[
    DowelsSpec | ScrewsSpec | ThreadRingSpec | SnapSpec | PressSpec, Field(discriminator="kind")
]
"""How the two parts are closed; `kind` says which."""
