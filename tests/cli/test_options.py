"""The options that commands share: their values, and inputs that are never overwritten."""

from __future__ import annotations

import argparse
from datetime import UTC, datetime
from pathlib import Path

import pytest

from navfix.catalog import radar_model
from navfix.cli import options, outputs
from navfix.cli.errors import CommandError
from navfix.errors import CatalogError


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(exit_on_error=False)
    options.add_log(parser)
    options.add_estimation(parser)
    options.add_evidence(parser)
    options.add_at(parser)
    options.add_window(parser)
    options.add_independent(parser)
    options.add_truth(parser)
    options.add_outlines(parser)
    options.add_output(parser)
    return parser


def _parse(*argv: str) -> argparse.Namespace:
    return _parser().parse_args(["log.nmea", *argv])


def test_defaults_are_those_of_the_library() -> None:
    args = _parse()
    assert (args.kernel, args.radar, args.heading_from) == ("hampel", "imo", "auto")
    assert (args.at, args.window, args.truth, args.outlines) == (None, None, None, None)
    assert (args.chart, args.out) == ([], [])
    assert (args.no_prior, args.independent, args.json) == (False, False, False)


@pytest.mark.parametrize(
    ("text", "time"),
    [
        ("2026-01-01T12:00:00Z", datetime(2026, 1, 1, 12, tzinfo=UTC)),
        ("2026-01-01T12:00:00", datetime(2026, 1, 1, 12, tzinfo=UTC)),
        ("2026-01-01T12:00:00.250+02:00", datetime(2026, 1, 1, 10, 0, 0, 250000, tzinfo=UTC)),
    ],
)
def test_at_is_utc_whatever_zone_it_is_given_in(text: str, time: datetime) -> None:
    assert _parse("--at", text).at == time
    assert _parse("--at", text).at.utcoffset().total_seconds() == 0.0


@pytest.mark.parametrize(
    "argv",
    [
        ["--at", "noon"],
        ["--at", "0001-01-01T00:00:00+14:00"],
        ["--range-sigma", "0"],
        ["--bearing-sigma", "-1"],
        ["--bearing-sigma", "nan"],
        ["--range-sigma", "inf"],
        ["--window", "abc"],
        ["--heading-from", "magic"],
        ["--out", "fix.bmp"],
        ["--out", "no/such/folder/fix.svg"],
    ],
)
def test_a_value_that_cannot_be_right_is_refused(argv: list[str]) -> None:
    with pytest.raises(argparse.ArgumentError):
        _parse(*argv)


def test_a_radar_sigma_replaces_the_one_of_the_model() -> None:
    imo = radar_model("imo")
    assert options.radar(_parse()) == imo
    coarse = options.radar(_parse("--range-sigma", "60", "--bearing-sigma", "2"))
    assert (coarse.range_sigma_m, coarse.range_sigma_fraction, coarse.bearing_sigma_deg) == (60.0, 0.0, 2.0)
    assert coarse.maximum_range_m == imo.maximum_range_m


def test_an_unknown_radar_is_named() -> None:
    with pytest.raises(CatalogError, match="'nope'"):
        options.radar(_parse("--radar", "nope"))


def test_an_input_is_never_overwritten(tmp_path: Path) -> None:
    log = tmp_path / "log.txt"
    log.write_text("precious")
    link = tmp_path / "link.txt"
    link.symlink_to(log)
    hard = tmp_path / "hard.txt"
    hard.hardlink_to(log)
    detour = tmp_path / "sub" / ".." / "log.txt"
    (tmp_path / "sub").mkdir()
    for out in (log, link, hard, detour):
        args = _parser().parse_args([str(log), "--out", str(out)])
        with pytest.raises(CommandError, match="never overwritten"):
            outputs.protect_inputs(args)
    assert log.read_text() == "precious"


