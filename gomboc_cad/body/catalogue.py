"""The catalogue of bodies, and bodies made from a family and its coefficients.

A body of the catalogue is `proven` or `refuted` because a certificate for exactly its decimals is shipped
beside it, in `certificates/`; without one it is only `computed`. The tests prove each of them again.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from types import MappingProxyType
from typing import Any, Literal, get_args

from gomboc_cad.body.families import FourierSloan, Harmonic, ShapeFunction, Sloan1
from gomboc_cad.body.surface import DEFAULT_RADIUS_MM, Body
from gomboc_cad.errors import BodyError

Family = Literal["sloan1", "sloan2", "extended", "harmonic"]
Status = Literal["proven", "computed", "refuted"]

INDEX_NAME = "index.json"
"""File that lists the shipped certificates with their digests, so that the catalogue need not read them."""

_FOLDER = resources.files("gomboc_cad.body")
_CERTIFICATES = _FOLDER.joinpath("certificates")


@dataclass(frozen=True)
class Evidence:
    """What our own census found for a catalogue body, in units of its nominal radius.

    Attributes:
        min_curvature: Smallest principal curvature; negative means not convex.
        min_gaussian_curvature: Smallest Gaussian curvature.
        margin: Radius of the largest ball of COM positions with an unchanged census; None for a
            body that is not strictly convex.
        s_margin: The same for the number of stable rests alone.
        u_margin: The same for the number of unstable rests alone.
    """

    min_curvature: float
    min_gaussian_curvature: float
    margin: float | None = None
    s_margin: float | None = None
    u_margin: float | None = None


@dataclass(frozen=True)
class CatalogueEntry:
    """A named body with its status, the reason for it and the evidence.

    Attributes:
        body: The body at the default size.
        beta: Amplitude β, None for harmonic bodies.
        coefficients: Coefficients by key: `"k"` for Fourier terms, `"l,m"` for harmonics.
        status: `proven` or `refuted` by the shipped certificate, or only `computed`.
        reason: Why it has that status.
        source: Where the parameters come from.
        evidence: Computed figures.
    """

    body: Body
    beta: float | None
    coefficients: Mapping[str, float]
    status: Status
    reason: str
    source: str
    evidence: Evidence


@dataclass(frozen=True)
class ExactParameters:
    """The numbers of a body as decimals, which a proof starts from; floats would already be rounded.

    Attributes:
        family: Family, as for `make_body`.
        beta: Decimal of β; None for a family without one.
        coefficients: Decimals by key.
    """

    family: str
    beta: str | None
    coefficients: Mapping[str, str]

    @classmethod
    def of(cls, body: Body) -> ExactParameters:
        """The shortest decimals that read back as the body's floats.

        These are the decimals that were typed, if they had 15 digits at most.
        """
        shape = body.shape
        beta, coefficients = None, {}
        if isinstance(shape, FourierSloan):
            beta, coefficients = repr(shape.beta), {str(k): repr(a) for k, a in shape.terms}
        elif isinstance(shape, Harmonic):
            coefficients = {f"{degree},{order}": repr(c) for (degree, order), c in shape.terms}
        return cls(shape.family, beta, MappingProxyType(coefficients))


@lru_cache(maxsize=1)
def catalogue_entries() -> Mapping[str, CatalogueEntry]:
    """Read the catalogue: entries by name, in the order of the file."""
    return MappingProxyType({name: _entry(name, data) for name, data in _catalogue_data().items()})


def catalogue_names() -> tuple[str, ...]:
    """Names of the catalogue, in the order of the file."""
    return tuple(_catalogue_data())


def exact_parameters(name: str) -> ExactParameters:
    """The decimals of a catalogue body as the catalogue has them.

    Raises:
        BodyError: If there is no body of that name.
    """
    _require_known(name)
    return _exact(_catalogue_data()[name])


def shipped_certificate(name: str) -> bytes | None:
    """The certificate that is shipped for a catalogue body, as it was written; None if there is none.

    Raises:
        BodyError: If there is no body of that name.
    """
    _require_known(name)
    file = _CERTIFICATES.joinpath(f"{name}.json")
    return file.read_bytes() if file.is_file() else None


@lru_cache(maxsize=1)
def _catalogue_data() -> dict[str, dict[str, Any]]:
    """The catalogue's tables, with every decimal as it is written."""
    text = _FOLDER.joinpath("catalogue.toml").read_text(encoding="utf-8")
    return tomllib.loads(text, parse_float=str)


def _exact(data: dict[str, Any]) -> ExactParameters:
    return ExactParameters(data["family"], data.get("beta"), MappingProxyType(data.get("coefficients", {})))


