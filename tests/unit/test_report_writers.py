"""Every writer for every sort of answer; sentences, GPX, CSV and HTML read back."""

from __future__ import annotations

import csv
import io
import json
from dataclasses import replace
from html.parser import HTMLParser
from xml.etree import ElementTree as ET

import numpy as np
import pynmea2
import pytest

from navfix.errors import InputError
from navfix.report import Answer
from navfix.report.nmea_out import navigation_status
from navfix.report.writers import SUFFIXES, render
from navfix.types import GlobalTest, GnssVerdict, Position
from tests.factories import OSLO, every_fix, every_no_fix, make_answer, make_fix, make_no_fix, make_plane_fix

EVERY = every_fix() | every_no_fix()
GPX = "{http://www.topografix.com/GPX/1/1}"


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", list(EVERY))
def test_every_writer_takes_every_answer(name: str, suffix: str) -> None:
    text = render(EVERY[name], suffix)
    assert text.endswith("\n")
    assert render(EVERY[name], suffix.upper()) == text


def test_an_unknown_suffix_lists_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"'\.pdf'.*\.txt \.json \.svg \.geojson \.html \.nmea \.gpx \.csv"):
        render(make_answer(), ".pdf")


@pytest.mark.parametrize("suffix", [".geojson", ".nmea", ".gpx"])
def test_places_on_the_globe_are_not_made_of_a_plane_fix(suffix: str) -> None:
    with pytest.raises(InputError, match="plane frame"):
        render(Answer(epoch=None, fix=make_plane_fix()), suffix)


@pytest.mark.parametrize("suffix", [".txt", ".json", ".svg", ".html", ".csv"])
def test_a_plane_fix_has_its_other_writers(suffix: str) -> None:
    assert "1234.5" in render(Answer(epoch=None, fix=make_plane_fix()), suffix) or suffix == ".csv"


# ------------------------------------------------------------------------------------------------------- sentences


def sentences(answer: Answer) -> list[pynmea2.NMEASentence]:
    """Return the sentences parsed, checksums checked."""
    text = render(answer, ".nmea")
    assert text.endswith("\r\n")
    return [pynmea2.parse(line, check=True) for line in text.split("\r\n")[:-1]]


@pytest.mark.parametrize("name", list(every_fix()))
def test_a_fix_is_rmc_hdt_gst_of_talker_in(name: str) -> None:
    answer = every_fix()[name]
    assert answer.fix is not None
    assert isinstance(answer.fix.position, Position)
    rmc, hdt, gst = sentences(answer)
    assert [s.talker + s.sentence_type for s in (rmc, hdt, gst)] == ["INRMC", "INHDT", "INGST"]
    assert rmc.status == "A"
    assert rmc.data[11] == "E"
    assert rmc.latitude == pytest.approx(answer.fix.position.lat_deg, abs=1e-7)
    assert rmc.longitude == pytest.approx(answer.fix.position.lon_deg, abs=1e-7)
    assert float(hdt.heading) == pytest.approx(answer.fix.heading_deg, abs=0.051)


def test_gst_is_the_ellipse_at_one_sigma() -> None:
    answer = make_answer()
    assert answer.fix is not None
    gst = sentences(answer)[2]
    covariance = answer.fix.covariance
    minor, major = np.sqrt(np.linalg.eigvalsh(covariance[:2, :2]))
    assert float(gst.data[2]) == pytest.approx(major, abs=0.006)
    assert float(gst.data[3]) == pytest.approx(minor, abs=0.006)
    assert float(gst.data[5]) == pytest.approx(np.sqrt(covariance[0, 0]), abs=0.006)
    assert float(gst.data[6]) == pytest.approx(np.sqrt(covariance[1, 1]), abs=0.006)


def test_time_and_date_are_those_of_the_epoch() -> None:
    rmc = sentences(make_answer())[0]
    assert (rmc.data[0], rmc.data[8]) == ("050607.25", "040326")
    assert sentences(every_fix()["bare"])[0].data[0] == ""


def test_no_fix_is_an_rmc_that_is_not_valid() -> None:
    (rmc,) = sentences(make_no_fix())
    assert (rmc.status, rmc.data[2], rmc.data[11], rmc.data[12]) == ("V", "", "N", "V")


def test_own_gnss_changes_no_sentence() -> None:
    far = GnssVerdict(Position(10.0, 10.0), 5e6, "unsafe", 60.0, 30.0, ())
    near = GnssVerdict(OSLO, 1.0, "ok", 60.0, 30.0, ())
    assert render(make_answer(gnss=far), ".nmea") == render(make_answer(gnss=near), ".nmea")


def test_navigation_status_is_safe_only_when_everything_says_so() -> None:
    fix = make_fix()
    assert navigation_status(fix) == "S"
    assert navigation_status(replace(fix, integrity=None)) == "C"
    assert navigation_status(replace(fix, global_test=GlobalTest(90.0, 27.4, 40.6, False))) == "C"
    assert navigation_status(replace(fix, association=None)) == "C"
    with_others = every_fix()["with_alternatives"].fix
    assert with_others is not None
    assert navigation_status(with_others) == "C"


# ------------------------------------------------------------------------------------------------- CSV, GPX, HTML


def test_csv_has_one_line_for_each_observation() -> None:
    answer = make_answer()
    assert answer.fix is not None
    rows = list(csv.DictReader(io.StringIO(render(answer, ".csv"))))
    assert len(rows) == len(answer.fix.observations)
    assert {row["target"] for row in rows if row["outlier"] == "1"} == {"05"}
    assert float(rows[0]["residual"]) == pytest.approx(answer.fix.observations[0].residual, rel=1e-8)
    assert list(csv.DictReader(io.StringIO(render(make_no_fix(), ".csv")))) == []


def test_gpx_holds_own_ship_and_the_marks_of_the_pairs() -> None:
    answer = make_answer()
    assert answer.fix is not None
    assert isinstance(answer.fix.position, Position)
    root = ET.fromstring(render(answer, ".gpx").encode())
    waypoints = root.findall(f"{GPX}wpt")
    assert len(waypoints) == 18
    assert float(waypoints[0].attrib["lat"]) == pytest.approx(answer.fix.position.lat_deg, abs=1e-9)
    assert waypoints[0].findtext(f"{GPX}name") == "own ship"
    nothing = ET.fromstring(render(make_no_fix(), ".gpx").encode())
    assert nothing.findall(f"{GPX}wpt") == []
    assert "ambiguous" in nothing.findtext(f"{GPX}metadata/{GPX}desc", "")


class _Tags(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.links: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if name in ("src", "href")]
        if tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.mark.parametrize("name", ["full", "ambiguous"])
def test_html_is_closed_and_loads_nothing(name: str) -> None:
    page = _Tags()
    page.feed(render(EVERY[name], ".html"))
    assert page.open == []
    assert page.links == []
    assert ("NO FIX" if name == "ambiguous" else "59°24.1241' N") in page.text


def test_json_is_one_line() -> None:
    text = render(make_answer(), ".json")
    assert text.count("\n") == 1
    assert json.loads(text)["status"] == "fix"
