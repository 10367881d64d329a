"""``navfix targets`` and --outlines, from the command line."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from navfix.cli import main


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a minute of the shipped recording."""
    lines = (Path(__file__).resolve().parents[2] / "data/logs/approach.nmea").read_text(encoding="ascii").splitlines()
    path = tmp_path_factory.mktemp("log") / "short.nmea"
    path.write_text("\n".join(lines[: len(lines) // 3]) + "\n", encoding="ascii")
    return path


def test_the_list_is_printed_and_written_in_every_format(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [tmp_path / f"ships{suffix}" for suffix in (".txt", ".json", ".csv", ".geojson")]
    argv = ["targets", str(log), "--filter", "20", *(word for file in files for word in ("--out", str(file)))]
    assert main(argv) == 0
    text = capsys.readouterr().out
    assert "RADAR AND AIS" in text
    assert text == files[0].read_text(encoding="utf-8")
    content = json.loads(files[1].read_text(encoding="utf-8"))
    assert (content["schema"], content["status"]) == ("navfix.targets/1", "fused")
    with files[2].open(encoding="utf-8", newline="") as lines:
        assert len(list(csv.DictReader(lines))) == len(content["targets"])
    assert json.loads(files[3].read_text(encoding="utf-8"))["type"] == "FeatureCollection"


def test_grey_pairs_of_tracks_are_mostly_those_of_the_fix(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pairs = {}
    for pairing in ("fix", "grey"):
        assert main(["targets", str(log), "--filter", "30", "--json", "--pairing", pairing]) == 0
        ships = json.loads(capsys.readouterr().out)["targets"]
        pairs[pairing] = {(s["target"], s["mark"]) for s in ships if s["sensor"] == "fused"}
    assert len(pairs["fix"] & pairs["grey"]) >= 0.7 * len(pairs["fix"]) > 5
    assert main(["targets", str(log), "--filter", "20", "--pairing", "grey"]) == 0
    assert "pairs by the grey relation of the tracks, to compare" in capsys.readouterr().out
    assert main(["targets", str(log), "--filter", "5", "--pairing", "grey"]) == 2
    assert "--filter must be 20 s at least" in capsys.readouterr().err


def test_find_shows_one_ship_and_says_when_there_is_none(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["targets", str(log), "--filter", "0", "--json"]) == 0
    fused = next(s for s in json.loads(capsys.readouterr().out)["targets"] if s["sensor"] == "fused")
    assert main(["targets", str(log), "--filter", "0", "--json", "--find", str(fused["mmsi"])]) == 0
    (found,) = json.loads(capsys.readouterr().out)["targets"]
    assert found == fused
    assert main(["targets", str(log), "--filter", "0", "--find", "NO SUCH SHIP"]) == 2
    assert "no target, MMSI or name like this" in capsys.readouterr().err


def test_without_a_fix_both_lists_are_printed_with_the_reason_and_code_3(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    few = tmp_path / "few.nmea"
    lines = log.read_text(encoding="ascii").splitlines()
    keep = [line for line in lines if "TTM,0" in line or "TTM,1," in line or "AIVDM" in line][:400]
    few.write_text("\n".join(keep[:60]) + "\n", encoding="ascii")
    code = main(["targets", str(few), "--filter", "0"])
    out, err = capsys.readouterr()
    assert code == 3
    assert "NOT FUSED: no fix" in out
    assert "RADAR ONLY" in out
    assert "AIS ONLY" in out
    assert err.count("\n") == 1


def test_outlines_beside_a_log_are_used_and_bad_lines_told(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fix", str(log), "--json"]) == 0
    plain = json.loads(capsys.readouterr().out)
    seen = {o["target"]: o["observed"] for o in plain["observations"] if o["kind"] == "range"}
    bearing = {o["target"]: o["observed"] for o in plain["observations"] if o["kind"] == "relative_bearing"}
    target = max(seen, key=lambda label: seen[label])
    range_m, bearing_deg = seen[target], bearing[target]
    points = [[range_m + 40.0, bearing_deg - 0.1], [range_m + 60.0, bearing_deg], [range_m + 50.0, bearing_deg + 0.1]]
    outlines = tmp_path / "outlines.jsonl"
    outlines.write_text(
        "rubbish\n"
        + json.dumps(
            {"time_utc": plain["time_utc"], "target": target, "points": points, "bearing_reference": "relative"}
        )
        + "\n",
        encoding="utf-8",
    )
    assert main(["fix", str(log), "--json", "--outlines", str(outlines)]) == 0
    out, err = capsys.readouterr()
    again = {o["target"]: o["observed"] for o in json.loads(out)["observations"] if o["kind"] == "range"}
    assert again[target] == pytest.approx(range_m + 50.0, abs=0.01)
    assert "1 lines were not used: 1 x not JSON" in err
    assert main(["replay", str(log), "--every", "20", "--outlines", str(outlines)]) == 0
    capsys.readouterr()


def test_missing_and_empty_outlines_end_with_4(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    empty = tmp_path / "none.jsonl"
    empty.write_text("", encoding="utf-8")
    for path, words in ((tmp_path / "gone.jsonl", "no such file"), (empty, "no echo outline")):
        assert main(["fix", str(log), "--outlines", str(path)]) == 4
        assert words in capsys.readouterr().err
