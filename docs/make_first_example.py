"""Write docs/first_example.md: the words below, the program and what it prints.

Run: python docs/make_first_example.py
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
PAGE, PROGRAM = DOCS / "first_example.md", DOCS / "examples" / "gdynia_test.py"

HEAD = """# First example: a published adjustment

The check test of the Gdynia stand for the automation of radar navigation [3 in [Theory](theory.md)]: own ship takes
five radar bearings to marks of known position; one of them, mark 5, is wrong. Nothing but the adjustment is at work
here, no log, no association, so every figure can be held against the paper. The case is
`data/golden/gdynia.toml`, and

```console
$ navfix adjust data/golden/gdynia.toml --kernel none
```

prints the whole textbook report: coefficient matrix, free terms, weights, increments, residuals, cofactors, redundancy
numbers, classical, Huber, Hampel and Danish side by side; `--out report.html` writes it as a page.
"""

WORDS = """
## What agrees with the paper

Residuals V, m0 = 1.948, the standard deviations of the adjusted bearings and the mean position error m_P = 146.30 m are
those of the paper, as far as its printed, rounded matrices allow (`tests/golden/test_gdynia.py`). Its errors are scaled
by m0, although the text says m0 = 1.

## Why the position is the mirror image of the printed one

The paper linearises the computed bearing about the start and writes V = A dx + L with L = computed - observed. A is
then the derivative of the bearing by own ship's position. Moving own ship east turns the bearing of a mark in the
north to the *left*: that entry is negative (a test shows it by hand: mark 10 km north, 100 m east, 0.573 deg to the
left). The printed A is positive there. It is the derivative by the *mark's* position, the negative of what the
formula asks for. Where A changes its sign, dx changes its sign too and A dx stays: V, m0, all standard deviations and
m_P are none the worse, and no check of the residuals notices. Only the position is wrong: the printed dx points away
from the solution, and the printed position lies as far on the wrong side of the start as the right one lies on the
other, 808 m from it. navfix gives the position with the right sign, the one from which the bearings fit.


## Where on earth

The table's bearings are true, its coordinates are grid coordinates (UTM zone 34, convergence -1.765 deg). The paper
mixes them, and so does this case, to reproduce its figures. On the ellipsoid, with true bearings and geodesics, own
ship is at 54.531337 N, 18.847065 E: `navfix adjust data/golden/gdynia_ellipsoid.toml`.

## Robust

From the first kernel on, mark 5 alone loses weight, and the position moves by 5 to 30 m. Five bearings for two unknowns
are few: with fewer than three degrees of freedom left after damping, m_P comes from the sigmas given (1 deg) and no
longer from m0, which is why it halves.
"""


def page() -> str:
    """Return the page."""
    done = subprocess.run([sys.executable, str(PROGRAM)], capture_output=True, text=True, check=True)
    program = f"\n```python\n{PROGRAM.read_text(encoding='utf-8')}```\n"
    return f"{HEAD}{program}\nprints\n\n```text\n{done.stdout}```\n{WORDS}"


def main() -> None:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
