"""Openings: where they are put, what is said of them, and what the drilled solid's own hull says."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from gomboc_cad.body import Body, catalog, mass_properties
from gomboc_cad.body.sphere import Array, unit
from gomboc_cad.equilibria import Census, find_equilibria, smooth_census
from gomboc_cad.equilibria.drill_map import drill_limits
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.equilibria.rim import rim_clearance_mm
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.openings.cylinder_gaps import gaps_mm, segment_distances
from gomboc_cad.products.openings.sites import (
    OpeningRequest,
    PlacedOpening,
    judged_opening,
    openings_document,
    place_around,
    place_openings,
)
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder, HollowBody, mesh
from tests.body.shapes import random_directions

BODY = catalog()["primary"].with_diameter(60.0)
COM = np.array(mass_properties(BODY).com_mm)
FRAME = RestFrame.from_rest(find_equilibria(BODY, COM)[0].direction)
PORT = OpeningRequest("the port", 2.0, 5.0)
EYE = OpeningRequest("the eye", 3.0, 5.0, "rest")
ON_A_GENTLE_SLOPE = as_vector(unit(np.array([0.3, 0.3, 1.0])))
FORCED = OpeningRequest("the cable hole", 1.5, 5.0, ON_A_GENTLE_SLOPE)


def placed(*requests: OpeningRequest, body: Body = BODY, com: Array = COM, **options) -> list[PlacedOpening]:
    return list(place_openings(body, com, requests, **({"frame": FRAME, "wall_mm": 1.5} | options)))


def drilled_census(
    *openings: PlacedOpening, com: Array = COM, sag_um: float = 5.0, barrier: float = 3e-3
) -> Census:
    """Of the hull of the really drilled solid, flocks left out by a barrier in mm."""
    drilled = mesh(HollowBody(BODY, None, openings=tuple(o.tool for o in openings)), sag_um)
    return mesh_census(drilled.vertices_mm, drilled.faces, com, barrier_mm=barrier, probabilities=False)


def test_an_opening_goes_where_the_drill_map_is_widest_and_adds_no_rest() -> None:
    (port,) = placed(PORT)
    assert port.state == "allowed"
    everywhere = drill_limits(BODY, random_directions(400, seed=1), COM).radius_mm
    # The centre of mass may move by about what the map leaves.
    assert port.com_clearance_mm > everywhere.max() - PORT.radius_mm - 0.05
    assert drilled_census(port).stable == 1


@pytest.mark.parametrize("seed", range(4))
def test_the_allowed_radius_is_where_a_hole_becomes_a_rest(seed: int) -> None:
    """The drill map's refined limit stops at the second-order formula, the true rim sometimes allows more."""
    direction = random_directions(1, seed)[0]
    hole = OpeningRequest("a hole", 0.2, 3.0, as_vector(direction))
    (small,) = placed(hole)
    limit = drill_limits(BODY, direction[None], COM).refined_radius_mm[0]
    assert 0.995 * limit < small.allowed_radius_mm < 1.1 * limit
    assert small.rim_radius_mm == pytest.approx(0.2, rel=1e-9)
    np.testing.assert_allclose(small.direction, direction, atol=1e-9)
    below, above = (placed(replace(hole, radius_mm=k * small.allowed_radius_mm))[0] for k in (0.98, 1.02))
    assert (below.state, above.state) == ("allowed", "forced")
    assert below.allowed_radius_mm == pytest.approx(above.allowed_radius_mm, rel=5e-3)


def test_a_forced_opening_is_said_to_be_a_rest_and_is_one() -> None:
    (hole,) = placed(FORCED)
    assert hole.state == "forced"
    assert hole.com_clearance_mm == 0.0
    assert "also rests on that rim" in hole.sentence
    census = drilled_census(hole)
    assert census.stable == 2
    said = float(hole.sentence.split("barrier of ")[1].split(" µm")[0])
    assert said == pytest.approx(1e3 * census.mesh.lowest_counted_mm, rel=0.15)
    (smaller,) = placed(replace(FORCED, radius_mm=0.95 * hole.allowed_radius_mm))
    assert smaller.state == "allowed"


def test_an_opening_at_the_rest_is_the_rest_as_long_as_the_centre_of_mass_is_near() -> None:
    (eye,) = placed(EYE)
    assert eye.state == "rest"
    assert eye.allowed_radius_mm is None
    np.testing.assert_allclose(eye.direction, -np.array(FRAME.up), atol=1e-12)
    rest = smooth_census(BODY, COM, margins=False).rest
    soft = rest.stiffness_mm[0]
    assert eye.com_clearance_mm == pytest.approx(soft * 3.0 / (soft + rest.height_mm), rel=0.02)
    assert f"{1e3 * eye.com_clearance_mm:.3g} µm" in eye.sentence
    assert drilled_census(eye).stable == 1


