"""How far a rest tilts when the COM is off: the prediction against the rest recomputed.

The tilt is `δu = −(∇²h)⁻¹ δ∇h` with the Hessian of the support function over the **normals**. The Hessian
of `|x(u) − c|` over the surface parameter has the same signs, and for the primary nearly the same soft
value, but its stiff value is eleven times smaller; the tests show which of the two a real rest obeys.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from gomboc_cad.body import Body, catalog
from gomboc_cad.body.sphere import tangent_frame
from gomboc_cad.equilibria import Census, find_equilibria, smooth_census

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def body() -> Body:
    return catalog()["primary"]


@pytest.fixture(scope="module")
def census(body: Body) -> Census:
    return smooth_census(body)


def turned_by(body: Body, census: Census, shift_mm: Array) -> Array:
    """Rotation of the rest direction, as a vector in degrees, after the COM has moved."""
    com = np.array(census.com_mm) + shift_mm
    return np.degrees(np.array(find_equilibria(body, com)[0].direction) - np.array(census.rest.direction))


def test_a_com_error_tilts_the_rest_as_predicted(body: Body, census: Census) -> None:
    """Along the soft and the stiff axis, both ways; the rest turns towards the shifted COM."""
    rest = census.rest
    axes = (rest.soft_direction, rest.stiff_direction)
    for axis, tilt, micrometres in zip(axes, rest.tilt_deg_per_um, (0.01, 1.0), strict=True):
        for sign in (1.0, -1.0):
            moved = turned_by(body, census, sign * micrometres * 1e-3 * np.array(axis))
            assert moved @ np.array(axis) == pytest.approx(sign * micrometres * tilt, rel=1e-3)
            assert np.linalg.norm(moved) == pytest.approx(micrometres * tilt, rel=1e-3)


def test_the_tilt_matrix_predicts_any_small_error_of_the_com(body: Body, census: Census) -> None:
    rest = census.rest
    basis = np.array([rest.soft_direction, rest.stiff_direction])
    matrix = np.array(rest.tilt_matrix_deg_per_um)
    for shift_um in np.random.default_rng(2).normal(size=(5, 3)) * 0.01:
        moved = turned_by(body, census, 1e-3 * shift_um)
        np.testing.assert_allclose(basis @ moved, matrix @ (basis @ shift_um), rtol=2e-3, atol=1e-8)


def test_a_com_error_along_the_rest_direction_does_not_tilt(body: Body, census: Census) -> None:
    moved = turned_by(body, census, 1e-3 * np.array(census.rest.direction))
    assert np.linalg.norm(moved) < 1e-9


def test_the_stiffness_is_that_of_the_height_over_normals(body: Body, census: Census) -> None:
    """0.003391 and 10.32 R: the radii of curvature at the foot less the height of the COM."""
    soft, stiff = (value / body.radius_mm for value in census.rest.stiffness_mm)
    assert soft == pytest.approx(0.003391, rel=1e-3)
    assert stiff == pytest.approx(10.32, rel=1e-3)
    foot = body.surface(-np.eye(3)[:1])
    radii = np.sort(1.0 / foot.principal_curvatures_per_mm()[0])
    np.testing.assert_allclose(census.rest.stiffness_mm, radii - census.rest.height_mm, rtol=1e-9)


def test_the_hessian_over_the_surface_parameter_is_another_matrix(body: Body, census: Census) -> None:
    """Its eigenvalues are 0.00340 and 0.8944 R, by differences along great circles of u.

    At a rest it is `h² (1/h − κ)`, against `1/κ − h` over normals: alike where κ h ≈ 1, far softer on the
    flat side. A tilt computed with 0.8944 R would be eleven times too large on the stiff axis.
    """
    com = np.array(census.com_mm)
    u = np.array(census.rest.direction)
    first, second = (e[0] for e in tangent_frame(u[None]))

    def distance(p: float, q: float) -> float:
        v = u + p * first + q * second
        v /= np.linalg.norm(v)
        return float(np.linalg.norm(body.position_mm(v[None])[0] - com))

    step = 1e-3
    centre = distance(0.0, 0.0)
    hessian = np.empty((2, 2))
    hessian[0, 0] = (distance(step, 0) - 2 * centre + distance(-step, 0)) / step**2
    hessian[1, 1] = (distance(0, step) - 2 * centre + distance(0, -step)) / step**2
    mixed = distance(step, step) - distance(step, -step) - distance(-step, step) + distance(-step, -step)
    hessian[0, 1] = hessian[1, 0] = mixed / (4 * step**2)
    values = np.linalg.eigvalsh(hessian) / body.radius_mm
    assert values[0] == pytest.approx(0.00340, rel=0.01)
    assert values[1] == pytest.approx(0.8944, rel=1e-3)

    true = census.rest.tilt_deg_per_um[1]
    wrong = np.degrees(1e-3 / (values[1] * body.radius_mm))
    measured = np.linalg.norm(turned_by(body, census, 1e-3 * np.array(census.rest.stiff_direction)))
    assert measured == pytest.approx(true, rel=1e-3)
    assert wrong / measured == pytest.approx(11.5, rel=0.02)


def test_ten_micrometres_tilt_the_housing_by_degrees_not_by_seconds(body: Body, census: Census) -> None:
    """arXiv 2604.17095 v1 states arctan(0.01/100) = 20.6″ for 10 µm; at R₀ = 50 mm it is about 3.3°.

    20.6″ would need the COM within 17 nm along the soft axis.
    """
    moved = turned_by(body, census, 0.01 * np.array(census.rest.soft_direction))
    assert np.linalg.norm(moved) == pytest.approx(3.3, abs=0.2)
    assert np.degrees(np.arctan(0.01 / 100.0)) * 3600.0 == pytest.approx(20.6, abs=0.05)
    needed_um = 20.6 / 3600.0 / census.rest.tilt_deg_per_um[0]
    assert needed_um == pytest.approx(0.017, abs=0.0005)


def test_the_stiffness_matrix_takes_a_small_tilt_to_the_com_error_behind_it() -> None:
    """The rest about a COM moved by v across the vertical turns by δu with `(∇²h) δu = v`."""
    body = catalog()["primary"]
    census = smooth_census(body)
    com, down = np.array(census.com_mm), np.array(census.rest.direction)
    for axis in (census.rest.soft_direction, census.rest.stiff_direction):
        moved = 1e-6 * np.array(axis)
        turned = np.array(find_equilibria(body, com + moved)[0].direction) - down
        found = np.array(census.rest.stiffness_matrix_mm) @ turned
        assert found == pytest.approx(moved, rel=1e-3, abs=1e-9)
