"""The check test of the Gdynia stand: own ship from five radar bearings, as a textbook adjusts them, then robustly."""

from __future__ import annotations

import math
from pathlib import Path

from navfix.adjustment.adjust_case import adjust_case, first_step
from navfix.adjustment.case import parse_case

CASE = Path(__file__).resolve().parents[2] / "data" / "golden" / "gdynia.toml"

case = parse_case(CASE.read_text(encoding="utf-8"))
classical = adjust_case(case, kernel="none")

print("One linear step from the start, as in the paper: V = A dx + L")
step = first_step(case, classical)
assert step is not None
north_m, east_m = step.increments
print(f"dX {east_m:+.2f} m, dY {north_m:+.2f} m, m0 {step.sigma0 or 1.0:.4f}, m_P {step.position_sigma_m:.2f} m")
for observation, v, sigma in zip(case.observations, step.residuals, step.adjusted_sigma, strict=True):
    print(f"  mark {observation.mark}   V {v:+.4f} deg   adjusted bearing +- {sigma:.3f} deg")

start, printed = case.start, (6045500.63, 360309.33)
print(f"start            X {start.east_m:.2f}  Y {start.north_m:.2f}")
print(f"start + dX, dY   X {start.east_m + east_m:.2f}  Y {start.north_m + north_m:.2f}")
print(f"printed          X {printed[1]:.2f}  Y {printed[0]:.2f}  (the mirror image about the start)")

print("Iterated to the end:")
for kernel in ("none", "huber", "hampel", "danish"):
    fix = adjust_case(case, kernel=kernel)
    error_m = math.sqrt(fix.covariance[0, 0] + fix.covariance[1, 1])
    damped = ", ".join(f"{o.mark} ({o.weight:.2f})" for o in fix.observations if o.weight < 0.99) or "none"
    place = f"X {fix.position.east_m:.2f}  Y {fix.position.north_m:.2f}"
    print(f"  {kernel:<7} {place}   m_P {error_m:6.1f} m   damped: {damped}")
