"""Marks: readable, where they were asked for, and no rest in any dot."""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np
import pytest

from gomboc_cad.body import Body, Harmonic, catalog, mass_properties
from gomboc_cad.body.sphere import Array, tangent_frame, unit
from gomboc_cad.equilibria import find_equilibria
from gomboc_cad.equilibria.mesh import mesh_census
from gomboc_cad.equilibria.records import as_vector
from gomboc_cad.errors import GeometryError
from gomboc_cad.products.common_spec import MarkSpec
from gomboc_cad.products.openings.dot_letters import COLUMNS, ROWS, letter
from gomboc_cad.products.openings.mark_layout import least_spacing_mm, mark_layouts, walked
from gomboc_cad.products.openings.marking import Mark, place_mark
from gomboc_cad.products.openings.sites import OpeningRequest, openings_document, place_openings
from gomboc_cad.products.placement import RestFrame
from gomboc_cad.solid.hollow import Cylinder, HollowBody, mesh
from tests.body.shapes import random_directions

BODY = catalog()["primary"].with_diameter(60.0)
COM = np.array(mass_properties(BODY).com_mm)
FRAME = RestFrame.from_rest(find_equilibria(BODY, COM)[0].direction)
SPHERE = Body("sphere", Harmonic((((2, 0), 0.0),)), 20.0)
LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-."
ARROW_DOTS = 13


def mark(text: str, *, body: Body = BODY, com: Array = COM, **options) -> Mark:
    sizes = {key: options.pop(key) for key in ("dot_mm", "depth_mm", "direction") if key in options}
    spec = MarkSpec(text=text, **({"dot_mm": 0.5, "depth_mm": 0.3} | sizes))
    return place_mark(body, com, spec, **({"frame": FRAME, "min_wall_mm": 0.5} | options))


@pytest.fixture(scope="module")
def on_the_upper_side() -> Mark:
    return mark("G4", pointing=FRAME.first, seam_height_mm=1.0, side="upper")


def positions(made: Mark) -> Array:
    return np.array([opening.position_mm for opening in made.openings])


def test_the_letters_are_told_apart_by_two_dots_or_more() -> None:
    dots = {c: {tuple(dot) for dot in letter(c).tolist()} for c in LETTERS}
    assert min(len(dots[a] ^ dots[b]) for a, b in combinations(LETTERS, 2)) >= 2
    every = np.concatenate([letter(c) for c in LETTERS])
    assert every.min(axis=0).tolist() == [0.0, 0.0]
    assert every.max(axis=0).tolist() == [COLUMNS - 1, ROWS - 1]
    with pytest.raises(GeometryError, match="no dots for 'ä'"):
        letter("ä")


def test_what_is_drilled_can_be_read(on_the_upper_side: Mark) -> None:
    """Seen from outside along the normal, with the reading direction to the right."""
    right = np.array(on_the_upper_side.reading)
    upwards = np.cross(on_the_upper_side.direction, right)
    seen = (positions(on_the_upper_side) - on_the_upper_side.position_mm) @ np.stack([right, upwards]).T
    cells = seen / least_spacing_mm(positions(on_the_upper_side))
    letters = np.rint(cells[:-ARROW_DOTS] - cells[:-ARROW_DOTS].min(axis=0)).astype(int)
    rows = [["." for _ in range(2 * COLUMNS + 1)] for _ in range(ROWS)]
    for column, row in letters:
        rows[ROWS - 1 - row][column] = "#"
    assert ["".join(row) for row in rows] == [
        ".###.....#.",
        "#...#...##.",
        "#......#.#.",
        "#.###.#..#.",
        "#...#.#####",
        "#...#....#.",
        ".###.....#.",
    ]


