"""A chart in which the valley and the ridge of a harmonic body are nearly straight, so that few cells do.

This is part of the search: any chart is valid, and the checker takes the one that the certificate has.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

from gomboc_cad.body.catalogue import ExactParameters, make_body

_DEGREE = 3
"""A cubic follows the valley well enough; higher degrees bend the chart so that more cells are needed."""

_RINGS = 128
_PLACES = 5
_NO_WAVE = 1e-6


def straightening_chart(parameters: ExactParameters) -> tuple[str, ...]:
    """Decimals of a polynomial P(z), for families whose chart is not given by their formula.

    P follows the phase of the first azimuthal harmonic, `Re[(x − iy) w₁(z)] = ρ |w₁| cos(φ − arg w₁)`, which
    shapes valley and ridge. It is fitted with the weight ρ |w₁|; without such a harmonic P is zero.

    Raises:
        BodyError: If the parameters are not those of a body.
    """
    if parameters.family != "harmonic":
        return ()
    body = make_body("harmonic", None, {key: float(c) for key, c in parameters.coefficients.items()})
    z, _ = legendre.leggauss(_RINGS)
    rho = np.sqrt(1.0 - z * z)[:, None]
    phi = 2.0 * np.pi * np.arange(_RINGS) / _RINGS
    rings = np.stack(np.broadcast_arrays(rho * np.cos(phi), rho * np.sin(phi), z[:, None]), axis=-1)
    values = body.shape.ambient_jet(rings.reshape(-1, 3)).value.reshape(_RINGS, _RINGS)
    wave = values @ np.exp(1j * phi) / _RINGS
    if np.abs(wave).max() <= _NO_WAVE * np.abs(values).max():
        return ()
    phase = np.unwrap(np.angle(wave))
    middle = _RINGS // 2
    phase += np.angle(wave[middle]) - phase[middle]
    fit = legendre.leg2poly(legendre.legfit(z, phase, _DEGREE, w=np.abs(wave)))
    return tuple(f"{coefficient + 0.0:.{_PLACES}f}" for coefficient in np.round(fit, _PLACES))
