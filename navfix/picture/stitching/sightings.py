"""What is stitched: the sightings of a sequence of scans, in a plane that does not turn with own ship."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from navfix.catalog import StitchingModel
from navfix.picture.tracking.filter import blended, carried
from navfix.picture.tracking.rotation import LEAST_TRACKS, Yaw, weighted_median
from navfix.types import Epoch, FloatArray, IntArray
from navfix.units import wrap_180

_NOISE_SIGMA = 3.0


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """All sightings of a sequence, scan by scan: arrays (n,), ``number`` counts the labels from 0.

    ``scan`` never falls; within a scan each label stands once. ``relative`` tells which bearings turn with own ship.
    """

    scan: IntArray
    time_s: FloatArray
    number: IntArray
    range_m: FloatArray
    bearing_deg: FloatArray
    range_sigma_m: FloatArray
    bearing_sigma_deg: FloatArray
    relative: IntArray
    labels: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.time_s)

    def scans(self) -> list[IntArray]:
        """Return the indices of the sightings of each scan, in order."""
        cuts = np.flatnonzero(np.diff(self.scan)) + 1
        return [part for part in np.split(np.arange(len(self)), cuts) if len(part)]


def of_epochs(epochs: Sequence[Epoch], *, range_sigma_m: float, bearing_sigma_deg: float) -> Sightings:
    """Return the targets of epochs as sightings; the sigmas are for targets that bring none."""
    index: dict[tuple[str, int], int] = {}
    rows = []
    for scan, epoch in enumerate(epochs):
        twice: Counter[str] = Counter()
        for target in epoch.targets:
            time_utc = target.time_utc or epoch.time_utc
            number = index.setdefault((target.label, twice[target.label]), len(index))
            twice[target.label] += 1  # two radars may use one number in one scan: two targets
            rows.append(
                (
                    scan,
                    float(scan) if time_utc is None else time_utc.timestamp(),
                    number,
                    target.range_m,
                    target.bearing_deg,
                    target.range_sigma_m or range_sigma_m,
                    target.bearing_sigma_deg or bearing_sigma_deg,
                    target.bearing_reference == "relative",
                )
            )
    labels = tuple(label for label, _ in index)
    columns = np.array(rows, dtype=np.float64).reshape(-1, 8).T
    whole = [columns[i].astype(np.intp) for i in (0, 2, 7)]
    return Sightings(whole[0], columns[1], whole[1], columns[3], columns[4], columns[5], columns[6], whole[2], labels)


@dataclass(frozen=True, slots=True, eq=False)
class Tracked:
    """Sightings in the plane with what a filter makes of them, forward in time: arrays (n, ...).

    ``position`` (n, 2) [m], ``spread`` (n, 2, 2), ``mean`` (n, 4), ``covariance`` (n, 4, 4) after each sighting;
    ``segment`` (n,) numbers the pieces of the labels that are one motion each.
    """

    position: FloatArray
    spread: FloatArray
    mean: FloatArray
    covariance: FloatArray
    segment: IntArray


def follow(seen: Sightings, model: StitchingModel) -> Tracked:
    """Run the filter forward over every label; a new segment begins where the motion does not allow the sighting.

    That is after a gap of more than ``gap_s``, a jump of more than ``jump_m`` and the noise, or beyond ``jump_chi2`` of
    the prediction.
    """
    count, labels = len(seen), len(seen.labels)
    out = Tracked(
        np.zeros((count, 2)), np.zeros((count, 2, 2)), np.zeros((count, 4)), np.zeros((count, 4, 4)),
        np.full(count, -1, dtype=np.intp),
    )  # fmt: skip
    last = np.full(labels, -1, dtype=np.intp)
    segments, yaw = 0, Yaw()
    for rows in seen.scans():
        before = last[seen.number[rows]]
        known = before >= 0
        turned = _turn(seen, rows[known], before[known], out, yaw, model)
        _place(seen, rows, out, yaw, turned, model)
        mean, covariance = _start(out, rows, model)
        segment = np.full(len(rows), -1, dtype=np.intp)
        if known.any():
            old, new = before[known], rows[known]
            gap_s = seen.time_s[new] - seen.time_s[old]
            ahead = carried(out.mean[old], out.covariance[old], gap_s, model.relative_acceleration_mps2)
            goes_on = _goes_on(ahead, out, old, new, gap_s, model)
            better = blended(*ahead, out.position[new], out.spread[new])
            where = np.flatnonzero(known)[goes_on]
            mean[where], covariance[where] = better[0][goes_on], better[1][goes_on]
            segment[where] = out.segment[old][goes_on]
        fresh = np.flatnonzero(segment < 0)
        segment[fresh] = segments + np.arange(len(fresh))
        segments += len(fresh)
        out.mean[rows], out.covariance[rows], out.segment[rows] = mean, covariance, segment
        last[seen.number[rows]] = rows
    return out


def backward(
    seen: Sightings, tracked: Tracked, segment: IntArray, model: StitchingModel
) -> tuple[FloatArray, FloatArray]:
    """Return means (n, 4) and covariances (n, 4, 4) of a filter that runs backward in each segment."""
    mean, covariance = np.zeros_like(tracked.mean), np.zeros_like(tracked.covariance)
    last = np.full(int(segment.max(initial=-1)) + 1, -1, dtype=np.intp)
    for rows in reversed(seen.scans()):
        mean[rows], covariance[rows] = _start(tracked, rows, model)
        later = last[segment[rows]]
        new, old = rows[later >= 0], later[later >= 0]
        ahead = carried(
            mean[old], covariance[old], seen.time_s[new] - seen.time_s[old], model.relative_acceleration_mps2
        )
        mean[new], covariance[new] = blended(*ahead, tracked.position[new], tracked.spread[new])
        last[segment[rows]] = rows
    return mean, covariance


def _turn(
    seen: Sightings, new: IntArray, old: IntArray, tracked: Tracked, yaw: Yaw, model: StitchingModel
) -> bool:  # fmt: skip
    """Follow own ship's turn by the labels that go on; tell whether enough of them did."""
    relative = seen.relative[new] == 1
    new, old = new[relative], old[relative]
    if len(new) < LEAST_TRACKS:
        if len(new):
            yaw.correct(float(np.median(seen.time_s[new])), None)
        return False
    mean = tracked.mean[old]
    dt_s = (seen.time_s[new] - seen.time_s[old])[:, None]
    ahead = mean[:, :2] + dt_s * mean[:, 2:]
    ahead_deg = np.degrees(np.arctan2(ahead[:, 1], ahead[:, 0]))
    seen_deg = seen.bearing_deg[new] + np.array([yaw.at(float(t)) for t in seen.time_s[new]])
    change_deg = weighted_median(wrap_180(seen_deg - ahead_deg), seen.range_m[new])
    yaw.correct(float(np.median(seen.time_s[new])), -change_deg)
    return True


