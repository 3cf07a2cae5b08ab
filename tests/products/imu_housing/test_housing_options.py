"""What a housing may have besides a board: battery, cable port, trim, mark, other closures, gap and step."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from gomboc_cad.body import depth_mm
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.equilibria.drill_map import drill_limits
from gomboc_cad.errors import GeometryError, SpecError
from gomboc_cad.products.assembly import Part
from gomboc_cad.products.imu_housing.layout import HousingContents, HousingLayout, lay_out
from gomboc_cad.products.imu_housing.parts import BATTERY, CABLE_PLUG, LOWER, UPPER
from gomboc_cad.products.imu_housing.recipe import HousingDesign, design_imu_housing
from gomboc_cad.products.imu_housing.spec import ImuHousingSpec
from gomboc_cad.products.placing.com_placement import com_target
from gomboc_cad.products.process import least_wall_mm
from gomboc_cad.products.toml_model import parse_model
from gomboc_cad.solid.hollow import Cylinder

NO_MARK = {"mark": {"text": ""}}
PORT = {"cable": {"thread": "M10x1"}}
POUCH = {"battery": {"type": "lipo-503562", "height_mm": 12.0, "clearance_mm": 0.8}}


def spec_with(**tables: dict[str, Any]) -> ImuHousingSpec:
    data: dict[str, Any] = {
        "product": "imu-housing",
        "body": {"name": "primary", "diameter_mm": 100.0},
        "mesh": {"sag_um": 200.0},
        **NO_MARK,
    }
    return parse_model(ImuHousingSpec, data | tables, "test")


def laid_out(**tables: dict[str, Any]) -> HousingLayout:
    spec = spec_with(**tables)
    body = spec.body.body()
    target = com_target(spec.com.target, body)
    return lay_out(spec, body, target, HousingContents.of(spec), least_wall_mm(spec.shell))


@lru_cache(maxsize=1)
def everything() -> HousingDesign:
    """Battery, plugged cable port, gap and step together."""
    port = {"cable": {"thread": "M10x1", "plug": True}}
    seam = {"split": {"gap_mm": 0.2, "step_mm": [0.1, -0.05]}}
    return design_imu_housing(spec_with(**POUCH, **port, **seam))


def part(design: HousingDesign, name: str) -> Part:
    return next(part for part in design.assembly.parts if part.name == name)


def overlap_mm3(one: Part, other: Part) -> float:
    common = one.solid.intersect(other.solid)
    return 0.0 if common is None else sum(solid.volume for solid in common.solids())


def test_with_everything_in_it_the_centre_of_mass_is_on_its_target() -> None:
    design = everything()
    assert design.assembly.com_residual_um < 0.1
    assert smooth_census(design.body, design.assembly.com_mm, margins=False).stable == 1
    assert part(design, BATTERY).mass_g == 23.0
    assert {"battery", "board"} == {load.part for load in design.mounted.loads}
    assert any("double-sided tape" in note for note in design.notes)


def test_the_upper_half_stands_off_by_gap_and_step_with_what_hangs_in_it() -> None:
    """The seam of the lower half is where the core has it; the upper half and its mesh are displaced."""
    design = everything()
    matrix, shift = design.frame.matrix(), np.array(design.placement.core_shift_mm)
    seam = float(matrix[2] @ shift)
    lower, upper = (part(design, name) for name in (LOWER, UPPER))
    assert lower.mesh is not None
    assert upper.mesh is not None
    assert (lower.mesh.vertices_mm @ matrix[2]).max() == pytest.approx(seam, abs=1e-4)
    assert (upper.mesh.vertices_mm @ matrix[2]).min() == pytest.approx(seam + 0.2, abs=1e-4)
    assert design.parting is not None
    assert design.parting.height_mm == pytest.approx(seam)
    assert design.layout.battery is not None
    wanted = np.array(design.layout.battery.com_mm) + shift + design.frame.point(0.1, -0.05, 0.2)
    assert part(design, BATTERY).com_mm == pytest.approx(wanted)
    assert np.allclose(upper.mesh.mass().com_mm, upper.com_mm, atol=0.1)
    # The boundary that files are inspected against went with it: the seam's vertices lie on its plane.
    assert upper.boundary is not None
    heights = upper.mesh.vertices_mm @ matrix[2]
    on_seam = upper.mesh.vertices_mm[heights < heights.min() + 1e-6]
    distances = [np.abs(surface.distance_mm(on_seam)).max() for surface in upper.boundary.surfaces()]
    assert min(distances) < 1e-4


def test_the_battery_touches_nothing_and_its_pedestal_reaches_it() -> None:
    design = everything()
    battery = part(design, BATTERY)
    for other in design.assembly.parts:
        if other.name != BATTERY:
            assert overlap_mm3(battery, other) == pytest.approx(0.0, abs=1e-6), other.name
    # Half a millimetre of tape between them.
    assert battery.solid.distance_to(part(design, UPPER).solid) == pytest.approx(0.5, abs=1e-3)


def test_the_plug_fills_the_recess_flush_with_the_surface() -> None:
    design = everything()
    plug, recess = part(design, CABLE_PLUG), design.layout.recess
    assert recess is not None
    assert recess.state == "plugged"
    assert overlap_mm3(plug, part(design, UPPER)) == pytest.approx(0.0, abs=1e-6)
    assert overlap_mm3(plug, part(design, LOWER)) == pytest.approx(0.0, abs=1e-6)
    assert plug.mesh is not None
    outermost = (plug.mesh.vertices_mm @ np.array(recess.direction)).max()
    assert outermost == pytest.approx(np.dot(recess.position_mm, recess.direction), abs=0.35)
    assert any("take the cable and its gland out" in note for note in design.notes)


def test_a_cable_port_is_where_the_drill_map_allows_it_and_opens_the_cavity() -> None:
    layout = laid_out(**PORT)
    assert layout.recess is not None
    assert layout.port is not None
    assert layout.recess.state == "allowed"
    com = com_target("best", layout.hollow.body)
    limits = drill_limits(layout.hollow.body, np.array([layout.recess.direction]), com)
    assert layout.recess.rim_radius_mm < limits.radius_mm[0]
    # Tapping drill of M10x1: 9 mm (ISO 2306).
    drilled = [tool for tool in layout.hollow.openings if isinstance(tool, Cylinder)]
    hole = next(tool for tool in drilled if tool.radius_mm == pytest.approx(4.5))
    end = np.array(hole.base_mm)
    assert layout.hollow.wall_mm is not None
    assert depth_mm(layout.hollow.body, end[None])[0] > layout.hollow.wall_mm
    inside = end + 0.5 * np.array(hole.direction)
    assert not any(boss.contains(inside[None])[0] for boss in layout.hollow.bosses)


def test_a_port_that_is_forced_where_it_is_a_rest_is_called_forced() -> None:
    """At the top, the unstable point, any hole is a second rest."""
    layout = laid_out(cable={"thread": "M10x1", "direction": [1.0, 0.0, 0.1]})
    assert layout.recess is not None
    assert layout.recess.state == "forced"


def test_the_mark_is_read_from_above_and_its_dots_are_shallow() -> None:
    layout = laid_out(mark={"text": "A-7"})
    assert layout.mark is not None
    assert layout.mark.state == "allowed"
    assert np.dot(layout.mark.position_mm, layout.frame.up) > 0.0
    depths = depth_mm(layout.hollow.body, np.array([dot.base_mm for dot in layout.mark.dots]))
    assert depths == pytest.approx(0.4, abs=5e-3)


def test_trim_helps_where_the_wall_lets_the_cavity_move_too_little() -> None:
    """The default needs a quarter of a millimetre; here the wall allows 0.15 mm."""
    tight = {"shell": {"wall_mm": 3.0, "min_wall_mm": 2.85}}
    with pytest.raises(GeometryError, match="cannot be brought to its target"):
        design_imu_housing(spec_with(**tight))
    trimmed = design_imu_housing(spec_with(**tight, trim={"kind": "balls", "max_diameter_mm": 8.0}))
    assert trimmed.assembly.com_residual_um < 0.1
    assert trimmed.min_wall_left_mm > 2.85 - 1e-9
    balls = [part for part in trimmed.assembly.parts if part.standard.startswith("ISO 3290")]
    assert balls
    for ball in balls:
        assert overlap_mm3(ball, part(trimmed, LOWER)) == pytest.approx(0.0, abs=1e-6)
        assert overlap_mm3(ball, part(trimmed, UPPER)) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "closure",
    [
        {"kind": "screws", "count": 2},
        {"kind": "screws", "count": 3, "plugged": True},
        {"kind": "thread-ring", "diameter_mm": 80.0},
        {"kind": "snap"},
        {"kind": "press"},
    ],
)
def test_every_closure_gives_a_housing_that_rights_itself(closure: dict[str, Any]) -> None:
    design = design_imu_housing(spec_with(closure=closure))
    assert design.assembly.com_residual_um < 0.1
    assert smooth_census(design.body, design.assembly.com_mm, margins=False).stable == 1
    assert all(opening.state in {"allowed", "plugged"} for opening in design.openings)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"shell": {"wall_mm": 0.5}}, "thinner than the .* mm that the process"),
        ({"shell": {"wall_mm": 3.0, "process": "smelting"}}, "no process 'smelting'"),
        ({"battery": {"type": "car"}}, "no battery 'car'"),
        (
            {"battery": {"type": "lipo-503562", "height_mm": 44.0}},
            "battery .* does not fit.*nearer to the middle",
        ),
        ({"battery": {"type": "sla-12v-7ah"}}, "battery .* does not fit"),
        (
            {"battery": {"type": "18650", "height_mm": 1.0}, "board": {"seat_mm": 33.0}},
            "comes within .* of the board",
        ),
        ({"split": {"height_mm": 20.0}, **POUCH}, "pedestal would end beyond the seam"),
        (
            {"cable": {"thread": "M12x1.5", "direction": [0.0, 0.0, 1.0]}},
            "cable port.*seam",
        ),
        ({"standoffs": {"screw_length_mm": 12.0}}, "reaches 10.4 mm below the board"),
        ({"trim": {"kind": "balls", "max_diameter_mm": 40.0}}, "no room for four columns|does not fit"),
        ({"mark": {"text": "LONG-TEXT-12", "dot_mm": 3.0}}, "[Mm]ark"),
    ],
)
def test_what_does_not_fit_is_said_in_one_sentence(tables: dict[str, Any], said: str) -> None:
    with pytest.raises((GeometryError, SpecError), match=said) as caught:
        laid_out(**tables)
    assert "\n" not in str(caught.value)
