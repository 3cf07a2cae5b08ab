"""The housing: masses add up, the centre of mass is where it was wanted, and what does not fit is said."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gomboc_cad.body import depth_mm, mass_properties
from gomboc_cad.equilibria import smooth_census
from gomboc_cad.errors import GeometryError, GombocError, SpecError
from gomboc_cad.products.assembly import center_of_mass
from gomboc_cad.products.imu_housing.boards import board_names
from gomboc_cad.products.imu_housing.layout import HousingContents
from gomboc_cad.products.imu_housing.parts import LOWER, UPPER
from gomboc_cad.products.imu_housing.recipe import HousingDesign, design_imu_housing
from gomboc_cad.products.materials import load_material
from gomboc_cad.products.process import load_process
from gomboc_cad.products.spec import load_spec
from gomboc_cad.products.verdict import judge, tilt_from_com_error_deg
from gomboc_cad.resources import template_folder

Template = Callable[..., Path]


def design(path: Path) -> HousingDesign:
    return design_imu_housing(load_spec(str(path)), path.parent)


def test_the_centre_of_mass_is_on_its_target(default_housing: HousingDesign) -> None:
    assembly = default_housing.assembly
    # The best place of the loading zone of the primary at 100 mm.
    assert assembly.com_target_mm == pytest.approx((-0.411, 0.0, 0.0), abs=2e-3)
    assert assembly.com_residual_um < 0.1
    by_hand = center_of_mass([(part.mass_g, part.com_mm) for part in assembly.parts])
    assert np.allclose(assembly.com_mm, by_hand, atol=1e-12)


def test_material_is_neither_lost_nor_counted_twice(default_housing: HousingDesign) -> None:
    """Both halves and everything empty in them fill the outer body, and the empty part is known."""
    spec, layout = default_housing.spec, default_housing.layout
    volumes = {part.name: part.volume_mm3 for part in default_housing.assembly.parts}
    full = mass_properties(default_housing.body).volume_mm3
    holes = sum(math.pi * hole.radius_mm**2 * hole.length_mm for hole in layout.hollow.holes)
    assert layout.mark is not None
    dots = len(layout.mark.dots) * math.pi * 0.4**2 * 0.4
    inner = layout.hollow.inner
    assert inner is not None
    bosses = full - volumes[LOWER] - volumes[UPPER] - inner.mass().volume_mm3 - holes - dots
    # Minus the bosses inside the cavity: four standoffs of about 9 mm and three columns.
    standoffs = 4 * math.pi * (0.5 * spec.standoffs.diameter_mm) ** 2 * 9.0
    assert -bosses > standoffs
    assert -bosses < standoffs + 3 * math.pi * 3.5**2 * 60.0


def test_two_kernels_agree_on_both_halves(default_housing: HousingDesign) -> None:
    """The meshes come from manifold3d, the solids from OCCT; the sag bounds what may lie between them."""
    sag_mm = 1e-3 * default_housing.spec.mesh.sag_um
    parts = {part.name: part for part in default_housing.assembly.parts}
    for name in (LOWER, UPPER):
        made = parts[name].mesh
        assert made is not None
        mesh = made.mass()
        area_mm2 = 2.0 * 2.0 * math.pi * default_housing.body.radius_mm**2
        assert abs(mesh.volume_mm3 - parts[name].volume_mm3) < area_mm2 * sag_mm
        assert np.allclose(mesh.com_mm, parts[name].com_mm, atol=0.02)


def test_bought_parts_have_the_masses_of_their_solids(default_housing: HousingDesign) -> None:
    parts = {part.name: part for part in default_housing.assembly.parts}
    assert {name.rstrip("-0123456789") for name in parts} == {LOWER, UPPER, "board", "insert", "screw", "pin"}
    pin = math.pi * 1.5**2 * 12.0 * load_material("steel").density_g_cm3 * 1e-3
    assert parts["pin-1"].mass_g == pytest.approx(pin, rel=1e-9)
    assert parts["board"].mass_g == default_housing.mounted.board.mass_g
    assert all(part.mass_g > 0.05 for part in parts.values())


def test_the_lower_half_is_below_and_the_wall_is_kept(default_housing: HousingDesign) -> None:
    parts = {part.name: part for part in default_housing.assembly.parts}
    up = np.array(default_housing.frame.up)
    assert parts[LOWER].com_mm @ up < parts["pin-1"].com_mm @ up < parts[UPPER].com_mm @ up
    assert np.allclose(up, [1.0, 0.0, 0.0])
    # Every vertex of the cavity in the mesh is at least the thinnest wall under the outer surface.
    least = load_process(default_housing.spec.shell.process).min_wall_mm
    assert least < default_housing.min_wall_left_mm < 3.0
    assert parts[UPPER].mesh is not None
    vertices = parts[UPPER].mesh.vertices_mm
    inner = vertices[np.linalg.norm(vertices, axis=1) < 47.5]
    sample = inner[:: max(1, len(inner) // 200)]
    assert depth_mm(default_housing.body, sample).min() > default_housing.min_wall_left_mm - 0.011


def test_parts_in_place_do_not_overlap(default_housing: HousingDesign) -> None:
    """A pin fills its hole and touches nothing else; a screw stays clear of the plastic."""
    parts = {part.name: part for part in default_housing.assembly.parts}

    def overlap(first: str, second: str) -> float:
        common = parts[first].solid.intersect(parts[second].solid)
        return 0.0 if common is None else sum(solid.volume for solid in common.solids())

    assert overlap("pin-1", LOWER) == pytest.approx(0.0, abs=1e-6)
    assert overlap("pin-1", UPPER) == pytest.approx(0.0, abs=1e-6)
    assert overlap("board", LOWER) == pytest.approx(0.0, abs=1e-6)
    assert overlap("screw-1", LOWER) == pytest.approx(0.0, abs=1e-6)
    # A heat-set insert is wider than its hole: the plastic it displaces flows into its knurls.
    insert = parts["insert-1"].volume_mm3
    assert 0.0 < overlap("insert-1", LOWER) < 0.5 * insert


def test_the_verdict_is_that_of_the_assembled_centre_of_mass(default_housing: HousingDesign) -> None:
    """Reference of the primary: S-margin 0.0077 R about the best place 0.0055 R below the centroid."""
    verdict = judge(default_housing.body, default_housing.assembly.com_mm)
    assert verdict.passed
    assert verdict.census is not None
    assert (verdict.census.stable, verdict.census.saddles, verdict.census.unstable) == (1, 0, 1)
    assert verdict.census.margin.s_margin_mm == pytest.approx(0.382, rel=0.01)
    assert "rights itself" in verdict.reasons[0]


def test_a_problem_found_elsewhere_makes_the_verdict_fail(default_housing: HousingDesign) -> None:
    verdict = judge(default_housing.body, default_housing.assembly.com_mm, ("The file is broken.",))
    assert not verdict.passed
    assert verdict.reasons[0] == "The file is broken."


def test_only_the_error_across_the_vertical_tilts(default_housing: HousingDesign) -> None:
    verdict = judge(default_housing.body, default_housing.assembly.com_mm)
    assert verdict.census is not None
    rest = verdict.census.rest
    down = tuple(0.001 * c for c in rest.direction)
    assert tilt_from_com_error_deg(rest, down) == pytest.approx(0.0, abs=1e-12)
    x, y, z = (1e-3 * c for c in rest.soft_direction)
    assert tilt_from_com_error_deg(rest, (x, y, z)) == pytest.approx(rest.tilt_deg_per_um[0])


Change = tuple[str, str]


def target(value: str) -> Change:
    return '"best" ', value


def diameter(value: float) -> Change:
    return "diameter_mm = 100.0", f"diameter_mm = {value}"


def on(board: str) -> Change:
    return 'type = "adafruit-bno055"', f'type = "{board}"'


# Several changes in one housing, where they have nothing to do with each other.
CHANGES: list[tuple[Change, ...]] = [
    (target('"centroid" '), ('material = "PLA"', 'material = "aluminium"'), on("adafruit-mpu6050")),
    (target("[-1.0, 0.0, 0.0] "), diameter(250.0), on("sparkfun-icm20948")),
    (target("[-0.2, -0.05, 0.04] "), ("angle_deg = 0.0", "angle_deg = 37.0"), on("adafruit-lsm6ds3tr-c")),
    (diameter(60.0),),
    (("seat_mm = 10.0", "seat_mm = 40.0"), ('name = "primary"', 'name = "sloan2-0.030"')),
    (
        ("cavity floor\noffset_mm = [0.0, 0.0]", "cavity floor\noffset_mm = [8.0, -5.0]"),
        ("height_mm = 0.0", "height_mm = -20.0"),
        on("adafruit-icm20948"),
    ),
]


@pytest.mark.parametrize("changes", CHANGES)
@pytest.mark.slow
def test_the_target_is_met_whatever_is_changed(template_with: Template, changes: tuple[Change, ...]) -> None:
    housing = design(template_with(*changes))
    assert housing.assembly.com_residual_um < 0.1
    assert smooth_census(housing.body, housing.assembly.com_mm, margins=False).stable == 1


def test_every_board_is_in_one_of_these_housings_or_in_that_of_the_template() -> None:
    changes = {change for changes in CHANGES for change in changes}
    assert {name for name in board_names() if on(name) not in changes} == {"adafruit-bno055"}


@pytest.mark.slow
def test_a_centre_of_mass_outside_the_loading_zone_fails(template_with: Template) -> None:
    """Raised by 0.5 mm the primary has more than one stable rest."""
    housing = design(template_with(('"best" ', "[0.5, 0.0, 0.0] ")))
    verdict = judge(housing.body, housing.assembly.com_mm)
    assert not verdict.passed
    assert "outside the loading zone" in verdict.reasons[0]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("wall_mm = 3.0 ", "wall_mm = 30.0 "), "thicker than the smallest inner radius allows.*29.07 mm"),
        (("diameter_mm = 100.0", "diameter_mm = 30.0"), "does not fit|no cavity"),
        (("diameter_mm = 100.0", "diameter_mm = 45.0"), "boss of the closure.*board"),
        (("seat_mm = 10.0", "seat_mm = 3.0"), "does not fit.*lower side.*raise board.seat_mm"),
        (("seat_mm = 10.0", "seat_mm = 60.0"), "not below the seam"),
        (("height_mm = 0.0", "height_mm = 49.0"), "does not fit|does not pass"),
        (("length_mm = 12.0", "length_mm = 99.0"), "use shorter pins"),
        (('"best" ', "[-20.0, 0.0, 0.0] "), "brought to its target.*52 % of the way.*limit of 2.2 mm"),
        (("screw_length_mm = 4.0", "screw_length_mm = 12.0"), "reaches 10.4 mm below the board"),
        (("screw_length_mm = 4.0", "screw_length_mm = 4.5"), "no standard length.*4, 5, 6"),
        (('insert = "M2-0.4-3"', 'insert = "M3-0.5-4"'), "different threads"),
        (('insert = "M2-0.4-3"', 'insert = "M9"'), "not made by CNCKitchen"),
        (('"CNCKitchen"', '"Nobody"'), "choose one of.*CNCKitchen"),
        (('"iso14583"', '"iso1"'), "choose one of.*iso14583"),
        (('"M2-0.4" ', '"M99" '), "choose one of"),
        (('material = "PLA"', 'material = "wood"'), "no material 'wood'"),
        (("diameter_mm = 6.0", "diameter_mm = 4.0"), "needs at least 5.8 mm"),
        (('type = "adafruit-bno055"', 'type = "nothing"'), "no board 'nothing'"),
    ],
)
def test_what_does_not_fit_is_said_with_numbers_and_a_remedy(
    template_with: Template, change: tuple[str, str], said: str
) -> None:
    with pytest.raises((GeometryError, SpecError), match=said) as caught:
        design(template_with(change))
    assert "\n" not in str(caught.value)


def test_a_board_that_is_too_large_does_not_fit(template_with: Template, tmp_path: Path) -> None:
    text = (template_folder() / "boards" / "adafruit-bno055.toml").read_text(encoding="utf-8")
    (tmp_path / "large.toml").write_text(
        text.replace("length_mm = 25.4", "length_mm = 95.0"), encoding="utf-8"
    )
    path = template_with(('type = "adafruit-bno055"', 'type = "large.toml"'))
    with pytest.raises(GombocError, match="does not fit"):
        design(path)


def test_a_board_of_ones_own_gives_the_same_contents(template_with: Template, tmp_path: Path) -> None:
    shutil.copy(template_folder() / "boards" / "adafruit-bno055.toml", tmp_path / "own.toml")
    own = load_spec(str(template_with(('type = "adafruit-bno055"', 'type = "own.toml"'))))
    assert HousingContents.of(own, tmp_path).board == HousingContents.of(load_spec("imu-housing")).board