def test_text_is_upright_and_the_arrow_points_along_what_it_should(on_the_upper_side: Mark) -> None:
    made = on_the_upper_side
    assert np.cross(made.direction, made.reading) @ FRAME.up > 0.0
    flat = np.array(FRAME.first) - np.dot(FRAME.first, made.direction) * np.array(made.direction)
    np.testing.assert_allclose(made.arrow, unit(flat), atol=1e-9)
    arrow = positions(made)[-ARROW_DOTS:]
    # The head, the last four dots of it, is ahead of the middle of the shaft.
    ahead = (arrow[-4:].mean(axis=0) - arrow[:9].mean(axis=0)) @ made.arrow
    assert ahead > 1.0


def test_every_dot_is_allowed_on_its_side_and_clear(on_the_upper_side: Mark) -> None:
    made = on_the_upper_side
    assert made.state == "allowed"
    assert len(made.dots) == len(letter("G")) + len(letter("4")) + ARROW_DOTS
    assert (positions(made) @ FRAME.up).min() >= 1.0 + 0.25 + 0.5
    assert least_spacing_mm(positions(made)) >= 1.0
    for opening in made.openings:
        assert opening.allowed_radius_mm > 0.25
        assert opening.com_clearance_mm >= made.com_clearance_mm > 0.0
        axis = np.array(opening.tool.direction)
        depth = np.dot(np.subtract(opening.position_mm, opening.tool.base_mm), axis)
        assert depth == pytest.approx(0.3)
        np.testing.assert_allclose(BODY.normal(unit(np.array([opening.position_mm])))[0], axis, atol=1e-9)
    assert openings_document(made.openings)[0]["count"] == len(made.dots)


def test_the_marked_solid_has_one_rest(on_the_upper_side: Mark) -> None:
    drilled = mesh(HollowBody(BODY, None, openings=on_the_upper_side.dots), 8.0)
    census = mesh_census(drilled.vertices_mm, drilled.faces, COM, barrier_mm=4e-3, probabilities=False)
    assert census.stable == 1


def test_no_other_place_tried_would_let_the_centre_of_mass_move_much_farther() -> None:
    best = mark("7")
    for direction in random_directions(12, seed=3):
        other = mark("7", direction=as_vector(direction))
        assert other.com_clearance_mm <= 1.05 * best.com_clearance_mm


def test_a_mark_is_flagged_when_the_centre_of_mass_is_over_one_of_its_dots() -> None:
    """No hole is allowed where the perpendicular from the centre of mass meets its middle."""
    made = mark("1")
    worst = min(made.openings, key=lambda opening: opening.com_clearance_mm)
    arm = np.subtract(worst.position_mm, COM)
    aside = arm - (arm @ worst.direction) * np.array(worst.direction)
    # |∇h| less the radius is what is sure; more where the curvatures differ.
    assert np.linalg.norm(aside) - 0.26 < made.com_clearance_mm < np.linalg.norm(aside)
    before, over = (
        mark("1", direction=made.direction, com=COM + share * aside)
        for share in (0.98 * made.com_clearance_mm / np.linalg.norm(aside), 1.0)
    )
    assert before.state == "allowed"
    assert over.state == "forced"
    assert over.com_clearance_mm == 0.0
    forced = [opening.name for opening in over.openings if opening.state == "forced"]
    assert worst.name in forced
    assert f"adds a rest at {len(forced)} of its dots" in over.sentence
    assert {opening.sentence for opening in over.openings} == {over.sentence}


def test_a_long_text_in_lines_keeps_its_land_on_the_curved_surface() -> None:
    made = mark("GC-IMU-100", min_wall_mm=0.4)
    assert max(made.size_mm) > 0.45 * BODY.diameter_mm
    assert 0.9 <= least_spacing_mm(positions(made)) < 0.99


def test_marks_scale_with_the_body() -> None:
    small = mark("B2")
    large = mark(
        "B2", body=BODY.with_diameter(120.0), com=2.0 * COM, dot_mm=1.0, depth_mm=0.6, min_wall_mm=1.0
    )
    np.testing.assert_allclose(positions(large), 2.0 * positions(small), atol=1e-5)
    assert large.com_clearance_mm == pytest.approx(2.0 * small.com_clearance_mm, rel=1e-5)


