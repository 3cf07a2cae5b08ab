"""The acceptance of a made part: its statistics and limits by closed forms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from gomboc_cad.body.catalogue import named_body
from gomboc_cad.report.json_values import Value
from gomboc_cad.report.protocol import protocol_document, share_at_least
from tests.report.conftest import DATA


def test_59_drops_without_a_miss_show_95_per_cent() -> None:
    """The classic sample of attribute testing: 0.95⁵⁹ < 0.05 (ISO 16269-6, one-sided, no miss)."""
    assert share_at_least(59, 0) >= 0.95 > share_at_least(58, 0)


@given(st.integers(1, 400))
def test_without_a_miss_the_bound_is_a_root(drops: int) -> None:
    assert share_at_least(drops, 0) == pytest.approx(0.05 ** (1.0 / drops), rel=1e-9)


@given(st.integers(2, 300), st.data())
def test_a_part_at_the_bound_does_as_well_in_one_case_of_twenty(drops: int, data: st.DataObject) -> None:
    misses = data.draw(st.integers(0, drops - 1))
    share = share_at_least(drops, misses)
    assert binom.sf(drops - misses - 1, drops, share) == pytest.approx(0.05, rel=1e-6)


def document_of(name: str) -> dict:
    return json.loads((DATA / "housing" / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def protocol() -> dict:
    verdict = Value(document_of("verdict.json"), "verdict.json")
    com_mm = np.array(verdict["assembly"]["com_mm"].numbers)
    study = Value.absent("tolerance.json")
    return protocol_document(named_body("primary"), com_mm, verdict, study, verdict["s_margin_mm"], 1.0)


def test_a_mass_at_its_limit_takes_a_quarter_of_the_margin(protocol: dict) -> None:
    """Weighed anew with one part heavier by its limit, the centre of mass moves by that, to first order."""
    verdict = document_of("verdict.json")
    masses = np.array([part["mass_g"] for part in verdict["parts"]])
    places = np.array([part["com_mm"] for part in verdict["parts"]])
    before = masses @ places / masses.sum()
    for k, row in enumerate(protocol["masses"]):
        step = 1e-4 * row["limit_g"]
        heavier = masses.copy()
        heavier[k] += step
        moved = np.linalg.norm(heavier @ places / heavier.sum() - before) / 1e-4
        assert moved == pytest.approx(0.25 * verdict["s_margin_mm"], rel=1e-3)


def test_the_centre_of_mass_may_be_off_as_far_as_it_tilts_to_the_limit(protocol: dict) -> None:
    rest = document_of("verdict.json")["rest"]
    tilt = protocol["com"]["pointing_um"] * rest["tilt_deg_per_um"][0]
    assert tilt == pytest.approx(1.0)
    assert math.degrees(1e-3 * protocol["com"]["pointing_um"] / rest["stiffness_mm"][0]) == pytest.approx(1.0)


def test_the_widths_are_those_of_the_surface(protocol: dict) -> None:
    """Twice the largest reach of many points along each axis, both ways."""
    from gomboc_cad.body.sphere import fibonacci_directions

    points = named_body("primary").position_mm(fibonacci_directions(200_000))
    for row in protocol["widths"]:
        reach = points @ np.array(row["direction"])
        assert row["width_mm"] == pytest.approx(reach.max() - reach.min(), abs=2e-3)
        assert row["width_mm"] >= reach.max() - reach.min()


def test_without_a_study_waviness_uses_the_margin_up_by_its_square(protocol: dict) -> None:
    amplitudes = {row["undulations"]: row["guaranteed_um"] for row in protocol["form"]}
    assert amplitudes[2] == pytest.approx(4.0 * amplitudes[4])
    assert amplitudes[2] == pytest.approx(1e3 * document_of("verdict.json")["s_margin_mm"] / 4.0)


def test_a_study_gives_the_limits_of_the_form_itself(tmp_path: Path) -> None:
    study = json.loads((DATA / "study" / "tolerance.json").read_text(encoding="utf-8"))
    build = Value.absent("verdict.json")
    found = protocol_document(
        named_body("primary"), np.zeros(3), build, Value(study, "tolerance.json"), build["s_margin_mm"], 3.0
    )
    degrees = [row["degree"] for row in study["form_error"]["degrees"]]
    assert [row["undulations"] for row in found["form"]] == degrees
    assert found["form"][0]["allowed_um"] == study["form_error"]["degrees"][0]["allowed_um"]
    assert "com" not in found
