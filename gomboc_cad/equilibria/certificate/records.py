"""Frozen records of a certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from gomboc_cad.body.catalogue import ExactParameters

Status = Literal["proven", "refuted", "undecided"]
WitnessKind = Literal["negative curvature", "saddle"]
Interval = tuple[str, str]
Decimals = tuple[str, str, str]

TURN_UNITS = 2**20
"""Cells are rectangles of whole numbers of this fraction of a half-turn, so that their edges are exact."""

MAX_CELLS = 20_000
"""Largest number of cells in one list of a certificate."""


class Cell(NamedTuple):
    """A rectangle of the chart (θ, ψ), each angle in 2⁻²⁰ half-turns."""

    theta_low: int
    theta_high: int
    psi_low: int
    psi_high: int

    @classmethod
    def at(cls, theta: int, psi: int) -> Cell:
        """The single direction at these angles."""
        return cls(theta, theta, psi, psi)

    def holds(self, other: Cell) -> bool:
        """Whether the other rectangle lies inside this one."""
        return (
            self.theta_low <= other.theta_low
            and other.theta_high <= self.theta_high
            and self.psi_low <= other.psi_low
            and other.psi_high <= self.psi_high
        )


SPHERE = Cell(0, TURN_UNITS, -TURN_UNITS // 2, 3 * TURN_UNITS // 2)
"""The rectangle that covers all directions."""


@dataclass(frozen=True)
class Disc:
    """A rectangle of the chart about one equilibrium, and the cells in which the Hessian is definite."""

    rectangle: Cell
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class ConvexityProof:
    """Cells in which both principal curvatures exceed a bound.

    Attributes:
        curvature_above: The bound, in 1/R₀, as a decimal.
        cells: Rectangles that cover the sphere.
    """

    curvature_above: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class EquilibriaProof:
    """Cells without an equilibrium about the centre of mass, and the two discs with one each.

    Attributes:
        cells: Rectangles that cover the sphere, each with its claim: `E`, `e`: the component of the gradient
            along e_φ is positive, negative; `M`, `m`: that along e_θ − q e_φ is; `s`, `u`: inside the stable,
            the unstable disc.
        stable: The disc with the stable equilibrium.
        unstable: The disc with the unstable equilibrium.
    """

    cells: tuple[tuple[Cell, str], ...]
    stable: Disc
    unstable: Disc


@dataclass(frozen=True)
class MarginProof:
    """Cells whose centres of curvature keep a distance from the centre of mass.

    Attributes:
        com_margin: The distance in R₀, as a decimal: the counts are the same for every centre of mass within.
        cells: Rectangles that cover the sphere.
    """

    com_margin: str
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class Witness:
    """One direction that refutes the body.

    Attributes:
        kind: `negative curvature`: the Gaussian curvature is negative there; `saddle`: the direction lies on
            the x-axis, where the symmetry makes an equilibrium, and that is a saddle.
        theta: θ in 2⁻²⁰ half-turns.
        psi: ψ likewise.
        gaussian_curvature_below: A bound on the Gaussian curvature there, as a decimal; None for a saddle.
    """

    kind: WitnessKind
    theta: int
    psi: int
    gaussian_curvature_below: str | None = None


@dataclass(frozen=True)
class Certificate:
    """What is proven of a body, in units of its nominal radius R₀.

    Attributes:
        parameters: Family and exact decimals.
        com_enclosure: An interval for each coordinate of the centroid.
        volume_enclosure: An interval for the volume.
        com: Decimals of the centre of mass that equilibria and margin are about; None for the centroid.
        chart: Decimals of the polynomial P(z) of the chart φ = ψ + P, for a family that has none of its own.
        convexity: Proof of strict convexity, if there is one.
        equilibria: Proof of one stable and one unstable equilibrium, if there is one.
        margin: Proof of how far the centre of mass may move, if there is one.
        witness: A direction that refutes the body, if there is one.
    """

    parameters: ExactParameters
    com_enclosure: tuple[Interval, Interval, Interval]
    volume_enclosure: Interval
    com: Decimals | None = None
    chart: tuple[str, ...] = ()
    convexity: ConvexityProof | None = None
    equilibria: EquilibriaProof | None = None
    margin: MarginProof | None = None
    witness: Witness | None = None

    @property
    def status(self) -> Status:
        """`proven`, `refuted`, or `undecided` if neither could be shown."""
        if self.witness:
            return "refuted"
        return "proven" if self.convexity and self.equilibria else "undecided"

    @property
    def strictly_convex(self) -> bool | None:
        """Whether the body is strictly convex; None if that is not known."""
        if self.witness and self.witness.kind == "negative curvature":
            return False
        return True if self.convexity else None

    @property
    def stable(self) -> int | None:
        """Number of stable equilibria, if proven; a dented body rests on its hull, which is not counted."""
        return 1 if self.status == "proven" else None

    @property
    def unstable(self) -> int | None:
        """Number of unstable equilibria, if proven."""
        return self.stable

    @property
    def reason(self) -> str:
        """One sentence for the status, in units of the nominal radius R₀."""
        if self.witness and self.witness.kind == "saddle":
            return "Refuted: a direction of the x-axis is a saddle, so there are more than two equilibria."
        if self.witness:
            return (
                "Refuted: not convex, for the Gaussian curvature at the witness is below "
                f"{float(self.witness.gaussian_curvature_below or 0.0):.4g} / R₀²."
            )
        if not self.convexity:
            return f"Undecided: the smallest curvature is too close to zero for {MAX_CELLS} cells."
        convex = f"strictly convex, both principal curvatures above {self.convexity.curvature_above} / R₀"
        if not self.equilibria:
            return (
                f"Undecided: {convex}, but the equilibria could not be confined to two discs; the census "
                "shows whether there are more than two."
            )
        where = f"for every centre of mass within {self.margin.com_margin} R₀ of" if self.margin else "about"
        center = "the centroid" if self.com is None else f"({', '.join(self.com)}) R₀"
        return f"Proven: {convex}; exactly one stable and one unstable equilibrium {where} {center}."
