"""Studies of real bodies with a single source of error, against what is known of them in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from gomboc_cad.body import Body, Harmonic, catalog
from gomboc_cad.body.sphere import BoolArray
from gomboc_cad.equilibria import com_margin
from gomboc_cad.products.process import load_process
from gomboc_cad.tolerance.executors import executor_for
from gomboc_cad.tolerance.product_study import body_study
from gomboc_cad.tolerance.requirement import Requirement
from gomboc_cad.tolerance.sampling import BATCH_ROWS, quantiles
from gomboc_cad.tolerance.study import run_study
from gomboc_cad.tolerance.variants import MONOSTABLE, MULTISTABLE, Variants

SPHERE = Body("sphere", Harmonic(()), 50.0)


def ellipsoids_with_one_rest(variants: Variants) -> BoolArray:
    """Whether ellipsoids with the COM on an axis rest in one pose only.

    With semi-axes a ≤ b and, along the COM, c, the lower pole is a rest if `c − a²/c < s` and the upper one
    no rest if `a²/c − c < s`; if the lower one is none, there are two to the sides of it.
    """
    axes = SPHERE.radius_mm * np.einsum("nii->ni", variants.stretch)
    shorter, along = axes[:, :2].min(axis=1), axes[:, 2]
    result: BoolArray = np.abs(shorter**2 / along - along) < -variants.com_mm[:, 2]
    return result


@pytest.mark.slow
def test_shrinkage_of_a_loaded_sphere_makes_ellipsoids_with_known_rests() -> None:
    model = body_study(SPHERE, load_process("fdm"), com_mm=(0.0, 0.0, -0.1)).only("shrinkage")
    found = run_study(model, BATCH_ROWS, seed=1)
    rows = quantiles(3, 1, 0)
    truth = ellipsoids_with_one_rest(model.variants(rows))
    assert 0.3 < truth.mean() < 0.9
    np.testing.assert_array_equal(found.rows["verdict"] == MONOSTABLE, truth)
    assert found.yield_monostable.passed == truth.sum()


@pytest.mark.slow
def test_a_com_of_the_primary_is_good_wherever_it_stays_within_the_margin() -> None:
    """The margin is the radius of the largest ball of good places; farther away some are good as well."""
    body = catalog()["primary"]
    model = body_study(body, load_process("fdm"), com_error_mm=0.4).only("com_error")
    margin = com_margin(body, model.nominal.com_mm)
    found = run_study(model, 2 * BATCH_ROWS, seed=2)
    error_um = np.sqrt(sum(found.rows[f"com_error_{axis}_um"] ** 2 for axis in "xyz"))
    inside = error_um < 1e3 * margin.s_margin_mm
    ball = 4.0 / 3.0 * np.pi * margin.s_margin_mm**3 / 0.8**3
    assert inside.mean() == pytest.approx(ball, rel=0.25)
    assert np.all(found.rows["verdict"][inside] == MONOSTABLE)
    assert np.any(found.rows["verdict"] == MULTISTABLE)
    assert found.yield_monostable.interval.low > ball


@pytest.mark.slow
def test_a_real_study_has_the_same_bits_in_every_process() -> None:
    model = body_study(catalog()["primary"], load_process("cnc-5axis"))
    count = BATCH_ROWS + 100  # two batches, one of them not full
    here = run_study(model, count, seed=3, requirement=Requirement(10.0, rolling_mm=0.005))
    with executor_for("local:2") as executor:
        there = run_study(
            model, count, seed=3, requirement=Requirement(10.0, rolling_mm=0.005), executor=executor
        )
    assert here.rows.tobytes() == there.rows.tobytes()
    assert here.yield_tilt == there.yield_tilt


@pytest.mark.slow
def test_a_real_body_without_tolerances_is_good() -> None:
    model = body_study(catalog()["primary"], load_process("fdm"))
    exact = model.scaled({source.name: 0.0 for source in model.sources})
    found = run_study(exact, 512, seed=4, requirement=Requirement(1e-6))
    assert found.yield_tilt.passed == 512
    assert found.com_error_um.largest < 1e-9
