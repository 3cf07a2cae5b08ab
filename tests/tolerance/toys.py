"""Models whose studies have answers in closed form. Worker processes import them from here."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import ndtri
from threadpoolctl import threadpool_info

from gomboc_cad.body import Body, Harmonic
from gomboc_cad.body.sphere import Array
from gomboc_cad.tolerance.model import Source
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, UNDECIDED, Nominal, Outcomes, Variants

SPHERE = Body("sphere", Harmonic(()), 50.0)


def made(com_mm: Array) -> Variants:
    """Bodies without any error but that of the COM."""
    count = len(com_mm)
    return Variants(
        com_mm, np.broadcast_to(np.eye(3), (count, 3, 3)), np.empty((count, 0)), np.zeros((count, 3))
    )


@dataclass(frozen=True)
class LoadedSphere:
    """A sphere whose COM is lowered along −z and scatters normally; two sources, across and along.

    A sphere has one rest wherever its COM is. So that some variants are bad, those are called multistable
    whose COM is farther from the nominal one than a margin, and undecided those beyond a second radius.

    Attributes:
        lowered_mm: Nominal distance of the COM from the centre.
        across_mm: Standard deviation of the COM in each of x and y.
        along_mm: Standard deviation of the COM in z.
        margin_mm: Radius of the ball of good places.
        doubt_mm: Radius of the ball of places with a verdict.
        pause_s: How long the judging of a batch takes at least.
    """

    lowered_mm: float = 1.0
    across_mm: float = 0.1
    along_mm: float = 0.1
    margin_mm: float = np.inf
    doubt_mm: float = np.inf
    pause_s: float = 0.0

    @property
    def sources(self) -> tuple[Source, ...]:
        return (
            Source("across", "COM across", self.across_mm, "mm sd", 2, "made up"),
            Source("along", "COM along", self.along_mm, "mm sd", 1, "made up"),
        )

    @cached_property
    def nominal(self) -> Nominal:
        return Nominal(SPHERE, (0.0, 0.0, -self.lowered_mm))

    def variants(self, quantiles: Array) -> Variants:
        sizes = (self.across_mm, self.across_mm, self.along_mm)
        return made(np.array(self.nominal.com_mm) + ndtri(quantiles) * sizes)

    def judge(self, variants: Variants) -> Outcomes:
        time.sleep(self.pause_s)
        com = variants.com_mm
        error = np.linalg.norm(com - np.array(self.nominal.com_mm), axis=1)
        off = np.linalg.norm(com, axis=1)
        verdict = np.where(error < self.margin_mm, MONOSTABLE, MULTISTABLE)
        verdict = np.where(error < self.doubt_mm, verdict, UNDECIDED).astype(np.int8)
        known = verdict != UNDECIDED
        tilt = np.degrees(np.arctan2(np.hypot(com[:, 0], com[:, 1]), -com[:, 2]))
        margin = np.minimum(off, np.maximum(self.margin_mm - error, 0.0))
        return Outcomes(
            verdict=verdict,
            stable=np.where(known, 1 + verdict, 0),
            rest_direction=com / off[:, None],
            tilt_deg=np.where(known, tilt, np.nan),
            s_margin_mm=np.where(known, margin, np.nan),
            stiffness_mm=np.where(known, off, np.nan)[:, None] * np.ones(2),
        )

    def scaled(self, factors: Mapping[str, float]) -> LoadedSphere:
        across, along = (factors.get(name, 1.0) for name in ("across", "along"))
        return replace(self, across_mm=across * self.across_mm, along_mm=along * self.along_mm)

    def describe(self) -> dict[str, Any]:
        return {"toy": "loaded sphere"}


@dataclass(frozen=True)
class Ishigami(LoadedSphere):
    """`sin x₁ + a sin² x₂ + b x₃⁴ sin x₁`, uniform in (−π, π)³, as the tilt; its groups are given.

    Attributes:
        groups: Columns of each source; those beyond the third have no effect.
    """

    groups: tuple[int, ...] = (1, 1, 1)

    @property
    def sources(self) -> tuple[Source, ...]:
        return tuple(Source(f"group {k}", "", 1.0, "", size, "made up") for k, size in enumerate(self.groups))

    def variants(self, quantiles: Array) -> Variants:
        return made(np.pi * (2.0 * quantiles[:, :3] - 1.0))

    def judge(self, variants: Variants) -> Outcomes:
        x, y, z = variants.com_mm.T
        value = np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
        return replace(super().judge(variants), tilt_deg=value, s_margin_mm=3.0 * value - 1.0)


@dataclass(frozen=True)
class Watched(LoadedSphere):
    """A loaded sphere whose number of rests is that of the threads of linear algebra after a pause."""

    def judge(self, variants: Variants) -> Outcomes:
        time.sleep(0.01 if variants.com_mm[0, 0] > 0.0 else 0.03)
        threads = max(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        return replace(super().judge(variants), stable=np.full(len(variants), threads))


@dataclass(frozen=True)
class Mortal(LoadedSphere):
    """A loaded sphere whose first judge in another process than its maker's kills that process.

    Attributes:
        maker: Process in which nothing happens.
        marker: File that is made on that occasion.
    """

    maker: int = 0
    marker: Path = Path()

    def judge(self, variants: Variants) -> Outcomes:
        if os.getpid() != self.maker and not self.marker.exists():
            self.marker.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super().judge(variants)
