"""Files that are no certificates: one sentence, never a crash."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gomboc_cad.equilibria.certificate import Certificate, dumps, load, loads
from gomboc_cad.equilibria.certificate.document import MAX_BYTES
from gomboc_cad.equilibria.certificate.records import MAX_CELLS
from gomboc_cad.errors import InspectionError
from tests.equilibria.certificate.tampering import signed

HOSTILE = {
    "empty": b"",
    "not JSON": b"solid gomboc",
    "not text": bytes(range(256)),
    "a number": b"1",
    "a list": b"[]",
    "an empty object": b"{}",
    "deeply nested": b"[" * 1_000_000,
    "nested objects": b'{"a":' * 200_000,
    "NaN": b'{"beta": NaN}',
    "an infinite number": b'{"beta": Infinity}',
    "a float": b'{"beta": 0.02}',
    "an absurd integer": b'{"version": ' + b"9" * 100_000 + b"}",
    "a key twice": b'{"beta": "0.02", "beta": "0.03"}',
    "too long": b" " * (MAX_BYTES + 1),
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_bytes_are_refused_with_a_sentence(what: str) -> None:
    with pytest.raises(InspectionError) as caught:
        loads(HOSTILE[what])
    text = str(caught.value)
    assert text.startswith("This is no valid certificate: ")
    assert text.endswith("Make a new one with gomboc-cad certify.")
    assert len(text) < 500


def _set(*path: str, to: Any) -> tuple[tuple[str, ...], Any]:
    return path, to


MALFORMED = {
    "another format": _set("format", to="something else"),
    "another version": _set("version", to=2),
    "a version that is true": _set("version", to=True),
    "β as a number": _set("beta", to=2),
    "β of a million digits": _set("beta", to="0." + "1" * 1_000_000),
    "coefficients as a list": _set("coefficients", to=[]),
    "a coefficient as a number": _set("coefficients", to={"1": 1}),
    "a long coefficient": _set("coefficients", to={"1": "0" * 1000}),
    "a chart as text": _set("chart", to="0.1"),
    "a chart of numbers": _set("chart", to=[0, 1]),
    "a chart of long texts": _set("chart", to=["0" * 1000]),
    "two coordinates": _set("com_enclosure", to=[["0", "0"], ["0", "0"]]),
    "coordinates of numbers": _set("com_enclosure", to=[0, 0, 0]),
    "half an interval": _set("volume_enclosure", to=["4.18"]),
    "a million cells": _set("convexity", "cells", to=["0 1 0 1"] * 1_000_000),
    "cells as numbers": _set("convexity", "cells", to=[1, 2, 3]),
    "a cell of three numbers": _set("convexity", "cells", to=["0 1 0"]),
    "a cell of absurd numbers": _set("convexity", "cells", to=["0 1 0 " + "9" * 1000]),
    "a claim where none belongs": _set("convexity", "cells", to=["0 1 0 1 E"]),
    "a margin as a number": _set("margin", "com_margin", to=1),
    "an unknown claim": _set("equilibria", "cells", to=["0 1 0 1 x"]),
    "a cell without a claim": _set("equilibria", "cells", to=["0 1 0 1"]),
    "a disc without a rectangle": _set("equilibria", "stable_disc", to={"cells": []}),
    "an unknown key": _set("convexity", "colour", to="red"),
    "a witness of an unknown kind": _set("witness", to={"kind": "rumour", "theta": 0, "psi": 0}),
    "a witness without a place": _set("witness", to={"kind": "saddle"}),
    "a better status": _set("status", to="refuted"),
    "more rests": _set("stable", to=2),
    "true rests": _set("stable", to=True),
    "a proof left out": _set("equilibria", to=None),
}


@pytest.mark.parametrize("what", MALFORMED)
def test_malformed_documents_are_refused_though_they_are_signed(
    primary_certificate: Certificate, what: str
) -> None:
    path, value = MALFORMED[what]
    document = json.loads(dumps(primary_certificate))
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    with pytest.raises(InspectionError, match="This is no valid certificate") as caught:
        loads(signed(document))
    assert len(str(caught.value)) < 500


def test_bounds_on_size_come_first(primary_certificate: Certificate) -> None:
    with pytest.raises(InspectionError, match="longer than 10 MB"):
        loads(b" " * (MAX_BYTES + 1))
    document = json.loads(dumps(primary_certificate))
    document["margin"]["cells"] = ["0 1 0 1"] * (MAX_CELLS + 1)
    with pytest.raises(InspectionError, match="more than 20000 cells"):
        loads(signed(document))


def test_a_key_that_occurs_twice_is_refused(primary_certificate: Certificate) -> None:
    text = dumps(primary_certificate)
    with pytest.raises(InspectionError, match="not JSON as certificates have it"):
        loads(text.replace(' "beta":', ' "beta": "0.02",\n "beta":'))


@pytest.mark.parametrize("key", ["sha256", "beta", "convexity", "units"])
def test_a_missing_key_is_refused(primary_certificate: Certificate, key: str) -> None:
    document = json.loads(dumps(primary_certificate))
    del document[key]
    with pytest.raises(InspectionError, match="must have the keys"):
        loads(json.dumps(document))


def test_files_are_read_and_their_absence_is_said(tmp_path: Path, primary_certificate: Certificate) -> None:
    path = tmp_path / "primary.json"
    path.write_text(dumps(primary_certificate), encoding="utf-8")
    assert load(path) == primary_certificate
    with pytest.raises(InspectionError, match="cannot be read: No such file"):
        load(tmp_path / "nowhere.json")
    with pytest.raises(InspectionError, match="cannot be read: Is a directory"):
        load(tmp_path)


def test_no_time_or_place_is_written(primary_certificate: Certificate) -> None:
    document = json.loads(dumps(primary_certificate))
    assert not {"seconds", "date", "path", "host"} & set(document)
    assert len(dumps(primary_certificate)) < 1_000_000
