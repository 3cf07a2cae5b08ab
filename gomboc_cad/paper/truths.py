"""How many rests the bodies of the paper's tables have, and what that rests on."""

from __future__ import annotations

from typing import NamedTuple

from gomboc_cad.body.catalogue import catalogue_entries
from gomboc_cad.paper.bodies import census_evidence, exact_census, unit_body
from gomboc_cad.paper.records import Evidence
from gomboc_cad.paper.solids import solid


class Rests(NamedTuple):
    """The truth beside a count.

    Attributes:
        shown: Number of stable rests, or what there is instead of isolated ones.
        evidence: What it rests on.
        refutes: Whether it contradicts the count.
    """

    shown: int | str
    evidence: Evidence
    refutes: bool


def true_rests(name: str, count: int) -> Rests:
    """The rests of a body of the paper's tables, beside the count that is given for it."""
    if name == "gomboc":
        return catalogue_rests("primary", count)
    known = solid(name)
    return Rests(known.shown, "closed form", known.refutes(count))


def catalogue_rests(name: str, count: int) -> Rests:
    """The rests of a catalogue body: by its certificate if that proves it, else by census."""
    census = exact_census(unit_body(name))
    proven = catalogue_entries()[name].status == "proven"
    return Rests(census.stable, "certificate" if proven else census_evidence(census), census.stable != count)
