"""The equation of moments about the target of the centre of mass, and what is free in it.

Moments about the target add up to zero when the centre of mass is there, whatever the total mass.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import lsq_linear

from gomboc_cad.body.sphere import Array
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.products.placing.trim import TrimItem, TrimSite

_STEPS = 20
_SETTLED = 1e-13


@dataclass(frozen=True)
class CoreMove:
    """How the core's place moves the centre of mass.

    Attributes:
        lever_g: Moving the core by s adds `lever_g · s` to the moment Σ m p: the mass of all that moves with
            the core, less the mass of shell that would fill what is empty in it.
        limit_mm: The farthest that the core may move.
    """

    lever_g: float
    limit_mm: float


@dataclass(frozen=True)
class Choice:
    """One way to use a site.

    Attributes:
        site: The site.
        item: The mass; None for a pocket.
        diameter_mm: Diameter of the hole.
        low_mm: Least depth: of the middle of the mass, or of the pocket's bottom.
        high_mm: Greatest depth.
        item_mass_g: Mass of the item; zero for a pocket.
        hole_g_mm: Mass of the shell's material that the hole takes away, per length.
        material: Material of the item; empty for a pocket.
    """

    site: TrimSite
    item: TrimItem | None
    diameter_mm: float
    low_mm: float
    high_mm: float
    item_mass_g: float
    hole_g_mm: float
    material: str = ""

    @property
    def range_mm(self) -> tuple[float, float]:
        """Depths among which to settle: of a pocket, a step more on both sides."""
        if self.item is not None:
            return self.low_mm, self.high_mm
        step = self.high_mm - self.low_mm
        return max(0.0, self.low_mm - step), min(self.site.length_mm, self.high_mm + step)

    def hole_mm(self, depth_mm: float) -> float:
        """Depth of the hole: it ends where the item ends."""
        return depth_mm if self.item is None else depth_mm + 0.5 * self.item.length_mm

    @property
    def bulge_g_mm(self) -> float:
        """Most by which the moment, quadratic in the depth as the hole grows, is off its chord."""
        return self.hole_g_mm * (self.high_mm - self.low_mm) ** 2 / 8.0

    def added_mass_g(self, depth_mm: float) -> float:
        """Mass of the item less that of the hole."""
        return self.item_mass_g - self.hole_g_mm * self.hole_mm(depth_mm)

    def cost_g(self, depth_mm: float) -> float:
        """What is to be small: the mass that is put in, or the mass that a pocket takes away."""
        return self.hole_g_mm * depth_mm if self.item is None else self.item_mass_g

    def moved_mass_g(self, depth_mm: float) -> float:
        """What it adds to the core's lever."""
        return self.added_mass_g(depth_mm) if self.site.moves_with_core else 0.0

    def moment_g_mm(self, depth_mm: float, target_mm: Vector) -> Array:
        """Moment of the item and the hole about the target, before the core's shift, shape (3,)."""
        below = 0.0 if self.item is None else self.item.com_below_middle_mm
        along = self.item_mass_g * (depth_mm + below) - 0.5 * self.hole_g_mm * self.hole_mm(depth_mm) ** 2
        arm = np.subtract(self.site.base_mm, target_mm)
        result: Array = self.added_mass_g(depth_mm) * arm + along * self.site.direction
        return result

    def moment_per_mm(self, depth_mm: float, target_mm: Vector) -> Array:
        """Change of that moment with the depth, shape (3,)."""
        bottom = np.subtract(self.site.base_mm, target_mm) + self.hole_mm(depth_mm) * self.site.direction
        result: Array = self.item_mass_g * self.site.direction - self.hole_g_mm * bottom
        return result


class Use(NamedTuple):
    """A choice and how deep it goes."""

    choice: Choice
    depth_mm: float


@dataclass(frozen=True)
class Balance:
    """The equation `moment + lever · shift = 0` about the target.

    Attributes:
        target_mm: The target.
        mass_g: Mass of the assembly without trim.
        moment_g_mm: Its moment about the target, the core not moved.
        core: What the core's place does; None for a core that cannot move.
        choices: All ways to use the sites.
    """

    target_mm: Vector
    mass_g: float
    moment_g_mm: Vector
    core: CoreMove | None
    choices: tuple[Choice, ...] = ()

    @property
    def limit_mm(self) -> float:
        """The farthest that the core may move."""
        return max(0.0, self.core.limit_mm) if self.core else 0.0

    def mass_with_g(self, uses: Sequence[Use]) -> float:
        """Total mass with some trim."""
        return self.mass_g + sum(use.choice.added_mass_g(use.depth_mm) for use in uses)

    def moment_with_g_mm(self, uses: Sequence[Use]) -> Array:
        """Moment about the target with some trim, the core not moved, shape (3,)."""
        moment = np.array(self.moment_g_mm)
        for use in uses:
            moment += use.choice.moment_g_mm(use.depth_mm, self.target_mm)
        return moment

    def lever_with_g(self, uses: Sequence[Use]) -> float:
        """Lever of the core with some trim; zero for a core that cannot move."""
        if self.core is None:
            return 0.0
        return self.core.lever_g + sum(use.choice.moved_mass_g(use.depth_mm) for use in uses)

    def shift_mm(self, uses: Sequence[Use]) -> Array:
        """Displacement of the core, within its limit, that leaves the least moment, shape (3,)."""
        moment, lever = self.moment_with_g_mm(uses), self.lever_with_g(uses)
        reach, size = abs(lever) * self.limit_mm, float(np.linalg.norm(moment))
        if reach == 0.0 or size == 0.0:
            return np.zeros(3)
        result: Array = -moment / lever * min(1.0, reach / size)
        return result

    def com_mm(self, uses: Sequence[Use]) -> Array:
        """Centre of mass with some trim and the core in the place that suits it, shape (3,)."""
        moment = self.moment_with_g_mm(uses) + self.lever_with_g(uses) * self.shift_mm(uses)
        result: Array = self.target_mm + moment / self.mass_with_g(uses)
        return result

    def off_mm(self, uses: Sequence[Use]) -> float:
        """Distance of that centre of mass from the target."""
        return float(np.linalg.norm(self.com_mm(uses) - self.target_mm))

    def drawn_near(self, uses: Sequence[Use]) -> tuple[Use, ...]:
        """Change the depths within their ranges so that the core has least to do: Gauss–Newton, bounded."""
        depth = np.array([use.depth_mm for use in uses])
        low, high = np.array([use.choice.range_mm for use in uses]).reshape(-1, 2).T
        free = high > low
        for _ in range(_STEPS if free.any() else 0):
            now = [Use(use.choice, float(d)) for use, d in zip(uses, depth, strict=True)]
            slope = np.array([use.choice.moment_per_mm(use.depth_mm, self.target_mm) for use in now])[free].T
            scale = float(np.abs(slope).max()) or 1.0
            step = lsq_linear(
                slope / scale,
                -self.moment_with_g_mm(now) / scale,
                (low[free] - depth[free], high[free] - depth[free]),
                method="bvls",
                tol=1e-15,
            ).x
            depth[free] = np.clip(depth[free] + step, low[free], high[free])
            if np.abs(step).max() < _SETTLED * high.max():
                break
        return tuple(Use(use.choice, float(d)) for use, d in zip(uses, depth, strict=True))
