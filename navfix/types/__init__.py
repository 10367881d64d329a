"""The frozen records: what goes in (targets, marks, epoch), what is found (association), what comes out (fix)."""

from navfix.types.adjusted import (
    AdjustedObservation,
    CovarianceScaling,
    Ellipse,
    Fix,
    GlobalTest,
    HeadingReference,
    Integrity,
    MeanFix,
    ObservationKind,
    confidence_radius,
)
from navfix.types.checks import FloatArray, IntArray
from navfix.types.found import Alternative, Association, SecondGroup
from navfix.types.observed import (
    BearingReference,
    Epoch,
    GnssReport,
    HeadingHint,
    Mark,
    MarkKind,
    PositionHint,
    RadarTarget,
    SpeedHint,
)
from navfix.types.places import Hull, PlanePosition, Position
from navfix.types.track import TrackState, TrackStatus
from navfix.types.verdicts import GnssVerdict, ShipVeracity, VeracityStatus, Verdict

__all__ = [
    "AdjustedObservation",
    "Alternative",
    "Association",
    "BearingReference",
    "CovarianceScaling",
    "Ellipse",
    "Epoch",
    "Fix",
    "FloatArray",
    "GlobalTest",
    "GnssReport",
    "GnssVerdict",
    "HeadingHint",
    "HeadingReference",
    "Hull",
    "IntArray",
    "Integrity",
    "Mark",
    "MarkKind",
    "MeanFix",
    "ObservationKind",
    "PlanePosition",
    "Position",
    "PositionHint",
    "RadarTarget",
    "SecondGroup",
    "ShipVeracity",
    "SpeedHint",
    "TrackState",
    "TrackStatus",
    "VeracityStatus",
    "Verdict",
    "confidence_radius",
]
