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
from navfix.types.charted import ChartCheck, Decision, Filter, MethodChoice, OffStation
from navfix.types.checks import FloatArray, IntArray
from navfix.types.found import Alternative, Association, SecondGroup
from navfix.types.fused import Pairing, Sensor, TargetList, TrackedShip
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
    TargetPoint,
)
from navfix.types.places import Hull, PlanePosition, Position
from navfix.types.radar_errors import CommonError, RadarErrors
from navfix.types.reckoned import DeadReckoning, ReckoningSource
from navfix.types.track import TrackState, TrackStatus
from navfix.types.verdicts import GnssVerdict, ShipVeracity, VeracityStatus, Verdict

__all__ = [
    "AdjustedObservation",
    "Alternative",
    "Association",
    "BearingReference",
    "ChartCheck",
    "CommonError",
    "CovarianceScaling",
    "DeadReckoning",
    "Decision",
    "Ellipse",
    "Epoch",
    "Filter",
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
    "MethodChoice",
    "ObservationKind",
    "OffStation",
    "Pairing",
    "PlanePosition",
    "Position",
    "PositionHint",
    "RadarErrors",
    "RadarTarget",
    "ReckoningSource",
    "SecondGroup",
    "Sensor",
    "ShipVeracity",
    "SpeedHint",
    "TargetList",
    "TargetPoint",
    "TrackState",
    "TrackStatus",
    "TrackedShip",
    "VeracityStatus",
    "Verdict",
    "confidence_radius",
]
