"""Bill of materials: one line for each kind of part, as CSV."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import groupby

from gomboc_cad.products.assembly import Part

FILE_NAME = "bill-of-materials.csv"

_NUMBER = re.compile(r"-\d+$")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""A cell of text that begins with one of these is run by spreadsheets."""


@dataclass(frozen=True)
class BillLine:
    """Parts that are alike.

    Attributes:
        part: Name, without the number of the single piece.
        quantity: How many.
        material: Material.
        standard: Standard or maker's number; empty for a part that is made.
        mass_each_g: Mass of one.
    """

    part: str
    quantity: int
    material: str
    standard: str
    mass_each_g: float

    @property
    def mass_g(self) -> float:
        """Mass of all of them."""
        return self.quantity * self.mass_each_g


def bill_of_materials(parts: Iterable[Part]) -> tuple[BillLine, ...]:
    """Gather parts of the same name, material and standard; made parts first, then bought ones by name."""

    def kind(part: Part) -> tuple[bool, str, str, str]:
        name = part.name if part.made else _NUMBER.sub("", part.name)
        return not part.made, name, part.material, part.standard

    lines = []
    for (_, name, material, standard), group in groupby(sorted(parts, key=kind), key=kind):
        masses = [part.mass_g for part in group]
        lines.append(BillLine(name, len(masses), material, standard, sum(masses) / len(masses)))
    return tuple(lines)


def bill_csv(lines: Iterable[BillLine]) -> bytes:
    """The bill as CSV (RFC 4180) in UTF-8; text that a spreadsheet would run is quoted."""
    stream = io.StringIO()
    writer = csv.writer(stream)
    writer.writerow(("part", "quantity", "material", "standard", "mass_each_g", "mass_g"))
    for line in lines:
        texts = [_harmless(text) for text in (line.part, line.material, line.standard)]
        writer.writerow(
            (texts[0], line.quantity, *texts[1:], f"{line.mass_each_g:.4f}", f"{line.mass_g:.4f}")
        )
    return stream.getvalue().encode()


def _harmless(text: str) -> str:
    return f"'{text}" if text.startswith(_FORMULA) else text
