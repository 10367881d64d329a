"""Real AIS reports left out and predicted: the default beats constant velocity at each age, and its sigma is honest."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from navfix.picture.motion import DEFAULT
from tests.benchmarks import bench_motion
from tests.benchmarks.bench_motion import BOUND, Growth, outcome, samples
from tests.benchmarks.motion_data import real_tracks, simulated_tracks


@pytest.fixture(scope="module")
def left_out(shared_data: Path):
    """Return samples of all recordings at three ages, fewer a station than the benchmark has."""
    monkeypatch = pytest.MonkeyPatch()
    monkeypatch.setattr(bench_motion, "AGES_S", (10, 60, 180))
    monkeypatch.setattr(bench_motion, "MOST_PER_STATION", 8)
    chosen = samples(real_tracks(), seed=5)
    monkeypatch.undo()
    return chosen, {name: outcome(name, chosen) for name in (DEFAULT, "constant_velocity")}


@pytest.mark.study
@pytest.mark.parametrize("age_s", [10, 60, 180])
def test_the_default_beats_constant_velocity_and_its_sigma_is_honest(left_out, age_s: int):
    chosen, outcomes = left_out
    here = np.array([sample.age_s == age_s and sample.ais_class == "A" for sample in chosen])
    assert np.count_nonzero(here) > 400
    ours, plain = outcomes[DEFAULT], outcomes["constant_velocity"]
    for percentile in (50, 95):
        assert np.percentile(ours.error_m[here], percentile) < 1.02 * np.percentile(plain.error_m[here], percentile)
    both = [np.percentile(o.error_m[here], [50, 95]) for o in (ours, plain)]
    assert np.log(both[0] / both[1]).mean() < 0.0
    assert 0.92 < np.mean(ours.error_m[here] < BOUND * ours.sigma_m[here]) < 0.98


def test_the_benchmark_fits_the_sigma_that_epochs_use():
    chosen = samples(simulated_tracks(1, 3))[::5]
    model = bench_motion.ais_model("class_a")
    fitted = Growth(chosen).sigma_m(np.array([getattr(model, key) for key in bench_motion.FITTED]))
    assert fitted == pytest.approx(outcome(DEFAULT, chosen).sigma_m, rel=1e-9)
