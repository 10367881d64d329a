"""Every line of every recording beside the project reads without an exception and is counted right."""

from __future__ import annotations

import logging
import re
from collections import Counter
from pathlib import Path

import pytest

from navfix.nmea import Reader, read_log
from navfix.nmea.records import AisPosition, AisStatic, OwnHeading, OwnPosition, OwnSpeed, RadarSettings, TargetReport

FOLDERS = ("ais_logs", "ais_vectors", "radar_ttm", "semi_real", "marce")
FILES = {
    "marce_01_001": "marce/marce_01_001.nmea",
    "marce_01_004": "marce/marce_01_004.nmea",
    "marce_01_010": "marce/marce_01_010.nmea",
    "dense_sf": "semi_real/dense_sf.nmea",
    "coastal_hakefjord": "semi_real/coastal_hakefjord.nmea",
    "moored_harlingen_atons": "semi_real/moored_harlingen_atons.nmea",
    "RadarLogs.txt": "radar_ttm/RadarLogs.txt",
    "PacCupStart.txt": "ais_logs/PacCupStart.txt",
    "hakan.txt": "ais_logs/hakan.txt",
    "gofree-merrimac.log": "ais_logs/gofree-merrimac.log",
    "nais400-merrimac.log": "ais_logs/nais400-merrimac.log",
    "stupan.se-10112-tcp.log": "ais_logs/stupan.se-10112-tcp.log",
}


@pytest.fixture(autouse=True)
def _quiet(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.CRITICAL, logger="navfix")


def expected_counts(folder: Path) -> dict[str, dict[str, int]]:
    """Return the table of expected sentence counts: ``name KIND number KIND number ... |``."""
    _, _, section = (folder / "MANIFEST.md").read_text(encoding="utf-8").partition("## Expected sentence counts")
    section = section.partition("\n## ")[0]
    table = {}
    for entry in re.split(r"[|\n]", section):
        words = entry.replace("`", "").split()
        if len(words) >= 3:
            table[words[0]] = {words[i]: int(words[i + 1]) for i in range(1, len(words) - 1, 2)}
    return table


def accounted(reader: Reader) -> int:
    """Return how many sentences and problems the reader has counted."""
    return sum(reader.counts.values()) + sum(problem.count for problem in reader.problems)


def test_the_counts_are_those_of_the_manifest(shared_data: Path) -> None:
    expected = expected_counts(shared_data)
    assert set(expected) == set(FILES)
    for name, counts in expected.items():
        log = read_log(shared_data / FILES[name])
        assert {kind: log.counts.get(kind, 0) for kind in counts} == counts, name


def test_every_line_of_every_file_reads_and_is_accounted_for(shared_data: Path) -> None:
    for folder in FOLDERS:
        for path in sorted((shared_data / folder).iterdir()):
            reader = Reader()
            for line in path.read_bytes().splitlines():
                before = accounted(reader)
                reader.feed(line)
                assert accounted(reader) > before or not line.strip() or line.startswith(b"#"), (path.name, line)
            assert reader.lines > 0


def test_the_files_hold_no_more_problems_than_are_known(shared_data: Path) -> None:
    found: dict[str, dict[str, int]] = {}
    for folder in FOLDERS:
        for path in sorted((shared_data / folder).iterdir()):
            log = read_log(path)
            if log.sentences and log.problems:
                found[path.name] = {problem.kind: problem.count for problem in log.problems}
    assert found == {
        "gpsd-ais-18-27.log": {"ais_payload": 69},  # type 24 with a part number that does not exist
        "gpsd-sample.aivdm": {"no_sentence": 1},
        "libais-test.aivdm": {"ais_short": 7},
        "pyais-nmea_data_sample.txt": {"ais_empty": 100, "ais_incomplete": 20},
        "RadarLogs.txt": {"no_checksum": 1},  # the recording stops in the middle of a sentence
    }