@pytest.mark.parametrize("option", ["--truth", "--chart", "--outlines", "--kernel"])
def test_side_inputs_are_protected_too(tmp_path: Path, option: str) -> None:
    side = tmp_path / "side.json"
    side.write_text("{}")
    args = _parser().parse_args(["-", option, str(side), "--out", str(side)])
    with pytest.raises(CommandError, match="never overwritten"):
        outputs.protect_inputs(args)


def test_no_output_is_named_twice(tmp_path: Path) -> None:
    args = _parse("--out", str(tmp_path / "a.svg"), "--out", str(tmp_path / "." / "a.svg"))
    with pytest.raises(CommandError, match="named twice"):
        outputs.protect_inputs(args)


def test_outputs_beside_the_inputs_are_written(tmp_path: Path) -> None:
    args = _parse("--out", str(tmp_path / "a.svg"), "--out", str(tmp_path / "B.JSON"))
    outputs.protect_inputs(args)
    called: list[str] = []
    writers = {suffix: (lambda suffix=suffix: called.append(suffix) or suffix) for suffix in (".svg", ".json", ".html")}
    outputs.write_outputs(args.out, writers)
    assert called == [".svg", ".json"]
    assert (tmp_path / "a.svg").read_text() == ".svg"
    assert (tmp_path / "B.JSON").read_text() == ".json"


def test_a_file_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    folder = tmp_path / "late.svg"
    folder.mkdir()
    with pytest.raises(CommandError, match="cannot be written"):
        outputs.write_outputs([folder], {".svg": lambda: "x"})


def test_a_format_that_a_command_cannot_write_is_said_before_anything_is_written(tmp_path: Path) -> None:
    paths = [tmp_path / "a.svg", tmp_path / "a.gpx"]
    with pytest.raises(CommandError, match=r"cannot write \.gpx; it writes \.svg"):
        outputs.write_outputs(paths, {".svg": lambda: "x"})
    assert not list(tmp_path.iterdir())


def test_a_command_can_name_the_formats_it_writes() -> None:
    parser = argparse.ArgumentParser(exit_on_error=False)
    options.add_output(parser, (".txt",))
    assert parser.parse_args(["--out", "a.txt"]).out == [Path("a.txt")]
    with pytest.raises(argparse.ArgumentError, match=r"one of \.txt"):
        parser.parse_args(["--out", "a.svg"])


def test_the_file_behind_standard_input_is_never_overwritten(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log, other = tmp_path / "log.nmea", tmp_path / "other.nmea"
    log.write_text("sentences")
    other.write_text("more")
    with log.open(encoding="ascii") as stdin:
        monkeypatch.setattr("sys.stdin", stdin)
        with pytest.raises(CommandError, match="is an input file"):
            outputs.protect_inputs(_parser().parse_args(["-", "--out", str(log)]))
        outputs.protect_inputs(_parser().parse_args(["-", "--out", str(other)]))
        outputs.protect_inputs(_parser().parse_args(["elsewhere.nmea", "--out", str(log)]))


def test_the_mounting_of_the_radar_goes_into_its_model() -> None:
    args = _parse("--radar-antenna", "20,-3.5", "--alignment", "1.5,0.3", "--compass-sigma", "0.8")
    model = options.radar(args)
    assert (model.antenna_forward_m, model.antenna_starboard_m) == (20.0, -3.5)
    assert (model.alignment_deg, model.alignment_sigma_deg, model.compass_sigma_deg) == (1.5, 0.3, 0.8)
    assert options.radar(_parse()) == radar_model("imo")
    assert _parse("--gnss-antenna=-4,0").gnss_antenna == (-4.0, 0.0)


@pytest.mark.parametrize("value", ["20", "20,x", "1,2,3", "nan,1"])
def test_an_offset_is_two_finite_numbers(value: str) -> None:
    with pytest.raises(argparse.ArgumentError):
        _parse("--radar-antenna", value)


def test_an_alignment_with_a_negative_sigma_is_refused() -> None:
    with pytest.raises(CommandError, match="alignment"):
        options.radar(_parse("--alignment", "1,-1"))
