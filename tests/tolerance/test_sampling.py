"""Quantiles: the same rows whatever was drawn before, evenly spread, inside (0, 1)."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scipy.stats import qmc

from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.sampling import BATCH_ROWS, PickFreeze, SobolSample, quantiles


def test_the_batches_are_the_scrambled_sobol_sequence_shifted_by_half_a_cell() -> None:
    wanted = qmc.Sobol(5, rng=np.random.default_rng(3)).random(4 * BATCH_ROWS)
    got = np.concatenate([quantiles(5, 3, batch) for batch in range(4)])
    np.testing.assert_array_equal(got, wanted + 2.0**-31)


def test_a_batch_does_not_depend_on_what_was_drawn_before() -> None:
    def drawn(batch: int) -> bytes:
        return quantiles(7, 11, batch).tobytes()

    in_order = [drawn(batch) for batch in range(6)]
    for batch in (5, 0, 3, 3, 1, 4, 2):
        assert drawn(batch) == in_order[batch]
        quantiles(7, 12, 2)


def test_threads_do_not_draw_from_each_others_sequence() -> None:
    batches = [5, 4, 3, 2, 1, 0] * 20
    alone = [quantiles(7, 11, batch).tobytes() for batch in batches]
    usual = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as threads:
            together = list(threads.map(lambda batch: quantiles(7, 11, batch).tobytes(), batches))
    finally:
        sys.setswitchinterval(usual)
    assert together == alone


def test_each_batch_is_stratified() -> None:
    """As many points in each of so many equal intervals as in any other: a property of Sobol points."""
    rows = quantiles(40, 0, 9)
    cells = np.sort((rows * BATCH_ROWS).astype(int), axis=0)
    np.testing.assert_array_equal(cells, np.tile(np.arange(BATCH_ROWS)[:, None], (1, 40)))


def test_no_quantile_is_zero_or_one() -> None:
    low, high = np.inf, -np.inf
    for batch in range(200):
        rows = quantiles(3, 1, batch)
        low, high = min(low, rows.min()), max(high, rows.max())
    assert 2.0**-31 <= low < 1e-4
    assert 1.0 - 1e-4 < high <= 1.0 - 2.0**-31


def test_seeds_differ() -> None:
    assert np.abs(quantiles(3, 1, 0) - quantiles(3, 2, 0)).max() > 0.5


def test_nothing_uncertain_needs_no_columns() -> None:
    assert quantiles(0, 1, 5).shape == (BATCH_ROWS, 0)


def test_pick_freeze_takes_the_columns_of_one_group_from_the_other_matrix() -> None:
    groups, samples = (2, 1, 3), 2 * BATCH_ROWS
    sample = PickFreeze(groups, 5, samples)
    rows = np.concatenate([sample.batch(index) for index in range(sample.batches)])
    a, b, *mixed = rows.reshape(-1, samples, 6)
    assert np.abs(np.corrcoef(a.T, b.T)[:6, 6:]).max() < 0.1
    assert len(mixed) == 3
    for matrix, columns in zip(mixed, ([0, 1], [2], [3, 4, 5]), strict=True):
        others = [k for k in range(6) if k not in columns]
        np.testing.assert_array_equal(matrix[:, columns], b[:, columns])
        np.testing.assert_array_equal(matrix[:, others], a[:, others])


def test_few_samples_are_one_batch_of_each_matrix() -> None:
    sample = PickFreeze((1, 1), 5, 64)
    assert sample.batches == 4
    assert sample.batch(3).shape == (64, 2)


@pytest.mark.parametrize("variants", [0, -5, 2**30 + 1])
def test_a_study_needs_variants(variants: int) -> None:
    with pytest.raises(StudyError, match="takes 1 to 1073741824 variants"):
        SobolSample(3, 0, variants)


@pytest.mark.parametrize("samples", [0, 1, 1000])
def test_sensitivities_need_a_power_of_two(samples: int) -> None:
    with pytest.raises(StudyError, match="power of two"):
        PickFreeze((1,), 0, samples)


def test_senseless_columns_are_refused() -> None:
    with pytest.raises(StudyError, match="seed must be zero or more"):
        quantiles(3, -1, 0)
    with pytest.raises(StudyError, match="too many"):
        quantiles(30000, 1, 0)