def test_every_ttm_of_the_semi_real_logs_is_a_report(shared_data: Path) -> None:
    for name in (
        "dense_sf",
        "coastal_hakefjord",
        "moored_harlingen_atons",
        "marce_01_001",
        "marce_01_004",
        "marce_01_010",
    ):
        log = read_log(shared_data / FILES[name])
        reports = log.of(TargetReport)
        assert len(reports) == log.counts["TTM"]
        assert {report.bearing_reference for report in reports} == {"relative"}
        assert {report.source for report in reports} == {"RA0001"}
        assert log.of(OwnPosition) == ()
        assert log.of(OwnHeading) == ()
        assert (log.time_basis, log.time_known) == ("reception", True)
        times = [record.time_s for record in log.records]
        assert None not in times
        assert times == sorted(times)  # type: ignore[type-var]


def test_a_simrad_radar_on_the_swedish_coast(shared_data: Path) -> None:
    log = read_log(shared_data / FILES["RadarLogs.txt"])
    first = log.of(TargetReport)[0]
    assert (first.number, first.status, first.name) == (1, "T", "1 (Broadband 4G - 2782 B)")
    assert (first.range_m, first.bearing_deg, first.bearing_reference) == (0.48 * 1852.0, 263.6, "true")
    assert (first.utc_of_day_s, first.time_s) == (49561.0, 1438004761.0)
    assert first.range_resolution_m == pytest.approx(18.52)
    assert log.of(OwnHeading)[0].variation_deg == 2.9
    times = [record.time_s or 0.0 for record in log.records]
    assert times == sorted(times)
    assert times[-1] - times[0] == pytest.approx(2432.0, abs=1.0)  # 40 min at 1 Hz
    late = [
        report.time_s % 86400.0 - report.utc_of_day_s
        for report in log.of(TargetReport)
        if report.time_s and report.utc_of_day_s
    ]
    assert Counter(late).most_common(2) == [(0.0, 889), (-1.0, 576)]
    assert len(late) == 1466  # and one sentence that is 798 s ahead of all others


def test_a_yacht_race_off_san_francisco(shared_data: Path) -> None:
    log = read_log(shared_data / FILES["PacCupStart.txt"])
    assert log.time_basis == "sentence"
    assert {settings.range_scale_m for settings in log.of(RadarSettings)} >= {1.5 * 1852.0}
    assert Counter(heading.sentence for heading in log.of(OwnHeading)) == {"HDM": 2212, "VHW": 2212}
    assert Counter((speed.sentence, speed.from_gnss) for speed in log.of(OwnSpeed)) == {
        ("VTG", True): 1106,
        ("VHW", False): 2209,
    }


def test_own_ship_of_a_transponder_is_marked(shared_data: Path) -> None:
    log = read_log(shared_data / FILES["hakan.txt"])
    own = [report for report in log.of(AisPosition) if report.own]
    assert len(own) + sum(static.own for static in log.of(AisStatic)) == 1309
    assert len({report.mmsi for report in own}) == 1
    assert own[0].mmsi not in {report.mmsi for report in log.of(AisPosition) if not report.own}


def test_aids_to_navigation_real_and_virtual(shared_data: Path) -> None:
    aids = {
        r.mmsi: r
        for r in read_log(shared_data / "ais_vectors/gpsd-ais-nmea-type6-fid55.log").of(AisPosition)
        if r.kind == "aton"
    }
    assert len(aids) > 20
    assert {aid.virtual for aid in aids.values()} == {True, False}
    merrimac = [r for r in read_log(shared_data / FILES["gofree-merrimac.log"]).of(AisPosition) if r.kind == "aton"]
    assert len(merrimac) == 77


def test_the_decoded_table_of_ais_is_no_nmea_and_no_error(shared_data: Path) -> None:
    log = read_log(shared_data / "ais_logs/SolentAIS_20160112_130211.csv")
    assert log.sentences == 0
    assert [(problem.kind, problem.count) for problem in log.problems] == [("no_sentence", 18624)]


def test_tll_alone_is_counted_and_gives_no_targets(shared_data: Path) -> None:
    log = read_log(shared_data / "radar_ttm/RATLL.txt")
    assert dict(log.counts) == {"TLL": 1466}
    assert log.of(TargetReport) == ()
    assert log.time_basis == "time_of_day"


def test_interleaved_parts_with_tag_groups(shared_data: Path) -> None:
    log = read_log(shared_data / "ais_vectors/libais-tagblock.nmea")
    (static,) = log.of(AisStatic)
    assert (static.time_s, static.source) == (1418169601.0, "rORBCOMM008")
    assert log.problems == ()
