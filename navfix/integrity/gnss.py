"""The verdict on own GNSS: compared with the fix, which never used it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.integrity.area_shift import area_shift
from navfix.integrity.noncentral import noncentrality, squared_radius
from navfix.types import Fix, FloatArray, GnssReport, GnssVerdict, Position, Verdict

PROBABILITY_OF_FALSE_ALARM = 1e-3
PROBABILITY_OF_MISSED_DETECTION = 1e-3
CAUTION_PROBABILITY = 0.05  # a difference that only this share of good receivers would show deserves a look
ONE_INSTANT = "not checked: a slow drift below these limits; this is one instant"


def gnss_verdict(
    fix: Fix,
    gnss: GnssReport,
    *,
    probability_of_false_alarm: float = PROBABILITY_OF_FALSE_ALARM,
    probability_of_missed_detection: float = PROBABILITY_OF_MISSED_DETECTION,
    alert_limit_m: float | None = None,
) -> GnssVerdict:
    """Compare the GNSS position with the fix and say what follows, with reasons in words.

    The squared difference in units of its covariance (fix and GNSS together) is chi-square with 2 degrees of freedom
    when both are right; where the fix's covariance was scaled by its own sigma0, half of it is F with (2, dof), which
    is taken for the whole and so on the careful side.

    Parameters
    ----------
    alert_limit_m : an offset that must not stay unseen; "not_available" where the comparison cannot see it

    Returns
    -------
    GnssVerdict - ``threshold_m`` along the direction of the difference; ``smallest_detectable_m`` is the offset that is
    noticed with 1 - ``probability_of_missed_detection`` whatever its direction (inf where none is). The verdicts:

    - "unsafe": a good receiver shows such a difference only with ``probability_of_false_alarm``
    - "caution": only 5 % of good receivers do; or the fix itself is doubtful
    - "not_available": too little redundancy checks the fix, or ``alert_limit_m`` cannot be guarded
    - "ok": none of these

    Raises
    ------
    InputError : a probability outside 0 .. 1, a fix in a plane without a place on earth, a GNSS sigma that is not > 0
    """
    _check(gnss, probability_of_false_alarm, probability_of_missed_detection)
    comparison = _compare(fix, gnss)
    threshold = squared_radius(probability_of_false_alarm, comparison.dof)
    threshold_m = comparison.metres(threshold)
    needed = noncentrality(threshold, comparison.dof, probability_of_missed_detection)
    smallest_m = math.sqrt(needed) * comparison.worst_sigma_m
    beyond_threshold = comparison.squared > threshold
    beyond_caution = comparison.squared > squared_radius(CAUTION_PROBABILITY, comparison.dof)

    area = area_shift(
        fix,
        probability_of_false_alarm=probability_of_false_alarm,
        probability_of_missed_detection=probability_of_missed_detection,
    )
    doubts = (*_doubts(fix), *filter(None, (area.doubt,)))
    verdict, why = _decide(fix, beyond_threshold, beyond_caution, doubts, smallest_m, alert_limit_m)
    measured = (
        f"GNSS lies {comparison.distance_m:.0f} m from the fix towards {comparison.azimuth_deg:03.0f}°; up to "
        f"{threshold_m:.0f} m are explained there by both sigmas (false alarm {probability_of_false_alarm:g})"
    )
    seen = (
        f"an offset of {smallest_m:.0f} m in any direction would be noticed with probability "
        f"{1.0 - probability_of_missed_detection:g}"
        if math.isfinite(smallest_m)
        else f"too few redundant observations ({comparison.dof or 0.0:.1f}) to say which offset would be noticed"
    )
    return GnssVerdict(
        position=gnss.position,
        distance_m=comparison.distance_m,
        verdict=verdict,
        threshold_m=threshold_m,
        smallest_detectable_m=smallest_m,
        reasons=(measured, seen, *why, *doubts, area.said, ONE_INSTANT),
    )


# -------------------------------------------------------------------------------------------------- the comparison


@dataclass(frozen=True, slots=True)
class _Comparison:
    """The difference GNSS - fix: its length and azimuth, its square in units of its covariance."""

    distance_m: float
    azimuth_deg: float
    squared: float
    sigma_along_m: float
    worst_sigma_m: float
    dof: float | None

    def metres(self, squared: float) -> float:
        """Return the length along the difference at which its square reaches ``squared``."""
        return math.sqrt(squared) * self.sigma_along_m


def difference(fix: Fix, gnss: GnssReport) -> tuple[FloatArray, FloatArray]:
    """Return GNSS - fix [m], (2,) in north and east, and the covariance of both together (2, 2).

    Raises
    ------
    InputError : a fix in a plane without a place on earth
    """
    if not isinstance(fix.position, Position):
        raise InputError("a fix in a plane frame cannot be compared with GNSS: it has no place on earth")
    covariance: FloatArray = fix.covariance[:2, :2] + gnss.sigma_m**2 * np.eye(2)
    return LocalPlane(fix.position).to_plane(gnss.position), covariance


def _compare(fix: Fix, gnss: GnssReport) -> _Comparison:
    difference_ne_m, covariance = difference(fix, gnss)
    variances, directions = np.linalg.eigh(covariance)
    distance_m = float(np.hypot(*difference_ne_m))
    along = difference_ne_m / distance_m if distance_m > 0.0 else directions[:, 1]
    per_metre_squared = float(along @ np.linalg.solve(covariance, along))
    return _Comparison(
        distance_m=distance_m,
        azimuth_deg=math.degrees(math.atan2(along[1], along[0])) % 360.0,
        squared=distance_m**2 * per_metre_squared,
        sigma_along_m=1.0 / math.sqrt(per_metre_squared),
        worst_sigma_m=math.sqrt(float(variances[1])),
        dof=fix.dof if fix.covariance_scaling == "a_posteriori" and fix.dof > 0.0 else None,
    )


# ----------------------------------------------------------------------------------------- what follows, in words


def _decide(
    fix: Fix,
    beyond_threshold: bool,
    beyond_caution: bool,
    doubts: tuple[str, ...],
    smallest_m: float,
    limit_m: float | None,
) -> tuple[Verdict, tuple[str, ...]]:
    if fix.redundancy <= 0:
        why = "no redundant observation checks the fix: a wrong pair would stay unseen"
        return ("caution" if beyond_threshold else "not_available"), (why,)
    if beyond_threshold:
        return "unsafe", ("the difference is larger than the threshold",)
    if not math.isfinite(smallest_m):
        return "not_available", ("no offset would surely be noticed",)
    if limit_m is not None and smallest_m > limit_m:
        return "not_available", (f"the alert limit of {limit_m:.0f} m cannot be guarded",)
    if beyond_caution:
        return "caution", (f"only {CAUTION_PROBABILITY:.0%} of good receivers would show such a difference",)
    return ("caution" if doubts else "ok"), ()


def _doubts(fix: Fix) -> tuple[str, ...]:
    """Return what speaks against the fix itself.

    Residuals larger than their sigmas are no doubt where the covariance was scaled by them.
    """
    doubts = []
    unscaled = fix.covariance_scaling == "a_priori"
    if unscaled and fix.global_test is not None and not fix.global_test.passed:
        doubts.append("doubt: the residuals of the fix are larger than their sigmas allow (global test)")
    group = fix.association.second_group if fix.association is not None else None
    if group is not None:
        doubts.append(
            f"doubt: {len(group.targets)} targets agree on another place, {group.offset_m:.0f} m towards "
            f"{group.azimuth_deg:03.0f}°; some AIS positions may be shifted alike"
        )
    return tuple(doubts)


def _check(gnss: GnssReport, false_alarm: float, missed: float) -> None:
    for name, value in (("probability_of_false_alarm", false_alarm), ("probability_of_missed_detection", missed)):
        if not 0.0 < value < 1.0:
            raise InputError(f"{name} must be within 0 .. 1, got {value!r}")
    if false_alarm + missed >= 1.0:
        raise InputError(f"false alarm and missed detection must together stay below 1, got {false_alarm} and {missed}")
    if not (math.isfinite(gnss.sigma_m) and gnss.sigma_m > 0.0):
        raise InputError(f"GNSS: sigma_m must be > 0, got {gnss.sigma_m!r}")
