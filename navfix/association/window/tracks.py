"""Step 1: the scans of a window -> tracks, freed of own ship's yaw.

All bearings of a scan turn together when own ship turns. The change that is common to all targets between two scans is
taken out, so that what is left of a track is nearly straight. A target number that is used again begins a new track.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from navfix.association.scene import ComplexArray
from navfix.association.window.yaw import Report, Yaw, common_yaw
from navfix.catalog import WindowModel, window_model
from navfix.types import Epoch, FloatArray, RadarTarget


@dataclass(frozen=True, eq=False)
class Track:
    """Reports (n,) of one target: times [POSIX s] and places in the de-rotated ship's frame [m, complex].

    ``newest`` is the index of the target among those of the window's last epoch, -1 where it is not there.
    """

    label: str
    time_s: FloatArray
    rho: ComplexArray
    range_sigma_m: float | None
    bearing_sigma_rad: float | None
    newest: int


_Placed = tuple[float, RadarTarget, complex]  # time [POSIX s], target, place in the de-rotated ship's frame [m]


def tracks_of(epochs: Sequence[Epoch], reference: str, model: WindowModel) -> tuple[list[Track], Yaw]:
    """Return the tracks of a window, longest first, and own ship's yaw that was taken out of them.

    Parameters
    ----------
    reference : bearings "relative" or "true" are used, not both; true bearings hold no yaw
    """
    scans = [_scan(epoch, reference) for epoch in epochs]
    times_s = np.array([epoch_time(epoch) for epoch in epochs])
    turns = common_yaw(scans, model) if reference == "relative" else np.zeros(len(scans))
    yaw = Yaw(times_s, turns)
    newest = {t.label: i for i, t in enumerate(epochs[-1].targets) if t.bearing_reference == reference}
    fewest = min(model.fewest_reports, len(scans))
    found = []
    for label, reports in sorted(_by_label(scans, turns).items()):
        parts = list(_pieces(reports, model))
        for number, part in enumerate(parts):
            live = label in newest and number == len(parts) - 1
            if len(part) >= fewest:
                found.append(_track(label, part, newest[label] if live else -1))
    return sorted(found, key=lambda track: -len(track.time_s)), yaw


def epoch_time(epoch: Epoch) -> float:
    """Return the instant of an epoch [POSIX s]; a window cannot be made of epochs without a time."""
    return 0.0 if epoch.time_utc is None else epoch.time_utc.timestamp()


def since_silence(epochs: Sequence[Epoch], model: WindowModel | str = "joint") -> tuple[Epoch, ...]:
    """Return the newest epochs of a window, from its last long silence of radar on; all of them where there is none.

    In a silence own ship may turn and change speed unseen: what came before and what came after are then no one motion,
    and the many scans of before would decide where she is after it.
    """
    constants = window_model(model)
    seen = [k for k, epoch in enumerate(epochs) if epoch.targets]
    apart_s = np.diff([epoch_time(epochs[k]) for k in seen])
    if not len(apart_s):
        return tuple(epochs)
    silent = np.flatnonzero(apart_s > max(constants.silence_s, constants.silent_turns * float(np.median(apart_s))))
    return tuple(epochs[seen[int(silent[-1]) + 1] :]) if len(silent) else tuple(epochs)


def _scan(epoch: Epoch, reference: str) -> dict[str, Report]:
    fallback_s = epoch_time(epoch)
    return {
        t.label: (fallback_s if t.time_utc is None else t.time_utc.timestamp(), t)
        for t in epoch.targets
        if t.bearing_reference == reference
    }


def _by_label(scans: Sequence[dict[str, Report]], turns: FloatArray) -> dict[str, list[_Placed]]:
    """Return the reports of every target number, placed in the de-rotated ship's frame."""
    reports = [report for scan in scans for report in scan.values()]
    turn = np.repeat(turns, [len(scan) for scan in scans])
    bearing_rad = np.radians([target.bearing_deg for _, target in reports]) + turn
    rho = np.array([target.range_m for _, target in reports]) * np.exp(1j * bearing_rad)
    found: dict[str, list[_Placed]] = {}
    for (time_s, target), place in zip(reports, rho.tolist(), strict=True):
        found.setdefault(target.label, []).append((time_s, target, place))
    return found


def _pieces(reports: list[_Placed], model: WindowModel) -> Iterator[list[_Placed]]:
    """Yield the pieces of one target number between reuses."""
    piece: list[_Placed] = []
    for time_s, target, rho in reports:
        if piece:
            since_s, jump_m = time_s - piece[-1][0], abs(rho - piece[-1][2])
            if since_s <= 0.0:
                continue  # the same report once more
            if since_s > model.gap_s or jump_m > model.jump_m:
                yield piece
                piece = []
        piece.append((time_s, target, rho))
    if piece:
        yield piece


def _track(label: str, piece: list[_Placed], newest: int) -> Track:
    last = piece[-1][1]
    return Track(
        label,
        np.array([time_s for time_s, _, _ in piece]),
        np.array([rho for _, _, rho in piece], dtype=np.complex128),
        last.range_sigma_m,
        None if last.bearing_sigma_deg is None else float(np.radians(last.bearing_sigma_deg)),
        newest,
    )
