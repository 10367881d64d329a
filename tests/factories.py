"""Records made by hand for tests: a plausible epoch, its fix, and answers of every sort (seeded, no solver)."""

from __future__ import annotations

import math
from datetime import UTC, datetime

import numpy as np

from navfix.errors import Ambiguous, NoAgreement, NoFix, TooFewPairs, Unobservable
from navfix.geodesy import direct, inverse
from navfix.report import Answer, Truth
from navfix.types import (
    AdjustedObservation,
    Alternative,
    Association,
    Epoch,
    Fix,
    GlobalTest,
    GnssVerdict,
    Hull,
    Integrity,
    Mark,
    MeanFix,
    PlanePosition,
    Position,
    RadarTarget,
    SecondGroup,
)
from navfix.units import wrap_180, wrap_360

TIME = datetime(2026, 3, 4, 5, 6, 7, 250000, tzinfo=UTC)
OSLO = Position(59.4021, 10.5873)
DATE_LINE = Position(-17.9, 179.999)
HEADING_DEG = 123.4
RANGE_SIGMA_M, BEARING_SIGMA_DEG, MARK_SIGMA_M = 20.0, 0.5, 8.0

_NAMES = (
    "FAIRPLAY 3", "STENA SAGA", "COLOR FANTASY", "BASTO VI", "NORDIC QUEEN", "RS ELIAS KULUKUNDIS", "VIKING ENERGY",
    "SEA & SUN <II>", "TORBAS", "HAVILA CASTOR", "KYSTVAKT BISON", "FJORD LADY", "BOW CARDINAL", "EIDE TUG", "ORCA",
)  # fmt: skip


def make_mark(index: int, position: Position, kind: str, rng: np.random.Generator) -> Mark:
    """Return one mark: most are ships under way, some lie at anchor without a heading."""
    if kind == "ship":
        moving = rng.random() < 0.7
        return Mark(
            label=str(257000100 + index),
            position=position,
            sigma_m=MARK_SIGMA_M,
            kind="ship",
            mmsi=257000100 + index,
            name=_NAMES[index % len(_NAMES)] if index % 7 else None,
            speed_mps=float(rng.uniform(2.0, 9.0)) if moving else 0.0,
            course_deg=float(rng.uniform(0.0, 360.0)) if moving else None,
            heading_deg=float(rng.uniform(0.0, 360.0)) if moving and index % 2 else None,
            hull=Hull(80.0, 20.0, 8.0, 8.0) if index % 3 else None,
            time_utc=TIME,
        )
    if kind == "aton":
        return Mark(f"aton {index}", position, 5.0, "aton", mmsi=992570100 + index, name=f"BUOY {index}")
    return Mark(f"chart:{index}", position, 2.0, "charted", name=f"LIGHT {index}")


def make_epoch(
    origin: Position = OSLO,
    heading_deg: float = HEADING_DEG,
    *,
    targets: int = 20,
    marks: int = 60,
    unmatched: int = 3,
    wrong: tuple[int, ...] = (4,),
    seed: int = 7,
    reach_m: float = 9000.0,
) -> Epoch:
    """Return an epoch seen from ``origin``: target i shows mark i, except the last ``unmatched`` targets.

    The marks of the targets ``wrong`` say a position 640 m off, along 045 deg.
    """
    rng = np.random.default_rng(seed)
    kinds = ["ship" if i % 5 or i == 0 else ("aton" if i % 2 else "charted") for i in range(marks)]
    seen = targets - unmatched
    where = [
        (float(rng.uniform(0.0, 360.0)), reach_m * math.sqrt(rng.uniform(0.02, 1.0)) * (1.0 if i < targets else 1.6))
        for i in range(max(marks, targets))
    ]
    true_places = [direct(origin, azimuth, distance) for azimuth, distance in where]
    told = [
        direct(place, 45.0, 640.0)
        if i in wrong
        else direct(place, rng.uniform(0, 360), MARK_SIGMA_M * abs(rng.normal()))
        for i, place in enumerate(true_places)
    ]
    radar = tuple(
        RadarTarget(
            label=f"{i + 1:02d}",
            range_m=max(50.0, distance + RANGE_SIGMA_M * rng.normal()),
            bearing_deg=wrap_360(azimuth - heading_deg + BEARING_SIGMA_DEG * rng.normal()),
            time_utc=TIME,
        )
        for i, (azimuth, distance) in enumerate(where[:seen] + [(w[0] + 77.0, w[1]) for w in where[seen:targets]])
    )
    return Epoch(TIME, radar, tuple(make_mark(i, told[i], kinds[i], rng) for i in range(marks)))


