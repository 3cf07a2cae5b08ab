"""The report of a build: what only the design in memory can tell goes into `report.json`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gomboc_cad.products.design import ProductDesign
from gomboc_cad.products.verdict import Verdict
from gomboc_cad.report.build_records import product_records
from gomboc_cad.report.document import body_document
from gomboc_cad.report.part_shapes import part_shapes
from gomboc_cad.report.write import add_to_report


def write_product_report(
    design: ProductDesign, verdict: Verdict, folder: Path, beside: Path
) -> dict[str, Any]:
    """Write the report of a product whose other files are in a folder already.

    Args:
        design: The product.
        verdict: The verdict on it.
        folder: Where its files are, and the report goes.
        beside: Where the files of that folder are to be moved; a study of the same design there is shown too.

    Returns:
        As `write_report`.

    Raises:
        InspectionError: If a file that is there already is damaged.
        OutputError: If the files cannot be written.
    """
    com_mm = np.array(design.assembly.com_mm)
    records = {
        "body": body_document(design.body, com_mm),
        "parts": part_shapes(design.assembly.parts, design.body.diameter_mm),
        **product_records(design, verdict),
    }
    return add_to_report(folder, records, beside)
