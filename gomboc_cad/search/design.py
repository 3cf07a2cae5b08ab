"""A new body: what a search found, judged by the exact methods, with its proof and its file."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from pathlib import Path

from gomboc_cad.body import Body
from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.equilibria import Census, smooth_census
from gomboc_cad.equilibria.certificate import Certificate, certify
from gomboc_cad.errors import BodyError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.search.extended import Evolution, search_extended
from gomboc_cad.search.harmonic import Programming, search_harmonic
from gomboc_cad.search.objectives import Goal
from gomboc_cad.solid.output import write_bytes

_COMMENT_WIDTH = 110


@dataclass(frozen=True)
class Figures:
    """What a body is worth, in units of its nominal radius R₀.

    Attributes:
        s_margin: How far the COM may move before the number of stable rests changes.
        u_margin: The same for unstable ones.
        min_curvature: Smallest principal curvature.
        height_range: Height of the COM in the unstable pose less that at rest.
        stiffness: Soft stiffness of the rest.
    """

    s_margin: float
    u_margin: float
    min_curvature: float
    height_range: float
    stiffness: float

    @classmethod
    def of(cls, census: Census, radius_mm: float) -> Figures:
        """The figures in the smooth census of a body of a nominal radius."""
        if census.margin is None or census.convexity is None:
            raise TypeError("These figures are those of a smooth census.")
        return cls(
            s_margin=census.margin.s_margin_mm / radius_mm,
            u_margin=census.margin.u_margin_mm / radius_mm,
            min_curvature=census.convexity.min_curvature_per_mm * radius_mm,
            height_range=census.height_range_mm / radius_mm,
            stiffness=census.rest.stiffness_mm[0] / radius_mm,
        )


@dataclass(frozen=True)
class Design:
    """A body that a search found.

    Attributes:
        body: The body.
        goal: What was searched for.
        census: Its poses, margins and extremes of curvature by the smooth census.
        certificate: The proof that it is strictly convex with one stable and one unstable pose, if there is
            one.
    """

    body: Body
    goal: Goal
    census: Census
    certificate: Certificate

    @property
    def figures(self) -> Figures:
        """What the body is worth."""
        return Figures.of(self.census, self.body.radius_mm)

    @property
    def missed(self) -> tuple[str, ...]:
        """The constraints that the body does not meet."""
        figures = self.figures
        return self.goal.missed(figures.min_curvature, min(figures.s_margin, figures.u_margin))

    @property
    def accepted(self) -> bool:
        """Whether the body is proven and meets every constraint."""
        return self.certificate.status == "proven" and not self.missed

    @property
    def reasons(self) -> tuple[str, ...]:
        """What is to be said of it, one sentence each."""
        sentences = [self.certificate.reason]
        if (self.census.stable, self.census.unstable) != (1, 1):
            sentences.append(
                f"The census finds {self.census.stable} stable and {self.census.unstable} unstable poses."
            )
        if self.certificate.status == "undecided":
            sentences.append("A larger smallest margin or curvature gives the proof more room.")
        if self.missed:
            sentences.append(f"The search ended with a body that misses the {' and the '.join(self.missed)}.")
        return tuple(sentences)

    def as_toml(self) -> str:
        """A `[body]` table as it stands in a product's spec, with what was found and proven as comments."""
        parameters = self.certificate.parameters
        wanted = f"{self.goal.objective}, smallest curvature {self.goal.min_curvature:g} / R0"
        figures = self.figures
        lines = [
            f"# gomboc-cad design: {wanted}, smallest margin {self.goal.min_margin:g} R0.",
            f"# S-margin {figures.s_margin:.6g} R0, U-margin {figures.u_margin:.6g} R0, smallest curvature "
            f"{figures.min_curvature:.6g} / R0,",
            f"# height range {figures.height_range:.6g} R0, soft stiffness {figures.stiffness:.6g} R0.",
            *textwrap.wrap(
                " ".join(self.reasons), _COMMENT_WIDTH, initial_indent="# ", subsequent_indent="# "
            ),
            "",
            "[body]",
            f'family = "{parameters.family}"',
        ]
        if parameters.beta is not None:
            lines.append(f"beta = {parameters.beta}")
        lines += ["diameter_mm = 100.0", "", "[body.coefficients]"]
        lines += [f'"{key}" = {value}' for key, value in parameters.coefficients.items()]
        return "\n".join(lines) + "\n"


def search_method(family: str, seed: int = 1, steps: int | None = None) -> Evolution | Programming:
    """The search in a family, by its name.

    Args:
        family: `extended` or `harmonic`.
        seed: Seed of the differential evolution; the other search has nothing random.
        steps: Largest number of generations, or of steps of each stage; as many as usual if not given.

    Raises:
        BodyError: If no search goes through the family, or a number is not possible.
    """
    if family == "extended":
        return Evolution(seed=seed) if steps is None else Evolution(seed=seed, generations=steps)
    if family == "harmonic":
        return Programming() if steps is None else Programming(steps=steps)
    raise BodyError(f"There is no search in the family {family!r}; choose extended or harmonic.")


def design_body(goal: Goal, method: Evolution | Programming, progress: Progress = silent) -> Design:
    """Search for a body, then judge and prove what was found.

    Args:
        goal: Objective and constraints.
        method: `Evolution` searches the extended family, `Programming` the harmonic one.
        progress: Told of every generation or step; an exception that it raises ends the search.

    Raises:
        BodyError: If the search knows no body that meets the constraints.
    """
    if isinstance(method, Evolution):
        return judge(search_extended(goal, method, progress), goal, progress)
    return judge(search_harmonic(goal, method, progress), goal, progress)


def judge(body: Body, goal: Goal, progress: Progress = silent) -> Design:
    """Judge what a search found by the smooth census, which looks everywhere, and try to prove it."""
    progress("counting the poses of the found body")
    census = smooth_census(body)
    return Design(body, goal, census, certify(ExactParameters.of(body), progress))


def write_body_file(design: Design, file: Path) -> None:
    """Write the body as a TOML file, whole or not at all.

    Raises:
        OutputError: If the file cannot be written there.
    """
    write_bytes(file, design.as_toml().encode())
