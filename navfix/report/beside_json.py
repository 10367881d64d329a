"""What stands beside a fix, as JSON: GNSS, plain mean, dead reckoning, observed position, track, truth."""

from __future__ import annotations

from typing import Any

from navfix.geodesy import inverse
from navfix.report.answer import Truth
from navfix.report.json_parts import ELLIPSE_PROBABILITIES, ellipse_to_dict, position_to_dict
from navfix.report.numbers import iso_utc, plain, plain_matrix
from navfix.types import DeadReckoning, Fix, GnssVerdict, MeanFix, Position, TrackState


def gnss_to_dict(gnss: GnssVerdict | None) -> dict[str, Any] | None:
    """Return the verdict on the GNSS of the log, None where none was asked for."""
    if gnss is None:
        return None
    return {
        "position": position_to_dict(gnss.position),
        "distance_m": plain(gnss.distance_m),
        "verdict": gnss.verdict,
        "threshold_m": plain(gnss.threshold_m),
        "smallest_detectable_m": plain(gnss.smallest_detectable_m),
        "reasons": list(gnss.reasons),
        "instant_verdict": gnss.instant,
        "alert": gnss.alert,
        "drift_mps": plain(gnss.drift_mps),
    }


def plain_mean_to_dict(mean: MeanFix | None, fix: Fix | None) -> dict[str, Any] | None:
    """Return the plain-mean fix, its distance from the fix (None without one) and the 95 % ellipse of its spread."""
    if mean is None:
        return None
    ellipse = mean.ellipse()
    distance_m = inverse(fix.position, mean.position)[0] if fix and isinstance(fix.position, Position) else None
    return {
        "position": position_to_dict(mean.position),
        "distance_m": plain(distance_m),
        "ellipse": None if ellipse is None else ellipse_to_dict(ellipse),
        "heading_deg": plain(mean.heading_deg),
        "used": int(mean.used.sum()),
    }


def dead_reckoning_to_dict(reckoned: DeadReckoning | None) -> dict[str, Any] | None:
    """Return position, heading, 95 % ellipse, source, age and doubt of the dead reckoning; None before a fix."""
    if reckoned is None:
        return None
    return {
        "position": position_to_dict(reckoned.position),
        "heading_deg": plain(reckoned.heading_deg),
        "heading_sigma_deg": plain(reckoned.heading_sigma_deg),
        "covariance": plain_matrix(reckoned.covariance),
        "ellipse": ellipse_to_dict(reckoned.ellipse(ELLIPSE_PROBABILITIES[0])),
        "since_utc": iso_utc(reckoned.since_utc),
        "age_s": plain(reckoned.age_s),
        "source": reckoned.source,
        "probability_wrong": plain(reckoned.probability_wrong),
        "doubt": reckoned.doubt or None,
    }


def observed_to_dict(fix: Fix | None) -> dict[str, Any] | None:
    """Return the observed pose: where matching the radar picture with the marks put own ship, before the adjustment."""
    found = None if fix is None else fix.association
    if found is None or found.position is None:
        return None
    return {"position": position_to_dict(found.position), "heading_deg": plain(found.heading_deg)}


def track_to_dict(track: TrackState | None) -> dict[str, Any] | None:
    """Return what is known of the place that is held over time, None where scans are solved alone."""
    if track is None:
        return None
    return {
        "status": track.status,
        "probability_wrong": plain(track.probability_wrong),
        "evidence": plain(track.evidence),
        "score": plain(track.score),
        "ahead": plain(track.ahead),
        "since_s": plain(track.since_s),
        "source": track.source,
        "innovation": plain(track.innovation),
        "confirmed_age_s": plain(track.confirmed_age_s),
        "not_checked": list(track.not_checked),
    }


def truth_to_dict(truth: Truth | None) -> dict[str, Any] | None:
    """Return the errors of the fix against the truth, None without a truth."""
    if truth is None:
        return None
    return {
        "distance_m": plain(truth.error_m),
        "heading_error_deg": plain(truth.heading_error_deg),
        "in_ellipse": truth.in_ellipse,
        "position": position_to_dict(truth.position),
        "heading_deg": plain(truth.heading_deg),
    }
