"""Certificates as JSON: written with the same bytes each time, read with suspicion.

One string per cell: the edges θ₁ θ₂ ψ₁ ψ₂ in 2⁻²⁰ half-turns, and the letter of the claim where there is a
choice. `sha256` is the digest of everything else, so that an accidental change shows at once; what makes a
certificate true is the check of its cells.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NoReturn, cast, get_args

from gomboc_cad.body.catalogue import ExactParameters
from gomboc_cad.equilibria.certificate.records import (
    MAX_CELLS,
    Cell,
    Certificate,
    ConvexityProof,
    Decimals,
    Disc,
    EquilibriaProof,
    Interval,
    MarginProof,
    Witness,
    WitnessKind,
)
from gomboc_cad.errors import InspectionError

FORMAT = "gomboc-cad certificate"
VERSION = 1
MAX_BYTES = 10_000_000
"""Largest certificate that is read; the largest that can be written has about 3 MB."""

_MAX_TEXT = 100
_CELL = re.compile(r"(\d{1,7}) (\d{1,7}) (-?\d{1,7}) (-?\d{1,7})(?: ([EeMmsu]))?", re.ASCII)


def dumps(certificate: Certificate) -> str:
    """Write a certificate; equal certificates give equal text."""
    document = _document(certificate)
    return json.dumps({**document, "sha256": _digest(document)}, indent=1) + "\n"


def load(path: Path) -> Certificate:
    """Read a certificate from a file.

    Raises:
        InspectionError: If it cannot be read or is no certificate.
    """
    try:
        with path.open("rb") as file:
            data = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise InspectionError(f"{path} cannot be read: {error.strerror}.") from error
    return loads(data)


def loads(data: bytes | str) -> Certificate:
    """Read the claims of a certificate; nothing is proven by that.

    Raises:
        InspectionError: If it is not a certificate of this format, or was changed after it was written.
    """
    if len(data) > MAX_BYTES:
        _refuse(f"it is longer than {MAX_BYTES // 1_000_000} MB")
    try:
        document = json.loads(
            data, parse_constant=_no_number, parse_float=_no_number, object_pairs_hook=_once
        )
    except (ValueError, RecursionError):
        _refuse("it is not JSON as certificates have it")
    given = [key for key in _OPTIONAL if isinstance(document, dict) and key in document]
    document = _record(document, "the file", {**dict(_KEYS), **dict.fromkeys(given, list)})
    if document["format"] != FORMAT or document["version"] != VERSION:
        _refuse(f"its format is not {FORMAT!r} version {VERSION}")
    if document.pop("sha256") != _digest(document):
        _refuse("its digest does not fit: something was changed after it was written")
    certificate = Certificate(
        parameters=ExactParameters(
            document["family"], document["beta"], MappingProxyType(_texts(document["coefficients"]))
        ),
        com_enclosure=_three([_interval(axis) for axis in document["com_enclosure"]]),
        volume_enclosure=_interval(document["volume_enclosure"]),
        com=_point(document["com"]) if "com" in given else None,
        chart=_decimals(document["chart"]) if "chart" in given else (),
        convexity=_convexity(document["convexity"]),
        equilibria=_equilibria(document["equilibria"]),
        margin=_margin(document["margin"]),
        witness=_witness(document["witness"]),
    )
    if repr({key: document[key] for key in _claims(certificate)}) != repr(_claims(certificate)):
        _refuse("its claims do not follow from the proofs that it holds")
    return certificate


def _claims(certificate: Certificate) -> dict[str, Any]:
    return {
        "status": certificate.status,
        "strictly_convex": certificate.strictly_convex,
        "stable": certificate.stable,
        "unstable": certificate.unstable,
    }


def _document(certificate: Certificate) -> dict[str, Any]:
    convexity, equilibria = certificate.convexity, certificate.equilibria
    margin, witness = certificate.margin, certificate.witness
    return {
        "format": FORMAT,
        "version": VERSION,
        "units": "nominal radius R0 = 1; angles in 2^-20 half-turns",
        "family": certificate.parameters.family,
        "beta": certificate.parameters.beta,
        "coefficients": dict(certificate.parameters.coefficients),
        **_claims(certificate),
        "com_enclosure": [list(axis) for axis in certificate.com_enclosure],
        "volume_enclosure": list(certificate.volume_enclosure),
        **({} if certificate.com is None else {"com": list(certificate.com)}),
        **({"chart": list(certificate.chart)} if certificate.chart else {}),
        "witness": witness and _without_none(vars(witness)),
        "convexity": convexity
        and {"curvature_above": convexity.curvature_above, "cells": _lines(convexity.cells)},
        "equilibria": equilibria
        and {
            "stable_disc": _disc_document(equilibria.stable),
            "unstable_disc": _disc_document(equilibria.unstable),
            "cells": [f"{line} {letter}" for line, letter in _lettered(equilibria)],
        },
        "margin": margin and {"com_margin": margin.com_margin, "cells": _lines(margin.cells)},
    }


def _lettered(proof: EquilibriaProof) -> Iterable[tuple[str, str]]:
    return zip(_lines(cell for cell, _ in proof.cells), (letter for _, letter in proof.cells), strict=True)


def _disc_document(disc: Disc) -> dict[str, Any]:
    return {"rectangle": _lines([disc.rectangle])[0], "cells": _lines(disc.cells)}


def _lines(cells: Iterable[Cell]) -> list[str]:
    return [" ".join(map(str, cell)) for cell in cells]


def _without_none(values: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in values.items() if value is not None}


def _digest(document: Mapping[str, Any]) -> str:
    canonical = json.dumps(document, sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(canonical.encode()).hexdigest()


# Reading. Each function refuses what is not exactly of its kind.

_KEYS: tuple[tuple[str, type | tuple[type, ...]], ...] = (
    ("format", str),
    ("version", int),
    ("units", str),
    ("family", str),
    ("beta", (str, type(None))),
    ("coefficients", dict),
    ("status", str),
    ("strictly_convex", (bool, type(None))),
    ("stable", (int, type(None))),
    ("unstable", (int, type(None))),
    ("com_enclosure", list),
    ("volume_enclosure", list),
    ("witness", (dict, type(None))),
    ("convexity", (dict, type(None))),
    ("equilibria", (dict, type(None))),
    ("margin", (dict, type(None))),
    ("sha256", str),
)
_OPTIONAL = ("com", "chart")


def _refuse(reason: str) -> NoReturn:
    raise InspectionError(f"This is no valid certificate: {reason}. Make a new one with gomboc-cad certify.")


def _no_number(text: str) -> NoReturn:
    raise ValueError(text)


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    result = dict(pairs)
    if len(result) < len(pairs):
        raise ValueError("a key occurs twice")
    return result


def _record(value: Any, where: str, kinds: dict[str, type | tuple[type, ...]]) -> dict[str, Any]:
    if not isinstance(value, dict) or value.keys() != kinds.keys():
        _refuse(f"{where} must have the keys {', '.join(kinds)}")
    for key, kind in kinds.items():
        if not isinstance(value[key], kind) or (isinstance(value[key], bool) and kind is int):
            _refuse(f"{key} in {where} is of the wrong type")
        if isinstance(value[key], str) and len(value[key]) > _MAX_TEXT:
            _refuse(f"{key} in {where} is too long")
    return value


def _texts(values: dict[str, Any]) -> dict[str, str]:
    if not all(isinstance(text, str) and len(key) + len(text) <= _MAX_TEXT for key, text in values.items()):
        _refuse("the coefficients must be decimals in quotes")
    return values


def _interval(value: Any) -> Interval:
    if not isinstance(value, list) or len(value) != 2:
        _refuse("an enclosure must be a pair of decimals in quotes")
    low, high = _texts(dict(zip(("low", "high"), value, strict=True))).values()
    return low, high


def _decimals(values: list[Any]) -> tuple[str, ...]:
    return tuple(_texts({str(place): text for place, text in enumerate(values)}).values())


def _point(values: list[Any]) -> Decimals:
    if len(values) != 3:
        _refuse("com must have three decimals in quotes")
    x, y, z = _decimals(values)
    return x, y, z


def _three(axes: list[Interval]) -> tuple[Interval, Interval, Interval]:
    if len(axes) != 3:
        _refuse("com_enclosure must have three intervals")
    return axes[0], axes[1], axes[2]


def _convexity(value: Any) -> ConvexityProof | None:
    if value is None:
        return None
    _record(value, "convexity", {"curvature_above": str, "cells": list})
    return ConvexityProof(value["curvature_above"], _plain_cells(value["cells"]))


def _equilibria(value: Any) -> EquilibriaProof | None:
    if value is None:
        return None
    _record(value, "equilibria", {"stable_disc": dict, "unstable_disc": dict, "cells": list})
    cells = _cells(value["cells"])
    if not all(letter for _, letter in cells):
        _refuse("a cell of equilibria has no claim")
    return EquilibriaProof(cells, _disc(value["stable_disc"]), _disc(value["unstable_disc"]))


def _margin(value: Any) -> MarginProof | None:
    if value is None:
        return None
    _record(value, "margin", {"com_margin": str, "cells": list})
    return MarginProof(value["com_margin"], _plain_cells(value["cells"]))


def _disc(value: Any) -> Disc:
    _record(value, "a disc", {"rectangle": str, "cells": list})
    return Disc(_plain_cells([value["rectangle"]])[0], _plain_cells(value["cells"]))


def _witness(value: Any) -> Witness | None:
    if value is None:
        return None
    kinds: dict[str, type | tuple[type, ...]] = {"kind": str, "theta": int, "psi": int}
    if "gaussian_curvature_below" in value:
        kinds["gaussian_curvature_below"] = str
    _record(value, "witness", kinds)
    if value["kind"] not in get_args(WitnessKind):
        _refuse("it has a witness of an unknown kind")
    return Witness(
        cast(WitnessKind, value["kind"]),
        value["theta"],
        value["psi"],
        value.get("gaussian_curvature_below"),
    )


def _plain_cells(values: list[Any]) -> tuple[Cell, ...]:
    cells = _cells(values)
    if any(letter for _, letter in cells):
        _refuse("a cell has a claim where none belongs")
    return tuple(cell for cell, _ in cells)


def _cells(values: list[Any]) -> tuple[tuple[Cell, str], ...]:
    if len(values) > MAX_CELLS:
        _refuse(f"a list has more than {MAX_CELLS} cells")
    matches = [_CELL.fullmatch(text) if isinstance(text, str) else None for text in values]
    if not all(matches):
        _refuse("a cell is not written as four whole numbers")
    return tuple(
        (Cell(*(int(number) for number in match.groups()[:4])), match.group(5) or "")
        for match in matches
        if match
    )