@pytest.mark.slow
def test_beyond_its_clearance_a_product_rests_in_the_eye_and_beside_it() -> None:
    """The smooth body has one rest about either centre of mass; the drilled one has two about the second."""
    (eye,) = placed(EYE)
    soft = np.array(smooth_census(BODY, COM, margins=False).rest.soft_direction)
    for share, rests in ((0.5, 1), (6.0, 2)):
        com = COM + share * eye.com_clearance_mm * soft
        assert sum(e.kind == "stable" for e in find_equilibria(BODY, com)) == 1
        assert drilled_census(eye, com=com, sag_um=1.0, barrier=4e-4).stable == rests


def test_an_eye_that_the_rest_has_left_is_said_to_be_a_second_rest() -> None:
    (eye,) = placed(EYE)
    soft = np.array(smooth_census(BODY, COM, margins=False).rest.soft_direction)
    near, off = (placed(EYE, com=COM + k * eye.com_clearance_mm * soft)[0] for k in (0.9, 1.1))
    assert (near.state, off.state) == ("rest", "forced")
    assert near.com_clearance_mm == pytest.approx(0.1 * eye.com_clearance_mm, rel=0.05)
    assert "does not hold the rest" in off.sentence


def test_a_lower_centre_of_mass_makes_an_eye_at_the_rest_more_tolerant() -> None:
    lower = COM - 0.5 * np.array(FRAME.up)
    assert placed(EYE, com=lower)[0].com_clearance_mm > 3.0 * placed(EYE)[0].com_clearance_mm


def test_a_plugged_opening_is_flush_wherever_it_is() -> None:
    (hole,) = placed(replace(FORCED, plug=True))
    assert hole.state == "plugged"
    assert hole.com_clearance_mm is None
    assert "flush" in hole.sentence


def test_openings_keep_to_their_side_clear_of_the_seam_of_bosses_and_of_each_other() -> None:
    wide = Cylinder(as_vector(FRAME.point(12.0, 0.0, -40.0)), FRAME.up, 4.0, 80.0)
    requests = [OpeningRequest(f"port {side}", 2.0, 4.0, side=side) for side in ("upper", "lower", "any")]
    openings = placed(*requests, seam_height_mm=1.0, keep_out=(wide,))
    heights = [float(np.dot(o.position_mm, FRAME.up)) - 1.0 for o in openings]
    assert heights[0] >= 3.5
    assert heights[1] <= -3.5
    assert abs(heights[2]) >= 3.5
    for index, one in enumerate(openings):
        base, mouth = np.array([one.tool.base_mm]), np.array([one.position_mm])
        for tool in (wide, *(other.tool for other in openings[:index])):
            assert gaps_mm(base, mouth, 2.0, tool)[0] >= 1.5 - 1e-9


def test_results_come_in_the_order_of_the_requests_and_are_the_same_each_time() -> None:
    small = OpeningRequest("small", 0.8, 3.0)
    openings = placed(small, EYE, PORT)
    assert [o.name for o in openings] == ["small", "the eye", "the port"]
    assert placed(small, EYE, PORT) == openings


def test_everything_scales_with_the_body() -> None:
    doubled = [
        replace(r, radius_mm=2.0 * r.radius_mm, depth_mm=2.0 * r.depth_mm) for r in (PORT, EYE, FORCED)
    ]
    large = placed(*doubled, body=BODY.with_diameter(120.0), com=2.0 * COM, wall_mm=3.0)
    for one, other in zip(placed(PORT, EYE, FORCED), large, strict=True):
        assert one.state == other.state
        np.testing.assert_allclose(other.position_mm, 2.0 * np.array(one.position_mm), atol=1e-6)
        assert other.com_clearance_mm == pytest.approx(2.0 * one.com_clearance_mm, rel=1e-5)


def test_an_oblique_hole_counts_with_the_circle_around_its_rim() -> None:
    """On a nearly flat patch a hole at 40° to the normal has an ellipse as its rim, 1/cos 40° longer."""
    (upright,) = placed(OpeningRequest("a hole", 0.3, 4.0))
    normal = np.array(upright.direction)
    side = unit(np.cross(normal, FRAME.up))
    axis = math.cos(math.radians(40.0)) * normal + math.sin(math.radians(40.0)) * side
    tool = Cylinder(as_vector(np.array(upright.position_mm) - 5.0 * axis), as_vector(axis), 0.3, 50.0)
    oblique = judged_opening(BODY, COM, "a hole", tool, frame=FRAME)
    assert oblique.rim_radius_mm == pytest.approx(0.3 / math.cos(math.radians(40.0)), rel=0.02)
    np.testing.assert_allclose(oblique.position_mm, upright.position_mm, atol=1e-6)
    # Cut off just outside the body: everything of the rim is inside the tool, and little else.
    top = np.array(oblique.tool.base_mm) + oblique.tool.length_mm * axis
    assert 0.0 < np.linalg.norm(top) - BODY.radius_at(unit(top)[None])[0] < 1.0


