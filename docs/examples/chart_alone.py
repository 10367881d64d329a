"""A fix from radar and a chart alone: a simulated buoyed channel from which every AIS sentence is taken out."""

from pathlib import Path
from tempfile import TemporaryDirectory

from navfix import pipeline
from navfix.chart import marks, read_chart
from navfix.nmea import read_log
from navfix.simulation import files, scenario


def main() -> None:
    recording = scenario.simulate(scenario.load("buoyed_channel"), seed=1, duration_s=40.0)
    radar_only = [line for line in recording.lines if "VDM" not in line]
    with TemporaryDirectory() as folder:
        path = Path(folder) / "channel.csv"
        path.write_text(files.chart_csv(recording), encoding="ascii")
        charted = marks(read_chart(path).objects)

    epoch = next(pipeline.epochs(read_log(radar_only, name="channel"), charted=charted, last=True))
    answer = pipeline.answer(epoch)
    if answer.fix is None:
        print(f"no fix: {answer.error}")
        return
    ellipse = answer.fix.ellipse(0.95)
    print(f"{len(epoch.targets)} targets, {len(charted)} charted marks, {len(answer.fix.observations) // 2} pairs")
    print(f"position {answer.fix.position}")
    print(f"95 % ellipse {ellipse.semi_major_m:.0f} m x {ellipse.semi_minor_m:.0f} m")


if __name__ == "__main__":
    main()
