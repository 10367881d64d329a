"""S-57 cells: the published cell with its updates, the geometry reader, depths, a clear word without pyogrio."""

from __future__ import annotations

import struct
import sys
from pathlib import Path

import numpy as np
import pytest

from navfix.chart import marks, read_chart
from navfix.chart.depth import DepthArea, depth_at
from navfix.chart.records import BadRow
from navfix.chart.shapes import wkb_parts, wkb_points
from navfix.errors import InputError
from navfix.types import Position

# What the cell US4MD81M holds after its updates 001 to 003, counted independently
COUNTS = {
    "BOYLAT": 71, "BOYSPP": 19, "BOYSAW": 2, "BCNLAT": 194, "BCNSPP": 30, "LIGHTS": 151, "DAYMAR": 206, "OFSPLF": 73,
    "LNDMRK": 59, "RTPBCN": 1, "PILPNT": 205, "TOPMAR": 2, "FOGSIG": 5, "WRECKS": 111,
}  # fmt: skip


@pytest.fixture(scope="module")
def cell(shared_data: Path) -> Path:
    pytest.importorskip("pyogrio", reason="extra enc absent")
    path = shared_data / "enc" / "US4MD81M.000"
    if not path.is_file():
        pytest.skip("shared data absent")
    return path


def test_the_cell_with_its_updates_gives_the_published_counts(cell: Path) -> None:
    chart = read_chart(cell)
    assert {code: chart.counts.get(code) for code in COUNTS} == COUNTS
    lights = sum("LIGHTS" in item.equipment for item in chart.objects)
    assert lights == 148  # 151 lights, some of them two in one place
    equipment = ("LIGHTS", "DAYMAR", "TOPMAR", "FOGSIG", "RTPBCN")
    assert not any(item.chart_class.code in equipment for item in chart.objects)
    floating = [item for item in chart.objects if item.kind == "floating"]
    assert all(item.depth_m is not None for item in floating)
    assert all(38.0 < item.position.lat_deg < 40.0 for item in chart.objects)
    found = marks(chart.objects)
    assert len({mark.label for mark in found}) == len(found) == 619
    assert len(marks(chart.objects, land=True)) == 700
    below_water = next(p for p in chart.passed_over if p.reason == "wreck below water")
    assert below_water.harmless


def test_the_updates_beside_the_cell_are_applied(cell: Path, tmp_path: Path) -> None:
    import shutil

    alone = tmp_path / cell.name
    shutil.copyfile(cell, alone)
    assert read_chart(alone).counts != read_chart(cell).counts


def test_a_file_that_is_no_cell_is_said(tmp_path: Path) -> None:
    pytest.importorskip("pyogrio", reason="extra enc absent")
    path = tmp_path / "bad.000"
    path.write_bytes(b"not a cell at all")
    with pytest.raises(InputError, match=r"bad\.000: not a readable S-57 cell"):
        read_chart(path)


def test_without_pyogrio_the_way_to_install_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "cell.000"
    path.write_bytes(b"x")
    monkeypatch.setitem(sys.modules, "pyogrio", None)
    with pytest.raises(InputError, match=r"pip install 'navfix\[enc\]'"):
        read_chart(path)


def test_geometry_is_read_in_both_byte_orders_and_with_heights() -> None:
    assert wkb_points(struct.pack("<BIdd", 1, 1, 7.0, 54.0)).tolist() == [[7.0, 54.0]]
    assert wkb_points(struct.pack(">BIdd", 0, 1, 7.0, 54.0)).tolist() == [[7.0, 54.0]]
    assert wkb_points(struct.pack("<BIddd", 1, 0x80000001, 7.0, 54.0, 3.0)).tolist() == [[7.0, 54.0]]
    assert wkb_points(struct.pack("<BIddd", 1, 1001, 7.0, 54.0, 3.0)).tolist() == [[7.0, 54.0]]
    points = struct.pack("<BII", 1, 4, 2) + 2 * struct.pack("<BIdd", 1, 1, 7.0, 54.0)
    assert len(wkb_points(points)) == 2
    triangle = struct.pack("<III6d", 3, 2, 3, *range(6))[4:]
    assert [len(ring) for ring in wkb_parts(struct.pack("<BI", 1, 3) + triangle[:4] + 2 * triangle[4:])[0]] == [3, 3]


@pytest.mark.parametrize("wkb", [None, b"", b"\x01", struct.pack("<BI", 1, 99), struct.pack("<BId", 1, 1, 7.0)])
def test_geometry_that_is_cut_off_or_strange_is_passed_over(wkb: bytes | None) -> None:
    with pytest.raises(BadRow, match="no geometry"):
        wkb_points(wkb)


def test_depth_is_that_of_the_area_around_with_its_holes() -> None:
    def ring(low: float, high: float) -> np.ndarray:
        return np.array([[low, low], [high, low], [high, high], [low, high], [low, low]])

    areas = [DepthArea((ring(0.0, 1.0), ring(0.4, 0.6)), 9.1, (0.0, 0.0, 1.0, 1.0))]
    assert depth_at(areas, Position(0.2, 0.3)) == 9.1
    assert depth_at(areas, Position(0.5, 0.5)) is None
    assert depth_at(areas, Position(1.5, 0.5)) is None
