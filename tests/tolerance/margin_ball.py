"""A study whose yield is known in closed form: a COM that has to stay within a ball.

The sources displace the COM by independent normal errors of the same size along all three axes, so its
distance from the nominal place, over the root of the sum of the squared sizes, has the chi distribution with
three degrees of freedom. A part is monostable when that distance is below the margin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import chi

from gomboc_cad.body import Body, Harmonic
from gomboc_cad.tolerance.model import Source
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, Nominal, Outcomes, Variants

Array = NDArray[np.float64]
SPHERE = Body("sphere", Harmonic(()), 50.0)
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class MarginBall:
    sizes_mm: Mapping[str, float]
    margin_mm: float = 0.2
    lowered_mm: float = 0.0
    margin_of_lowering: Callable[[float], float] | None = None
    best_mm: float | None = None
    nominal: Nominal = field(default=Nominal(SPHERE, (0.0, 0.0, 0.0)))

    @property
    def sources(self) -> tuple[Source, ...]:
        return tuple(
            Source(name, name, size, "mm", 3, "test", self.best_mm) for name, size in self.sizes_mm.items()
        )

    @property
    def sigma_mm(self) -> float:
        return float(np.linalg.norm(list(self.sizes_mm.values())))

    @property
    def true_yield(self) -> float:
        return float(chi(3).cdf(self.margin() / self.sigma_mm))

    def margin(self) -> float:
        if self.margin_of_lowering is None:
            return self.margin_mm
        return self.margin_of_lowering(self.lowered_mm)

    def variants(self, quantiles: Array) -> Variants:
        n = len(quantiles)
        draws = ndtri(quantiles).reshape(n, -1, 3)
        error = np.einsum("nkx,k->nx", draws, np.array(list(self.sizes_mm.values())))
        return Variants(error, np.broadcast_to(np.eye(3), (n, 3, 3)), np.zeros((n, 0)), np.zeros((n, 3)))

    def judge(self, variants: Variants) -> Outcomes:
        n = len(variants)
        left = self.margin() - np.linalg.norm(variants.com_mm, axis=1)
        return Outcomes(
            verdict=np.where(left > 0.0, MONOSTABLE, MULTISTABLE).astype(np.int8),
            stable=np.where(left > 0.0, 1, 2),
            rest_direction=np.tile(DOWN, (n, 1)),
            tilt_deg=np.linalg.norm(variants.com_mm[:, :2], axis=1),
            s_margin_mm=np.maximum(left, 0.0),
            stiffness_mm=np.ones((n, 2)),
        )

    def scaled(self, factors: Mapping[str, float]) -> MarginBall:
        assert set(factors) <= set(self.sizes_mm)
        return replace(self, sizes_mm={n: s * factors.get(n, 1.0) for n, s in self.sizes_mm.items()})

    def with_com_shift(self, shift_mm: tuple[float, float, float]) -> MarginBall:
        return replace(self, lowered_mm=self.lowered_mm + float(np.array(shift_mm) @ DOWN))

    def describe(self) -> dict[str, Any]:
        return {"margin_mm": self.margin_mm}
