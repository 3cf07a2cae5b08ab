"""Rows of the reproduced tables: what the paper gives, what comes out, what is true, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Figure = int | float | str | None
Verdict = Literal["agrees", "differs", "refuted"]
Evidence = Literal[
    "certificate",
    "smooth census",
    "mesh census",
    "closed form",
    "quadrature",
    "integral",
    "arithmetic",
    "none",
]


@dataclass(frozen=True)
class Row:
    """One figure of the paper.

    Attributes:
        label: What is measured, and on what.
        paper: The published figure.
        reproduced: What the paper's own method gives here; None where it gives no method.
        truth: What is so; None where nothing is known beyond the paper's definition.
        evidence: What the truth rests on.
        verdict: `refuted` where the truth contradicts what the figure is given for; else whether the
            reproduced figure agrees with the published one in its digits or differs.
        why: One sentence for the verdict.
        digits: Decimals in which floating-point figures are compared and shown.
    """

    label: str
    paper: Figure
    reproduced: Figure
    truth: Figure
    evidence: Evidence
    verdict: Verdict
    why: str
    digits: int

    def document(self) -> dict[str, Any]:
        """The row as `gomboc-cad paper` gives it."""
        return {
            "label": self.label,
            "paper": self.paper,
            "reproduced": self.reproduced,
            "truth": self.truth,
            "evidence": self.evidence,
            "verdict": self.verdict,
            "why": self.why,
        }


def judged(
    label: str,
    paper: Figure,
    reproduced: Figure,
    truth: Figure,
    evidence: Evidence,
    why: str,
    *,
    refuted: bool = False,
    within: bool | None = None,
    digits: int = 3,
) -> Row:
    """Make a row, with the verdict that follows from its figures.

    Args:
        label: What is measured.
        paper: The published figure.
        reproduced: What the paper's method gives here.
        truth: What is so.
        evidence: What the truth rests on.
        why: One sentence.
        refuted: Whether the truth contradicts the published figure.
        within: Whether the reproduced figure is what the paper gives, where its digits alone do not say so.
        digits: Decimals that the paper gives.
    """
    same = shown(reproduced, digits) == shown(paper, digits) if within is None else within
    verdict: Verdict = "refuted" if refuted else "agrees" if same else "differs"
    return Row(label, paper, reproduced, truth, evidence, verdict, why, digits)


def shown(figure: Figure, digits: int) -> str:
    """A figure as the page shows it: floating-point numbers with a fixed number of decimals."""
    if figure is None:
        return "–"
    if isinstance(figure, float):
        # Adding zero turns a rounded −0.0 into 0.0.
        return f"{round(figure, digits) + 0.0:.{digits}f}"
    return str(figure)


@dataclass(frozen=True)
class Table:
    """One table of the paper.

    Attributes:
        name: Its name on the command line.
        title: Its heading.
        notes: How it was reproduced, in sentences.
        rows: Its figures.
    """

    name: str
    title: str
    notes: tuple[str, ...]
    rows: tuple[Row, ...]

    def document(self) -> dict[str, Any]:
        """The table as `gomboc-cad paper` gives it."""
        return {
            "name": self.name,
            "title": self.title,
            "notes": list(self.notes),
            "rows": [row.document() for row in self.rows],
        }
