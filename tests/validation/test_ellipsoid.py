"""An ellipsoid through the harmonic family: every figure of geometry against its closed form.

The ellipsoid `x²/a² + y²/b² + z²/c² = 1` has `r⁴ = (x²/a² + y²/b² + z²/c²)⁻²` over the directions, which is
projected on the real orthonormal harmonics up to a degree; the errors must fall geometrically with it.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from gomboc_cad.body import Body, mass_properties, support_jet
from tests.body.shapes import Array, ellipsoid, random_directions

RATIOS = (1.5, 1.2, 1.0)
DEGREES = (8, 16, 24, 40)


@pytest.fixture(scope="module")
def family() -> dict[int, tuple[Body, Array]]:
    return {degree: ellipsoid(RATIOS, degree) for degree in DEGREES}


def errors_of(body: Body, axes: Array) -> dict[str, float]:
    """The greatest error of each figure against its closed form."""
    u = random_directions(200, seed=1)
    points = body.surface(u)
    x = points.position_mm
    gradient = x / axes**2
    length = np.linalg.norm(gradient, axis=1)
    # Gauss and mean curvature of an ellipsoid: do Carmo, Differential Geometry of Curves and Surfaces, §3-3.
    gauss = 1.0 / (np.prod(axes) ** 2 * length**4)
    mean = (np.sum(axes**2) - np.sum(x * x, axis=1)) / (2.0 * np.prod(axes) ** 2 * length**3)
    curvature = points.principal_curvatures_per_mm()
    jet = support_jet(body, u)
    h = np.sqrt(np.sum((axes * u) ** 2, axis=1))
    touch = axes**2 * u / h[:, None]
    # ∇²h + h I restricted to the tangent plane is the ambient Hessian of h(u) = |A u|.
    ambient = (np.diag(axes**2) - touch[:, :, None] * touch[:, None, :]) / h[:, None, None]
    hessian = jet.tangents @ ambient @ jet.tangents.transpose(0, 2, 1) - h[:, None, None] * np.eye(2)
    mass = mass_properties(body)
    volume = 4.0 / 3.0 * np.pi * np.prod(axes)
    inertia = volume / 5.0 * np.diag(np.sum(axes**2) - axes**2)
    return {
        "radius": np.abs(body.radius_at(u) - np.sum((u / axes) ** 2, axis=1) ** -0.5).max(),
        "normal": np.abs(points.normal - gradient / length[:, None]).max(),
        "gauss curvature": np.abs(np.prod(curvature, axis=1) - gauss).max(),
        "mean curvature": np.abs(curvature.mean(axis=1) - mean).max(),
        "support": np.abs(jet.height_mm - h).max(),
        "support gradient": np.abs(jet.gradient_mm - (touch - h[:, None] * u)).max(),
        "support hessian": np.abs(jet.hessian_mm - hessian).max(),
        "volume": abs(mass.volume_mm3 - volume),
        "centroid": np.abs(mass.com_mm).max(),
        "inertia": np.abs(np.array(mass.inertia_mm5) - inertia).max(),
    }


def test_every_figure_converges_to_its_closed_form(family: dict[int, tuple[Body, Array]]) -> None:
    errors = {degree: errors_of(*family[degree]) for degree in DEGREES}
    for name in errors[40]:
        if name == "centroid":
            assert all(errors[degree][name] < 1e-13 for degree in DEGREES)
            continue
        sequence = [errors[degree][name] for degree in DEGREES]
        for coarse, fine in pairwise(sequence):
            assert fine < 0.05 * coarse or fine < 1e-11, (name, sequence)
    for name in ("radius", "normal", "support", "support gradient", "volume", "inertia"):
        assert errors[40][name] < 1e-10, name
    for name in ("gauss curvature", "mean curvature", "support hessian"):
        assert errors[40][name] < 1e-8, name


def test_principal_curvatures_at_the_ends_of_the_axes(family: dict[int, tuple[Body, Array]]) -> None:
    """At the end of the axis a: κ = a/b² and a/c²."""
    body, axes = family[40]
    for i in range(3):
        for sign in (1.0, -1.0):
            u = sign * np.eye(3)[i : i + 1]
            points = body.surface(u)
            a, others = axes[i], np.delete(axes, i)
            expected = np.sort(a / others**2)[::-1]
            np.testing.assert_allclose(points.principal_curvatures_per_mm()[0], expected, atol=1e-8)
            np.testing.assert_allclose(points.normal, u, atol=1e-10)
