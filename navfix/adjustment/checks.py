"""Has a network a solution? Enough observations, no free direction, no contradiction, no rival: else it is told why."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from navfix.adjustment.dense import Linear, linearise
from navfix.adjustment.minimal import on_danger_circle
from navfix.adjustment.network import Network
from navfix.adjustment.sights import prior_residual
from navfix.adjustment.start import Minimum, on_a_mark, separation
from navfix.adjustment.whitening import normal_matrix, whitened
from navfix.errors import Ambiguous, NoAgreement, TooFewPairs, Unobservable
from navfix.kernels import Damping, Kernel
from navfix.types import Alternative, FloatArray, PlanePosition, Position, confidence_radius
from navfix.units import wrap_360, wrap_pi

Place = Callable[[FloatArray], tuple[Position | PlanePosition, float | None]]
DECISIVE = math.log(1000.0)
_HOPELESS_SHARE = 0.5  # a sigma of more than half the distance to the marks: the linear picture means nothing


def check_solution(
    network: Network,
    kernel: Kernel,
    damping: Damping,
    minima: list[Minimum],
    *,
    place: Place | None = None,
    rivals: bool = True,
) -> None:
    """Raise what `solve.solve` raises where the first of the minima is no solution."""
    if on_a_mark(network, minima[0].pose):
        raise Unobservable(
            "the way ends on a mark, and from there its bearing means nothing", direction="not determined"
        )
    if rivals and network.redundancy == 0:
        _check_exact(network, kernel, damping, minima, place or on_the_plane)
    linear = linearise(network, kernel, damping, minima[0].pose)
    check_rank(network, linear.pose, linear.a_white, network.mask.astype(np.float64))
    _check_agreement(network, linear, minima[0])
    if rivals:
        _check_rivals(network, kernel, damping, minima, linear, place or on_the_plane)


def check_counts(network: Network) -> None:
    """Raise `TooFewPairs` where there are fewer observations (the heading prior counts) than unknowns."""
    if network.redundancy < 0:
        message = f"{network.observations} observations cannot determine {network.unknowns} unknowns"
        raise TooFewPairs(message, observations=network.observations, unknowns=network.unknowns)


def check_rank(network: Network, pose: FloatArray, a_white: FloatArray, weights: FloatArray) -> None:
    """Raise `Unobservable` where ``weights`` (m,) leave a direction free, exactly or for any practical purpose.

    ``a_white`` (m, 3): the Jacobian at the pose in units of sigma.

    The heading is compared as the shift it causes at the marks' median distance; a direction counts as free when its
    sigma is more than half that distance (more than 29 deg in heading): linear error propagation says nothing then.
    """
    u, reach_m = network.unknowns, _median_distance(network, pose)
    scale = np.array([1.0, 1.0, 1.0 / reach_m])[:u]
    matrix = normal_matrix(network, a_white, weights)[:u, :u] * scale[:, None] * scale[None, :]
    values, vectors = np.linalg.eigh(matrix)
    if values[0] * (_HOPELESS_SHARE * reach_m) ** 2 < 1.0 or values[0] < 1e-12 * values[-1]:
        direction = vectors[:, 0] * scale
        direction = direction / np.linalg.norm(direction)
        why = ": own ship and the marks lie on one circle" if on_danger_circle(network, pose) else ""
        message = f"the geometry leaves {_in_words(vectors[:, 0])} free{why}"
        raise Unobservable(message, direction=tuple(direction.tolist()))


def determined(network: Network, pose: FloatArray, damping: Damping) -> bool:
    """Tell whether all observations together leave no direction free (see `check_rank`)."""
    try:
        check_rank(network, pose, whitened(network, pose, damping)[1], network.mask.astype(np.float64))
    except Unobservable:
        return False
    return True


def _median_distance(network: Network, pose: FloatArray) -> float:
    marks = network.mark_ne_m[np.unique(network.mark[network.mask])]
    return max(float(np.median(np.hypot(*(marks - pose[:2]).T))), 1.0)


def _in_words(vector: FloatArray) -> str:
    if len(vector) == 3 and abs(vector[2]) > 0.9:
        return "the heading"
    azimuth_deg = math.degrees(math.atan2(vector[1], vector[0])) % 180.0
    turning = " together with the heading" if len(vector) == 3 and abs(vector[2]) > 0.1 else ""
    return f"the position along {azimuth_deg:.0f}°{turning}"


def _check_agreement(network: Network, linear: Linear, best: Minimum) -> None:
    effective = float(linear.weights.sum()) + float(network.prior_counts)
    if effective < network.unknowns - 1e-9:
        raise NoAgreement(
            f"the observations contradict each other: after damping {effective:.1f} of {network.observations} are left "
            f"for {network.unknowns} unknowns",
            evidence=-best.loss,
        )
    check_rank(network, linear.pose, linear.a_white, linear.weights)


def same_place(network: Network, pose: FloatArray, other: FloatArray) -> bool:
    """Tell whether two minima are one place (see `find_minima`)."""
    apart_m, apart_rad = separation(network, pose)
    near = math.hypot(*(pose[:2] - other[:2])) <= apart_m
    return near and (not network.heading_unknown or abs(float(wrap_pi(pose[2] - other[2]))) <= apart_rad)


def decisive_gap(kernel: Kernel, damping: Damping) -> float:
    """Return the difference of losses that decides between two places: ln 1000, or half of what one target can cost.

    The loss is minus the logarithm of a likelihood: ln 1000 is a thousand to one. A kernel that levels off low (Tukey)
    cannot give one target that much; there half a target's worth must do.
    """
    return min(DECISIVE, 0.5 * kernel.bound(damping))


def _check_rivals(
    network: Network, kernel: Kernel, damping: Damping, minima: list[Minimum], linear: Linear, place: Place
) -> None:
    """Raise `Ambiguous` where another minimum has nearly the same loss and lies outside the best one's 99.9 % ellipse.

    Where the residuals are larger than their sigmas say, the gap is measured with the larger ones.
    """
    best, weights = minima[0], linear.weights
    dof = float(weights.sum()) + float(network.prior_counts) - network.unknowns
    squared = float(weights @ linear.v_white**2) + float(prior_residual(network, best.pose)) ** 2
    inflation = max(1.0, squared / dof) if dof >= 3.0 else 1.0
    matrix = linear.normal_matrix(network) / inflation
    rivals = [m for m in minima[1:] if (m.loss - best.loss) / inflation < decisive_gap(kernel, damping)]
    if any(_distance_sq(matrix, m.pose - best.pose) > confidence_radius(0.999) ** 2 for m in rivals):
        alternatives = [alternative(m, place) for m in minima]
        apart_m = max(math.hypot(*(m.pose[:2] - best.pose[:2])) for m in rivals)
        raise Ambiguous(
            f"{len(rivals) + 1} places explain the data about equally well, up to {apart_m:.0f} m apart",
            alternatives=alternatives,
        )


def _check_exact(network: Network, kernel: Kernel, damping: Damping, minima: list[Minimum], place: Place) -> None:
    """Raise `Ambiguous` where just enough observations fit in more than one place: nothing is left to choose by."""
    alike = [m for m in minima if m.loss - minima[0].loss < decisive_gap(kernel, damping)]
    if len(alike) > 1 and any(determined(network, m.pose, damping) for m in alike):
        apart_m = max(math.hypot(*(m.pose[:2] - alike[0].pose[:2])) for m in alike)
        raise Ambiguous(
            f"no redundancy, and {len(alike)} places fit the observations alike, up to {apart_m:.0f} m apart",
            alternatives=[alternative(m, place) for m in minima],
        )


def _distance_sq(matrix: FloatArray, offset: FloatArray) -> float:
    turned = np.append(offset[:2], wrap_pi(offset[2]))[: len(matrix)]
    return float(turned @ matrix @ turned)


def on_the_plane(pose: FloatArray) -> tuple[PlanePosition, float]:
    """Return a pose as a plane position and a heading [deg]."""
    return PlanePosition(float(pose[0]), float(pose[1])), float(wrap_360(math.degrees(pose[2])))


def alternative(minimum: Minimum, place: Place = on_the_plane) -> Alternative:
    """Return a minimum as a record; its score is minus its loss."""
    position, heading_deg = place(minimum.pose)
    return Alternative(position, heading_deg, -minimum.loss, minimum.targets)
