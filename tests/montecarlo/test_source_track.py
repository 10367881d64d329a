"""The manoeuvring track of a source through both filters, and what brings radar and AIS onto one time in its turns."""

from __future__ import annotations

import numpy as np
import pytest

from navfix.errors import InputError
from navfix.picture.motion import ekf, ukf
from navfix.picture.motion.grey_model import at_times
from navfix.picture.motion.spline import curve
from navfix.simulation.manoeuvres import SOURCE_LEGS, Leg, run
from tests.benchmarks.bench_source_track import as_printed, ours, rmse

TRUTH = run(SOURCE_LEGS, period_s=10.0)


def test_the_filters_beat_the_raw_positions_and_the_unscented_is_no_worse():
    """R read as 0.1 arc minutes (185 m an axis), the unit being open: raw place 262 m."""
    found = {f.__name__: rmse(TRUTH, 185.0, f.predict, ours, 4) for f in (ukf, ekf)}
    for name, (distance, bearing, speed, place) in found.items():
        print(
            f"{name}: distance {distance:.0f} m, bearing {bearing:.2f} deg, speed {speed:.1f} m/s, place {place:.0f} m"
        )
    unscented, extended = found["navfix.picture.motion.ukf"], found["navfix.picture.motion.ekf"]
    assert unscented[3] < 0.75 * 262.0
    assert unscented[3] < 1.05 * extended[3]


def test_the_noise_as_printed_gives_no_speed():
    """Q = diag(1e-6, 1e-6, 100, 1, 1) lets course and rate wander by a radian a period."""
    assert rmse(TRUTH, 10.0, ukf.predict, as_printed, 2)[2] > 10.0 * rmse(TRUTH, 10.0, ukf.predict, ours, 2)[2]


@pytest.mark.parametrize(("sigma_m", "within"), [(0.0, 0.5), (15.0, 15.0)], ids=["no noise", "noise 15 m"])
def test_a_series_on_other_times_grey_model_line_and_spline(sigma_m: float, within: float):
    """Ranges of every third second, brought to the times of AIS: rms errors in a turn, printed."""
    fine = run(SOURCE_LEGS, period_s=1.0)
    rng, errors = np.random.default_rng(6), {"grey": [], "line": [], "spline": []}
    for first in range(610, 880, 15):
        scans = np.arange(first, first + 15, 3)
        range_m = np.hypot((fine.lat_deg - 39.95) * 111_000.0, (fine.lon_deg - 100.02) * 85_000.0)
        seen = range_m[scans] + sigma_m * rng.normal(size=len(scans))
        wanted = np.array([first + 4.0, first + 7.0, first + 10.0])
        exact = np.interp(wanted, fine.time_s, range_m)
        errors["grey"].append(at_times(seen, float(first), 3.0, wanted) - exact)
        errors["line"].append(np.interp(wanted, scans, seen) - exact)
        errors["spline"].append(
            [curve(scans.astype(float), seen[:, None], t)[0] - e for t, e in zip(wanted, exact, strict=True)]
        )
    rms = {name: float(np.sqrt(np.mean(np.square(values)))) for name, values in errors.items()}
    print({name: round(value, 2) for name, value in rms.items()})
    assert max(rms.values()) < within
    if sigma_m:
        assert rms["grey"] < rms["line"] < rms["spline"]  # five values make one line: the noise averages


@pytest.mark.parametrize(
    "leg", [Leg(1000.0, acceleration_mps2=0.1), Leg(200.0, acceleration_mps2=-0.1), Leg(20.0, turn_rate_rad_s=2.5)]
)
def test_generated_ships_keep_to_60_knots_forward_and_2_g(leg: Leg):
    with pytest.raises(InputError, match="60 kn and at most 2 g"):
        run([leg], period_s=10.0)
