"""How much form error a design stands, undulation by undulation.

A form error δ of degree n moves the support function by δ, its gradient by ∇δ and its Hessian by ∇²δ. It
cannot change the number of stable rests while `sqrt(|∇δ|² + |∇²δ|²)` stays below the S-margin everywhere,
|∇²δ| being the larger of the moduli of the eigenvalues: for the census to change on the way from 0 to δ, some
tδ would need a place with `∇h = −t∇δ` and with an eigenvalue of ∇²h that tδ takes to zero, which is no
farther from zero than t|∇²δ| (Weyl), and that place would be nearer than the S-margin.

How large that gets, at most, among all fields of degree n whose mean square over the sphere is 1, is known in
closed form. By symmetry one place is as good as another. Take the pole. Of the 2n + 1 harmonics only those of
order 0, ±1 and ±2 have anything there: the trace of the Hessian, the gradient and the traceless part of the
Hessian. The sums over all orders are the same at every place, with λ = n(n + 1):

* Σ Y² = 2n + 1 (addition theorem), and order 0 has all of it; both eigenvalues get −λ/2 times the value;
* Σ |∇Y|² = (2n + 1) λ, and each of the orders ±1 has half of it;
* Σ |∇²Y|² = (2n + 1) (λ² − λ) (Bochner's formula on the unit sphere), of which the trace takes λ²/2; each of
  the orders ±2 has half of the rest, and its eigenvalues have half of that as their squares.

So with coefficients x, y, z of the three kinds the gradient is `sqrt((2n + 1) λ/2) |y|` and the eigenvalue of
larger modulus at most `sqrt(2n + 1) (λ/2 |x| + sqrt(λ(λ − 2)/8) |z|)`. With x² + |y|² + |z|² = 1 the sum of
their squares is largest with y = 0: `growth(n)² = (2n + 1) λ (3λ − 2)/8`. It is reached.

So S-margin / growth(n) is safe whatever the field; its decay with n is that of n^(−5/2), since a field of
high degree can gather its amplitude in one place. A random field does not, and its limit falls as n^(−2).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from scipy.special import ndtri

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.equilibria.convexity import convexity
from gomboc_cad.equilibria.records import Vector
from gomboc_cad.errors import StudyError
from gomboc_cad.progress import Progress, silent
from gomboc_cad.tolerance.acceptance import (
    Checked,
    Effort,
    Target,
    accepted,
    as_designed,
    dimensions,
    first_confirmed,
    largest_accepted,
    require_good_design,
)
from gomboc_cad.tolerance.harmonics import LOWEST_DEGREE, coefficient_count
from gomboc_cad.tolerance.model import Source, StudyModel
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.variants import Nominal, Outcomes, Variants

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_EFFORT = Effort(BATCH_ROWS, 4 * BATCH_ROWS)
_FORM = "form_error"
_ACCURACY = 0.03
_LEAST = 2.0**-20
_BACKED_OFF = (1.0, 0.94, 0.88, 0.82)


def census_growth(degrees: IntArray) -> Array:
    """Largest `sqrt(|∇δ|² + |∇²δ|²)` of fields of each degree n ≥ 2 with the mean square 1, shape (n,)."""
    eigenvalue = degrees * (degrees + 1.0)
    result: Array = np.sqrt((2.0 * degrees + 1.0) * eigenvalue * (3.0 * eigenvalue - 2.0) / 8.0)
    return result


def curvature_growth(degrees: IntArray) -> Array:
    """Largest modulus of an eigenvalue of `∇²δ + δ I` among the same fields, shape (n,).

    It is how much a principal radius of curvature may lose. The trace is now −(λ − 2) times the value, the
    traceless part as above.
    """
    eigenvalue = degrees * (degrees + 1.0)
    result: Array = np.sqrt((2.0 * degrees + 1.0) * (eigenvalue - 2.0) * (3.0 * eigenvalue - 4.0) / 8.0)
    return result


def guaranteed_form_mm(s_margin_mm: float, least_radius_mm: float, degrees: IntArray) -> Array:
    """Rms amplitude up to which no field of one degree changes the number of stable rests, shape (n,).

    Args:
        s_margin_mm: S-margin of the design.
        least_radius_mm: Its smallest principal radius of curvature, which must not come to zero.
        degrees: Degrees n ≥ 2.
    """
    result: Array = np.minimum(
        s_margin_mm / census_growth(degrees), least_radius_mm / curvature_growth(degrees)
    )
    return result


@dataclass(frozen=True, eq=False)
class FormErrorCurve:
    """The form error that a design stands, each degree by itself.

    Attributes:
        degrees: Degrees n, in undulations around a great circle, shape (n,).
        guaranteed_mm: Rms amplitude over the sphere up to which no field of that degree, however it lies,
            adds a stable rest, shape (n,).
        probable: Rms amplitude of a random field of that degree alone, all its harmonics independent and
            normal with the same variance, at which the target is met; checked by fresh rows.
        target: The target.
        process_mm: Rms amplitude that the process makes at each degree, shape (n,); None if not asked about.
    """

    degrees: IntArray
    guaranteed_mm: Array
    probable: tuple[Checked, ...]
    target: Target
    process_mm: Array | None

    @property
    def probable_mm(self) -> Array:
        """Rms amplitudes at which the target is met, shape (n,); NaN where no amplitude was confirmed."""
        return np.array([checked.value if checked.met else np.nan for checked in self.probable])

    @property
    def process_use(self) -> Array | None:
        """What the process makes over what is allowed at the target, shape (n,)."""
        return None if self.process_mm is None else self.process_mm / self.probable_mm

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the allowed amplitudes against the undulations.

        Args:
            ax: Axes to draw on; new ones if not given.

        Returns:
            The axes.
        """
        from gomboc_cad.report.study_figures import plot_form_error
        from gomboc_cad.report.study_records import FormErrorLimits

        return plot_form_error(FormErrorLimits.of_curve(self), ax)

    def document(self) -> dict[str, Any]:
        """The curve as the study gives it."""
        process = self.process_mm
        return {
            "good_share": self.target.good_share,
            "confidence": self.target.confidence,
            "degrees": [
                {
                    "degree": int(degree),
                    "guaranteed_um": 1e3 * float(self.guaranteed_mm[k]),
                    "allowed_um": 1e3 * checked.value if checked.met else None,
                    "checked": checked.document(),
                    "process_um": None if process is None else 1e3 * float(process[k]),
                }
                for k, (degree, checked) in enumerate(zip(self.degrees, self.probable, strict=True))
            ],
        }


