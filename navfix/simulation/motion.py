"""How things move: straight, through one turn, yawing, at anchor. Closed forms, so any time can be asked."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from navfix.types import FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where something is at given times, in the plane of the stage; every array has the shape of the times.

    Directions are plane directions: `Stage.convergence_rad` turns them into true ones.
    """

    north_m: FloatArray
    east_m: FloatArray
    north_mps: FloatArray
    east_mps: FloatArray
    heading_rad: FloatArray
    turn_rate_rad_s: FloatArray

    @property
    def speed_mps(self) -> FloatArray:
        return np.hypot(self.north_mps, self.east_mps)

    @property
    def course_rad(self) -> FloatArray:
        return np.arctan2(self.east_mps, self.north_mps)

    def offset(self, forward_m: float, starboard_m: float) -> tuple[FloatArray, FloatArray]:
        """Return (north, east) [m] of a point given in the ship's axes."""
        cos, sin = np.cos(self.heading_rad), np.sin(self.heading_rad)
        return self.north_m + cos * forward_m - sin * starboard_m, self.east_m + sin * forward_m + cos * starboard_m


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion by closed formulas: constant speed, course with one turn, heading with leeway and yaw.

    With ``swing_radius_m`` > 0 the place is an anchor, the hull's centre lies ``swing_radius_m`` astern of it, and
    the yaw is the swinging about the anchor (then ``speed_mps`` is 0).
    """

    north_m: float
    east_m: float
    course_rad: float = 0.0
    speed_mps: float = 0.0
    turn_at_s: float = 0.0
    turn_rate_rad_s: float = 0.0
    turn_time_s: float = 0.0
    drift_rad: float = 0.0
    yaw_rad: float = 0.0
    yaw_period_s: float = 60.0
    yaw_phase_rad: float = 0.0
    swing_radius_m: float = 0.0

    def at(self, time_s: ArrayLike) -> Pose:
        """Return the pose at times [s] counted from the start of the scenario."""
        t = np.asarray(time_s, dtype=np.float64)
        since_turn = t - self.turn_at_s
        turning_s = np.clip(since_turn, 0.0, self.turn_time_s)
        course = self.course_rad + self.turn_rate_rad_s * turning_s
        run_north, run_east = self._run(t, turning_s, course)
        omega = 2.0 * math.pi / self.yaw_period_s
        phase = omega * t + self.yaw_phase_rad
        heading = course + self.drift_rad + self.yaw_rad * np.sin(phase)
        yaw_rate = self.yaw_rad * omega * np.cos(phase)
        in_turn = (since_turn >= 0.0) & (since_turn < self.turn_time_s)
        return Pose(
            north_m=self.north_m + run_north - self.swing_radius_m * np.cos(heading),
            east_m=self.east_m + run_east - self.swing_radius_m * np.sin(heading),
            north_mps=self.speed_mps * np.cos(course) + self.swing_radius_m * yaw_rate * np.sin(heading),
            east_mps=self.speed_mps * np.sin(course) - self.swing_radius_m * yaw_rate * np.cos(heading),
            heading_rad=heading,
            turn_rate_rad_s=self.turn_rate_rad_s * in_turn + yaw_rate,
        )

    def _run(self, t: FloatArray, turning_s: FloatArray, course: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what was run since time 0 [m]: straight, an arc, straight again."""
        start, rate, speed = self.course_rad, self.turn_rate_rad_s, self.speed_mps
        if rate == 0.0 or self.turn_time_s == 0.0:
            return speed * t * math.cos(start), speed * t * math.sin(start)
        before = speed * np.minimum(t, self.turn_at_s)
        after = speed * np.maximum(t - self.turn_at_s - self.turn_time_s, 0.0)
        radius = speed / rate
        north = before * math.cos(start) + radius * (np.sin(course) - math.sin(start)) + after * np.cos(course)
        east = before * math.sin(start) - radius * (np.cos(course) - math.cos(start)) + after * np.sin(course)
        return north, east
