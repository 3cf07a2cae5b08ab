"""Bodies whose truth is known, made without the package's own harmonics and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray
from scipy.special import sph_harm_y

from gomboc_cad.body import Body, Harmonic, ShapeFunction
from gomboc_cad.body.families import AmbientJet

Array = NDArray[np.float64]

EVERY_FAMILY = {
    "sloan1": ("sloan1", 0.03, {}),
    "sloan2": ("sloan2", 0.03, {}),
    "extended": ("extended", 0.02, {"1": 0.234433, "2": -0.1, "5": 0.04}),
    "harmonic": (
        "harmonic",
        None,
        {"2,0": 0.02, "2,-1": 0.01, "3,3": -0.008, "4,-2": 0.004, "7,1": 2e-3, "9,-9": 1e-3},
    ),
}


def real_harmonic(degree: int, order: int, directions: Array) -> Array:
    """Real orthonormal Y_lm without the Condon–Shortley sign, by SciPy."""
    x, y, z = directions.T
    polar, azimuth = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    value = sph_harm_y(degree, abs(order), polar, azimuth) * (-1.0) ** order
    if order == 0:
        return value.real
    return np.sqrt(2.0) * (value.real if order > 0 else value.imag)


def product_rule(order: int) -> tuple[Array, Array]:
    """Gauss–Legendre in cosθ times equal steps in φ: exact for harmonics below degree 2·order."""
    z, weight = np.polynomial.legendre.leggauss(order)
    phi = 2.0 * np.pi * np.arange(2 * order) / (2 * order)
    rho = np.sqrt(1.0 - z * z)
    grid = np.stack(
        [np.outer(rho, np.cos(phi)), np.outer(rho, np.sin(phi)), np.outer(z, np.ones_like(phi))], axis=-1
    )
    return grid.reshape(-1, 3), np.outer(weight, np.full(2 * order, np.pi / order)).ravel()


def projected(f: Callable[[Array], Array], places: Iterable[tuple[int, int]], order: int) -> Harmonic:
    """Project a function on the sphere on the real harmonics (l, m) of the given places."""
    u, weight = product_rule(order)
    values = weight * f(u)
    terms = {(degree, m): float(values @ real_harmonic(degree, m, u)) for degree, m in places}
    return Harmonic(tuple((place, c) for place, c in terms.items() if abs(c) > 1e-17))


def ellipsoid(ratios: tuple[float, float, float], degree: int) -> tuple[Body, Array]:
    """Make an ellipsoid through the harmonic family, truncated at a degree.

    The size is such that the mean of r⁴ is 1, because the family has no term of degree 0.

    Returns:
        The body with R₀ = 1, and the semi-axes of the ellipsoid that it approaches.
    """
    axes = np.array(ratios, dtype=float)
    u, weight = product_rule(64)
    mean = weight @ np.sum((u / axes) ** 2, axis=1) ** -2 / (4.0 * np.pi)
    axes /= mean**0.25

    def f(directions: Array) -> Array:
        return (np.sum((directions / axes) ** 2, axis=1) ** -2 - 1.0) / 4.0

    # By its planes of symmetry an ellipsoid has even degrees and cosines of even orders only.
    places = [(n, m) for n in range(2, degree + 1, 2) for m in range(0, n + 1, 2)]
    return Body("ellipsoid", projected(f, places, 48), 1.0), axes


def rotated(body: Body, rotation: Array) -> Body:
    """Rotate a harmonic body: f'(u) = f(Rᵀ u), projected again on its own degrees."""
    assert isinstance(body.shape, Harmonic)
    shape = body.shape
    degrees = sorted({degree for (degree, _), _ in shape.terms})

    def f(directions: Array) -> Array:
        return shape.ambient_jet(directions @ rotation).value

    places = [(degree, m) for degree in degrees for m in range(-degree, degree + 1)]
    return Body(f"{body.name} rotated", projected(f, places, max(degrees) + 2), body.radius_mm)


def random_directions(count: int, seed: int = 0) -> Array:
    """Uniform random directions."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


class Counting:
    """A shape function that counts at how many directions it was asked."""

    def __init__(self, shape: ShapeFunction) -> None:
        self.shape = shape
        self.asked = 0

    @property
    def family(self) -> str:
        return self.shape.family

    def ambient_jet(self, directions: Array) -> AmbientJet:
        self.asked += len(directions)
        return self.shape.ambient_jet(directions)
