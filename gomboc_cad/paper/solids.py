"""What is true of the simple solids in the paper's tables, in closed form.

All have the volume of the unit ball and the proportions of the meshes of `equilibria.drainage_shapes`.
With the support function h about the centroid, a quasi-static release ends where h has its minimum; SRE is
the mean of h over the sphere, which is half the mean width, less that minimum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

from scipy.special import elliprg

_BALL = 4.0 * math.pi / 3.0


@dataclass(frozen=True)
class Solid:
    """Exact figures of a homogeneous solid.

    Attributes:
        rests: Number of stable rests, a connected set of neutral ones being one.
        neutral: What such a set is, and what other rests there are; empty if all are isolated.
        height_range: Largest less smallest height of the centroid.
        sre: Mean drop of the centroid from a random orientation to the lowest rest; None where not needed.
        boa: Share of the orientations that end in the most frequent rest.
    """

    rests: int
    neutral: str
    height_range: float
    sre: float | None
    boa: float

    @property
    def shown(self) -> int | str:
        """The number of rests, or what there is instead of isolated ones."""
        return self.neutral or self.rests

    def refutes(self, count: int) -> bool:
        """Whether a count of the paper is wrong.

        A ring of neutral rests is not the strong minimum for which the paper counts it. Of a ball, where
        every pose is neutral, it says itself that the count is noise.
        """
        if self.height_range == 0.0:
            return False
        return self.rests != count or (self.rests == 1 and bool(self.neutral))


def solid(name: str) -> Solid:
    """One of the six solids."""
    return _solids()[name]


@lru_cache(maxsize=1)
def _solids() -> dict[str, Solid]:
    return {
        "sphere": Solid(1, "every pose, neutral", 0.0, 0.0, 1.0),
        "cylinder": _cylinder(),
        "hemisphere": _hemisphere(),
        "ellipsoid": _ellipsoid(),
        "capsule": _capsule(),
        "cube": _cube(),
    }


def _cylinder() -> Solid:
    """Radius r, length 4 r: it tips from an end to its side where the COM passes over the rim.

    That is at the angle of tangent 1/2 from the axis, so the ends have the share `1 − 2/√5`. The mean of
    `r sinθ + 2 r |cosθ|` is `(π/4 + 1) r`.
    """
    r = (1.0 / 3.0) ** (1.0 / 3.0)
    return Solid(3, "2 ends and a ring", (math.sqrt(5.0) - 1.0) * r, 0.25 * math.pi * r, 2.0 / math.sqrt(5.0))


def _hemisphere() -> Solid:
    """Centroid at 3/8 R over the flat; the basins border where it is over the rim."""
    radius = 2.0 ** (1.0 / 3.0)
    rim = math.hypot(1.0, 0.375)
    return Solid(2, "", (rim - 0.375) * radius, None, 0.5 * (1.0 + 0.375 / rim))


def _ellipsoid() -> Solid:
    """Semi-axes a > b > c: it rests on either end of c. The mean of h is Carlson's `R_G(a², b², c²)`."""
    size = 1.05 ** (1.0 / 3.0)
    a, b, c = 1.5 / size, 1.0 / size, 0.7 / size
    return Solid(2, "", a - c, float(elliprg(a * a, b * b, c * c)) - c, 0.5)


def _capsule() -> Solid:
    """Caps of radius r on a straight part of 5 r: `h = r + 2.5 r |cosθ|`."""
    r = (_BALL / (5.0 * math.pi + _BALL)) ** (1.0 / 3.0)
    return Solid(1, "a neutral ring", 2.5 * r, 1.25 * r, 1.0)


def _cube() -> Solid:
    """Edge 2 a: `h = a (|x| + |y| + |z|)`, with the mean 3 a/2."""
    a = 0.5 * _BALL ** (1.0 / 3.0)
    return Solid(6, "", (math.sqrt(3.0) - 1.0) * a, 0.5 * a, 1.0 / 6.0)