def _entry(name: str, data: dict[str, Any]) -> CatalogueEntry:
    exact = _exact(data)
    beta = None if exact.beta is None else float(exact.beta)
    coefficients = {key: float(value) for key, value in exact.coefficients.items()}
    return CatalogueEntry(
        body=make_body(exact.family, beta, coefficients, name=name),
        beta=beta,
        coefficients=MappingProxyType(coefficients),
        status=_status(name, exact),
        reason=data["reason"],
        source=data["source"],
        evidence=Evidence(**{key: float(value) for key, value in data["evidence"].items()}),
    )


def _status(name: str, exact: ExactParameters) -> Status:
    """What the shipped certificate says, if the index knows these bytes as one for these decimals."""
    known = _certificate_index().get(name)
    certificate = shipped_certificate(name)
    if known is None or certificate is None or ExactParameters(**known["parameters"]) != exact:
        return "computed"
    if hashlib.sha256(certificate).hexdigest() != known["sha256"] or known["status"] == "undecided":
        return "computed"
    status: Status = known["status"]
    return status


@lru_cache(maxsize=1)
def _certificate_index() -> dict[str, dict[str, Any]]:
    index: dict[str, dict[str, Any]] = json.loads(
        _CERTIFICATES.joinpath(INDEX_NAME).read_text(encoding="utf-8")
    )
    return index


def catalog() -> Mapping[str, Body]:
    """Give the catalogue's bodies by name, each with a nominal diameter of 100 mm."""
    return MappingProxyType({name: entry.body for name, entry in catalogue_entries().items()})


def named_body(name: str, diameter_mm: float = 2.0 * DEFAULT_RADIUS_MM) -> Body:
    """Look a body up in the catalogue.

    Raises:
        BodyError: If there is no body of that name; the sentence offers the nearest names.
    """
    _require_known(name)
    return catalog()[name].with_diameter(diameter_mm)


def _require_known(name: str) -> None:
    names = _catalogue_data()
    if name not in names:
        near = difflib.get_close_matches(name, names, n=2) or list(names)
        raise BodyError(
            f"There is no body named {name!r} in the catalogue; did you mean {' or '.join(near)}?"
        )


def make_body(
    family: str,
    beta: float | None = None,
    coefficients: Mapping[str, float] | None = None,
    *,
    diameter_mm: float = 2.0 * DEFAULT_RADIUS_MM,
    name: str | None = None,
) -> Body:
    """Make a body from a family and its parameters.

    Args:
        family: `sloan1`, `sloan2`, `extended` or `harmonic`.
        beta: Amplitude β of the Sloan families; not used by `harmonic`.
        coefficients: `{"k": a_k}` for `extended`, `{"l,m": c_lm}` for `harmonic`.
        diameter_mm: Nominal diameter 2 R₀.
        name: Name to carry; by default a description of the parameters.

    Raises:
        BodyError: If the family is unknown or the parameters do not belong to it.
    """
    given = dict(coefficients or {})
    shape = _make_shape(family, beta, given)
    if name is None:
        terms = [] if beta is None else [f"beta={beta:g}"]
        name = f"{family}({', '.join(terms + [f'{key}={value:g}' for key, value in given.items()])})"
    return Body(name, shape, 0.5 * diameter_mm)


def _make_shape(family: str, beta: float | None, coefficients: dict[str, float]) -> ShapeFunction:
    if family not in get_args(Family):
        raise BodyError(f"There is no family {family!r}; choose one of {', '.join(get_args(Family))}.")
    if family == "harmonic":
        if beta is not None:
            raise BodyError("The harmonic family takes no beta; give coefficients l,m = c instead.")
        return Harmonic(tuple(((degree, order), c) for (degree, order), c in _keyed(coefficients, 2)))
    if beta is None:
        raise BodyError(f"The family {family!r} needs beta, for example 0.02.")
    if family == "extended":
        if not coefficients:
            raise BodyError(
                "The extended family needs at least one coefficient k = a; without any it is sloan2."
            )
        return FourierSloan(beta, tuple((k, a) for (k,), a in _keyed(coefficients, 1)))
    if coefficients:
        raise BodyError(f"The family {family!r} takes no coefficients; use the extended family.")
    return Sloan1(beta) if family == "sloan1" else FourierSloan(beta)


def _keyed(coefficients: dict[str, float], width: int) -> list[tuple[tuple[int, ...], float]]:
    """Read keys `k` or `l,m` as integers."""
    shape = "an integer k" if width == 1 else "two integers l,m"
    result = []
    for key, value in coefficients.items():
        try:
            index = tuple(int(part) for part in key.split(","))
        except ValueError:
            index = ()
        if len(index) != width:
            raise BodyError(f"The coefficient key {key!r} must be {shape}.")
        result.append((index, float(value)))
    return result
