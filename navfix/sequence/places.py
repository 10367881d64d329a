"""Places over time: a pose with its velocity, carried forward, as prior of a window or compared with another."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from navfix.adjustment.window import KnownPose
from navfix.association.scene import convergence_of
from navfix.association.window.joint import Window
from navfix.association.window.knots import PosePrior
from navfix.association.window.tracks import epoch_time
from navfix.catalog import NavigatorModel
from navfix.geodesy import LocalPlane, cloud_to_plane, ecef
from navfix.sequence.yaw import YawLog
from navfix.types import Epoch, FloatArray, Position
from navfix.units import wrap_180


@dataclass(frozen=True, eq=False)
class Place:
    """Own pose at an instant [POSIX s], with its velocity (north, east) [m/s] and covariance (3, 3) [m, m, rad].

    All data that it rests on are older than ``time_s``. ``yaw`` is the log of own ship's turning, where it is kept.
    ``turned_unseen``: own ship may have turned by anything since, for radar did not show it.
    """

    time_s: float
    position: Position
    heading_deg: float
    velocity_mps: complex
    covariance: FloatArray
    yaw: YawLog | None = None
    turned_unseen: bool = False

    def carried(self, to_s: float, model: NavigatorModel, unseen_s: float | None = None) -> Place:
        """Return the place carried to another instant by its velocity; what happens unseen makes it less sure.

        Own yaw is seen in the bearings of every scan: the heading follows the log of it, and ``unseen_s`` is the time
        without scans (default: all of it).
        """
        after_s = to_s - self.time_s
        unseen_s = after_s if unseen_s is None else unseen_s
        step = self.velocity_mps * after_s
        position = LocalPlane(self.position).to_position(step.real, step.imag)
        grown = np.diag([(model.gap_mps * after_s) ** 2] * 2 + [math.radians(model.gap_degps * unseen_s) ** 2])
        turned_deg = 0.0 if self.yaw is None else self.yaw.between_deg(self.time_s, to_s)
        heading_deg = (self.heading_deg + turned_deg) % 360.0
        missed = self.yaw is not None and self.yaw.missed(self.time_s, to_s)
        return replace(
            self,
            time_s=to_s,
            position=position,
            heading_deg=heading_deg,
            covariance=self.covariance + grown,
            turned_unseen=self.turned_unseen or missed,
        )

    def velocity_turned(self, to_s: float) -> complex:
        """Return the velocity (north, east) [m/s] turned as own ship was seen to turn until an instant [POSIX s]."""
        turned_deg = 0.0 if self.yaw is None else self.yaw.between_deg(self.time_s, to_s)
        return self.velocity_mps * cmath.rect(1.0, math.radians(turned_deg))

    def distance_m(self, other: Place) -> float:
        """Return how far another place of the same instant lies [m]."""
        return math.dist(self._point, other._point)

    def turn_deg(self, other: Place) -> float:
        """Return how far the heading of another place of the same instant lies [deg], >= 0."""
        return abs(wrap_180(other.heading_deg - self.heading_deg))

    def differs(self, other: Place, apart_m: float, apart_deg: float) -> bool:
        """Tell whether another place of the same instant is another answer: elsewhere, or turned.

        What turned unseen may lie any way round and be the same.
        """
        unknown = self.turned_unseen or other.turned_unseen
        return self.distance_m(other) > apart_m or (not unknown and self.turn_deg(other) > apart_deg)

    def misfit_sq(self, other: Place, model: NavigatorModel, swept_m: float = 0.0) -> float:
        """Return how far another place of now lies, squared, in sigmas of both, this one widened as a prior is.

        ``swept_m`` is how far a turn since may have led from the straight way.
        """
        offset = LocalPlane(self.position).to_plane(other.position)
        widened = model.prior_factor**2 * self.covariance[:2, :2] + (model.prior_m**2 + swept_m**2) * np.eye(2)
        return float(offset @ np.linalg.solve(widened + other.covariance[:2, :2], offset))

    @cached_property
    def _point(self) -> tuple[float, ...]:
        """Earth-centred coordinates [m]: a chord is 0.1 m short at 40 km, and quick."""
        return tuple(ecef(self.position.lat_deg, self.position.lon_deg).tolist())

    @property
    def sigma_m(self) -> float:
        """1 sigma along the worst direction [m]."""
        return float(math.sqrt(np.linalg.eigvalsh(self.covariance[:2, :2])[-1]))


def as_prior(places: Sequence[Place], window: Window, model: NavigatorModel) -> PosePrior:
    """Return places as priors of a window that uses none of their data: carried to its first knot and widened."""
    scene = window.field.scene
    knot_s = scene.middle_s + float(scene.knot_s[0])
    first_s = float(scene.yaw.time_s[0])
    carried = [place.carried(knot_s, model, max(0.0, first_s - place.time_s)) for place in places]
    origin = scene.flat.origin
    plane = cloud_to_plane(origin, [p.position.lat_deg for p in carried], [p.position.lon_deg for p in carried])
    widened = np.diag([model.prior_m**2, model.prior_m**2, math.radians(model.prior_deg) ** 2])
    # A heading holds at the place's own instant; the tracks are de-rotated to the first scan, which may be later.
    turns = np.array([scene.yaw.at(place.time_s) - _turned_before(place, first_s) for place in places])
    p = plane[:, 0] + 1j * plane[:, 1]
    return PosePrior(
        0,
        p,
        np.radians([place.heading_deg for place in places]) - turns - convergence_of(scene.flat, p),
        np.array([model.prior_factor**2 * p.covariance + widened for p in carried]),
    )


def _turned_before(place: Place, first_s: float) -> float:
    """Return how far own ship has turned [rad] from a place to the first scan of a window that begins after it."""
    if place.yaw is None or place.time_s >= first_s:
        return 0.0
    return math.radians(place.yaw.between_deg(place.time_s, first_s))


def as_known_pose(place: Place, epoch: Epoch, model: NavigatorModel) -> KnownPose:
    """Return a place as what is known of the first epoch of a window that uses none of its data, widened as above."""
    first_s = epoch_time(epoch)
    there = place.carried(first_s, model, max(0.0, first_s - place.time_s))
    widened = np.diag([model.prior_m**2, model.prior_m**2, math.radians(model.prior_deg) ** 2])
    return KnownPose(there.position, there.heading_deg, model.prior_factor**2 * there.covariance + widened)