def form_error_curve(
    model: StudyModel,
    degrees: Sequence[int],
    target: Target,
    effort: Effort = _EFFORT,
    *,
    process_mm: Array | None = None,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> FormErrorCurve:
    """Find the form error of each degree that the design of a study stands when all else is perfect.

    Args:
        model: The study; only its design and its judge matter.
        degrees: Degrees n ≥ 2.
        target: What counts as good, and which share has to be.
        effort: How many variants each degree may cost.
        process_mm: Rms amplitude that the process makes at each of the degrees.
        executor: Where to run; here if not given.
        progress: Called with the name of each stage as it begins.

    Raises:
        StudyError: If the design itself is not good, or a degree is below 2.
    """
    orders = np.array(degrees, dtype=np.int64)
    if len(orders) == 0 or orders.min() < LOWEST_DEGREE:
        raise StudyError("The allowable form error is that of degrees from 2 on; lower ones change no shape.")
    s_margin = float(require_good_design(model, target.requirement).s_margin_mm[0])
    least_radius = convexity(model.nominal.body).min_radius_of_curvature_mm
    found = []
    for degree in degrees:
        progress(f"form error with {degree} undulations")
        field = SingleDegree(model, degree, s_margin / degree**2)
        found.append(_confirmed_amplitude(field, target, effort, executor))
    guaranteed = guaranteed_form_mm(s_margin, least_radius, orders)
    return FormErrorCurve(orders, guaranteed, tuple(found), target, process_mm)


@dataclass(frozen=True, eq=False)
class SingleDegree:
    """A study of random form error of one degree alone, everything else being as designed.

    Attributes:
        study: The study whose design and judge are taken.
        degree: The degree n.
        amplitude_mm: Root of the mean square of the field, over the sphere and over the parts.
    """

    study: StudyModel
    degree: int
    amplitude_mm: float

    @property
    def sources(self) -> tuple[Source, ...]:
        """The one source."""
        text = f"form error, {self.degree} undulations"
        return (Source(_FORM, text, self.amplitude_mm, "mm rms", 2 * self.degree + 1, "searched for"),)

    @property
    def nominal(self) -> Nominal:
        """The design."""
        return self.study.nominal

    def variants(self, quantiles: Array) -> Variants:
        """The design with the field of each row: its harmonics are independent and equally large."""
        design = as_designed(self.study)
        perfect = design.variants(np.full((len(quantiles), dimensions(design)), 0.5))
        form = np.zeros((len(quantiles), coefficient_count(self.degree)))
        form[:, coefficient_count(self.degree - 1) :] = (
            self.amplitude_mm / np.sqrt(2.0 * self.degree + 1.0) * ndtri(quantiles)
        )
        return replace(perfect, form_mm=form)

    def judge(self, variants: Variants) -> Outcomes:
        """As the study does."""
        return self.study.judge(variants)

    def scaled(self, factors: Mapping[str, float]) -> Self:
        """The same with another amplitude."""
        return replace(self, amplitude_mm=self.amplitude_mm * factors.get(_FORM, 1.0))

    def with_com_shift(self, shift_mm: Vector) -> Self:
        """The same with the nominal COM elsewhere."""
        return replace(self, study=self.study.with_com_shift(shift_mm))

    def describe(self) -> dict[str, Any]:
        """What is varied."""
        return {"study": self.study.describe(), "degree": self.degree, "amplitude_mm": self.amplitude_mm}


def _confirmed_amplitude(
    field: SingleDegree, target: Target, effort: Effort, executor: Executor | None
) -> Checked:
    """Largest amplitude of a random field that meets the target, searched from that of the given one."""

    def at(amplitude_mm: float) -> SingleDegree:
        return replace(field, amplitude_mm=amplitude_mm)

    def accepts(amplitude_mm: float) -> bool:
        return accepted(at(amplitude_mm), target, effort.search_rows, executor)

    # An amplitude as large as the body leaves no convex shape.
    most = field.nominal.body.radius_mm
    largest = largest_accepted(accepts, field.amplitude_mm, _LEAST * field.amplitude_mm, most, _ACCURACY)
    if largest is None:
        return first_confirmed([0.0], at, target, effort.check_rows, executor)
    return first_confirmed([part * largest for part in _BACKED_OFF], at, target, effort.check_rows, executor)
