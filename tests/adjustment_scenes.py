"""Seeded scenes for the adjustment: own ship in the origin of a plane, or anywhere on the globe."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.adjustment.network import RANGE, RELATIVE_BEARING, TRUE_BEARING, Network
from navfix.adjustment.whitening import normal_matrix, whitened
from navfix.geodesy import LocalPlane
from navfix.types import Association, Epoch, Mark, Position, RadarTarget

RANGE_SIGMA_M, BEARING_SIGMA_RAD, MARK_SIGMA_M = 30.0, math.radians(0.5), 10.0
GDYNIA_BAY = Position(54.5, 18.8)
Array = NDArray[np.float64]


@dataclass(frozen=True)
class Scene:
    """A network, its true pose (3,), and which marks are wrong."""

    network: Network
    truth: Array
    wrong: NDArray[np.int64]

    def bound(self) -> Array:
        """Return the Cramer-Rao bound (3, 3): the covariance when the wrong marks are known and left out."""
        _, a_white = whitened(self.network, self.truth)
        right = ~np.isin(self.network.mark, self.wrong)
        return np.linalg.inv(normal_matrix(self.network, a_white, right.astype(np.float64)))


def plane_scene(
    rng: np.random.Generator,
    *,
    marks: int = 20,
    wrong: int = 0,
    sector_deg: float = 360.0,
    mark_sigma_m: float = MARK_SIGMA_M,
    noise: float = 1.0,
    agreeing: bool = False,
) -> Scene:
    """Marks at 1 to 15 km within a sector, seen with range and relative bearing; wrong ones 200 to 3000 m off."""
    distance = np.exp(rng.uniform(math.log(1e3), math.log(15e3), marks))
    azimuth = math.radians(sector_deg) * rng.uniform(-0.5, 0.5, marks)
    heading = rng.uniform(-math.pi, math.pi)
    true = np.stack([distance * np.cos(azimuth), distance * np.sin(azimuth)], axis=1)
    given = true + noise * mark_sigma_m * rng.normal(size=(marks, 2))
    chosen = rng.permutation(marks)[:wrong]
    off, direction = rng.uniform(200.0, 3000.0, wrong), rng.uniform(0.0, 2.0 * math.pi, wrong)
    if agreeing and wrong:
        off, direction = np.full(wrong, off[0]), np.full(wrong, direction[0])
    given[chosen] += np.stack([off * np.cos(direction), off * np.sin(direction)], axis=1)
    sigma = np.tile([RANGE_SIGMA_M, BEARING_SIGMA_RAD], marks)
    seen = np.stack([distance, azimuth - heading], axis=1).ravel() + noise * sigma * rng.normal(size=2 * marks)
    kinds = np.tile([RANGE, RELATIVE_BEARING], marks)
    network = Network.build(kinds, np.repeat(np.arange(marks), 2), seen, sigma, given, mark_sigma_m=mark_sigma_m)
    return Scene(network, np.array([0.0, 0.0, heading]), chosen)


def mixed_network(rng: np.random.Generator, truth: Array, *, noise: float, full_covariance: bool) -> Network:
    """All three kinds of observations to eight marks, some marks seen three times, some once."""
    marks = rng.uniform(-8e3, 8e3, (8, 2))
    kinds = np.array([0, 1, 0, 1, 2, 0, 2, 0, 1, 1, 0, 2, 0, 1, 1])
    mark = np.array([0, 0, 1, 1, 1, 2, 2, 3, 3, 4, 5, 6, 7, 7, 6])
    sigma = np.where(kinds == RANGE, RANGE_SIGMA_M, BEARING_SIGMA_RAD)
    offset = marks[mark] - truth[:2]
    bearing = np.arctan2(offset[:, 1], offset[:, 0]) - np.where(kinds == TRUE_BEARING, 0.0, truth[2])
    exact = np.where(kinds == RANGE, np.hypot(offset[:, 0], offset[:, 1]), bearing)
    root = rng.normal(size=(8, 2, 2)) * 15.0
    return Network.build(
        kinds,
        mark,
        exact + noise * sigma * rng.normal(size=len(kinds)),
        sigma,
        marks,
        mark_covariance_m2=root @ np.swapaxes(root, 1, 2) if full_covariance else None,
        mark_sigma_m=12.0,
    )


def epoch_scene(
    rng: np.random.Generator,
    own: Position = GDYNIA_BAY,
    *,
    heading_deg: float = 123.4,
    marks: int = 20,
    wrong: int = 0,
    bearing_reference: str = "relative",
    noise: float = 1.0,
    sector_deg: float = 360.0,
) -> tuple[Epoch, Association]:
    """The same on the globe, with exact geodesics; the first ``wrong`` marks are wrong."""
    sigma_deg = math.degrees(BEARING_SIGMA_RAD)
    targets, places = [], []
    for index in range(marks):
        distance = math.exp(rng.uniform(math.log(1e3), math.log(15e3)))
        azimuth = sector_deg * rng.uniform(-0.5, 0.5)
        off = rng.uniform(200.0, 3000.0) if index < wrong else noise * MARK_SIGMA_M * math.hypot(*rng.normal(size=2))
        place = displaced(own, azimuth, distance, rng.uniform(0.0, 360.0), off)
        bearing = azimuth - (0.0 if bearing_reference == "true" else heading_deg)
        targets.append(
            RadarTarget(
                label=f"t{index}",
                range_m=distance + noise * RANGE_SIGMA_M * rng.normal(),
                bearing_deg=bearing + noise * sigma_deg * rng.normal(),
                bearing_reference=bearing_reference,  # type: ignore[arg-type]
                range_sigma_m=RANGE_SIGMA_M,
                bearing_sigma_deg=sigma_deg,
            )
        )
        places.append(Mark(f"m{index}", place, MARK_SIGMA_M))
    epoch = Epoch(None, tuple(targets), tuple(places))
    return epoch, Association.from_pairs(epoch, [(i, i) for i in range(marks)])


def displaced(own: Position, azimuth_deg: float, distance_m: float, direction_deg: float, off_m: float) -> Position:
    """Return what lies ``off_m`` beside the place at azimuth and distance, all directions as at own ship."""
    steps = ((distance_m, math.radians(azimuth_deg)), (off_m, math.radians(direction_deg)))
    north, east = (sum(length * turn(angle) for length, angle in steps) for turn in (math.cos, math.sin))
    return LocalPlane(own).to_position(north, east)
