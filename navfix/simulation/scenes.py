"""Seeded scenes of one instant, for the association: targets and marks, true pose and pairs, predicted evidence.

A scene needs no sentences: it is what a perfect picture of one radar turn would hold. Layouts: uniform traffic,
anchorages, lanes, a buoyed channel. Echoes without AIS (clutter), AIS positions that are false one by one or shifted
alike, and noise that is larger than the model says, can be mixed in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from navfix.geodesy import LocalPlane, convergence
from navfix.simulation.layouts import Crowding, in_disc, lay_out
from navfix.types import Epoch, FloatArray, Hull, IntArray, Mark, Position, RadarTarget
from navfix.units import NM_M


@dataclass(frozen=True, slots=True)
class SceneRecipe:
    """How a scene is made.

    ``targets`` echoes in the radar disc of ``radar_nm``, of which the share ``clutter`` belongs to no mark; ``marks``
    AIS stations in the disc of ``ais_nm``, of which the share ``false_ais`` is elsewhere than it says (by 200 .. 3000 m
    one by one; with ``coherent_m`` > 0 all by that one vector). Sigmas are 1 sigma; range sigma is the larger of metres
    and fraction. The noise drawn is ``noise_misfit`` times what the scene states; every mark is ``mark_offset_m`` off
    in a direction of its own. With ``lengths`` every mark is a ship of known length and the radar tells how long its
    echoes are.
    """

    targets: int
    marks: int
    radar_nm: float = 12.0
    ais_nm: float = 24.0
    clutter: float = 0.0
    false_ais: float = 0.0
    coherent_m: float = 0.0
    layout: str = "uniform"
    range_sigma_m: float = 30.0
    range_sigma_fraction: float = 0.01
    bearing_sigma_deg: float = 0.5
    mark_sigma_m: float = 10.0
    noise_misfit: float = 1.0
    range_bias_m: float = 0.0
    mark_offset_m: float = 0.0
    lengths: bool = False
    centre: Position = Position(54.2, 7.6)  # noqa: RUF009 (a frozen record)


@dataclass(frozen=True, eq=False)
class MadeScene:
    """A scene with its truth: pairs (k, 2) target and mark index of right matches (false AIS are none)."""

    epoch: Epoch
    position: Position
    heading_deg: float
    pairs: IntArray
    crlb: FloatArray | None
    predicted_evidence: float
    predicted_if_uniform: float


def make_scene(recipe: SceneRecipe, seed: int | np.random.Generator) -> MadeScene:
    """Make one scene; the same seed gives the same scene."""
    random = np.random.default_rng(seed)
    radar_m, ais_m = recipe.radar_nm * NM_M, recipe.ais_nm * NM_M
    heading_rad = random.uniform(0.0, 2.0 * math.pi)
    own = in_disc(random, 1, max(ais_m - radar_m, 0.0) + 1.0)[0]
    truth, crowding = lay_out(random, recipe.layout, recipe.marks, ais_m)
    stated, false = _state_positions(random, recipe, truth)
    visible = np.flatnonzero(np.abs(truth - own) < 0.98 * radar_m)
    wanted = min(recipe.targets - round(recipe.clutter * recipe.targets), len(visible))
    seen = random.permutation(visible)[:wanted]
    echoes = np.concatenate([truth[seen], own + in_disc(random, recipe.targets - wanted, 0.98 * radar_m)])
    order = random.permutation(len(echoes))
    polar = (echoes[order] - own) * np.exp(-1j * heading_rad)
    range_m, bearing_rad, sigma_m, sigma_rad = _measure(random, recipe, polar)
    plane = LocalPlane(recipe.centre)
    epoch = Epoch(
        None,
        tuple(
            RadarTarget(
                f"{i + 1:02d}",
                float(r),
                math.degrees(b),
                range_sigma_m=float(s),
                bearing_sigma_deg=math.degrees(sigma_rad),
            )
            for i, (r, b, s) in enumerate(zip(range_m, bearing_rad, sigma_m, strict=True))
        ),
        tuple(
            Mark(f"{200000001 + i}", plane.to_position(z.real, z.imag), recipe.mark_sigma_m, mmsi=200000001 + i)
            for i, z in enumerate(stated)
        ),
    )
    mark_of = np.concatenate([seen, np.full(len(echoes) - len(seen), -1)])[order]
    right = np.array([i for i, j in enumerate(mark_of) if j >= 0 and not false[j]], dtype=np.int64)
    pairs = np.column_stack([right, mark_of[right]]).astype(np.int64)
    information = _information(polar[right] * np.exp(1j * heading_rad), sigma_m[right], sigma_rad, recipe.mark_sigma_m)
    if recipe.lengths:
        epoch = _with_lengths(epoch, mark_of, random)
    turned, scattered = polar[right] * np.exp(1j * heading_rad), (sigma_m[right], sigma_rad)
    uniform = predicted_evidence(recipe, polar[right], *scattered, information, len(echoes), len(visible))
    return MadeScene(
        epoch,
        plane.to_position(own.real, own.imag),
        math.degrees(heading_rad + float(convergence(recipe.centre, own)[0])) % 360.0,
        pairs,
        np.linalg.inv(information).astype(np.float64) if len(right) >= 2 else None,
        uniform - log_crowding(recipe, turned, own, crowding, len(visible)),
        uniform,
    )


def predicted_evidence(
    recipe: SceneRecipe,
    matched: NDArray[np.complex128],
    range_sigma_m: FloatArray,
    bearing_sigma_rad: float,
    information: FloatArray,
    targets: int,
    visible: int,
) -> float:
    """Return the evidence (nats) that right matches must reach over chance among marks that lie anywhere alike.

    Sum over the right pairs of [ln 1/(rho 2 pi s_r s_t) - 1], less the entropy of which targets are matched, less the
    logarithm of searched volume over posterior volume; rho is the density of marks within radar range: eq. (6.10) of
    the theory without its last term.
    """
    matches = len(matched)
    if matches < 2 or visible == 0:
        return -math.inf
    density = visible / (math.pi * (recipe.radar_nm * NM_M) ** 2)
    radial = np.sqrt(range_sigma_m**2 + recipe.mark_sigma_m**2)
    tangential = np.sqrt((np.abs(matched) * bearing_sigma_rad) ** 2 + recipe.mark_sigma_m**2)
    gain = float(np.sum(-np.log(density * 2.0 * math.pi * radial * tangential) - 1.0))
    share = matches / targets
    entropy = 0.0 if share >= 1.0 else -share * math.log(share) - (1.0 - share) * math.log(1.0 - share)
    posterior = 1.5 * math.log(2.0 * math.pi) - 0.5 * float(np.linalg.slogdet(information)[1])
    return gain - targets * entropy - (math.log(_searched_volume(recipe)) - posterior)


def log_crowding(
    recipe: SceneRecipe, relative: NDArray[np.complex128], own: complex, crowding: Crowding | None, visible: int
) -> float:
    """Return by how many nats marks that crowd make chance agreement likelier: the last term of eq. (6.10).

    ``relative`` (k,) right matches about own ship, turned north; ``crowding`` gives the layout's marks per m^2 at any
    place, None where they lie anywhere alike. The mean over all poses of prod max(1, rho(w_i) / mean rho) is taken by
    importance sampling, with normal distributions of growing width about the true pose beside the whole volume: where
    crowds lie on crowds and lanes on lanes, the product is large.
    """
    if crowding is None or len(relative) < 2 or visible == 0:
        return 0.0
    random, reach_m = np.random.default_rng(0), recipe.radar_nm * NM_M
    widths_m = reach_m * 0.5 ** np.arange(7)
    step_m = widths_m[:, None] * (random.normal(size=(7, 200)) + 1j * random.normal(size=(7, 200)))
    turn_rad = widths_m[:, None] / reach_m * random.normal(size=(7, 200))
    anywhere = in_disc(random, 400, (recipe.ais_nm + recipe.radar_nm) * NM_M)
    p = np.concatenate([own + step_m.ravel(), anywhere])
    turn = np.concatenate([turn_rad.ravel(), random.uniform(-math.pi, math.pi, size=400)])
    volume = _searched_volume(recipe)
    off = np.abs(p - own)[:, None] ** 2 / widths_m**2 + (turn[:, None] * reach_m / widths_m) ** 2
    drawn = np.exp(-0.5 * off) / ((2.0 * math.pi) ** 1.5 * widths_m**3 / reach_m)
    drawn_per_volume = (200.0 * drawn.sum(axis=1) + 400.0 / volume) * volume
    world = p[:, None] + np.exp(1j * turn)[:, None] * relative[None, :]
    mean_per_m2 = visible / (math.pi * reach_m**2)
    log_product = np.log(np.maximum(crowding(world) / mean_per_m2, 1.0)).sum(axis=1)
    return max(0.0, float(np.logaddexp.reduce(log_product - np.log(drawn_per_volume))))


def _searched_volume(recipe: SceneRecipe) -> float:
    """Return places x headings [m^2 rad] that own ship may have."""
    return math.pi * ((recipe.ais_nm + recipe.radar_nm) * NM_M) ** 2 * 2.0 * math.pi


def _state_positions(
    random: np.random.Generator, recipe: SceneRecipe, truth: NDArray[np.complex128]
) -> tuple[NDArray[np.complex128], NDArray[np.bool_]]:
    """Return where the AIS says that the marks are (n,), and which are false (n,)."""
    count = len(truth)
    noise = recipe.noise_misfit * recipe.mark_sigma_m * (random.normal(size=count) + 1j * random.normal(size=count))
    false = random.permutation(count) < round(recipe.false_ais * count)
    angle = np.exp(2j * math.pi * random.uniform(size=count))
    alone = random.uniform(200.0, 3000.0, size=count) * angle
    alike = recipe.coherent_m * angle[0]
    everywhere = recipe.mark_offset_m * np.exp(2j * math.pi * random.uniform(size=count))
    return truth + noise + everywhere + np.where(false, alike if recipe.coherent_m > 0.0 else alone, 0.0), false


def _measure(
    random: np.random.Generator, recipe: SceneRecipe, polar: NDArray[np.complex128]
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """Return measured ranges and bearings (m,), and the sigmas that the scene states."""
    range_m = np.abs(polar)
    sigma_m = np.maximum(recipe.range_sigma_m, recipe.range_sigma_fraction * range_m)
    sigma_rad = math.radians(recipe.bearing_sigma_deg)
    measured_m = range_m + recipe.range_bias_m + recipe.noise_misfit * sigma_m * random.normal(size=len(polar))
    bearing_rad = np.angle(polar) + recipe.noise_misfit * sigma_rad * random.normal(size=len(polar))
    return np.maximum(measured_m, 20.0), bearing_rad, sigma_m, sigma_rad


def _with_lengths(epoch: Epoch, mark_of: IntArray, random: np.random.Generator) -> Epoch:
    """Give every mark a length (median 90 m) and every echo what shows of it by its aspect; clutter is small craft."""
    ship_m = np.clip(90.0 * np.exp(0.7 * random.normal(size=len(epoch.marks))), 8.0, 400.0)
    own_m = np.clip(25.0 * np.exp(0.8 * random.normal(size=len(mark_of))), 5.0, 400.0)
    aspect = np.abs(np.sin(math.pi * random.uniform(size=len(mark_of))))
    true_m = np.where(mark_of >= 0, ship_m[mark_of], own_m)
    seen_m = np.hypot(true_m * np.maximum(aspect, 0.2), 15.0) * np.exp(0.15 * random.normal(size=len(mark_of)))
    return replace(
        epoch,
        targets=tuple(replace(t, length_m=float(m)) for t, m in zip(epoch.targets, seen_m, strict=True)),
        marks=tuple(
            replace(mark, hull=Hull(0.5 * m, 0.5 * m, 0.08 * m, 0.08 * m))
            for mark, m in zip(epoch.marks, ship_m.tolist(), strict=True)
        ),
    )


def _information(
    relative: NDArray[np.complex128], range_sigma_m: FloatArray, bearing_sigma_rad: float, mark_sigma_m: float
) -> FloatArray:
    """Return the Fisher information (3, 3) of north m, east m, heading rad from right matches (k,), north-oriented."""
    range_m, azimuth_rad = np.abs(relative), np.angle(relative)
    cos, sin = np.cos(azimuth_rad), np.sin(azimuth_rad)
    radial = np.column_stack([cos, sin, np.zeros(len(cos))]) / np.hypot(range_sigma_m, mark_sigma_m)[:, None]
    tangential_m = np.hypot(range_m * bearing_sigma_rad, mark_sigma_m)
    tangential = np.column_stack([-sin, cos, range_m]) / tangential_m[:, None]
    design = np.vstack([radial, tangential])
    information: FloatArray = design.T @ design
    return information
