"""A window of epochs as arrays: sightings of tracks, the marks they belong to, own sensors between the epochs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from navfix.adjustment.window.prior import PlanePose
from navfix.catalog import AdjustmentModel
from navfix.geodesy import LocalPlane
from navfix.types import FloatArray, IntArray, Mark, RadarTarget
from navfix.units import wrap_pi


class Sighting(NamedTuple):
    """A target of one epoch and the mark that it is."""

    epoch: int
    target: RadarTarget
    mark: Mark


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """What the radar followed: ``label``, ``mark`` (n,) index of the mark, ``sigma`` (n, 2) of what stays: m, rad.

    A track is a target label and a mark label without a pause longer than ``split_gap_s``: a number that is given to
    another ship begins another track.
    """

    label: tuple[str, ...]
    mark: IntArray
    sigma: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """Range and bearing of one track in one epoch, k of them, in the order of the epochs.

    Attributes
    ----------
    epoch, track, mark : (k,) indices
    value, sigma : (k, 2) range [m] and bearing [rad] as observed; 1 sigma of what is new in every scan
    place_ne_m, velocity_ne_mps : (k, 2) of the mark at the epoch
    is_true : (k,) whether the bearing is a true one
    fresh_m : (k,) 1 sigma per axis of what the mark has gained since its best report in the window
    """

    epoch: IntArray
    track: IntArray
    mark: IntArray
    value: FloatArray
    sigma: FloatArray
    place_ne_m: FloatArray
    velocity_ne_mps: FloatArray
    is_true: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    fresh_m: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class OwnSensors:
    """Heading and log at each epoch, NaN where there is none: rad, m/s; ``through_water`` (E,)."""

    gyro_rad: FloatArray
    gyro_sigma_rad: FloatArray
    log_mps: FloatArray
    log_sigma_mps: FloatArray
    through_water: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


@dataclass(frozen=True, slots=True, eq=False)
class WindowNetwork:
    """Everything on one plane. ``mark_sigma_m`` (n,): of each mark's offset that stays; ``time_s`` (E,) POSIX.

    ``prior`` is the pose of the first epoch as older data have it, None where nothing is known.
    """

    plane: LocalPlane
    time_s: FloatArray
    seen: Sightings
    tracks: Tracks
    mark_labels: tuple[str, ...]
    mark_sigma_m: FloatArray
    own: OwnSensors
    model: AdjustmentModel
    compass_sigma_rad: float
    prior: PlanePose | None = None

    @property
    def epochs(self) -> int:
        return len(self.time_s)

    @property
    def any_relative(self) -> bool:
        """Whether a relative bearing takes part: only these show the heading."""
        return bool(np.any(~self.seen.is_true))

    @property
    def global_sigma(self) -> FloatArray:
        """1 sigma of what all sightings share, as `state.GLOBALS`: s, m, rad, m/s, m/s."""
        model, log = self.model, np.isfinite(self.own.log_mps)
        water = bool(np.any(self.own.through_water & log)) or not np.any(log)
        current = model.current_sigma_mps if water else model.ground_log_sigma_mps
        return np.array([model.clock_sigma_s, model.range_bias_sigma_m, self.compass_sigma_rad, current, current])


def gyro_steps(window: WindowNetwork) -> FloatArray:
    """Return the turn of the gyro between successive epochs (E - 1,) [rad], NaN where one of them is missing."""
    return np.asarray(wrap_pi(np.diff(window.own.gyro_rad)))
