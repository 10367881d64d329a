"""How dense echoes are about each target: clutter comes in clusters and along lines."""

from __future__ import annotations

import numpy as np

from navfix.association.scene import Scene
from navfix.catalog import AssociationModel
from navfix.types import FloatArray

FEWEST_NEIGHBOURS = 3  # fewer have no shape


def clutter_density(scene: Scene, model: AssociationModel) -> FloatArray:
    """Return echoes per m^2 about each target (m,), from the other targets: eq. (6.6) of the theory.

    Echoes come in clusters (anchorages, moorings) and along lines (quays, lanes). Half a uniform density plus half a
    leave-one-out kernel, and never less than the uniform one; the kernel is the densest of round ones and of one that
    takes its shape from the nearest other targets.
    """
    count = len(scene.rho)
    uniform = count / (np.pi * scene.radar_range_m**2)
    if not model.use_local_clutter:
        return np.full(count, uniform)
    apart = scene.rho[:, None] - scene.rho[None, :]
    apart_sq = apart.real**2 + apart.imag**2
    densest = np.zeros(count)
    for width_m in model.clutter_kernels_m:
        kernel = np.exp(-0.5 * apart_sq / width_m**2) / (2.0 * np.pi * width_m**2)
        np.fill_diagonal(kernel, 0.0)
        densest = np.maximum(densest, kernel.sum(axis=1))
    density = np.maximum(uniform, 0.5 * uniform + 0.5 * densest)
    if count > FEWEST_NEIGHBOURS:
        density = np.maximum(density, 0.5 * density + 0.5 * _density_of_neighbours(scene, apart_sq, model))
    return density


def _density_of_neighbours(scene: Scene, apart_sq: FloatArray, model: AssociationModel) -> FloatArray:
    """Return echoes per m^2 (m,) of one normal distribution through each target's nearest others: long on a line."""
    others = apart_sq.copy()
    np.fill_diagonal(others, np.inf)
    neighbours = min(model.clutter_neighbours, len(apart_sq) - 1)
    nearest = np.argsort(others, axis=1)[:, :neighbours]
    offset = scene.rho[nearest] - scene.rho[:, None]
    offset_m = np.stack([offset.real, offset.imag], axis=-1)
    mean = offset_m.mean(axis=1)
    centred = offset_m - mean[:, None, :]
    covariance = np.einsum("mki,mkj->mij", centred, centred) / (neighbours - 1)
    tangential_m = scene.range_m * scene.bearing_sigma_rad
    floor_m2 = (scene.range_sigma_m**2 + tangential_m**2) / 2.0 + model.clutter_floor_m**2
    covariance += floor_m2[:, None, None] * np.eye(2)
    distance_sq = np.einsum("mi,mi->m", mean, np.linalg.solve(covariance, mean[:, :, None])[:, :, 0])
    area_m2 = 2.0 * np.pi * np.sqrt(np.linalg.det(covariance))
    density: FloatArray = neighbours * np.exp(-0.5 * distance_sq) / area_m2
    return density
