"""A window of epochs with their pairs to one fix at the newest instant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from navfix import catalog
from navfix.adjustment.graph import available
from navfix.adjustment.graph import window as window_graph
from navfix.adjustment.solve import Solver
from navfix.adjustment.window.checks import check, check_rank
from navfix.adjustment.window.components import Judged, with_components
from navfix.adjustment.window.descent import COARSE, DENSE_BELOW, ROUGH, Damper, Descended, descend
from navfix.adjustment.window.prior import KnownPose
from navfix.adjustment.window.problem import Sighting, WindowNetwork
from navfix.adjustment.window.reading import Pairs, replaced, sightings_of, times_of, window_of
from navfix.adjustment.window.record import fix_of
from navfix.adjustment.window.rows import COMPONENTS, Plan
from navfix.adjustment.window.start import Pose, first_pose, initial_state, plane_pose, poses_from
from navfix.catalog import AdjustmentModel, RadarModel, radar_model
from navfix.errors import InputError
from navfix.geodesy import LocalPlane
from navfix.kernels import Damping, Kernel
from navfix.types import Epoch, Fix, FloatArray
from navfix.units import wrap_pi

Start = Pose | Sequence[Pose]
_CENTRED_M = 100.0  # an origin as near as this to the newest pose leaves millimetres
_CENTRINGS = 5
_AGREE = 1e-4  # sigma: how well the two roads must agree


@dataclass(frozen=True, slots=True, eq=False)
class Solved:
    """A window where it was solved: ``found`` with the whole state, ``cofactor`` (3, 3) of the newest pose.

    ``sightings`` are those that the pairs named, ``solver`` the road that stands: "gtsam" or "dense".
    """

    sightings: Sequence[Sighting]
    window: WindowNetwork
    found: Judged
    cofactor: FloatArray
    solver: str

    @property
    def state(self) -> FloatArray:
        return self.found.descended.state


def adjust_window(
    epochs: Sequence[Epoch],
    pairs: Pairs,
    *,
    start: Start | None = None,
    radar: RadarModel | str = "imo",
    kernel: Kernel | str = "hampel",
    damping: Damping = "joint",
    model: AdjustmentModel | str = "window",
    compass_sigma_deg: float | None = None,
    prior: KnownPose | None = None,
    solver: Solver = "auto",
) -> Fix:
    """Adjust own ship's position and heading at the newest of several epochs from all of them together.

    Unknowns are the poses of all epochs, the radar's clock offset, its range bias, the error of the compass where
    bearings are true, the current (drift of the log), the offset of each mark that stays (AIS antenna, hull) and the
    range and bearing errors that stay with each track. What stays is thus not counted as new in every scan. Own motion
    between the epochs is that of log and gyro (``speed_hint``, differences of ``heading_hint``: a gyro's constant error
    cancels), else what a ship can do.

    Parameters
    ----------
    epochs : in the order of time, each with its time
    pairs : {target label: mark label} for the whole window, or an association of the newest epoch, or one of these for
        each epoch. A label may be absent from an epoch; after a pause, or with another mark, it is another track
    start : pose (position, heading [deg]) at the newest epoch, or one for each epoch; default: a single epoch's fix
    radar : sigma of one range [m] and one bearing [deg], by name or as a model; a target's own sigma overrides it
    kernel : damping function; acts on each sighting, and on the errors that stay with each mark
    damping : "joint" (range and bearing of a sighting together) or "separate"
    model : constants, by name in models/adjustment or as a record
    compass_sigma_deg : of the error common to all true bearings; default the radar model's
    prior : pose at the first epoch as data from before the window have it; a factor of the network, eq. (10.6a)
    solver : "gtsam", "dense" (own normal equations), or "auto": GTSAM where it is installed

    Returns
    -------
    Fix - its epoch is the newest; covariance (3, 3) in north [m], east [m], heading [rad] at that instant, scaled by
    the sigma0 of the errors that stay; one row for range and bearing of each track, the mean over the window;
    ``notes`` say what else was estimated

    Raises
    ------
    InputError : epochs without time or out of order, sets of pairs or starts that do not match them
    NoFix : TooFewPairs, Unobservable, NoAgreement, Ambiguous (the single epoch that gives the start)

    References
    ----------
    Theory 10, eq. (10.1) to (10.10).
    """
    radar, kernel = radar_model(radar), catalog.kernel(kernel)
    solved = solve_window(
        epochs, pairs, start=start, radar=radar, kernel=kernel, damping=damping, model=model,
        compass_sigma_deg=compass_sigma_deg, prior=prior, solver=solver,
    )  # fmt: skip
    return fix_of(epochs, solved.sightings, solved.window, solved.found, solved.cofactor, kernel, solved.solver)


def solve_window(
    epochs: Sequence[Epoch],
    pairs: Pairs,
    *,
    start: Start | None,
    radar: RadarModel,
    kernel: Kernel,
    damping: Damping = "joint",
    model: AdjustmentModel | str = "window",
    compass_sigma_deg: float | None = None,
    prior: KnownPose | None = None,
    solver: Solver = "auto",
) -> Solved:
    """Solve as `adjust_window` does and return everything: the smoother takes the poses of all epochs from it."""
    times_of(epochs)
    sightings = sightings_of(epochs, pairs)
    anchor, given = _given(epochs, sightings, start, radar, kernel)
    window = window_of(
        epochs, sightings, LocalPlane(given[anchor][0]), radar=radar, model=catalog.adjustment_model(model),
        compass_sigma_deg=radar.compass_sigma_deg if compass_sigma_deg is None else compass_sigma_deg, prior=prior,
    )  # fmt: skip
    poses = _start_poses(window, anchor, given)
    for _ in range(_CENTRINGS):
        plan = Plan.of(window)
        damper, descended = _robust(plan, kernel, damping, initial_state(window, plan.layout, poses))
        poses = plan.layout.poses(descended.state).copy()
        if float(np.hypot(*poses[-1, :2])) < _CENTRED_M:
            break
        window, poses = _centred(window, epochs, sightings, poses)
    check(damper, descended)
    found = with_components(damper, descended)
    check(found.damper, found.descended)
    found, cofactor, road = _finished(window, found, solver)
    return Solved(sightings, window, found, cofactor, road)


def _given(
    epochs: Sequence[Epoch], sightings: Sequence[Sighting], start: Start | None, radar: RadarModel, kernel: Kernel
) -> tuple[int, dict[int, Pose]]:
    """Return the epoch that anchors the start, and the poses that are known beforehand by epoch."""
    if start is None:
        anchor, pose = first_pose(epochs, sightings, radar, kernel)
        return anchor, {anchor: pose}
    newest = len(epochs) - 1
    if isinstance(start, tuple) and len(start) == 2 and not isinstance(start[0], tuple):
        return newest, {newest: start}
    if len(start) != len(epochs):
        raise InputError(f"start must be one pose or one for each of {len(epochs)} epochs, got {len(start)}")
    return newest, dict(enumerate(start))


def _start_poses(window: WindowNetwork, anchor: int, given: dict[int, Pose]) -> FloatArray:
    if len(given) == window.epochs and window.epochs > 1:
        poses = np.array([plane_pose(window.plane, given[e]) for e in range(window.epochs)])
    else:
        poses = poses_from(window, anchor, plane_pose(window.plane, given[anchor]))
    poses[:, 2] = np.unwrap(poses[:, 2])
    return poses


def _centred(
    window: WindowNetwork, epochs: Sequence[Epoch], sightings: Sequence[Sighting], poses: FloatArray
) -> tuple[WindowNetwork, FloatArray]:
    """Return the window and the poses on a plane about the newest pose."""
    places = [window.plane.to_position(float(p[0]), float(p[1])) for p in poses]
    turns = [window.plane.convergence_deg(place) for place in (places[0], places[-1])]
    plane = LocalPlane(places[-1])
    turn_rad = math.radians(turns[-1])
    ne_m = plane.all_to_plane([p.lat_deg for p in places], [p.lon_deg for p in places])
    return replaced(window, epochs, sightings, plane), np.column_stack([ne_m, poses[:, 2] + turn_rad])


def _robust(plan: Plan, kernel: Kernel, damping: Damping, state: FloatArray) -> tuple[Damper, Descended]:
    """Descend with Huber's kernel, then with the wanted one; leave out marks whose constant error it has given up."""
    everything = np.ones(plan.layout.marks, bool)
    huber = Damper(plan, catalog.kernel("huber"), damping, np.ones(COMPONENTS), everything)
    descended = descend(huber, state, tolerance=ROUGH)
    damper = replace(huber, kernel=kernel)
    descended = descend(damper, descended.state, tolerance=COARSE)
    state = descended.state
    keep = descended.weights.static >= plan.window.model.least_static_weight
    if not np.all(keep) and np.any(keep):
        damper = replace(damper, taking_part=keep)
        state = state.copy()
        out = ~keep[plan.layout.static_mark(plan.window)]
        state[plan.layout.shared + 5 :][out] = 0.0
    return damper, descend(damper, state, tolerance=COARSE)


def _finished(window: WindowNetwork, found: Judged, solver: Solver) -> tuple[Judged, FloatArray, str]:
    """Solve once more as a factor graph and check that it is the same place; else our own road stands."""
    layout, state = found.damper.plan.layout, found.descended.state
    newest = layout.newest()
    own = found.cofactor[newest, newest]
    check_rank(window, state[newest], own)
    if solver == "dense" or (solver == "auto" and (not available() or layout.size > DENSE_BELOW)):
        return found, own, "dense"
    graph, there = window_graph.solve(found.damper, state)
    off = there[newest] - state[newest]
    off[2] = wrap_pi(off[2])
    if float(off @ np.linalg.solve(own, off)) > _AGREE**2:
        return found, own, "dense"
    return replace(found, descended=found.damper.at(there)), graph.cofactor, "gtsam"
