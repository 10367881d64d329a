"""The fix as JSON, schema ``navfix.fix/1``: the same keys for a fix and for no fix, null where nothing can be said."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from navfix.errors import Ambiguous, NoAgreement, NoFix
from navfix.report.answer import Answer
from navfix.report.beside_json import (
    dead_reckoning_to_dict,
    gnss_to_dict,
    observed_to_dict,
    plain_mean_to_dict,
    track_to_dict,
    truth_to_dict,
)
from navfix.report.data_used import chart_to_dict, choice_to_dict
from navfix.report.json_parts import ELLIPSE_PROBABILITIES, ellipse_to_dict, position_to_dict
from navfix.report.numbers import iso_utc, plain, plain_matrix
from navfix.report.radar_errors import radar_errors_to_dict
from navfix.types import (
    AdjustedObservation,
    Alternative,
    Association,
    Epoch,
    Fix,
    GlobalTest,
    Integrity,
)

SCHEMA = "navfix.fix/1"
STEPS = ("epoch", "associate", "adjust")

_FIX_KEYS = (
    "position", "heading_deg", "heading_reference", "covariance", "cofactor_matrix", "covariance_scaling", "ellipses",
    "sigma0", "redundancy", "kernel", "damping", "standardise", "global_test", "observations", "pairs",
    "unmatched_targets", "unmatched_marks",
    "ambiguity", "integrity", "compass_error_deg", "compass_error_sigma_deg",
)  # fmt: skip


def answer_to_dict(answer: Answer) -> dict[str, Any]:
    """Return the object ``navfix.fix/1`` of an answer: plain numbers, strings, lists and None only.

    Beyond the keys of every fix it carries ``truth`` (null without a truth file), ``targets`` and ``marks`` (how many
    the epoch holds), ``chart`` (null without one), ``choice`` (which data are used and why), ``notes``,
    ``radar_errors`` (null where nobody looked), and two positions apart from the adjusted one: ``dead_reckoning`` by
    the fixes before, ``observed`` by matching the radar picture with the marks.
    """
    body = no_fix_to_dict(answer.error) if answer.fix is None else fix_to_dict(answer.fix)
    return body | {
        "time_utc": iso_utc(answer.time_utc),
        "gnss": gnss_to_dict(answer.gnss),
        "plain_mean": plain_mean_to_dict(answer.plain_mean, answer.fix),
        "timing_ms": {step: plain(answer.timing_ms.get(step), 6) for step in (*STEPS, *answer.timing_ms)},
        "truth": truth_to_dict(answer.truth),
        "dead_reckoning": dead_reckoning_to_dict(answer.dead_reckoning),
        "observed": observed_to_dict(answer.fix),
        "track": track_to_dict(answer.track),
        "radar_errors": radar_errors_to_dict(answer.radar_errors),
        "targets": None if answer.epoch is None else len(answer.epoch.targets),
        "marks": None if answer.epoch is None else len(answer.epoch.marks),
        "chart": None if answer.epoch is None else chart_to_dict(answer.epoch.chart),
        "choice": None if answer.epoch is None else choice_to_dict(answer.epoch.choice),
        "notes": list(dict.fromkeys((*body["notes"], *answer.cautions, *answer.notes))),
    }


def fix_to_dict(fix: Fix) -> dict[str, Any]:
    """Return the object ``navfix.fix/1`` of a fix alone; what stands beside a fix (GNSS, plain mean, times) is null.

    The position is ``{"north_m", "east_m"}`` for a fix in a plane frame.
    """
    used = len({(o.target, o.mark) for o in fix.observations})
    epoch, association = fix.epoch, fix.association
    own = f"fix from {len(fix.observations)} observations of {used} pairs"
    return _head("fix", None, own if used else "fix carried by other scans: no pair of this one") | {
        "time_utc": None if epoch is None else iso_utc(epoch.time_utc),
        "position": position_to_dict(fix.position),
        "heading_deg": plain(fix.heading_deg),
        "heading_reference": None if fix.heading_deg is None else fix.heading_reference,
        "covariance": plain_matrix(fix.covariance),
        "cofactor_matrix": plain_matrix(fix.cofactor_matrix),
        "covariance_scaling": fix.covariance_scaling,
        "ellipses": [ellipse_to_dict(fix.ellipse(probability)) for probability in ELLIPSE_PROBABILITIES],
        "sigma0": plain(fix.sigma0),
        "redundancy": int(fix.redundancy),
        "kernel": fix.kernel,
        "damping": fix.damping,
        "standardise": fix.standardise,
        "global_test": global_test_to_dict(fix.global_test),
        "observations": [observation_to_dict(observation) for observation in fix.observations],
        **_pairing(epoch, association),
        "ambiguity": ambiguity_to_dict(association, fix.alternatives),
        "integrity": integrity_to_dict(fix.integrity),
        "compass_error_deg": plain(fix.compass_error_deg),
        "compass_error_sigma_deg": plain(fix.compass_error_sigma_deg),
        "notes": [*(() if association is None else association.notes), *fix.notes],
    }


def no_fix_to_dict(error: NoFix | None) -> dict[str, Any]:
    """Return the same keys as `fix_to_dict` with the reason, and null where nothing can be said."""
    reason, message = ("no_fix", "") if error is None else (error.reason, str(error))
    return (
        _head("no_fix", reason, message) | dict.fromkeys(_FIX_KEYS) | {"ambiguity": _ambiguity_of(error), "notes": []}
    )


def _head(status: str, reason: str | None, message: str) -> dict[str, Any]:
    return (
        {"schema": SCHEMA, "status": status, "reason": reason, "message": message, "time_utc": None}
        | dict.fromkeys((*_FIX_KEYS, "gnss", "plain_mean"))
        | {"timing_ms": dict.fromkeys(STEPS)}
    )


def observation_to_dict(observation: AdjustedObservation) -> dict[str, Any]:
    """Return one adjusted observation with its unit."""
    return {
        "target": observation.target,
        "mark": observation.mark,
        "kind": observation.kind,
        "unit": observation.unit,
        "observed": plain(observation.observed, 12),
        "adjusted": plain(observation.adjusted, 12),
        "residual": plain(observation.residual),
        "sigma": plain(observation.sigma),
        "standardized": plain(observation.standardized),
        "redundancy_number": plain(observation.redundancy_number),
        "weight": plain(observation.weight),
        "mdb": plain(observation.mdb),
        "external_m": plain(observation.external_m),
    }


def global_test_to_dict(test: GlobalTest | None) -> dict[str, Any] | None:
    """Return the chi-square test of the whole, None without one."""
    if test is None:
        return None
    return {
        "statistic": plain(test.statistic),
        "dof": plain(test.dof),
        "threshold": plain(test.threshold),
        "passed": bool(test.passed),
    }


def integrity_to_dict(integrity: Integrity | None) -> dict[str, Any] | None:
    """Return R95 and the protection level with its probabilities, None without them."""
    if integrity is None:
        return None
    return {
        "r95_m": plain(integrity.r95_m),
        "protection_level_m": plain(integrity.protection_level_m),
        "probability_of_false_alarm": plain(integrity.probability_of_false_alarm),
        "probability_of_missed_detection": plain(integrity.probability_of_missed_detection),
        "slope_level_m": plain(integrity.slope_level_m),
        "reason": integrity.reason or None,
    }


def _pairing(epoch: Epoch | None, association: Association | None) -> dict[str, Any]:
    """Return pairs, unmatched targets (labels) and the number of unmatched marks; None without an association."""
    if epoch is None or association is None:
        return {"pairs": None, "unmatched_targets": None, "unmatched_marks": None}
    matched = {int(target) for target in association.pairs[:, 0]}
    return {
        "pairs": [
            {
                "target": epoch.targets[target].label,
                "mark": epoch.marks[mark].label,
                "probability": plain(float(probability), 6),
            }
            for (target, mark), probability in zip(association.pairs, association.probability, strict=True)
        ],
        "unmatched_targets": [target.label for i, target in enumerate(epoch.targets) if i not in matched],
        "unmatched_marks": len(epoch.marks) - len(association.pairs),
    }


def ambiguity_to_dict(association: Association | None, alternatives: Sequence[Alternative] = ()) -> dict[str, Any]:
    """Return evidence, margin, probability of another place, and the other places of association and adjustment."""
    if association is None:
        return _ambiguity(None, None, None, alternatives)
    second = association.second_group
    content = _ambiguity(
        association.evidence,
        association.margin,
        association.probability_wrong,
        (*association.alternatives, *(a for a in alternatives if a not in association.alternatives)),
    )
    if second is not None:
        content["second_group"] = {
            "offset_m": plain(second.offset_m),
            "azimuth_deg": plain(second.azimuth_deg),
            "targets": list(second.targets),
        }
    return content


def _ambiguity_of(error: NoFix | None) -> dict[str, Any] | None:
    if isinstance(error, NoAgreement):
        return _ambiguity(error.evidence, None, None, error.alternatives)
    if isinstance(error, Ambiguous):
        return _ambiguity(None, None, None, error.alternatives)
    return None


def _ambiguity(
    evidence: float | None, margin: float | None, wrong: float | None, alternatives: Sequence[Alternative]
) -> dict[str, Any]:
    return {
        "evidence": plain(evidence, 6),
        "margin": plain(margin, 6),
        "probability_wrong": plain(wrong, 6),
        "alternatives": [
            {
                "position": position_to_dict(other.position),
                "heading_deg": plain(other.heading_deg),
                "score": plain(other.score, 6),
                "pairs": other.pairs or None,
            }
            for other in alternatives
        ],
        "second_group": None,
    }
