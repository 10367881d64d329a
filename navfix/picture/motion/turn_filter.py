"""A Kalman filter through a history, unscented or extended: filtered and carried on."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from navfix.catalog import AisModel, FilterModel, filter_model
from navfix.picture.motion.geodetic_turn import COURSE, LAT, LON, RATE, SPEED, metres_per_degree
from navfix.picture.motion.history import History
from navfix.picture.motion.outcome import Carried, Declined
from navfix.picture.motion.steering import STILL_MPS
from navfix.types import FloatArray
from navfix.units import wrap_180, wrap_pi

LONGEST_STEP_S = 20.0  # the motion is moved on in steps over which it is nearly linear


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Mean (5,) in (longitude deg, latitude deg, speed m/s, course rad, rate rad/s) and covariance at a time."""

    time_s: float
    mean: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Report:
    """What one report measures: ``value`` (k,) of the state's ``components`` (k,) with ``covariance`` (k, k)."""

    time_s: float
    components: tuple[int, ...]
    value: FloatArray
    covariance: FloatArray


Predict = Callable[[State, float, FilterModel], State]


def carry(past: History, at_s: float, model: AisModel, *, predict: Predict) -> Carried | Declined:
    """Carry a ship by a filter through its history; its sigma is the filter's and that of the time of the report.

    Declines without speed and course to start from.
    """
    if float(past.speed_mps[0]) <= STILL_MPS:
        return Declined("a ship that lies still has no course to filter")
    constants = filter_model()
    reports = reports_of(past, constants)
    began = next((i for i, report in enumerate(reports) if len(report.components) == 4), None)
    if began is None:
        return Declined("no report tells speed and course: the filter cannot start")
    state = started(reports[began], constants)
    for report in reports[began + 1 :]:
        state = corrected(moved(state, report.time_s, predict, constants), report)
    found = moved(state, at_s, predict, constants)
    north_m, east_m, sigma_m = _step(past, found)
    return Carried(north_m, east_m, math.hypot(sigma_m, model.clock_sigma_s * float(state.mean[SPEED])))


def moved(state: State, to_s: float, predict: Predict, constants: FilterModel) -> State:
    """Return a state moved on to a time in steps of at most `LONGEST_STEP_S`."""
    for time_s in stepping(state.time_s, to_s):
        state = predict(state, time_s, constants)
    return state


def stepping(from_s: float, to_s: float) -> list[float]:
    """Return the times after ``from_s`` up to ``to_s``, none more than `LONGEST_STEP_S` from the one before."""
    count = max(math.ceil(abs(to_s - from_s) / LONGEST_STEP_S), 1)
    return [from_s + (to_s - from_s) * k / count for k in range(1, count)] + [to_s]


def reports_of(past: History, constants: FilterModel) -> list[Report]:
    """Return what the reports of a history measure, oldest first: the place, and speed and course where told."""
    lat_m, lon_m = metres_per_degree(past.lat_deg)
    found = []
    for i in range(len(past) - 1, -1, -1):
        sigmas = [constants.position_sigma_m / float(lon_m[i]), constants.position_sigma_m / float(lat_m[i])]
        values = [float(past.lon_deg[i]), float(past.lat_deg[i])]
        components: tuple[int, ...] = (LON, LAT)
        speed, course = float(past.speed_mps[i]), float(past.course_rad[i])
        if speed > STILL_MPS and math.isfinite(course):
            values, components = [*values, speed, course], (LON, LAT, SPEED, COURSE)
            course_sigma = math.hypot(math.radians(constants.course_sigma_deg), constants.speed_sigma_mps / speed)
            sigmas += [constants.speed_sigma_mps, course_sigma]
        found.append(Report(float(past.time_s[i]), components, np.array(values), np.diag(np.square(sigmas))))
    return found


def started(report: Report, constants: FilterModel) -> State:
    """Return the state after a first report that tells place, speed and course."""
    covariance = np.zeros((5, 5))
    covariance[:4, :4] = report.covariance
    covariance[RATE, RATE] = constants.start_turn_sigma_rad_s**2
    return State(report.time_s, np.append(report.value, 0.0), covariance)


def corrected(state: State, report: Report) -> State:
    """Return a state after a report: the measurement picks components, so this step is linear in both filters."""
    H = np.eye(5)[list(report.components)]
    off = report.value - H @ state.mean
    off[0] = wrap_180(float(off[0]))
    if len(off) == 4:
        off[3] = wrap_pi(float(off[3]))
    S = H @ state.covariance @ H.T + report.covariance
    scale = np.sqrt(np.diag(S))
    PH = state.covariance @ H.T
    K = np.linalg.solve(S / np.outer(scale, scale), (PH / scale).T).T / scale
    left = np.eye(5) - K @ H
    covariance = left @ state.covariance @ left.T + K @ report.covariance @ K.T  # Joseph: stays positive
    return State(state.time_s, state.mean + K @ off, covariance)


def _step(past: History, state: State) -> tuple[float, float, float]:
    """Return (north, east) [m] from the newest report to a state and its sigma per axis [m]."""
    lat_m, lon_m = (float(m) for m in metres_per_degree(0.5 * (float(state.mean[LAT]) + past.origin.lat_deg)))
    north_m = (float(state.mean[LAT]) - past.origin.lat_deg) * lat_m
    east_m = wrap_180(float(state.mean[LON]) - past.origin.lon_deg) * lon_m
    variance = 0.5 * (state.covariance[LAT, LAT] * lat_m**2 + state.covariance[LON, LON] * lon_m**2)
    return north_m, east_m, math.sqrt(float(variance))
