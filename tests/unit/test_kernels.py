"""Kernels: loss, derivative and weight agree; constants have the efficiency that their files state."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from navfix import catalog
from navfix.errors import CatalogError, InputError
from navfix.kernels import FAMILIES, Kernel, gaussian_efficiency

NAMES = catalog.names("kernel")
DAMPINGS = ("separate", "joint")
Z = np.concatenate([np.linspace(0.001, 12.0, 2399), [20.0, 50.0, 200.0]])


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("name", NAMES)
def test_derivative_is_slope_of_loss(name: str, damping: str) -> None:
    kernel, step = catalog.kernel(name), 1e-5
    slope = (kernel.loss(Z + step, damping) - kernel.loss(Z - step, damping)) / (2.0 * step)
    np.testing.assert_allclose(slope, kernel.derivative(Z, damping), atol=2e-5)


@pytest.mark.parametrize("damping", DAMPINGS)
@pytest.mark.parametrize("name", NAMES)
def test_derivative_is_weight_times_residual(name: str, damping: str) -> None:
    kernel = catalog.kernel(name)
    np.testing.assert_allclose(kernel.weight(Z, damping) * Z, kernel.derivative(Z, damping), atol=1e-12)


def knots_of(kernel: Kernel, damping: str) -> tuple[float, ...]:
    """Return where the curves of a kernel have kinks."""
    constants = kernel.constants(damping)  # type: ignore[arg-type]
    if kernel.family != "tls":
        return constants
    c, mu = constants
    return c * math.sqrt(mu / (mu + 1.0)), c * math.sqrt((mu + 1.0) / mu)


@pytest.mark.parametrize("name", NAMES)
def test_loss_is_the_integral_of_the_derivative_from_zero(name: str) -> None:
    kernel = catalog.kernel(name)
    knots = [point for point in knots_of(kernel, "joint") if point < 9.0]
    for end in (1.0, 3.0, 9.0):
        breaks = [point for point in knots if point < end] or None
        integral, _ = quad(lambda z: float(kernel.derivative(np.array([z]), "joint")[0]), 0.0, end, points=breaks)
        assert float(kernel.loss(end, "joint")) == pytest.approx(integral, abs=1e-7)


@pytest.mark.parametrize("name", NAMES)
def test_small_residuals_keep_full_weight_and_large_ones_never_gain(name: str) -> None:
    weight = catalog.kernel(name).weight(Z)
    assert weight[0] == pytest.approx(1.0, abs=1e-6)
    assert np.all(np.diff(weight) <= 1e-12)
    assert np.all((weight >= 0.0) & (weight <= 1.0))


@pytest.mark.parametrize(("name", "below"), [("hampel", 1e-12), ("tukey", 1e-12), ("igg3", 1e-12), ("danish", 1e-6)])
def test_redescenders_forget_a_gross_error(name: str, below: float) -> None:
    kernel = catalog.kernel(name)
    assert float(kernel.weight(20.0)) < below
    assert math.isfinite(kernel.bound())
    assert float(kernel.loss(1e4)) == pytest.approx(kernel.bound(), rel=1e-9)


@pytest.mark.parametrize("name", ["none", "huber"])
def test_convex_kernels_have_no_bound(name: str) -> None:
    assert catalog.kernel(name).bound() == math.inf


def test_values_by_hand() -> None:
    huber, hampel, tukey = (catalog.kernel(name) for name in ("huber", "hampel", "tukey"))
    assert float(huber.weight(2.69)) == pytest.approx(0.5)
    assert float(hampel.weight(6.0)) == pytest.approx(2.0 / 6.0 * 0.5)
    assert hampel.bound() == pytest.approx(2.0 * (4.0 + 8.0 - 2.0) / 2.0)  # a (b + c - a) / 2
    assert tukey.bound() == pytest.approx(4.685**2 / 6.0)
    assert float(catalog.kernel("danish_low").weight(10.0)) == pytest.approx(math.exp(-0.01 * 64.0))  # .53: no damper
    assert float(catalog.kernel("gdynia_linear").weight(5.0)) == pytest.approx(0.5)


def test_huber_without_limit_is_least_squares() -> None:
    limitless = replace(catalog.kernel("huber"), separate=(math.inf,), joint=(math.inf,))
    none = catalog.kernel("none")
    for curve in ("loss", "derivative", "weight"):
        np.testing.assert_array_equal(getattr(limitless, curve)(Z), getattr(none, curve)(Z))


def efficiency_by_quadrature(kernel: Kernel, dof: int, damping: str) -> float:
    """B^2 / V with E[psi'] taken from the numerical slope of the derivative: another road than the library's."""

    def mean(function: object) -> float:
        norm, _ = quad(lambda z: z ** (dof - 1) * math.exp(-0.5 * z * z), 0.0, 14.0)
        value, _ = quad(
            lambda z: function(z) * z ** (dof - 1) * math.exp(-0.5 * z * z),  # type: ignore[operator]
            1e-9,
            14.0,
            points=[p for p in knots_of(kernel, damping) if p < 14.0] or None,
            limit=400,
        )
        return value / norm

    def psi(z: float) -> float:
        return float(kernel.derivative(np.array([z]), damping)[0])

    slope = mean(lambda z: (psi(z + 1e-6) - psi(max(z - 1e-6, 0.0))) / (z + 1e-6 - max(z - 1e-6, 0.0)))
    b = slope / dof + (1.0 - 1.0 / dof) * mean(lambda z: psi(z) / z)
    return b * b / (mean(lambda z: psi(z) ** 2) / dof)


@pytest.mark.parametrize("name", NAMES)
def test_both_sets_of_constants_have_the_stated_efficiency(name: str) -> None:
    kernel = catalog.kernel(name)
    for damping, dof in (("separate", 1), ("joint", 2)):
        assert gaussian_efficiency(kernel, damping) == pytest.approx(kernel.efficiency, abs=2e-5)
        assert efficiency_by_quadrature(kernel, dof, damping) == pytest.approx(kernel.efficiency, abs=1e-4)


def test_textbook_constants_are_as_efficient_as_said() -> None:
    assert catalog.kernel("huber").efficiency == pytest.approx(0.95, abs=1e-4)
    assert catalog.kernel("tukey").efficiency == pytest.approx(0.95, abs=1e-4)
    assert catalog.kernel("hampel").efficiency == pytest.approx(0.99, abs=1e-3)
    assert catalog.kernel("igg3").efficiency == pytest.approx(0.76, abs=5e-3)


def test_one_dimensional_constants_lose_efficiency_when_damping_jointly() -> None:
    assert gaussian_efficiency(catalog.kernel("huber"), "separate", dof=2) < 0.94


def test_kernel_is_found_by_name_path_or_itself(tmp_path: Path) -> None:
    own = tmp_path / "mine.toml"
    own.write_text(
        'title = "Mine"\nsource = "test"\nfamily = "huber"\nefficiency = 0.98\n[separate]\nk = 1.7\n[joint]\nk = 1.9\n'
    )
    assert catalog.kernel(str(own)).separate == (1.7,)
    assert catalog.kernel(own).name == "mine"
    hampel = catalog.kernel("hampel")
    assert catalog.kernel(hampel) is hampel
    assert hampel.family in FAMILIES


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('family = "hubert"\nefficiency = 1.0', "family must be one of"),
        ('family = "huber"\nefficiency = 1.0\n[separate]\nk = 1.0', r"\[joint\] must hold k"),
        ('family = "huber"\nefficiency = 1.0\n[separate]\nk = -1.0\n[joint]\nk = 1.0', "must be > 0"),
        ('family = "hampel"\nefficiency = 1.0\n[separate]\na=2\nb=1\nc=8\n[joint]\na=1\nb=2\nc=3', "must increase"),
        ('family = "huber"\nefficiency = 1.0\nsigma = 2\n[separate]\nk = 1.0\n[joint]\nk = 1.0', "unknown key 'sigma'"),
        ('family = "huber"\n[separate]\nk = 1.0\n[joint]\nk = 1.0', "missing key 'efficiency'"),
        ('family = "huber"\nefficiency = 1.0\n[separate]\nk = "a"\n[joint]\nk = 1.0', "must be a number"),
    ],
)
def test_a_wrong_file_says_what_is_wrong(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(f'title = "t"\nsource = "s"\n{text}\n')
    with pytest.raises(CatalogError, match=says):
        catalog.kernel(path)


def test_an_unknown_name_lists_the_known_ones() -> None:
    with pytest.raises(CatalogError, match="hampel"):
        catalog.kernel("hample")


def test_constants_are_checked_on_construction() -> None:
    with pytest.raises(InputError, match="constants"):
        Kernel("x", "t", "s", "huber", (1.0, 2.0), (1.0,), 1.0)
    with pytest.raises(InputError, match="unknown family"):
        Kernel("x", "t", "s", "nope", (), (), 1.0)
