"""The JSON twin of the page: `report.json`, with everything that the page shows and no other file holds.

A build and a study put in what takes long to compute: shapes, fields and curves. The rest follows from the
other JSON files and is computed again each time the page is written.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from gomboc_cad import __version__
from gomboc_cad.body import Body, catalogue_entries, make_body
from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import GombocError, InspectionError
from gomboc_cad.report.folder import CALIBRATION, FORMAT, REPORT, TOLERANCE, VERDICT, Results
from gomboc_cad.report.json_values import Value
from gomboc_cad.report.protocol import CONFIDENCE, LIMITS_DEG, MARGIN_SHARE, protocol_document
from gomboc_cad.report.scene import legend_of, read_record
from gomboc_cad.report.surface_fields import SurfaceFields

HEAD = {"program": "gomboc-cad", "format": FORMAT, "version": __version__}
"""What every `report.json` begins with."""

_DERIVED = ("files", "constants", "legend", "protocol")


def body_document(body: Body, com_mm: Array) -> dict[str, Any]:
    """A body and the centre of mass that it is judged about, so that both can be had again from JSON."""
    exact = ExactParameters.of(body)
    return {
        "name": body.name,
        "family": exact.family,
        "beta": None if exact.beta is None else float(exact.beta),
        "coefficients": {key: float(value) for key, value in exact.coefficients.items()},
        "diameter_mm": body.diameter_mm,
        "com_mm": [float(value) for value in com_mm],
    }


def body_of(results: Results) -> tuple[Body, Array] | None:
    """The body and the centre of mass of a folder; None where its files do not say.

    Raises:
        GombocError: If they do not describe a body.
    """
    known = results.value(REPORT)["body"]
    if known:
        return _body(known, known["diameter_mm"]), _point(known["com_mm"])
    verdict = results.value(VERDICT)
    asked = verdict["spec"]["body"]
    if not asked:
        return None
    return _body(asked, verdict["diameter_mm"]), _point(verdict["assembly"]["com_mm"])


def completed(results: Results) -> dict[str, Any]:
    """The whole `report.json` of a folder: what is in it, and what follows from the other files.

    Raises:
        GombocError: If a file holds what cannot be.
    """
    kept = {
        key: value for key, value in (results.plain(REPORT) or {}).items() if key not in (*HEAD, *_DERIVED)
    }
    document = {**HEAD, **kept, "files": _files(results), "constants": _constants()}
    if "surface" in kept:
        document["legend"] = legend_of(read_record(SurfaceFields.of_document, "surface", kept))
    found = body_of(results)
    if found is not None:
        body, com_mm = found
        verdict, study = results.value(VERDICT), results.value(TOLERANCE)
        limit = study["max_tilt_deg"].number if study else LIMITS_DEG["industrial"]
        of_surface = results.value(REPORT)["zone_section"]["s_margin_mm"]
        margin = of_surface if of_surface else verdict["s_margin_mm"]
        document["protocol"] = protocol_document(body, com_mm, verdict, study, margin, limit)
    return document


def merged(before: Mapping[str, Any], new: Mapping[str, Any]) -> dict[str, Any]:
    """The `report.json` of a folder with what a build or a study has to add.

    What was there is kept if it is of the same body with the same centre of mass.
    """
    same = before.get("body") == new.get("body")
    return {**HEAD, **(before if same else {}), **new}


def cone_95_deg(results: Results) -> Value:
    """The cone that holds the rest direction of 95 % of the parts: of the study, else of the calibration."""
    study = results.value(TOLERANCE)["tilt_deg"]["p95"]
    return study if study.there else results.value(CALIBRATION)["cone_95_deg"]


def _files(results: Results) -> list[dict[str, str]]:
    """The files that no verdict lists with its hash: that itself, and what a study wrote."""
    listed = {file["path"].raw for file in results.value(VERDICT)["files"]}
    return [{"path": name, "sha256": digest} for name, digest in results.hashes.items() if name not in listed]


def _constants() -> dict[str, Any]:
    """Numbers of the page's sentences."""
    return {
        "hash": "SHA-256",
        "confidence": CONFIDENCE,
        "limits_deg": dict(LIMITS_DEG),
        "margin_share": MARGIN_SHARE,
    }


def _body(asked: Value, diameter_mm: Value) -> Body:
    """The body of a catalogue name or of a family, which a document describes."""
    size = diameter_mm.number
    if not 1.0 <= size <= 1e5:
        raise InspectionError(f"{diameter_mm.where} must be from 1 to 100000.")
    name = asked["name"].text if asked["name"] else ""
    try:
        if asked["family"]:
            beta = asked["beta"].number if asked["beta"].there else None
            terms = {key: asked["coefficients"][key].number for key in asked["coefficients"].names()}
            return make_body(asked["family"].text, beta, terms, diameter_mm=size, name=name or None)
        if name not in catalogue_entries():
            raise InspectionError(f"{asked.where} names no body of the catalogue and no family.")
        return catalogue_entries()[name].body.with_diameter(size)
    except InspectionError:
        raise
    except GombocError as error:
        raise InspectionError(f"{asked.where} is no body: {error}") from None


def _point(value: Value) -> Array:
    numbers = np.array(value.numbers)
    if numbers.shape != (3,):
        raise value.refused("three numbers")
    return numbers
