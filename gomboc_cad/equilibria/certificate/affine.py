"""First-order Taylor models over a cell: how a number depends on the place in it, and a ball for the rest.

A ball forgets where in a cell a value occurs, so differences of balls are as wide as their sum. An affine
number remembers it to the first order: `c + a ε + b η`, where ε and η run from −1 to 1 over the cell in θ and
in ψ. At each place of the cell the true value is of that form with some c, a and b of their balls, so the
error falls with the square of the cell's width.
"""

from __future__ import annotations

from flint import arb

UNIT = arb(0, 1)
"""The interval from −1 to 1."""

SQUARED = arb(1, 1) / 2
"""The interval from 0 to 1: the square of a number of the former."""


class Affine:
    """A number that depends on the place in a cell, affinely but for what the balls hold.

    Attributes:
        center: Ball of c.
        theta: Ball of a, half the change across the cell in θ.
        psi: Ball of b, half the change across the cell in ψ.
    """

    __slots__ = ("_swing", "center", "psi", "theta")

    def __init__(self, center: arb, theta: arb, psi: arb) -> None:
        self.center, self.theta, self.psi = center, theta, psi
        self._swing: arb | None = None

    @property
    def swing(self) -> arb:
        """Ball of `a ε + b η` over the cell; kept, since most numbers are factors more than once."""
        if self._swing is None:
            self._swing = self.theta * UNIT + self.psi * UNIT
        return self._swing

    @property
    def range(self) -> arb:
        """Ball of all values over the cell."""
        return self.center + self.swing

    def upper(self) -> arb:
        """An upper bound over the cell."""
        return self.range.upper()

    def __neg__(self) -> Affine:
        return Affine(-self.center, -self.theta, -self.psi)

    def __add__(self, other: Affine | arb | int) -> Affine:
        if isinstance(other, Affine):
            return Affine(self.center + other.center, self.theta + other.theta, self.psi + other.psi)
        return Affine(self.center + other, self.theta, self.psi)

    __radd__ = __add__

    def __sub__(self, other: Affine | arb | int) -> Affine:
        if isinstance(other, Affine):
            return Affine(self.center - other.center, self.theta - other.theta, self.psi - other.psi)
        return Affine(self.center - other, self.theta, self.psi)

    def __rsub__(self, other: arb | int) -> Affine:
        return Affine(other - self.center, -self.theta, -self.psi)

    def __mul__(self, other: Affine | arb | int) -> Affine:
        if isinstance(other, Affine):
            return Affine(
                self.center * other.center + self.swing * other.swing,
                self.theta * other.center + self.center * other.theta,
                self.psi * other.center + self.center * other.psi,
            )
        return Affine(self.center * other, self.theta * other, self.psi * other)

    __rmul__ = __mul__

    def __truediv__(self, other: Affine | arb | int) -> Affine:
        if isinstance(other, Affine):
            return self * other._inverse()
        return Affine(self.center / other, self.theta / other, self.psi / other)

    def __rtruediv__(self, other: arb | int) -> Affine:
        return self._inverse() * other

    def sqrt(self) -> Affine:
        """Square root: `√c + L/(2√c) − L²/(8 ξ^(3/2))` with `L = a ε + b η` and ξ a value of the cell."""
        root, lowest = self.center.sqrt(), self.range.lower()
        rest = self.swing.abs_upper() ** 2 * SQUARED / (8 * lowest * lowest.sqrt())
        return Affine(root - rest, self.theta / (2 * root), self.psi / (2 * root))

    def _inverse(self) -> Affine:
        """Reciprocal: `1/c − L/c² + L²/ξ³`."""
        inverse, nearest = 1 / self.center, self.range.abs_lower()
        rest = self.center.sgn() * self.swing.abs_upper() ** 2 * SQUARED / nearest**3
        slope = -inverse * inverse
        return Affine(inverse + rest, slope * self.theta, slope * self.psi)

    def __gt__(self, other: Affine | arb | int) -> bool:
        return bool((self - other).range > 0)

    def __lt__(self, other: Affine | arb | int) -> bool:
        return bool((self - other).range < 0)
