"""Form error as harmonics: against an independent implementation, and bounds that hold and are reached."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gomboc_cad.body import Harmonic
from gomboc_cad.body.mass import sphere_quadrature
from gomboc_cad.body.sphere import fibonacci_directions, tangent_frame
from gomboc_cad.errors import GombocError
from gomboc_cad.tolerance.harmonics import (
    coefficient_count,
    degrees_and_orders,
    derivative_bounds_mm,
    form_error,
    form_jets,
    harmonic_jets,
    harmonic_slopes,
    highest_degree,
    largest_bends_mm,
)


def frames(normals):
    return np.stack(tangent_frame(normals), axis=1)


def random_coefficients(degree, seed, decay=1.5):
    degrees = degrees_and_orders(degree)[:, 0].astype(float)
    return np.random.default_rng(seed).normal(size=len(degrees)) * degrees**-decay


def test_the_harmonics_are_orthogonal_with_mean_square_one():
    normals, weights = sphere_quadrature(24)
    values = harmonic_jets(normals, frames(normals), 6)[0]
    gram = (values * weights) @ values.T / (4.0 * np.pi)
    assert np.allclose(gram, np.eye(coefficient_count(6)), atol=1e-12)


def test_value_gradient_and_hessian_agree_with_the_harmonics_of_the_bodies():
    """`Harmonic` sums complex profiles of orthonormal harmonics: other normalisation, other recurrence."""
    coefficients = random_coefficients(16, 1)
    normals = np.concatenate([fibonacci_directions(300), np.eye(3), -np.eye(3)])
    terms = [
        ((int(n), int(m)), float(c)) for (n, m), c in zip(degrees_and_orders(16), coefficients, strict=True)
    ]
    jet, frame = Harmonic(tuple(terms)).ambient_jet(normals), frames(normals)
    bend = frame @ jet.hessian @ frame.transpose(0, 2, 1)
    bend -= np.einsum("nx,nx->n", normals, jet.gradient)[:, None, None] * np.eye(2)
    slope = np.einsum("nax,nx->an", frame, jet.gradient)
    other = [jet.value, *slope, bend[:, 0, 0], bend[:, 0, 1], bend[:, 1, 1]]
    assert np.allclose(
        form_jets(normals, frame, coefficients), np.sqrt(4.0 * np.pi) * np.stack(other), atol=1e-11
    )


def test_single_harmonics_add_up_to_the_form_error():
    coefficients = random_coefficients(9, 2)
    normals = fibonacci_directions(200)
    frame = frames(normals)
    jet = form_jets(normals, frame, coefficients)
    assert np.allclose(
        np.einsum("akn,k->an", harmonic_jets(normals, frame, 9), coefficients), jet, atol=1e-12
    )
    slopes = np.einsum("nax,kxn,k->an", frame, harmonic_slopes(normals, 9), coefficients)
    assert np.allclose(slopes, jet[1:3], atol=1e-12)


def test_the_gradient_in_space_is_tangent_and_tells_the_change_of_the_value():
    coefficients = random_coefficients(8, 3)
    normals = fibonacci_directions(100)
    value, gradient = form_error(normals, coefficients)
    assert np.allclose(np.einsum("nx,nx->n", gradient, normals), 0.0, atol=1e-13)
    way = frames(normals)[:, 0]
    angle = 1e-5
    ahead = form_error(np.cos(angle) * normals + np.sin(angle) * way, coefficients).value_mm
    behind = form_error(np.cos(angle) * normals - np.sin(angle) * way, coefficients).value_mm
    assert np.allclose((ahead - behind) / (2.0 * angle), np.einsum("nx,nx->n", gradient, way), atol=1e-8)
    assert value.shape == (100,)


def test_one_row_of_coefficients_per_normal():
    rows = np.stack([random_coefficients(5, seed) for seed in range(7)])
    normals = fibonacci_directions(7)
    each = [form_error(n[None], row).value_mm[0] for n, row in zip(normals, rows, strict=True)]
    assert np.allclose(form_error(normals, rows).value_mm, each, rtol=1e-14)


@pytest.mark.parametrize("degree", [2, 5, 16])
def test_the_bound_of_a_degree_is_reached_by_its_zonal_harmonic(degree):
    """Coefficients Y_lm(v) make the field with the highest peak, at v."""
    top = np.array([[0.36, 0.48, 0.8]])
    peak = harmonic_jets(top, frames(top), degree)[0, :, 0]
    peak[degrees_and_orders(degree)[:, 0] < degree] = 0.0
    bounds = derivative_bounds_mm(peak[None])[0]
    jet = form_jets(top, frames(top), peak)[:, 0]
    assert jet[0] == pytest.approx(bounds[0], rel=1e-12)
    assert bounds[1] == pytest.approx(bounds[0] * np.sqrt(degree * (degree + 1) / 2.0), rel=1e-12)
    everywhere = fibonacci_directions(4000)
    value, g1, g2, *_ = form_jets(everywhere, frames(everywhere), peak)
    assert np.abs(value).max() <= bounds[0] * (1.0 + 1e-12)
    assert np.hypot(g1, g2).max() <= bounds[1]


@given(seed=st.integers(0, 10**6), decay=st.floats(0.0, 3.0))
@settings(max_examples=15, deadline=None)
def test_sampled_bends_bound_the_second_derivative_more_tightly(seed, decay):
    coefficients = random_coefficients(12, seed, decay)
    everywhere = fibonacci_directions(5000)
    h11, h12, h22 = form_jets(everywhere, frames(everywhere), coefficients)[3:]
    largest = (0.5 * np.abs(h11 + h22) + np.hypot(0.5 * (h11 - h22), h12)).max()
    bound = largest_bends_mm(coefficients[None])[0]
    assert largest <= bound <= derivative_bounds_mm(coefficients[None])[0, 2]
    assert bound < 1.6 * largest


def test_a_number_of_coefficients_that_is_no_set_of_degrees_is_refused():
    assert highest_degree(0) == 1
    assert highest_degree(285) == 16
    with pytest.raises(GombocError, match="6 is no such number"):
        highest_degree(6)