def test_screws_around_the_vertical_take_the_best_starting_angle() -> None:
    options = {"radius_mm": 1.5, "from_axis_mm": 20.0, "base_height_mm": 5.0, "outwards": "up"}
    common = {"frame": FRAME, "wall_mm": 1.0}
    screws = place_around(BODY, COM, "screw", 2, **options, **common)
    assert [s.state for s in screws] == ["allowed", "allowed"]
    across = np.array([FRAME.matrix()[:2] @ s.tool.base_mm for s in screws])
    np.testing.assert_allclose(np.linalg.norm(across, axis=1), 20.0)
    np.testing.assert_allclose(across[0], -across[1], atol=1e-9)
    least = min(s.com_clearance_mm for s in screws)
    for angle in (0.0, 45.0, 90.0, 135.0):
        others = place_around(BODY, COM, "screw", 2, first_angle_deg=angle, **options, **common)
        assert min(o.com_clearance_mm for o in others) <= least
    assert drilled_census(*screws).stable == 1
    with pytest.raises(GeometryError, match=r"2 x screw.* meet something else at every angle"):
        place_around(BODY, COM, "screw", 2, others=screws, **options, frame=FRAME, wall_mm=40.0)


def test_screws_that_would_be_rests_at_every_angle_are_refused_unless_plugged() -> None:
    options = {"radius_mm": 1.5, "from_axis_mm": 24.0, "base_height_mm": 2.0, "outwards": "up"}
    with pytest.raises(GeometryError, match="add a rest at every angle"):
        place_around(BODY, COM, "screw", 4, **options, frame=FRAME, wall_mm=1.0)
    plugged = place_around(BODY, COM, "screw", 4, **options, frame=FRAME, wall_mm=1.0, plug=True)
    assert {screw.state for screw in plugged} == {"plugged"}


@pytest.mark.parametrize(
    ("requests", "options", "message"),
    [
        ((EYE, replace(EYE, name="the exit")), {}, r"the exit and the eye meet|the eye and the exit meet"),
        ((replace(FORCED, direction=(0.0, 0.3, 1.0)),), {"seam_height_mm": 0.0}, "meets the seam"),
        (
            (FORCED,),
            {"keep_out": (Cylinder((0.0, 0.0, 0.0), ON_A_GENTLE_SLOPE, 3.0, 40.0),)},
            "the cable hole meets a boss",
        ),
        (
            (replace(PORT, radius_mm=9.0),),
            {},
            "No free place on the whole surface allows the port of radius 9 mm",
        ),
        ((replace(PORT, side="upper"),), {"seam_height_mm": 29.0}, "There is no room for the port"),
        ((replace(PORT, direction=(0.0, 0.0, 0.0)),), {}, "direction of the port has no length"),
        ((replace(FORCED, depth_mm=80.0),), {}, "inner end outside the body"),
    ],
)
def test_requests_that_cannot_be(requests, options, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        placed(*requests, **options)


def test_the_document_has_one_entry_for_a_group_with_its_worst_member() -> None:
    port, eye = placed(PORT, EYE)
    dots = [
        replace(port, name=f"dot {i}", group="the mark", com_clearance_mm=c) for i, c in enumerate((0.4, 0.3))
    ]
    document = openings_document([*dots, eye])
    assert [(entry["name"], entry["count"]) for entry in document] == [("the mark", 2), ("the eye", 1)]
    assert document[0]["com_clearance_mm"] == 0.3
    assert json.loads(json.dumps(document, allow_nan=False)) == document


def test_the_clearance_is_that_of_the_true_rim() -> None:
    (port,) = placed(PORT)
    axis = np.array(port.tool.direction)
    angles = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    first = unit(np.cross(axis, [0.0, 0.0, 1.0]))
    circle = np.outer(np.cos(angles), first) + np.outer(np.sin(angles), np.cross(axis, first))
    rim = np.array(port.position_mm) + 2.0 * circle
    for _ in range(50):
        excess = np.linalg.norm(rim, axis=1) - BODY.radius_at(unit(rim))
        rim = rim - excess[:, None] * axis
    assert rim_clearance_mm(rim, COM) == pytest.approx(port.com_clearance_mm, rel=5e-3)


@settings(deadline=None)
@given(numbers=st.lists(st.floats(-5.0, 5.0), min_size=12, max_size=12))
def test_the_distance_of_two_segments_is_that_of_their_nearest_points(numbers: list[float]) -> None:
    a, b, c, d = np.array(numbers).reshape(4, 3)
    nearest = lsq_linear(np.column_stack([b - a, c - d]), c - a, bounds=(0.0, 1.0), tol=1e-14)
    distance = float(np.linalg.norm(nearest.fun))
    assert segment_distances(a[None], b[None], c, d)[0] == pytest.approx(distance, abs=1e-4)
