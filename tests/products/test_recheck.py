"""The recheck of the exported parts, on solids that are really drilled, plugged, moved and cut."""

from __future__ import annotations

import json

import numpy as np
import pytest
from build123d import Location, Solid

from gomboc_cad.body import catalog, mass_properties
from gomboc_cad.equilibria import find_equilibria, smooth_census
from gomboc_cad.equilibria.records import Vector, as_vector
from gomboc_cad.products.common_spec import Direction
from gomboc_cad.products.openings.placed_opening import displaced, judged_opening
from gomboc_cad.products.openings.sites import OpeningRequest, PlacedOpening, place_openings
from gomboc_cad.products.placement import Parting, RestFrame
from gomboc_cad.products.recheck import Recheck, recheck, recheck_document
from gomboc_cad.solid.export import write_step
from gomboc_cad.solid.hollow import HollowBody, Seam, brep, plug_brep, split_brep
from gomboc_cad.solid.step import NamedSolid, read_step

BODY = catalog()["primary"].with_diameter(60.0)
CENTROID = mass_properties(BODY).com_mm
FRAME = RestFrame.from_rest(smooth_census(BODY, CENTROID, margins=False).rest.direction)
FLANK: Vector = (0.5, -0.5, 0.7)


def opening(
    radius_mm: float, direction: Direction = FLANK, com: Vector = CENTROID, plug: bool = False
) -> PlacedOpening:
    request = OpeningRequest("port", radius_mm, 4.0, direction, plug=plug)
    return place_openings(BODY, com, [request], frame=FRAME, wall_mm=1.0)[0]


def drilled(*openings: PlacedOpening) -> Solid:
    return brep(HollowBody(BODY, wall_mm=None, openings=tuple(item.tool for item in openings)))


def rechecked(solid: Solid, *openings: PlacedOpening, com: Vector = CENTROID) -> Recheck:
    return recheck({"body": solid}, com, openings, BODY)


@pytest.fixture(scope="module")
def allowed_mm() -> float:
    """Largest radius that is allowed on the flank."""
    allowed = opening(0.1).allowed_radius_mm
    assert allowed is not None
    return allowed


@pytest.fixture(scope="module")
def whole() -> Recheck:
    """The body without openings."""
    return rechecked(drilled())


@pytest.fixture(scope="module")
def wide_hole(allowed_mm: float) -> PlacedOpening:
    """Five times as wide as it may be."""
    return opening(5.0 * allowed_mm)


@pytest.fixture(scope="module")
def wide(wide_hole: PlacedOpening, tmp_path_factory: pytest.TempPathFactory) -> Recheck:
    """The same, drilled into a body that went through a STEP file."""
    file = tmp_path_factory.mktemp("wide") / "part.step"
    write_step(file, [NamedSolid("body", drilled(wide_hole), None)], "part")
    solids = {part.name: part.solid for part in read_step(file)}
    return recheck(solids, CENTROID, [wide_hole], BODY)


def test_a_body_without_openings_has_its_one_rest(whole: Recheck) -> None:
    assert (whole.verdict, whole.stable, whole.rims) == ("monostable", 1, ())
    assert whole.barrier_mm < 0.05
    assert whole.outside_mm < 1e-4


def test_a_hole_of_nine_tenths_of_the_limit_passes(allowed_mm: float) -> None:
    hole = opening(0.9 * allowed_mm)
    found = rechecked(drilled(hole), hole)
    assert (found.verdict, found.stable) == ("monostable", 1)
    (rim,) = found.rims
    assert rim.on_solid
    assert rim.rest is None
    assert rim.com_clearance_mm == pytest.approx(hole.com_clearance_mm, rel=0.02)


def test_a_hole_just_too_wide_fails_by_name_though_the_sampling_cannot_see_it(allowed_mm: float) -> None:
    hole = opening(1.1 * allowed_mm)
    found = rechecked(drilled(hole), hole)
    assert (found.verdict, found.stable, found.census.stable) == ("multistable", 2, 1)
    assert "also rests on the rim of port" in found.reasons[0]
    assert found.rims[0].rest is not None
    assert found.rims[0].rest.barrier_mm < found.barrier_mm


def test_a_hole_forced_much_too_wide_fails_by_name(wide: Recheck, wide_hole: PlacedOpening) -> None:
    assert (wide.verdict, wide.stable, wide.census.stable) == ("multistable", 2, 2)
    assert "also rests on the rim of port" in wide.reasons[0]
    (rim,) = wide.rims
    assert rim.on_solid
    assert rim.state == "forced"
    assert rim.rest is not None
    assert np.dot(rim.rest.direction, wide_hole.direction) > np.cos(np.radians(3.0))


