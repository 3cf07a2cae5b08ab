"""The centre of mass as made, against closed forms and against bodies that are really made so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gomboc_cad import catalog
from gomboc_cad.body import Body, FourierSloan, mass_properties
from gomboc_cad.body.mass import mesh_mass
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.tolerance.com_model import Deviations, MassModel, WeighedPart, skin_moments, spread_mm2
from gomboc_cad.tolerance.harmonics import form_error

SPHERE = Body("sphere", FourierSloan(0.0), 10.0)
PRIMARY = catalog()["primary"]
SHELL = WeighedPart("shell", "shell", 30.0, (1.0, 0.0, -2.0), build_up=(0.0, 0.0, 1.0), volume_mm3=3e4)
BOARD = WeighedPart("board", "payload", 10.0, (-3.0, 4.0, 2.0), carrier="shell")
LID = replace(SHELL, name="lid", mass_g=20.0, com_mm=(0.0, 1.0, 8.0), upper=True, volume_mm3=2e4)
PARTS = (SHELL, BOARD, LID)
DEGREE = 4

MODEL = MassModel.of(PARTS, SPHERE, DEGREE)
NOMINAL = MODEL.no_deviations()

small = st.floats(-0.2, 0.2)
vectors = arrays(float, 3, elements=small)


def weighed(*masses: tuple[float, np.ndarray]) -> np.ndarray:
    """Centre of point masses, the definition itself."""
    return sum(m * np.asarray(p) for m, p in masses) / sum(m for m, _ in masses)


def one(**changed: object) -> Deviations:
    return replace(NOMINAL, **changed)


def test_nominal_is_the_weighted_mean() -> None:
    expected = weighed(*((part.mass_g, np.array(part.com_mm)) for part in PARTS))
    assert MODEL.com_mm(NOMINAL)[0] == pytest.approx(expected, abs=1e-14)


@given(mass=st.floats(-9.0, 20.0), place=vectors)
def test_a_heavier_part_elsewhere(mass: float, place: np.ndarray) -> None:
    masses, places = np.zeros((1, 3)), np.zeros((1, 3, 3))
    masses[0, 1], places[0, 1] = mass, place
    com = MODEL.com_mm(one(mass_g=masses, place_mm=places))[0]
    expected = weighed(
        (30.0, SHELL.com_mm), (10.0 + mass, np.array(BOARD.com_mm) + place), (20.0, LID.com_mm)
    )
    assert com == pytest.approx(expected, abs=1e-13)


@given(shift=vectors)
def test_displaced_upper_part_takes_its_own_along_and_nothing_else(shift: np.ndarray) -> None:
    moved = MODEL.com_mm(one(upper_shift_mm=shift[None]))[0] - MODEL.com_mm(NOMINAL)[0]
    assert moved == pytest.approx(20.0 / 60.0 * shift, abs=1e-14)


@given(factors=arrays(float, 3, elements=st.floats(0.9, 1.1)))
def test_shrinkage_moves_everything_but_changes_only_made_masses(factors: np.ndarray) -> None:
    com = MODEL.com_mm(one(stretch=np.diag(factors)[None]))[0]
    growth = factors.prod()
    expected = weighed(
        (30.0 * growth, factors * SHELL.com_mm),
        (10.0, factors * BOARD.com_mm),
        (20.0 * growth, factors * LID.com_mm),
    )
    assert com == pytest.approx(expected, abs=1e-13)


def test_free_error_and_intended_shift_simply_add() -> None:
    shifted = replace(MODEL, shift_mm=(0.0, 0.0, -1.0))
    com = shifted.com_mm(one(com_mm=np.array([[0.1, 0.2, 0.3]])))[0]
    assert com - MODEL.com_mm(NOMINAL)[0] == pytest.approx([0.1, 0.2, -0.7], abs=1e-14)


def test_there_is_no_negative_mass() -> None:
    masses = np.array([[0.0, -11.0, 0.0]])
    expected = weighed((30.0, SHELL.com_mm), (20.0, LID.com_mm))
    assert MODEL.com_mm(one(mass_g=masses))[0] == pytest.approx(expected, abs=1e-13)


def test_rows_do_not_depend_on_their_batch() -> None:
    rng, n = np.random.default_rng(1), 100
    stretch = np.eye(3) + 0.01 * rng.normal(size=(n, 3, 3))
    many = Deviations(
        form_mm=rng.normal(size=(n, len(MODEL.skin_g_per_mm))),
        stretch=0.5 * (stretch + stretch.transpose(0, 2, 1)),
        upper_shift_mm=rng.normal(size=(n, 3)),
        mass_g=rng.normal(size=(n, 3)),
        place_mm=rng.normal(size=(n, 3, 3)),
        com_mm=rng.normal(size=(n, 3)),
    )
    together = MODEL.com_mm(many)
    for rows in (slice(0, 1), slice(17, 18), slice(3, 96, 7), slice(50, 100)):
        some = Deviations(**{name: value[rows] for name, value in vars(many).items()})
        assert np.array_equal(MODEL.com_mm(some), together[rows])


def test_spread_of_a_box_and_of_a_sphere() -> None:
    corners = np.array(np.meshgrid([-1.0, 1.0], [-2.0, 2.0], [-3.0, 3.0], indexing="ij")).reshape(3, -1).T
    faces = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    box = mesh_mass(corners + 5.0, np.array(faces))
    assert spread_mm2(box) == pytest.approx(np.diag([4.0, 16.0, 36.0]) / 12.0, abs=1e-12)
    assert spread_mm2(mass_properties(SPHERE)) == pytest.approx(20.0 * np.eye(3), abs=1e-9)


def test_a_skin_of_a_harmonic_weighs_nothing_on_a_sphere() -> None:
    volume, moment = skin_moments(SPHERE, 6)
    assert volume.shape == (45,)
    assert np.abs(volume).max() < 1e-9 * 10.0**2
    assert np.abs(moment).max() < 1e-9 * 10.0**3


def test_form_error_moves_the_centroid_of_a_body_that_is_really_made_so() -> None:
    """The body with the support function h + δ as a mesh of points `x + ∇δ + δ v`."""
    degree, rng = 5, np.random.default_rng(3)
    directions, faces = geodesic_triangulation(6)
    surface = PRIMARY.surface(directions)
    mass = mass_properties(PRIMARY)
    whole = WeighedPart(
        "body", "shell", 1.0, mass.com_mm, build_up=(0.0, 0.0, 1.0), volume_mm3=mass.volume_mm3
    )
    model = MassModel.of((whole,), PRIMARY, degree)
    coefficients = 0.01 * rng.normal(size=(4, len(model.skin_g_per_mm)))
    blank = model.no_deviations()
    for row in coefficients:
        delta = form_error(surface.normal, row)
        skin = delta.gradient_mm + delta.value_mm[:, None] * surface.normal
        more, less = (mesh_mass(surface.position_mm + sign * skin, faces) for sign in (1.0, -1.0))
        # Half the difference has no term of second order.
        expected = 0.5 * np.subtract(more.com_mm, less.com_mm)
        both = [model.com_mm(replace(blank, form_mm=sign * row[None]))[0] for sign in (1.0, -1.0)]
        found = 0.5 * (both[0] - both[1])
        assert np.linalg.norm(expected) > 0.001
        assert np.linalg.norm(found - expected) < 0.005 * np.linalg.norm(expected)
        volume = row @ model.skin_g_per_mm * whole.volume_mm3
        assert volume == pytest.approx(0.5 * (more.volume_mm3 - less.volume_mm3), rel=0.005)
