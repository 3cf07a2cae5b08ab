"""Variants for tests, and the solids that they stand for."""

import numpy as np

from gomboc_cad.body import Body, Harmonic, catalog, mass_properties
from gomboc_cad.body.sphere import geodesic_triangulation
from gomboc_cad.tolerance.harmonics import coefficient_count, degrees_and_orders, form_error
from gomboc_cad.tolerance.variants import Nominal, Variants

RADIUS_MM = 50.0


def primary():
    body = catalog()["primary"].with_diameter(2.0 * RADIUS_MM)
    return Nominal(body, mass_properties(body).com_mm)


def ballasted_sphere(lowering_mm):
    return Nominal(Body("sphere", Harmonic(()), RADIUS_MM), (0.0, 0.0, -lowering_mm))


def unchanged(nominal, count, degree=None):
    size = 0 if degree is None else coefficient_count(degree)
    return Variants(
        np.tile(nominal.com_mm, (count, 1)),
        np.tile(np.eye(3), (count, 1, 1)),
        np.zeros((count, size)),
        np.zeros((count, 3)),
    )


def with_com(nominal, com_mm):
    plain = unchanged(nominal, len(com_mm))
    return Variants(np.asarray(com_mm, dtype=float), plain.stretch, plain.form_mm, plain.upper_shift_mm)


def random_variants(nominal, count, seed, *, form_mm=0.0, com_mm=0.0, stretch=0.0, shift_mm=0.0, degree=16):
    """Normal scatter of everything; the form error falls off with the square of the degree."""
    rng = np.random.default_rng(seed)
    degrees = degrees_and_orders(degree)[:, 0].astype(float)
    spread = degrees**-2.0 / np.sqrt(2.0 * degrees + 1.0)
    spread *= form_mm / np.sqrt((np.arange(2.0, degree + 1.0) ** -4.0).sum())
    scatter = rng.normal(size=(count, 3, 3)) * stretch
    return Variants(
        np.array(nominal.com_mm) + com_mm * rng.normal(size=(count, 3)),
        np.eye(3) + 0.5 * (scatter + scatter.transpose(0, 2, 1)),
        rng.normal(size=(count, len(degrees))) * spread,
        shift_mm * rng.normal(size=(count, 3)),
    )


def points_as_made(nominal, variants, row, level=6):
    """Points of the surface of a variant before it is stretched or displaced, and triangles."""
    directions, faces = geodesic_triangulation(level)
    surface = nominal.body.surface(directions)
    value, gradient = form_error(surface.normal, variants.form_mm[row])
    points = surface.position_mm + gradient + value[:, None] * surface.normal
    return points, faces
