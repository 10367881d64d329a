"""Charts: aids to navigation and conspicuous objects from CSV, GeoJSON and S-57 cells, and the marks that they give."""

from navfix.chart.marks import marks
from navfix.chart.read import read_chart, read_charts
from navfix.chart.records import Chart, ChartClass, ChartObject

__all__ = ["Chart", "ChartClass", "ChartObject", "marks", "read_chart", "read_charts"]
