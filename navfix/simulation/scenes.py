"""Seeded scenes of one instant, for the association: targets and marks, true pose and pairs, predicted evidence.

A scene needs no sentences: it is what a perfect picture of one radar turn would hold. Layouts: uniform traffic,
anchorages, lanes, a buoyed channel. Echoes without AIS (clutter), AIS positions that are false one by one or shifted
alike, and noise that is larger than the model says, can be mixed in.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from navfix.geodesy import LocalPlane
from navfix.types import Epoch, FloatArray, IntArray, Mark, Position, RadarTarget
from navfix.units import NM_M

LAYOUTS = ("uniform", "anchorages", "lanes", "channel")


@dataclass(frozen=True, slots=True)
class SceneRecipe:
    """How a scene is made.

    ``targets`` echoes in the radar disc of ``radar_nm``, of which the share ``clutter`` belongs to no mark; ``marks``
    AIS stations in the disc of ``ais_nm``, of which the share ``false_ais`` is elsewhere than it says (by 200 .. 3000 m
    one by one; with ``coherent_m`` > 0 all by that one vector). Sigmas are 1 sigma; range sigma is the larger of metres
    and fraction. The noise drawn is ``noise_misfit`` times what the scene states; every mark is ``mark_offset_m`` off
    in a direction of its own.
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


def make_scene(recipe: SceneRecipe, seed: int | np.random.Generator) -> MadeScene:
    """Make one scene; the same seed gives the same scene."""
    random = np.random.default_rng(seed)
    radar_m, ais_m = recipe.radar_nm * NM_M, recipe.ais_nm * NM_M
    heading_rad = random.uniform(0.0, 2.0 * math.pi)
    own = _in_disc(random, 1, max(ais_m - radar_m, 0.0) + 1.0)[0]
    truth = _lay_out(random, recipe, ais_m)
    stated, false = _state_positions(random, recipe, truth)
    visible = np.flatnonzero(np.abs(truth - own) < 0.98 * radar_m)
    wanted = min(recipe.targets - round(recipe.clutter * recipe.targets), len(visible))
    seen = random.permutation(visible)[:wanted]
    echoes = np.concatenate([truth[seen], own + _in_disc(random, recipe.targets - wanted, 0.98 * radar_m)])
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
    return MadeScene(
        epoch,
        plane.to_position(own.real, own.imag),
        math.degrees(heading_rad),
        pairs,
        np.linalg.inv(information).astype(np.float64) if len(right) >= 2 else None,
        predicted_evidence(recipe, polar[right], sigma_m[right], sigma_rad, information, len(echoes), len(visible)),
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
    """Return the evidence (nats) that right matches must reach over chance in a scene; above 5 it can be determined.

    Sum over the right pairs of [ln 1/(rho 2 pi s_r s_t) - 1], less the entropy of which targets are matched, less the
    logarithm of searched volume over posterior volume; rho is the density of marks within radar range.
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
    searched = math.log(math.pi * ((recipe.ais_nm + recipe.radar_nm) * NM_M) ** 2 * 2.0 * math.pi)
    posterior = 1.5 * math.log(2.0 * math.pi) - 0.5 * float(np.linalg.slogdet(information)[1])
    return gain - targets * entropy - (searched - posterior)


def _in_disc(random: np.random.Generator, count: int, radius_m: float) -> NDArray[np.complex128]:
    radius = radius_m * np.sqrt(random.uniform(size=count))
    return np.asarray(radius * np.exp(2j * math.pi * random.uniform(size=count)), dtype=np.complex128)


def _lay_out(random: np.random.Generator, recipe: SceneRecipe, radius_m: float) -> NDArray[np.complex128]:
    """Return true places (n,) of the marks about the centre."""
    count = recipe.marks
    if recipe.layout == "uniform":
        return _in_disc(random, count, radius_m)
    if recipe.layout == "anchorages":
        centres = _in_disc(random, max(2, count // 20), 0.8 * radius_m)
        scatter = 900.0 * (random.normal(size=count) + 1j * random.normal(size=count))
        clustered = centres[random.integers(len(centres), size=count)] + scatter
        return np.where(random.uniform(size=count) < 0.6, clustered, _in_disc(random, count, radius_m))
    if recipe.layout == "lanes":
        along = random.uniform(-radius_m, radius_m, size=count)
        across = 600.0 * random.normal(size=count) + np.where(random.uniform(size=count) < 0.5, 1500.0, -1500.0)
        turn = np.exp(1j * random.uniform(0.0, math.pi))
        return np.asarray((along + 1j * across) * turn)
    if recipe.layout == "channel":
        place = np.arange(count)
        spacing_m = NM_M
        row = (place // 2 - (count // 2 - 1) / 2.0) * spacing_m + 1j * np.where(place % 2 == 0, 150.0, -150.0)
        return np.asarray(row * np.exp(1j * random.uniform(0.0, math.pi)))
    raise ValueError(f"layout must be one of {', '.join(LAYOUTS)}, got {recipe.layout!r}")


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
