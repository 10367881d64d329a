"""The residual table as CSV: one line for each observation, numbers as in the JSON."""

from __future__ import annotations

import csv
import io

from navfix.report.answer import Answer
from navfix.report.fix_json import observation_to_dict
from navfix.report.rows import is_outlier, pair_rows

COLUMNS = (
    "target", "mark", "name", "mmsi", "kind", "unit", "observed", "adjusted", "residual", "sigma", "standardized",
    "redundancy_number", "weight", "mdb", "external_m", "outlier", "offset_m", "offset_azimuth_deg",
)  # fmt: skip


def csv_text(answer: Answer) -> str:
    """Return the table with its header; the header alone where there is no fix. What cannot be said is blank.

    ``offset_m`` along ``offset_azimuth_deg`` leads from where the radar sees the target to where the mark says it is.
    """
    out = io.StringIO()
    table = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    table.writeheader()
    if answer.fix is None:
        return out.getvalue()
    for row in pair_rows(answer.fix):
        pair = {
            "name": row.name,
            "mmsi": None if row.mark is None else row.mark.mmsi,
            "offset_m": None if row.offset_m is None else f"{row.offset_m:.2f}",
            "offset_azimuth_deg": None if row.offset_azimuth_deg is None else f"{row.offset_azimuth_deg:.2f}",
        }
        for observation in (row.range, row.bearing):
            if observation is not None:
                outlier = int(is_outlier(answer.fix, observation))
                table.writerow(observation_to_dict(observation) | pair | {"outlier": outlier})
    return out.getvalue()
