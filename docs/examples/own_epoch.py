"""From numbers to a fix: six echoes (the last is no mark), seven marks, no position or heading known."""

from __future__ import annotations

import navfix
from navfix.errors import NoFix

MARKS = [
    navfix.Mark("FERRY", navfix.Position(54.2410, 7.6480), sigma_m=15.0),
    navfix.Mark("TANKER", navfix.Position(54.1830, 7.5020), sigma_m=25.0),
    navfix.Mark("BUOY N", navfix.Position(54.2205, 7.7150), sigma_m=10.0, kind="aton"),
    navfix.Mark("BUOY W", navfix.Position(54.1500, 7.6010), sigma_m=10.0, kind="aton"),
    navfix.Mark("PILOT", navfix.Position(54.2690, 7.5560), sigma_m=10.0),
    navfix.Mark("CARGO", navfix.Position(54.1720, 7.7700), sigma_m=25.0),
    navfix.Mark("YACHT", navfix.Position(54.2120, 7.5660), sigma_m=8.0),
]
ECHOES = [(5679.1, 357.5), (7172.5, 231.4), (7429.4, 39.5), (5036.6, 158.5), (8967.0, 309.3), (4411.0, 120.2)]
# range m, relative bearing deg; a fine radar: 10 m and 0.25 deg

epoch = navfix.Epoch(
    time_utc=None,
    targets=[navfix.RadarTarget(f"{i:02d}", r, b) for i, (r, b) in enumerate(ECHOES, start=1)],
    marks=MARKS,
)

try:
    fix = navfix.fix(epoch, radar="solid_state")
except NoFix as error:
    print("no fix:", error)
else:
    ellipse = fix.ellipse(0.95)
    print(f"{fix.position.lat_deg:.5f} N {fix.position.lon_deg:.5f} E, heading {fix.heading_deg:.1f} deg")
    print(f"95 % within {ellipse.semi_major_m:.0f} x {ellipse.semi_minor_m:.0f} m, sigma0 {fix.sigma0:.2f}")
