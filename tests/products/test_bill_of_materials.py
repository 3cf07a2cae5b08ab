"""The bill of materials: everything once, nothing that a spreadsheet runs."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import pytest
from build123d import Solid

from gomboc_cad.products.assembly import Part
from gomboc_cad.products.bill_of_materials import bill_csv, bill_of_materials
from gomboc_cad.products.imu_housing.recipe import HousingDesign
from gomboc_cad.products.materials import load_material

GREY = (0.5, 0.5, 0.5)


def rows(data: bytes) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(data.decode(), newline="")))


def test_the_bill_of_the_housing_names_every_part_once(default_housing: HousingDesign) -> None:
    assembly = default_housing.assembly
    lines = bill_of_materials(assembly.parts)
    assert [(line.part, line.quantity) for line in lines] == [
        ("imu-housing-lower", 1),
        ("imu-housing-upper", 1),
        ("board", 1),
        ("insert", 4),
        ("pin", 3),
        ("screw", 4),
    ]
    assert sum(line.quantity for line in lines) == len(assembly.parts)
    assert sum(line.mass_g for line in lines) == pytest.approx(assembly.mass_g)
    pins = next(line for line in lines if line.part == "pin")
    assert pins.standard == "ISO 8734 3 x 12"


def test_parts_of_another_standard_are_a_line_of_their_own() -> None:
    steel = load_material("steel")
    box = Solid.make_box(1.0, 1.0, 1.0)
    parts = [Part.homogeneous(f"screw-{k}", box, steel, GREY, standard) for k, standard in enumerate("AAB")]
    assert [(line.standard, line.quantity) for line in bill_of_materials(parts)] == [("A", 2), ("B", 1)]


def test_text_that_a_spreadsheet_would_run_is_quoted() -> None:
    part = Part.homogeneous("board", Solid.make_box(1.0, 1.0, 1.0), load_material("steel"), GREY, "x")
    evil = replace(part, standard='=HYPERLINK("http://x"),"', material="@SUM(A1)")
    (row,) = rows(bill_csv(bill_of_materials([evil])))
    assert row["standard"] == "'" + '=HYPERLINK("http://x"),"'
    assert row["material"] == "'@SUM(A1)"
    assert float(row["mass_g"]) == pytest.approx(part.mass_g, abs=1e-4)