def observations_of(
    epoch: Epoch, association: Association, position: Position, heading_deg: float
) -> list[AdjustedObservation]:
    """Return the ranges and bearings of the pairs after an adjustment that ended at this pose."""
    found = []
    for target_index, mark_index in association.pairs:
        target, mark = epoch.targets[target_index], epoch.marks[mark_index]
        distance_m, azimuth_deg = inverse(position, mark.position)
        bearing_deg = azimuth_deg if target.bearing_reference == "true" else wrap_360(azimuth_deg - heading_deg)
        range_sigma_m = math.hypot(RANGE_SIGMA_M, mark.sigma_m)
        bearing_sigma_deg = math.hypot(BEARING_SIGMA_DEG, math.degrees(mark.sigma_m / distance_m))
        kind = "true_bearing" if target.bearing_reference == "true" else "relative_bearing"
        for name, observed, adjusted, residual, sigma in (
            ("range", target.range_m, distance_m, distance_m - target.range_m, range_sigma_m),
            (kind, target.bearing_deg, bearing_deg, wrap_180(bearing_deg - target.bearing_deg), bearing_sigma_deg),
        ):
            redundancy_number = 0.91
            standardized = residual / (sigma * math.sqrt(redundancy_number))
            weight = (
                1.0
                if abs(standardized) < 2.0
                else max(0.0, 2.0 / abs(standardized) if abs(standardized) < 4.0 else 0.0)
            )
            found.append(
                AdjustedObservation(
                    target.label, mark.label, name, observed, adjusted, residual, sigma, standardized,
                    redundancy_number, weight, 4.13 * sigma / math.sqrt(redundancy_number),
                )
            )  # fmt: skip
    return found


def make_association(epoch: Epoch, seen: int, position: Position, heading_deg: float) -> Association:
    """Return the association target i = mark i of the first ``seen`` targets."""
    return Association(
        pairs=np.column_stack([np.arange(seen), np.arange(seen)]),
        probability=np.linspace(0.999, 0.9, seen),
        position=position,
        heading_deg=heading_deg,
        covariance=np.diag([80.0, 90.0, 4e-6]),
        evidence=41.7,
        margin=15.8,
        probability_wrong=2e-6,
        method="seeds + cpd",
    )


def make_fix(
    epoch: Epoch | None = None, position: Position = OSLO, heading_deg: float = HEADING_DEG, *, unmatched: int = 3
) -> Fix:
    """Return the fix of an epoch of `make_epoch`, some metres off the truth."""
    epoch = make_epoch(position, heading_deg) if epoch is None else epoch
    estimate, estimated_deg = direct(position, 210.0, 4.0), wrap_360(heading_deg + 0.06)
    association = make_association(epoch, len(epoch.targets) - unmatched, estimate, estimated_deg)
    observations = tuple(observations_of(epoch, association, estimate, estimated_deg))
    cofactors = np.array([[60.0, 22.0, 1e-3], [22.0, 38.0, -2e-3], [1e-3, -2e-3, 3.9e-6]])
    return Fix(
        position=estimate,
        heading_deg=estimated_deg,
        covariance=1.04**2 * cofactors,
        sigma0=1.04,
        redundancy=len(observations) - 3,
        observations=observations,
        association=association,
        epoch=epoch,
        cofactor_matrix=cofactors,
        covariance_scaling="a_posteriori",
        dof=27.4,
        kernel="hampel",
        global_test=GlobalTest(29.7, 27.4, 40.6, True),
        integrity=Integrity(18.3, 61.0, 1e-5, 1e-3),
    )


def make_answer(position: Position = OSLO, heading_deg: float = HEADING_DEG, **changes: object) -> Answer:
    """Return the answer of an epoch with everything in it: fix, plain mean, GNSS verdict, truth, timing."""
    fix = make_fix(make_epoch(position, heading_deg), position, heading_deg)
    mean_place = direct(position, 50.0, 143.0)
    individual = np.random.default_rng(3).normal(0.0, 60.0, (17, 2))
    mean = MeanFix(mean_place, heading_deg + 0.4, individual, np.arange(17) != 4, np.cov(individual.T), np.ones(17))
    gnss = GnssVerdict(
        direct(position, 300.0, 1480.0), 1481.2, "unsafe", 61.0, 38.0, ("GNSS lies outside the protection level",)
    )
    content = {
        "epoch": fix.epoch, "fix": fix, "plain_mean": mean, "gnss": gnss,
        "timing_ms": {"epoch": 3.21, "associate": 41.0, "adjust": 6.5},
        "truth": Truth(position, heading_deg, 4.0, 0.06), "notes": ("1 target older than 2 s was left out",),
    } | changes  # fmt: skip
    return Answer(**content)  # type: ignore[arg-type]