def test_a_mark_keeps_clear_of_other_openings_and_bosses() -> None:
    alone = mark("C3")
    there = place_openings(
        BODY, COM, [OpeningRequest("the port", 2.0, 4.0, alone.direction)], frame=FRAME, wall_mm=1.0
    )
    beside = mark("C3", others=there)
    gaps = np.linalg.norm(positions(beside) - there[0].position_mm, axis=1)
    assert gaps.min() >= 2.0 + 0.25 + 0.5
    boss = Cylinder((0.0, 0.0, 0.0), beside.direction, 3.0, 40.0)
    assert mark("C3", others=there, keep_out=(boss,)).position_mm != beside.position_mm


def test_a_way_on_a_sphere_is_a_great_circle() -> None:
    sites = random_directions(50, seed=1)
    first, second = tangent_frame(sites)
    ways = 12.0 * (0.6 * first + 0.8 * second)
    angle = 12.0 / 20.0
    expected = math.cos(angle) * sites + math.sin(angle) * (0.6 * first + 0.8 * second)
    np.testing.assert_allclose(walked(SPHERE, sites, ways), expected, atol=1e-5)
    np.testing.assert_allclose(walked(SPHERE, sites, 0.0 * ways), sites, atol=1e-15)


def test_a_way_on_the_primary_has_its_length_and_is_the_shortest() -> None:
    """Its length, measured along points on the way; a kinked way between the same ends is longer."""
    start, end_way = unit(np.array([[0.3, -0.5, 0.8]])), 0.4 * BODY.radius_mm
    along = BODY.surface(start).tangents[:, 0]
    shares = np.linspace(0.0, 1.0, 401)[:, None]
    stations = walked(BODY, np.repeat(start, 401, axis=0), shares * end_way * along)
    steps = np.diff(BODY.position_mm(stations), axis=0)
    length = np.linalg.norm(steps, axis=1).sum()
    assert length == pytest.approx(end_way, rel=1e-3)
    # It does not turn sideways: the second differences are along the normal.
    bend = steps[200] - steps[199]
    side = np.cross(BODY.normal(stations[200:201])[0], steps[200])
    assert abs(bend @ unit(side)) < 0.05 * np.linalg.norm(bend)


@pytest.mark.parametrize("text", ["A", "GC-1", "HOUSING-0001"])
def test_layouts_hold_every_letter_once_and_are_sorted_by_reach(text: str) -> None:
    layouts = mark_layouts(text, 1.0)
    count = sum(len(letter(c)) for c in text)
    for layout in layouts:
        assert layout.letters_mm.shape == (count, 2)
        assert least_spacing_mm(layout.dots_mm(-1.0)) >= 1.0
        np.testing.assert_allclose(layout.dots_mm(1.0).max(axis=0)[1], -layout.dots_mm(1.0).min(axis=0)[1])
    reaches = [layout.reach_mm for layout in layouts]
    assert reaches == sorted(reaches)


@pytest.mark.parametrize(
    ("text", "options", "message"),
    [
        ("", {}, "needs a text"),
        ("HOUSING-0001", {"dot_mm": 0.8, "min_wall_mm": 0.8}, "too large for a body of 60 mm"),
        ("A", {"depth_mm": 0.6, "wall_mm": 1.0}, r"leave 0.4 mm of a wall of 1 mm, and 0.5 mm is needed"),
        ("A", {"direction": (0.0, 1.0, 0.0), "seam_height_mm": 0.0}, "meets the seam"),
        ("A", {"direction": (0.0, 0.0, 0.0)}, "mark.direction has no length"),
        (
            "A",
            {"direction": FRAME.first, "pointing": FRAME.first},
            "has no direction where the surface faces",
        ),
        ("A1", {"seam_height_mm": 28.5, "side": "upper"}, "There is no room for the mark 'A1'"),
    ],
)
def test_marks_that_cannot_be(text: str, options: dict, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        mark(text, **options)