def test_the_sampled_census_and_the_rim_agree_on_a_rest(wide: Recheck, wide_hole: PlacedOpening) -> None:
    poses = [pose for pose in wide.census.equilibria if pose.kind == "stable"]
    nearest = max(poses, key=lambda pose: float(np.dot(pose.direction, wide_hole.direction)))
    rest = wide.rims[0].rest
    assert rest is not None
    assert rest.height_mm == pytest.approx(nearest.height_mm, abs=wide.barrier_mm)
    assert np.dot(rest.direction, nearest.direction) > np.cos(np.radians(0.5))
    assert nearest.barrier_mm is not None
    assert rest.barrier_mm <= nearest.barrier_mm + wide.barrier_mm


def test_the_document_is_plain_json(wide: Recheck) -> None:
    document = json.loads(json.dumps(recheck_document(wide), allow_nan=False))
    assert document["verdict"] == "multistable"
    assert document["openings"][0]["rest"]["barrier_um"] > document["barrier_um"]
    assert len(document["poses"]) == 2


def test_a_hole_that_nobody_mentions_is_found_by_the_sampling(wide_hole: PlacedOpening) -> None:
    found = rechecked(drilled(wide_hole))
    assert (found.verdict, found.stable, found.rims) == ("multistable", 2, ())
    assert "sampled" in found.reasons[0]


def test_a_plug_takes_the_rest_away(wide_hole: PlacedOpening) -> None:
    solids = {"body": drilled(wide_hole), "plug": plug_brep(BODY, wide_hole.tool)}
    found = recheck(solids, CENTROID, [opening(wide_hole.tool.radius_mm, plug=True)], BODY)
    assert (found.verdict, found.stable) == ("monostable", 1)
    assert found.rims[0].state == "plugged"
    assert found.rims[0].rest is None


def test_a_recess_at_the_rest_is_the_rest() -> None:
    low: Vector = (-0.6, 0.0, 0.0)
    eye = opening(4.0, find_equilibria(BODY, low)[0].direction, com=low)
    assert eye.state == "rest"
    found = rechecked(drilled(eye), eye, com=low)
    assert (found.verdict, found.stable) == ("monostable", 1)
    assert found.rims[0].rest is not None


def test_a_recess_beside_the_rest_makes_two() -> None:
    """The centre of mass has moved along the soft direction by more than the rim allows."""
    rest = smooth_census(BODY, CENTROID, margins=False).rest
    eye = opening(4.0, rest.direction)
    assert eye.com_clearance_mm is not None
    soft = 3.0 * eye.com_clearance_mm * np.array(rest.soft_direction)
    moved = as_vector(np.array(CENTROID) + soft)
    assert smooth_census(BODY, moved, margins=False).stable == 1
    found = rechecked(drilled(eye), eye, com=moved)
    assert (found.verdict, found.stable) == ("multistable", 2)
    assert "also beside it" in found.reasons[0]


def test_an_opening_goes_with_its_half(allowed_mm: float) -> None:
    """A half displaced by d is that half about the centre of mass less d."""
    hole = opening(0.9 * allowed_mm)
    shift = FRAME.point(0.2, -0.1, 0.3)
    parting = Parting(FRAME.up, 0.0, as_vector(shift))
    assert parting.above(np.array([hole.position_mm]))[0]
    lower, upper = split_brep(drilled(hole), Seam((0.0, 0.0, 0.0), FRAME.up))
    solids = {"lower": lower, "upper": upper.moved(Location(as_vector(shift)))}
    found = recheck(solids, CENTROID, displaced([hole], parting), BODY, parting)
    as_if = judged_opening(BODY, np.subtract(CENTROID, shift), "port", hole.tool, frame=FRAME)
    (rim,) = found.rims
    assert rim.on_solid
    assert rim.com_clearance_mm == pytest.approx(as_if.com_clearance_mm, rel=0.04)
    assert abs(as_if.com_clearance_mm / hole.com_clearance_mm - 1.0) > 0.1
    (undisplaced,) = recheck(solids, CENTROID, [hole], BODY).rims
    assert not undisplaced.on_solid


@pytest.mark.slow
def test_an_upper_half_that_slipped_makes_another_hull() -> None:
    lower, upper = split_brep(drilled(), Seam((0.0, 0.0, 0.0), FRAME.up))
    upper = upper.moved(Location(as_vector(2.0 * np.array(FRAME.second))))
    found = recheck({"lower": lower, "upper": upper}, CENTROID, [], BODY)
    assert found.outside_mm == pytest.approx(2.0, abs=0.1)
    assert found.verdict == "multistable"


def test_parts_inside_do_not_matter_and_a_missing_hole_is_noticed(whole: Recheck, allowed_mm: float) -> None:
    solids = {"body": drilled(), "ballast": Solid.make_sphere(10.0)}
    found = recheck(solids, CENTROID, [opening(0.9 * allowed_mm)], BODY)
    assert found.census.mesh == whole.census.mesh
    assert not found.rims[0].on_solid