def make_alternatives(count: int, position: Position = OSLO) -> tuple[Alternative, ...]:
    """Return places that explain the data nearly alike, best first."""
    return tuple(
        Alternative(direct(position, 40.0 * i, 900.0 * i), (40.0 * i) % 360.0, 12.5 - 0.3 * i, 6) for i in range(count)
    )


def make_no_fix(error: NoFix | None = None, **changes: object) -> Answer:
    """Return an answer without a fix (default: 14 places fit)."""
    error = error or Ambiguous("14 places explain the data nearly as well", alternatives=make_alternatives(14))
    return Answer(**({"epoch": make_epoch(), "error": error} | changes))  # type: ignore[arg-type]


def every_no_fix() -> dict[str, Answer]:
    """Return one answer for every reason without a fix, and one without any epoch."""
    return {
        "ambiguous": make_no_fix(),
        "no_agreement": make_no_fix(
            NoAgreement("nothing fits better than chance", evidence=1.2, alternatives=make_alternatives(2))
        ),
        "too_few_pairs": make_no_fix(TooFewPairs("2 targets, 3 are needed", observations=2, unknowns=3)),
        "unobservable": make_no_fix(Unobservable("all marks lie in one point", direction=(0.6, 0.8, 0.0))),
        "no_epoch": Answer(epoch=None, error=TooFewPairs("no targets", observations=0, unknowns=3)),
    }


def every_fix() -> dict[str, Answer]:
    """Return fixes with everything, with the optional parts missing, and in odd places."""
    full = make_fix()
    bare = Fix(
        full.position,
        full.heading_deg,
        full.covariance,
        1.0,
        3,
        full.observations[:6],
        None,
        None,
        full.cofactor_matrix,
        "a_priori",
        math.inf,
        "none",
    )
    crowd = make_epoch(targets=120, marks=300, unmatched=20, wrong=(4, 17, 60))
    return {
        "full": make_answer(),
        "bare": Answer(epoch=None, fix=bare),
        "with_alternatives": Answer(epoch=full.epoch, fix=with_alternatives(full)),
        "without_marks": make_answer(gnss=None, plain_mean=None, truth=None, timing_ms={}, notes=()),
        "date_line": make_answer(DATE_LINE),
        "arctic": make_answer(Position(89.999, 12.0)),
        "crowd": Answer(epoch=crowd, fix=make_fix(crowd, unmatched=20)),
    }


def with_alternatives(fix: Fix) -> Fix:
    """Return the fix with two other places and a second group in its association."""
    old = fix.association
    assert old is not None
    association = Association(
        old.pairs,
        old.probability,
        old.position,
        old.heading_deg,
        old.covariance,
        21.0,
        9.1,
        0.0017,
        make_alternatives(2),
        SecondGroup(820.0, 45.0, ("02", "05", "09")),
    )
    return Fix(
        fix.position,
        fix.heading_deg,
        fix.covariance,
        fix.sigma0,
        fix.redundancy,
        fix.observations,
        association,
        fix.epoch,
        fix.cofactor_matrix,
        fix.covariance_scaling,
        fix.dof,
        fix.kernel,
    )


def make_plane_fix() -> Fix:
    """Return the adjustment of a case in a plane frame: ranges only, no heading, covariance (2, 2)."""
    observations = tuple(
        AdjustedObservation(
            "",
            f"P{i}",
            "range",
            100.0 * i,
            100.0 * i + 0.2,
            0.2,
            0.5,
            None if i == 1 else 0.6,
            0.0 if i == 1 else 0.5,
            1.0,
            None,
        )
        for i in (1, 2, 3)
    )
    cofactors = np.array([[0.2, 0.05], [0.05, 0.1]])
    return Fix(
        PlanePosition(1234.5678, -88.25),
        None,
        cofactors,
        1.0,
        1,
        observations,
        None,
        None,
        cofactors,
        "a_priori",
        1.0,
        "none",
        alternatives=(Alternative(PlanePosition(900.0, 10.0), None, -3.0),),
    )
