"""The search on the globe: minima on a plane whose north is that of the best one, re-centred until it stands still."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix.adjustment import checks
from navfix.adjustment.network import TRUE_BEARING, Network
from navfix.adjustment.pairs import Pair
from navfix.adjustment.reliability import by_residual_sigma
from navfix.adjustment.start import Minimum, find_minima, follow, follow_given
from navfix.adjustment.trials import with_heading
from navfix.geodesy import LocalPlane, centroid
from navfix.kernels import Damping, Kernel, Standardisation
from navfix.types import FloatArray, Position
from navfix.units import wrap_360

_STANDS_STILL_M = 1e-3
_TURNED_DEG = 0.02  # convergence between search planes that is small beside any radar's bearing sigma
_PLANES = 12


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A plane, the network on it, and the minima there, the solution first."""

    plane: LocalPlane
    network: Network
    minima: list[Minimum]


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """How to look: the marks, the damping, and the pose to begin from.

    ``given`` is a position with a turn [deg] (heading or compass error) or None; with ``only_given`` the minimum
    reached from it is the solution, else it is one start among others.
    """

    pairs: Sequence[Pair]
    kernel: Kernel
    damping: Damping
    given: tuple[Position, float | None] | None
    only_given: bool
    standardise: Standardisation = "sigma"

    def minima(self, network: Network) -> Found:
        """Find the minima; directions in a plane are true only at its origin.

        The first origin is a given pose or the middle of the marks; where true bearings or a prior make north matter,
        the search moves to where it led until north stays.
        """
        lat, lon = self.coordinates()
        origin = centroid(lat, lon) if self.given is None else self.given[0]
        north_matters = network.prior_counts or bool(np.any((network.kind == TRUE_BEARING) & network.mask))
        for _ in range(_PLANES):
            plane = LocalPlane(origin)
            network = network.with_marks(plane.all_to_plane(lat, lon))
            minima = self._on_the_plane(network, plane)
            if self.standardise == "gdynia" and checks.determined(network, minima[0].pose, self.damping):
                network = by_residual_sigma(network, minima[0].pose, self.damping)
                minima = self._on_the_plane(network, plane)
            if not north_matters:
                break
            there, turned_deg = plane.place(*minima[0].pose[:2].tolist())
            if abs(turned_deg) < _TURNED_DEG:
                break
            origin = there
        return Found(plane, network, minima)

    def _on_the_plane(self, network: Network, plane: LocalPlane) -> list[Minimum]:
        if self.given is None:
            return find_minima(network, self.kernel, self.damping)
        position, turn_deg = self.given
        pose = with_heading(network, plane.to_plane(position)[None, :])[0]
        if turn_deg is not None and network.heading_unknown:
            pose[2] = math.radians(turn_deg - plane.convergence_deg(position))
        minima = find_minima(network, self.kernel, self.damping, given=(("association", pose),))
        if not self.only_given:
            return minima
        best = follow_given(network, self.kernel, self.damping, pose, minima)
        return [best, *(m for m in minima if not checks.same_place(network, m.pose, best.pose))]

    def stand_still(self, found: Found) -> Found:
        """Re-centre the plane on the solution until it stands still: then ranges and bearings are exact geodesics."""
        lat, lon = self.coordinates()
        plane, network, best = found.plane, found.network, found.minima[0]
        for _ in range(_PLANES):
            before = network.mark_ne_m - best.pose[:2]
            plane = LocalPlane(plane.to_position(float(best.pose[0]), float(best.pose[1])))
            network = network.with_marks(plane.all_to_plane(lat, lon))
            turn_rad = cmath.phase(complex(np.sum(_complex(network.mark_ne_m) * np.conj(_complex(before)))))
            start = np.array([0.0, 0.0, best.pose[2] + turn_rad * network.heading_unknown])
            best = replace(follow(network, self.kernel, self.damping, start, best.start), start=best.start)
            if math.hypot(best.pose[0], best.pose[1]) < _STANDS_STILL_M:
                break
        return Found(plane, network, [best])

    def coordinates(self) -> tuple[list[float], list[float]]:
        """Return latitudes and longitudes [deg] of the marks."""
        places = [pair.mark.position for pair in self.pairs]
        return [place.lat_deg for place in places], [place.lon_deg for place in places]


class Placer:
    """Turns a pose on a plane into a position and a true heading [deg], None where the turn is not a heading."""

    def __init__(self, plane: LocalPlane, *, heading: bool) -> None:
        self._plane, self._heading = plane, heading

    def __call__(self, pose: FloatArray) -> tuple[Position, float | None]:
        """Return the place of a pose (3,)."""
        north_m, east_m, turn_rad = pose.tolist()
        position, convergence_deg = self._plane.place(north_m, east_m)
        return position, wrap_360(math.degrees(turn_rad) + convergence_deg) if self._heading else None


def _complex(north_east: FloatArray) -> np.ndarray[tuple[int, ...], np.dtype[np.complex128]]:
    return north_east[:, 0] + 1j * north_east[:, 1]