def _place(seen: Sightings, rows: IntArray, out: Tracked, yaw: Yaw, turned: bool, model: StitchingModel) -> None:
    """Put the sightings of a scan into the plane; where own ship's turn is not seen, bearings are less certain."""
    relative = seen.relative[rows] == 1
    angle = np.array([yaw.at(float(t)) for t in seen.time_s[rows]])
    bearing = np.radians(seen.bearing_deg[rows] + np.where(relative, angle, 0.0))
    unseen_deg = np.where(relative & (not turned), model.unseen_turn_deg, 0.0)
    across_m = seen.range_m[rows] * np.radians(np.hypot(seen.bearing_sigma_deg[rows], unseen_deg))
    sight = np.stack([np.cos(bearing), np.sin(bearing)], axis=-1)
    beam = np.stack([-np.sin(bearing), np.cos(bearing)], axis=-1)
    out.position[rows] = seen.range_m[rows][:, None] * sight
    out.spread[rows] = (
        seen.range_sigma_m[rows][:, None, None] ** 2 * sight[:, :, None] * sight[:, None, :]
        + across_m[:, None, None] ** 2 * beam[:, :, None] * beam[:, None, :]
    )


def _start(tracked: Tracked, rows: IntArray, model: StitchingModel) -> tuple[FloatArray, FloatArray]:
    mean, covariance = np.zeros((len(rows), 4)), np.zeros((len(rows), 4, 4))
    mean[:, :2], covariance[:, :2, :2] = tracked.position[rows], tracked.spread[rows]
    covariance[:, 2, 2] = covariance[:, 3, 3] = model.relative_speed_mps**2
    return mean, covariance


def _goes_on(
    ahead: tuple[FloatArray, FloatArray], tracked: Tracked, old: IntArray, new: IntArray, gap_s: FloatArray,
    model: StitchingModel,
) -> np.ndarray:  # fmt: skip
    miss = tracked.position[new] - ahead[0][:, :2]
    spread = ahead[1][:, :2, :2] + tracked.spread[new]
    chi2 = np.einsum("ni,ni->n", miss, np.linalg.solve(spread, miss[..., None])[..., 0])
    noise_m = np.sqrt(np.trace(tracked.spread[old] + tracked.spread[new], axis1=1, axis2=2))
    jump_m = np.hypot(*(tracked.position[new] - tracked.position[old]).T) - _NOISE_SIGMA * noise_m
    goes_on: np.ndarray = (gap_s <= model.gap_s) & (jump_m <= model.jump_m) & (chi2 <= model.jump_chi2)
    return goes_on
