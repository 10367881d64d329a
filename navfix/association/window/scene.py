"""Step 2: tracks in bins, in a basis in which their errors are independent.

The error of a track is a constant, a slope and what is new in each bin. In the basis (mean, straight line, the rest) of
its own bins the covariance is diagonal: n s_c^2 + s_w^2, S_tt s_s^2 + s_w^2, s_w^2; so a track is judged by its place,
its velocity and its scatter, each a factor of its own: eq. (6.18) of the theory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.association.scene import ComplexArray, Scene, conspicuity, middle
from navfix.association.window.bins import bases, binned
from navfix.association.window.marks import MarkPaths, paths_of
from navfix.association.window.tracks import Track, epoch_time, tracks_of
from navfix.association.window.yaw import Yaw
from navfix.catalog import AssociationModel, RadarModel, WindowModel
from navfix.errors import TooFewPairs
from navfix.types import Epoch, FloatArray, IntArray, Position


@dataclass(frozen=True, eq=False)
class WindowScene:
    """Tracks (m,) and marks (n,) of a window with knots (K,), one in the middle of each bin.

    Attributes
    ----------
    flat : tracks at their middle and marks at the middle knot, as a scene of one instant
    knot_s (K,) : seconds after the middle of the window; ``end_s`` its end; ``middle_s`` POSIX seconds of the middle
    gauge : index of the knot whose pose stands for the whole
    rho (m, K) : tracks at the knots in the de-rotated ship's frame [m], 0 where they do not live
    alive (m, K) : where they do
    basis (m, K, K) : rows are basis vectors over bins: mean, line, the rest; zero rows where a track has fewer bins
    used (m, K) : which rows are not zero
    bins (m,), spread_s2 (m,) : bins of a track and the sum of squares of their times about their mean
    constant_m2, white_m2 (m, 2) : variances, radial and tangential
    middle_bin (m,) : a bin in the middle of each track's life
    """

    flat: Scene
    tracks: tuple[Track, ...]
    paths: MarkPaths
    yaw: Yaw
    middle_s: float
    knot_s: FloatArray
    end_s: float
    gauge: int
    rho: ComplexArray
    alive: np.ndarray
    basis: FloatArray
    used: np.ndarray
    bins: FloatArray
    spread_s2: FloatArray
    constant_m2: FloatArray
    white_m2: FloatArray
    middle_bin: IntArray

    @property
    def yaw_at_end(self) -> float:
        """How far own ship has turned [rad] from the first scan to the end: what the de-rotated heading lacks."""
        return self.yaw.at(self.middle_s + self.end_s)

    @property
    def knots(self) -> int:
        """How many knots there are."""
        return len(self.knot_s)


def build(epochs: Sequence[Epoch], model: WindowModel, shared: AssociationModel, radar: RadarModel) -> WindowScene:
    """Cut a window into bins and bring its tracks and marks to them; targets without sigmas have those of ``radar``.

    Raises
    ------
    TooFewPairs : not one track, or not one mark
    """
    reference = _reference(epochs)
    tracks, yaw = tracks_of(epochs, reference, model)
    end_s, begin_s = epoch_time(epochs[-1]), epoch_time(epochs[0])
    count = max(1, round((end_s - begin_s) / model.bin_s))
    knot_s: FloatArray = np.array([0.5 * (begin_s + end_s)])
    if count > 1:
        knot_s = end_s - model.bin_s * (np.arange(count, dtype=np.float64)[::-1] + 0.5)
    middle_s = float(knot_s.mean())
    alive, rho = binned(tracks, knot_s, model.bin_s)
    kept = np.flatnonzero(alive.any(axis=1))
    tracks, alive, rho = [tracks[i] for i in kept], alive[kept], rho[kept]
    _require_some(tracks, epochs)
    lat = [m.position.lat_deg for m in epochs[-1].marks] or [m.position.lat_deg for e in epochs for m in e.marks]
    lon = [m.position.lon_deg for m in epochs[-1].marks] or [m.position.lon_deg for e in epochs for m in e.marks]
    origin = middle(np.array(lat), np.array(lon))
    paths = paths_of(epochs, origin, knot_s, model)
    basis, used, spread = bases(alive, knot_s)
    constant, white = _variances(tracks, rho, alive, model, radar)
    middle_bin = np.array([int(np.flatnonzero(row)[row.sum() // 2]) for row in alive], dtype=np.int64)
    flat = _flat(origin, rho[np.arange(len(kept)), middle_bin], constant, paths, count // 2, reference, shared)
    return WindowScene(
        flat, tuple(tracks), paths, yaw, middle_s, knot_s - middle_s, end_s - middle_s, count // 2, rho, alive,
        basis, used, alive.sum(axis=1).astype(np.float64), spread, constant, white, middle_bin,
    )  # fmt: skip


def _require_some(tracks: list[Track], epochs: Sequence[Epoch]) -> None:
    for word, count in (("tracks", len(tracks)), ("marks of known position", max(len(e.marks) for e in epochs))):
        if count == 0:
            raise TooFewPairs(f"no {word} in the window of {len(epochs)} scans", observations=0, unknowns=3)


def _reference(epochs: Sequence[Epoch]) -> str:
    """Return which bearings prevail in the window."""
    true = sum(t.bearing_reference == "true" for e in epochs for t in e.targets)
    return "true" if 2 * true > sum(len(e.targets) for e in epochs) else "relative"


def _variances(
    tracks: list[Track], rho: ComplexArray, alive: np.ndarray, model: WindowModel, radar: RadarModel
) -> tuple[FloatArray, FloatArray]:
    """Return the constant and the white variances (m, 2) of the tracks, radial and tangential [m^2].

    What a target's error is told to be, by its own sigmas or else those of the radar, may stay over the window.
    """
    range_m = np.abs(rho).sum(axis=1) / np.maximum(alive.sum(axis=1), 1)
    of_radar_m, of_radar_rad = radar.sigma_of_range_m(range_m), float(np.radians(radar.bearing_sigma_deg))
    told_m = np.array([track.range_sigma_m or sigma_m for track, sigma_m in zip(tracks, of_radar_m, strict=True)])
    told_rad = np.array([track.bearing_sigma_rad or of_radar_rad for track in tracks])
    constant_rad = np.maximum(np.radians(model.constant_deg), told_rad)
    constant = np.stack([np.maximum(model.constant_m, told_m), range_m * constant_rad], axis=1)
    white = np.stack([np.full(len(tracks), model.white_m), range_m * np.radians(model.white_deg)], axis=1)
    return constant**2, white**2


def _flat(
    origin: Position,
    rho: ComplexArray,
    constant: FloatArray,
    paths: MarkPaths,
    knot: int,
    reference: str,
    shared: AssociationModel,
) -> Scene:
    """Return the scene of one instant: what clutter density, conspicuity and searched area are taken from."""
    range_m = np.abs(rho)
    return Scene(
        origin=origin,
        rho=rho,
        range_m=range_m,
        bearing_rad=np.angle(rho),
        range_sigma_m=np.sqrt(constant[:, 0]),
        bearing_sigma_rad=np.sqrt(constant[:, 1]) / np.maximum(range_m, 1.0),
        z=paths.z[:, knot],
        mark_sigma_m=paths.constant_m,
        conspicuity=np.array([conspicuity(m, shared) for m in paths.marks]),
        target_speed_mps=np.full(len(rho), np.nan),
        mark_speed_mps=np.abs(paths.v[:, knot]),
        target_length_m=np.full(len(rho), np.nan),
        mark_length_m=np.full(len(paths.marks), np.nan),
        reference=reference,
        target_index=np.arange(len(rho)),
        mark_index=np.arange(len(paths.marks)),
    )
