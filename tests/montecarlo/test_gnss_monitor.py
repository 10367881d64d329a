"""How soon the monitor of GNSS alarms, and how often without need: simulated hours, 15 pairs, a fix every 3 s.

Errors are those of a linear adjustment: AIS antennas that stay where they are, radar noise anew in every scan. The
receiver wanders slowly by 4 m besides 2 m of noise; its stated sigma is 8 m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from navfix.adjustment.sights import jacobian
from navfix.adjustment.whitening import whitened
from navfix.geodesy import LocalPlane
from navfix.integrity import GnssMonitor
from navfix.types import Epoch, Fix, GnssReport, GnssVerdict, Position
from tests.adjustment_scenes import MARK_SIGMA_M, plane_scene

OWN = Position(54.5, 18.8)
START = datetime(2026, 5, 1, tzinfo=UTC)
STEP_S, PAIRS, BEGINS_S = 3.0, 15, 402.0
Offset = Callable[[float], float]


def passage(rng: np.random.Generator, seconds: float, offset_m: Offset) -> Iterator[tuple[float, Fix, GnssReport]]:
    """Yield time, fix and GNSS report; GNSS is moved northwards by ``offset_m(time)``."""
    network = plane_scene(rng, marks=PAIRS).network
    pose = np.zeros(3)
    _, a_white = whitened(network, pose)
    cofactor = np.linalg.inv(a_white.T @ a_white)
    effect = jacobian(network, pose)[:, :2]
    sigma = np.linalg.norm(a_white, axis=1) / np.linalg.norm(jacobian(network, pose), axis=1)
    antennas = MARK_SIGMA_M * rng.normal(size=(PAIRS, 2))
    steady = np.einsum("mi,mi->m", effect, antennas[network.mark])
    plane, wander = LocalPlane(OWN), 4.0 * rng.normal(size=2)
    for time_s in np.arange(0.0, seconds, STEP_S):
        error = (steady + network.sigma * rng.normal(size=len(sigma))) * sigma
        shift = cofactor @ a_white.T @ error
        v = a_white @ shift - error
        dof = 2.0 * PAIRS - 3.0
        sigma0 = math.sqrt(float(v @ v) / dof)
        wander += -wander * STEP_S / 120.0 + 4.0 * math.sqrt(2.0 * STEP_S / 120.0) * rng.normal(size=2)
        gnss = wander + 2.0 * rng.normal(size=2) + [offset_m(time_s), 0.0]
        at = START + timedelta(seconds=float(time_s))
        yield time_s, _fix(plane, shift, cofactor, sigma0, dof, at), GnssReport(plane.to_position(*gnss), 8.0)


def _fix(plane: LocalPlane, shift: np.ndarray, cofactor: np.ndarray, sigma0: float, dof: float, at: datetime) -> Fix:
    return Fix(
        position=plane.to_position(float(shift[0]), float(shift[1])),
        heading_deg=0.0,
        covariance=sigma0**2 * cofactor,
        sigma0=sigma0,
        redundancy=2 * PAIRS - 3,
        observations=(),
        association=None,
        epoch=Epoch(at, (), ()),
        cofactor_matrix=cofactor,
        covariance_scaling="a_posteriori",
        dof=dof,
        kernel="hampel",
    )


def time_to_alarm(seed: int, offset_m: Offset, *, seconds: float = 1200.0) -> tuple[float, list[str]]:
    """Return the seconds from the offset's beginning to "unsafe", and every alert."""
    monitor, alerts, alarm_s = GnssMonitor(), [], math.inf
    for time_s, fix, gnss in passage(np.random.default_rng(seed), BEGINS_S + seconds, offset_m):
        verdict = monitor.feed(fix, gnss)
        assert verdict is not None
        alerts += [verdict.alert] if verdict.alert else []
        if verdict.verdict == "unsafe":
            alarm_s = time_s - BEGINS_S
            break
    return alarm_s, alerts


def jump(time_s: float) -> float:
    return 200.0 if time_s >= BEGINS_S else 0.0


def drag(rate_mps: float) -> Offset:
    return lambda time_s: rate_mps * max(0.0, time_s - BEGINS_S)


def unrest(hours: float, seed: int) -> tuple[int, dict[str, float]]:
    """Return the alerts of ``hours`` with a good receiver, and the share of each verdict."""
    monitor, alerts, counts = GnssMonitor(), [], dict.fromkeys(("ok", "caution", "unsafe", "not_available"), 0)
    for _, fix, gnss in passage(np.random.default_rng(seed), 3600.0 * hours, lambda _: 0.0):
        verdict = _answered(monitor.feed(fix, gnss))
        counts[verdict.verdict] += 1
        alerts += [verdict.alert] if verdict.alert else []
    return len(alerts), {word: count / sum(counts.values()) for word, count in counts.items()}


def _answered(verdict: GnssVerdict | None) -> GnssVerdict:
    assert verdict is not None
    return verdict


def test_a_jump_of_200_m_alarms_within_two_fixes() -> None:
    found = [time_to_alarm(seed, jump) for seed in range(3)]
    print(f"jump of 200 m, time to alarm: {[float(alarm_s) for alarm_s, _ in found]} s")
    for alarm_s, alerts in found:
        assert 0.0 <= alarm_s <= STEP_S, "the first fix after the jump is at 0 s, the second one turn later"
        assert len(alerts) == 1
        assert alerts[0].startswith("GNSS ok -> unsafe: 2 of the last 5 comparisons, far beyond")


def test_a_drag_off_of_1_mps_alarms_within_two_minutes() -> None:
    found = [time_to_alarm(seed, drag(1.0)) for seed in range(3)]
    print(f"drag-off of 1 m/s, time to alarm: {[float(alarm_s) for alarm_s, _ in found]} s")
    assert all(0.0 < alarm_s <= 120.0 for alarm_s, _ in found)


def test_a_slower_drag_is_found_by_its_trend_before_a_single_comparison_could() -> None:
    """0.2 m/s: the alarm comes at an offset below what one comparison allows."""
    alarm_s, alerts = time_to_alarm(1, drag(0.2))
    print(f"drag-off of 0.2 m/s: alarm after {alarm_s:.0f} s, {0.2 * alarm_s:.0f} m; {alerts}")
    assert 0.0 < alarm_s <= 300.0
    assert "GNSS leaves the fix at 0." in alerts[-1]


def test_an_hour_of_a_good_receiver_is_quiet() -> None:
    alerts, shares = unrest(1.0, 5)
    print(f"one hour, good receiver: {alerts} alerts, {shares}")
    assert shares["unsafe"] == 0.0
    assert shares["ok"] > 0.95


@pytest.mark.study
def test_study_times_to_alarm() -> None:
    for name, offset in (("jump 200 m", jump), *((f"drag {r} m/s", drag(r)) for r in (1.0, 0.5, 0.2, 0.1))):
        times = np.array([time_to_alarm(seed, offset)[0] for seed in range(40)])
        print(
            f"{name}: median {np.median(times):.0f} s, 95 % {np.quantile(times, 0.95):.0f} s, most {times.max():.0f} s"
        )
        assert times.min() >= 0.0
        assert np.all(np.isfinite(times))


@pytest.mark.study
def test_study_false_alarms() -> None:
    found = [unrest(4.0, 100 + seed) for seed in range(12)]
    unsafe = np.mean([shares["unsafe"] for _, shares in found])
    caution = np.mean([shares["caution"] for _, shares in found])
    alerts = sum(count for count, _ in found)
    print(f"48 h, good receiver: {alerts} alerts, unsafe {unsafe:.2%} of the time, caution {caution:.2%}")
    assert unsafe < 1e-3
