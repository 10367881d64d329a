"""A chart file of any format -> its objects, merged and counted."""

from __future__ import annotations

import logging
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from navfix.catalog import ChartModel, chart_model
from navfix.chart.colocated import merge, same_objects
from navfix.chart.csv_file import read_csv
from navfix.chart.geojson import read_geojson
from navfix.chart.records import Chart, ChartObject, Problem
from navfix.errors import InputError

_logger = logging.getLogger(__name__)
CSV_SUFFIXES, JSON_SUFFIXES, S57_SUFFIX = (".csv", ".tsv", ".txt"), (".geojson", ".json"), ".000"


def read_chart(path: str | Path, *, model: ChartModel | str = "aids", report: bool = True) -> Chart:
    """Read a chart file: CSV (.csv, .tsv, .txt), GeoJSON (.geojson, .json) or an S-57 cell (.000 with its updates).

    What was passed over is logged as a warning, once for each reason, unless ``report`` is False.

    Raises
    ------
    InputError : no such file, unreadable, of another format, or without a single object
    """
    path, model = Path(path), chart_model(model)
    objects, counts, problems = _objects(path, model)
    if not objects:
        why = f": {problems[0]}" if problems else ""
        raise InputError(f"{path}: no charted object in it{why}", source=str(path))
    chart = Chart(path.name, tuple(merge(objects, model.colocated_m)), counts, problems)
    if report:
        report_problems(chart)
    return chart


def read_charts(paths: Sequence[str | Path], *, model: ChartModel | str = "aids", report: bool = True) -> Chart:
    """Read several files as one chart; an object that an earlier file has already is taken once."""
    model = chart_model(model)
    charts = [read_chart(path, model=model, report=report) for path in paths]
    objects: list[ChartObject] = []
    counts: Counter[str] = Counter()
    for chart in charts:
        objects += same_objects(tuple(objects), chart.objects, model.same_object_m)
        counts.update(chart.counts)
    problems = tuple(problem for chart in charts for problem in chart.passed_over)
    return Chart(", ".join(chart.name for chart in charts), tuple(objects), dict(counts), problems)


def report_problems(chart: Chart) -> None:
    """Log what was passed over: what cannot be read as a warning, what is no mark by its nature as information."""
    for problem in chart.passed_over:
        _logger.log(logging.INFO if problem.harmless else logging.WARNING, "%s: %s", chart.name, problem)


def _objects(path: Path, model: ChartModel) -> tuple[list[ChartObject], dict[str, int], tuple[Problem, ...]]:
    suffix = path.suffix.lower()
    if path.is_dir():
        raise InputError(f"{path}: is a directory, expected a chart file", source=str(path))
    if not path.exists():
        raise InputError(f"{path}: no such file", source=str(path))
    if suffix == S57_SUFFIX:
        from navfix.chart.s57 import read_s57

        return read_s57(path, largest_extent_m=model.largest_extent_m)
    if suffix in JSON_SUFFIXES:
        objects, problems = read_geojson(_text(path), source=str(path), largest_extent_m=model.largest_extent_m)
    elif suffix in CSV_SUFFIXES:
        objects, problems = read_csv(_text(path), source=str(path))
    else:
        raise InputError(f"{path}: {_other_format(suffix)}", source=str(path))
    return objects, dict(Counter(o.chart_class.code or o.chart_class.words for o in objects)), problems


def _other_format(suffix: str) -> str:
    if suffix[1:].isdecimal():
        return "is an update; name the cell itself (.000), updates beside it are applied"
    return f"unknown format {suffix or '(no suffix)'}; expected .csv, .geojson or an S-57 cell .000"


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        return path.read_text(encoding="latin-1")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}", source=str(path)) from error
