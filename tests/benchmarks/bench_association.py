"""The association, counted: `python tests/benchmarks/bench_association.py [TABLE ...] [--scenes N]`.

Tables: methods, speed, determinable, random, nothing, mirrored, rows, lines, shifted, misfit, bound, growth, lengths,
switches, recordings, foreign. All seeded; ``--first`` shifts the seeds, so that a long table can be counted in parts.
"""

from __future__ import annotations

import argparse
import math
import time
import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from navfix.association import acceptance, ambiguity, cpd, seeded, warm_start
from navfix.association import scene as scenes
from navfix.association.epoch import associate
from navfix.association.pair_index import PairIndex
from navfix.catalog import AssociationModel, association_model, radar_model
from navfix.errors import Ambiguous, NoAgreement, NoFix
from navfix.geodesy import LocalPlane, direct, inverse
from navfix.simulation.scenes import MadeScene, SceneRecipe, make_scene
from navfix.types import Epoch, HeadingHint, Mark, Position, PositionHint, RadarTarget
from navfix.units import NM_M, wrap_180

FIRST = 0
MODEL, RADAR = association_model(), radar_model("imo")
SCENES = {
    "20 x 24, same disc": SceneRecipe(20, 24, 12.0, 12.0),
    "20 x 40, 12/16": SceneRecipe(20, 40, 12.0, 16.0),
    "30 x 150, 10 % + 5 %": SceneRecipe(30, 150, 12.0, 24.0, 0.1, 0.05),
    "30 x 120, 40 % + 20 %": SceneRecipe(30, 120, 12.0, 24.0, 0.4, 0.2),
    "60 x 300, 30 % + 10 %": SceneRecipe(60, 300, 12.0, 24.0, 0.3, 0.1),
    "100 x 1000, 40 % + 20 %": SceneRecipe(100, 1000, 12.0, 36.0, 0.4, 0.2),
    "10 x 100": SceneRecipe(10, 100, 12.0, 24.0),
    "8 x 40, 25 % + 10 %": SceneRecipe(8, 40, 12.0, 24.0, 0.25, 0.1),
}


def is_right(made: MadeScene, position: Position, heading_deg: float) -> bool:
    """The same place as the truth: within 300 m and 2 deg, or within five sigma of the bound."""
    bound_m = 300.0 if made.crlb is None else max(300.0, 5.0 * math.sqrt(np.trace(made.crlb[:2, :2])))
    bound_deg = 2.0 if made.crlb is None else max(2.0, 5.0 * math.degrees(math.sqrt(made.crlb[2, 2])))
    return inverse(position, made.position)[0] <= bound_m and abs(wrap_180(heading_deg - made.heading_deg)) <= bound_deg


def searched(made: MadeScene, model: AssociationModel = MODEL) -> tuple[seeded.Search, scenes.Scene]:
    scene = scenes.build(made.epoch, RADAR, model)
    return seeded.search(scene, model, epoch=made.epoch), scene


def row_is_right(made: MadeScene, found: seeded.Search, scene: scenes.Scene, row: int) -> bool:
    answers = found.answers
    position = scenes.position_of(scene, complex(answers.poses.p[row]))
    return is_right(made, position, math.degrees(answers.poses.heading_rad[row]))


# ------------------------------------------------------------------------------------------------------------ tables


def methods(count: int) -> Iterator[str]:
    """The thesis's eight starts (ours), ICP from eight sides, cliques and the seeded method, on every scene."""
    few = max(5, count // 20)
    yield _row("scene", "8 starts", "ICP 8", "cliques", "seeded")
    for name, recipe in SCENES.items():
        made = [make_scene(recipe, 10_000 + seed) for seed in range(few)]
        source = [associate(m.epoch, method="cpd") for m in made]
        by_source = np.mean([is_right(m, a.position, a.heading_deg) for m, a in zip(made, source, strict=True)])
        by_icp = np.mean([_by_icp(m) for m in made])
        by_clique = np.mean([_by_clique(m) for m in made]) if recipe.targets * recipe.marks <= 800 else math.nan
        found = [searched(m) for m in made]
        by_seeds = np.mean([row_is_right(m, f, s, 0) for m, (f, s) in zip(made, found, strict=True)])
        yield _row(name, *(f"{share:.0%}" for share in (by_source, by_icp, by_clique, by_seeds)))


def speed(count: int) -> Iterator[str]:
    """CPU milliseconds against pycpd's eight starts, in the units that it may be given, measured in turns.

    pycpd's tolerance and start are absolute, so that its work depends on the units: in metres it stops at once, having
    matched nothing.
    """
    few = max(3, count // 40)
    yield "ours with the index of mark pairs kept; warm from a hint 400 m and 2 deg off; pycpd's eight starts"
    yield _row("scene", "index", "ours", "warm", "km", "metres", "degrees", "/km", "/metres", "/degrees", "warm/km")
    for name, recipe in SCENES.items():
        table = np.array([_speeds(make_scene(recipe, 11_000 + seed)) for seed in range(few)])
        index, ours, warm, *theirs = np.nanmedian(table, axis=0)
        ratios = [f"1/{their / ours:.0f}" for their in theirs]
        times = (f"{ms:.1f}" for ms in (index, ours, warm))
        yield _row(name, *times, *(f"{their:.0f}" for their in theirs), *ratios, f"1/{theirs[0] / warm:.0f}")


def _speeds(made: MadeScene) -> tuple[float, ...]:
    """Return CPU ms of the index, of the search with it, of a warm search, and of pycpd in km, metres and degrees."""
    scene = scenes.build(made.epoch, RADAR, MODEL)
    index, index_ms = _timed(lambda: PairIndex.of(scene.z, 2.0 * scene.radar_range_m))
    assert isinstance(index, PairIndex)
    near = replace(
        made.epoch,
        position_hint=PositionHint(direct(made.position, 70.0, 400.0), 500.0),
        heading_hint=HeadingHint(made.heading_deg + 2.0, 3.0),
    )
    ours_ms = min(
        _timed(lambda: seeded.search(scenes.build(made.epoch, RADAR, MODEL), MODEL, index=index))[1] for _ in range(5)
    )
    found, warm_ms = _timed(lambda: warm_start.search(scenes.build(near, RADAR, MODEL), MODEL, near))
    warm_ms = min(
        warm_ms, *(_timed(lambda: warm_start.search(scenes.build(near, RADAR, MODEL), MODEL, near))[1] for _ in "1234")
    )
    units_m = (1000.0, 1.0, 60.0 * NM_M)
    return index_ms, ours_ms, warm_ms if found else math.nan, *(_pycpd_ms(scene, unit_m) for unit_m in units_m)


def determinable(count: int) -> Iterator[str]:
    """Every scene whose predicted evidence is above 5: is the right place the best, or accepted?"""
    yield _row("scene", "scenes", "determin.", "solved", "accepted", "wrong")
    for name, recipe in SCENES.items():
        solved = accepted = wrong = total = 0
        for seed in range(FIRST, FIRST + count):
            made = make_scene(recipe, seed)
            found, scene = searched(made)
            right = row_is_right(made, found, scene, 0)
            taken = _is_accepted(found)
            wrong += taken and not right
            if made.predicted_evidence > 5.0:
                total, solved, accepted = total + 1, solved + right, accepted + taken
        shares = (f"{share / max(total, 1):.2%}" for share in (solved, accepted))
        yield _row(name, count, total, *shares, wrong)


def random(count: int) -> Iterator[str]:
    """Random scenes, a quarter without any solution: accepted, wrong, and the reliability of probability_wrong."""
    rows = []
    for seed in range(FIRST, FIRST + count):
        made = make_scene(random_recipe(np.random.default_rng(seed + 10**6)), seed)
        if len(made.epoch.targets) < 3:
            continue
        found, scene = searched(made)
        decision = acceptance.decide(found, MODEL)
        rows.append(
            (
                made.predicted_evidence,
                made.predicted_if_uniform,
                ambiguity.probability_of_accident(decision.evidence, MODEL)
                + ambiguity.probability_of_rival(decision.margin, MODEL),
                decision.reason is None,
                row_is_right(made, found, scene, 0),
                found.answers.ships[0],
                seed,
            )
        )
    table = np.array(rows, dtype=np.float64)
    predicted, uniform, wrong_p, taken, right, marks, seeds = table.T
    taken, right = taken > 0, right > 0
    wrong = int((taken & ~right).sum())
    limit = _most_wrong(wrong, int(taken.sum()))
    yield f"{len(table)} scenes, {taken.sum()} accepted, {wrong} of them wrong: at most {limit}"
    for row in np.flatnonzero(taken & ~right):
        yield f"wrong: seed {seeds[row]:.0f}, stated {wrong_p[row]:.1e}, predicted evidence {predicted[row]:.1f}"
    for low, high in BANDS:
        band = (predicted > low) & (predicted <= high)
        yield (
            f"predicted evidence {low:>5} .. {high:>4}: {band.sum():>6} scenes, accepted {taken[band].mean():.1%}, "
            f"best right {right[band].mean():.1%}"
        )
    beyond = uniform > 12.0
    yield f"if marks lay anywhere alike  12 ..  inf: {beyond.sum():>6} scenes, accepted {taken[beyond].mean():.1%}"
    yield "stated P(wrong)      answers   counted wrong   mean stated"
    for low, high in ((0.0, 1e-4), (1e-4, 1e-3), (1e-3, 1e-2), (1e-2, 0.1), (0.1, 0.5), (0.5, 9.9)):
        band = (wrong_p > low) & (wrong_p <= high) & (marks >= 3)
        if band.any():
            yield (
                f"{low:>8g} .. {high:<8g}{band.sum():>7}{np.mean(~right[band]):>16.5f}"
                f"{np.minimum(wrong_p[band], 1.0).mean():>14.5f}"
            )


BANDS = ((-math.inf, 0.0), (0.0, 5.0), (5.0, 12.0), (12.0, math.inf))


def _most_wrong(wrong: int, answers: int) -> str:
    """Return the 95 % upper limit of a probability that was counted (Clopper-Pearson)."""
    from scipy.special import betaincinv

    return f"{betaincinv(wrong + 1.0, max(answers - wrong, 1), 0.95):.1e} (95 %)"


def nothing(count: int) -> Iterator[str]:
    """No common target at all."""
    taken = 0
    for seed in range(FIRST, FIRST + count):
        recipe = replace(random_recipe(np.random.default_rng(seed + 2 * 10**6)), clutter=1.0)
        try:
            associate(make_scene(recipe, seed).epoch)
            taken += 1
        except NoFix:
            pass
    yield f"{count} scenes without a common target: {taken} accepted"


def mirrored(count: int) -> Iterator[str]:
    """Bearings counted the wrong way round: accepted, and what would be without the search of the mirror image."""
    base = SceneRecipe(16, 40, 8.0, 12.0)
    yield _row("scene", "scenes", "accepted", "unmended")
    for name, recipe in {
        "16 x 40": base,
        "16 x 40, lanes": replace(base, layout="lanes"),
        "16 x 40, anchorages": replace(base, layout="anchorages"),
        "16 x 40, 20 % + 5 %": replace(base, clutter=0.2, false_ais=0.05),
        "25 x 80": SceneRecipe(25, 80, 12.0, 20.0),
    }.items():
        taken = without = 0
        for seed in range(FIRST, FIRST + count):
            epoch = make_scene(recipe, seed).epoch
            targets = tuple(replace(t, bearing_deg=-t.bearing_deg) for t in epoch.targets)
            if len(targets) < 3:
                continue
            scene = scenes.build(replace(epoch, targets=targets), RADAR, MODEL)
            decision = acceptance.decide(seeded.search(scene, MODEL), MODEL)
            taken += decision.reason is None
            without += decision.reason in (None, "mirror")
        yield _row(name, count, taken, without)


def lines(count: int) -> Iterator[str]:
    """Echoes of one line (quay, row of aids) against the marks of another of the same kind: nothing is right."""
    plane = LocalPlane(Position(54.0, 8.0))
    yield _row("line: marks, echoes, m apart", "scenes", "accepted")
    for number, (marks, echoes, least_m, most_m, across_m, kind) in enumerate(LINES):
        taken = 0
        for seed in range(FIRST, FIRST + count):
            generator = np.random.default_rng((seed, number))
            here, there = (
                np.cumsum(generator.uniform(least_m, most_m, size)) + 1j * generator.normal(0.0, across_m, size)
                for size in (marks, echoes)
            )
            there = there - there[echoes // 2].real + 1j * generator.uniform(-3000.0, 3000.0)
            away = 12000.0 * np.sqrt(generator.uniform(size=15)) * np.exp(2j * np.pi * generator.uniform(size=15))
            epoch = Epoch(
                None,
                tuple(
                    RadarTarget(
                        f"{k}",
                        max(30.0, abs(z) + 20.0 * generator.normal()),
                        math.degrees(np.angle(z)) + 0.5 * generator.normal(),
                    )
                    for k, z in enumerate(there)
                ),
                tuple(
                    Mark(f"{k}", plane.to_position(z.real, z.imag), 15.0, kind=kind)
                    for k, z in enumerate(np.concatenate([here, away]))
                ),
            )
            try:
                associate(epoch)
                taken += 1
            except NoFix:
                continue
        yield _row(f"{kind} {marks}, {echoes}, {least_m:.0f}-{most_m:.0f} +- {across_m:.0f}", count, taken)


LINES = (
    (25, 12, 60.0, 220.0, 8.0, "ship"),
    (40, 20, 40.0, 120.0, 5.0, "ship"),
    (30, 12, 500.0, 1200.0, 30.0, "ship"),
    (12, 7, 600.0, 2200.0, 8.0, "aton"),
    (12, 7, 600.0, 2200.0, 60.0, "aton"),
    (20, 10, 400.0, 1500.0, 20.0, "aton"),
    (16, 9, 900.0, 1000.0, 10.0, "aton"),
)


def rows(count: int) -> Iterator[str]:
    """Regular buoy rows, single and double: every answer listed, none picked, and the step between them."""
    plane = LocalPlane(Position(54.0, 8.0))
    single = [plane.to_position(0.0, k * NM_M) for k in range(12)]
    double = [plane.to_position(side, k * NM_M) for k in range(8) for side in (0.0, 400.0)]
    for name, places, first, last in (
        ("single row of 12, 6 seen", single, 3, 9),
        ("double row of 16, 8 seen", double, 4, 12),
    ):
        picked, listed, with_truth, steps = 0, [], 0, []
        for seed in range(count):
            generator = np.random.default_rng(seed)
            own = plane.to_position(-900.0 + 200.0 * generator.normal(), 5.5 * NM_M if name[0] == "s" else 3.5 * NM_M)
            epoch = _epoch_of(places, own, 360.0 * generator.uniform(), range(first, last), generator)
            try:
                associate(epoch)
                picked += 1
            except (Ambiguous, NoAgreement) as refused:
                places_m = np.array([inverse(own, a.position)[0] for a in refused.alternatives])
                listed.append(len(places_m))
                with_truth += bool(places_m.min() < 300.0)
                steps.append(np.median(_nearest_m(refused)))
            except NoFix:
                listed.append(0)
        yield (
            f"{name}: {picked} of {count} picked one; {np.mean(listed):.1f} places listed, the truth among them in "
            f"{with_truth} of {count}, step {np.median(steps) / NM_M:.3f} NM"
        )


def shifted(count: int) -> Iterator[str]:
    """AIS positions shifted alike: alarm, also where four or more shifted ships carry an echo, and false alarms."""
    yield _row("share and shift", "answers", "refused", "alarm", "4+ seen", "alarm", "error m", "95 %", "in 3 sigma")
    for share, shift_m in ((0.2, 600.0), (0.2, 1500.0), (0.3, 600.0), (0.3, 1500.0), (0.3, 6000.0), (0.4, 1500.0)):
        recipe = SceneRecipe(40, 120, 12.0, 20.0, 0.2, share, coherent_m=shift_m)
        seen, alarms, errors_m = [], [], []
        for seed in range(FIRST, FIRST + count):
            made = make_scene(recipe, 50_000 + seed)
            try:
                found = associate(made.epoch)
            except NoFix:
                continue
            seen.append(round(0.8 * recipe.targets) - len(made.pairs))  # echoes of ships whose AIS is shifted
            alarms.append(found.second_group is not None)
            if found.second_group is not None:
                errors_m.append(abs(found.second_group.offset_m - shift_m))
        enough = np.array(seen) >= 4
        median, most = np.percentile(errors_m, [50, 95]) if errors_m else (math.nan, math.nan)
        within = np.mean(np.array(errors_m) <= 3.0 * SHIFT_SIGMA_M)
        yield _row(
            f"{share:.0%}, {shift_m:.0f} m", len(alarms), count - len(alarms), f"{np.mean(alarms):.1%}", enough.sum(),
            f"{np.mean(np.array(alarms)[enough]):.1%}", f"{median:.0f}", f"{most:.0f}", f"{within:.1%}",
        )  # fmt: skip
    false = answers = 0
    for seed in range(FIRST, FIRST + 5 * count):
        try:
            found = associate(make_scene(SceneRecipe(40, 120, 12.0, 20.0, 0.2, 0.1), 60_000 + seed).epoch)
        except NoFix:
            continue
        answers, false = answers + 1, false + (found.second_group is not None)
    yield f"nothing shifted alike: {false} false alarms in {answers} answers"


SHIFT_SIGMA_M = 60.0  # of the shift of a group of four to eight ships at some 6 NM


def misfit(count: int) -> Iterator[str]:
    """Noise larger than stated, AIS off one by one, ranges biased: refuse rather than lie."""
    base = SceneRecipe(30, 120, 12.0, 24.0, 0.3, 0.1)
    for name, recipe in (
        ("as stated", base),
        ("noise x 2", replace(base, noise_misfit=2.0)),
        ("noise x 3", replace(base, noise_misfit=3.0)),
        ("every AIS off by 200 m", replace(base, noise_misfit=1.0, mark_offset_m=200.0)),
        ("ranges + 150 m", replace(base, range_bias_m=150.0)),
    ):
        answers = wrong = 0
        for seed in range(count):
            made = make_scene(recipe, 70_000 + seed)
            try:
                found = associate(made.epoch)
            except NoFix:
                continue
            answers += 1
            wrong += inverse(found.position, made.position)[0] > 1000.0
        yield f"{name:<24} answers {answers / count:>6.1%}   wrong {wrong}"


def bound(count: int) -> Iterator[str]:
    """Position and heading of the association against the Cramer-Rao bound of the right pairs, and their NEES."""
    recipe = SceneRecipe(25, 80, 12.0, 20.0, 0.2, 0.05)
    squared, bounds, nees = [], [], []
    for seed in range(FIRST, FIRST + count):
        made = make_scene(recipe, 80_000 + seed)
        try:
            found = associate(made.epoch)
        except NoFix:
            continue
        if made.crlb is None:
            continue
        north_m, east_m = LocalPlane(made.position).to_plane(found.position)
        error = np.array([north_m, east_m, math.radians(wrap_180(found.heading_deg - made.heading_deg))])
        squared.append(error**2)
        bounds.append(np.diag(made.crlb))
        nees.append(error @ np.linalg.solve(found.covariance, error))
    ratio = np.sqrt(np.mean(squared, axis=0) / np.mean(bounds, axis=0))
    half = 1.96 * math.sqrt(6.0 / len(nees))
    yield f"{len(nees)} answers: RMSE / bound north {ratio[0]:.3f}, east {ratio[1]:.3f}, heading {ratio[2]:.3f}"
    yield f"NEES {np.mean(nees):.3f} (3 expected, 95 % band {3 - half:.3f} .. {3 + half:.3f})"


def growth(_: int) -> Iterator[str]:
    """Time and memory against the numbers of marks and targets."""
    yield f"{'targets':>8}{'marks':>7}{'ms':>8}{'peak MB':>9}"
    for targets, marks in ((60, 100), (60, 300), (60, 1000), (60, 2000), (20, 300), (200, 300)):
        made = make_scene(SceneRecipe(targets, marks, 12.0, 24.0, 0.2, 0.05), 7)
        times = [_timed(lambda made=made: searched(made))[1] for _ in range(5)]
        tracemalloc.start()
        searched(made)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        yield f"{targets:>8}{marks:>7}{np.median(times):>8.1f}{peak / 1e6:>9.1f}"


def switches(_: int) -> Iterator[str]:
    """What each part of the evidence brings on the recordings: answers, wrong ones, and answers to foreign AIS."""
    yield _row("without", "010 fixes", "004 fixes", "wrong", "foreign", "highest E")
    for name, change in (
        ("nothing", {}),
        ("speeds", {"use_speed": False}),
        ("missed detections", {"use_missed": False}),
        ("local clutter density", {"use_local_clutter": False}),
    ):
        model = replace(MODEL, **change)
        counted = [_solved_alone(f"marce/marce_01_{run}", model) for run in ("010", "004")]
        if not all(counted):
            yield "shared data absent"
            return
        fixes = (f"{len(off_m) / scans:.1%}" for scans, off_m in counted)
        total, accepted, highest = _mixed(model, thin=3)
        wrong = sum(sum(m > WRONG_M for m in off_m) for _, off_m in counted)
        yield _row(name, *fixes, wrong, f"{accepted}/{total}", f"{highest:.1f}")


def lengths(count: int) -> Iterator[str]:
    """What the size of echoes brings, where the radar tells it: scenes with lengths, counted with and without them."""
    recipe = SceneRecipe(14, 120, 12.0, 24.0, 0.4, 0.1, lengths=True)
    made = [make_scene(recipe, 90_000 + seed) for seed in range(count)]
    foreign = [make_scene(replace(recipe, clutter=1.0), 95_000 + seed) for seed in range(count)]
    yield _row("", "accepted", "wrong", "nothing", "first right")
    for name, model in (("with lengths", MODEL), ("without", replace(MODEL, use_length=False))):
        found = [searched(m, model) for m in made]
        taken = [_is_accepted(f, model) for f, _ in found]
        right = [row_is_right(m, f, s, 0) for m, (f, s) in zip(made, found, strict=True)]
        wrong = sum(t and not r for t, r in zip(taken, right, strict=True))
        nothing = sum(_is_accepted(searched(m, model)[0], model) for m in foreign)
        yield _row(name, f"{np.mean(taken):.1%}", wrong, nothing, f"{np.mean(right):.1%}")


def foreign(_: int) -> Iterator[str]:
    """Radar of one place with the AIS of another (needs the recordings beside the project)."""
    total, accepted, highest = _mixed(MODEL)
    yield f"{total} scans: {accepted} accepted; highest evidence refused {highest:.1f}"


def recordings(_: int) -> Iterator[str]:
    """Every second scan of the recordings alone, from nothing: answers and wrong ones (beyond 500 m)."""
    yield _row("recording", "scans", "answers", "wrong", "median m")
    for name in RECORDINGS:
        counted = _solved_alone(name, MODEL)
        if counted is not None:
            scans, off_m = counted
            wrong = sum(m > WRONG_M for m in off_m)
            yield _row(name, scans, f"{len(off_m) / scans:.1%}", wrong, f"{np.median(off_m):.0f}" if off_m else "-")


WRONG_M = 500.0

RECORDINGS = {
    "semi_real/dense_sf": 6,
    "semi_real/coastal_hakefjord": 4,
    "semi_real/moored_harlingen_atons": 1,
    "marce/marce_01_001": 2,
    "marce/marce_01_004": 2,
    "marce/marce_01_010": 4,
}
SHARED = Path(__file__).resolve().parents[3] / "shared" / "data"


@cache
def _epochs(name: str, every: int) -> tuple[Epoch, ...]:
    from navfix.nmea import read_log
    from navfix.picture import epochs

    log = SHARED / f"{name}.nmea"
    return tuple(epochs(read_log(log).records, every=every)) if log.is_file() else ()


def _solved_alone(name: str, model: AssociationModel) -> tuple[int, list[float]] | None:
    """Return how many scans have a truth, and how far off [m] each answer is."""
    from navfix.report.truth import TruthTrack

    if not _epochs(name, 2):
        return None
    with (SHARED / f"{name}_truth.csv").open() as lines:
        track = TruthTrack.parse(lines)
    scans, off_m = 0, list[float]()
    for epoch in _epochs(name, 2):
        truth = track.at(epoch.time_utc.timestamp()) if epoch.time_utc else None
        if truth is None:
            continue
        scans += 1
        try:
            found = associate(epoch, method=model)
        except NoFix:
            continue
        off_m.append(inverse(found.position, truth.position)[0])
    return scans, off_m


def _mixed(model: AssociationModel, thin: int = 1) -> tuple[int, int, float]:
    """Return scans of radar here with AIS from elsewhere, how many had an answer, the highest evidence refused."""
    taken = {name: [e for e in _epochs(name, step) if len(e.targets) >= 3] for name, step in RECORDINGS.items()}
    total, accepted, highest = 0, 0, -math.inf
    for radar, theirs in taken.items():
        for ais, others in taken.items():
            if radar == ais or (radar.startswith("marce") and ais.startswith("marce")):
                continue
            for k, epoch in enumerate(theirs[::thin]):
                total += 1
                try:
                    associate(replace(epoch, marks=others[(7 * k) % len(others)].marks), method=model)
                    accepted += 1
                except NoFix as error:
                    highest = max(highest, getattr(error, "evidence", -math.inf))
    return total, accepted, highest


# ----------------------------------------------------------------------------------------------------------- helpers


def _row(first: object, *others: object) -> str:
    return f"{first!s:<30}" + "".join(f"{other!s:>10}" for other in others)


def random_recipe(generator: np.random.Generator) -> SceneRecipe:
    return SceneRecipe(
        targets=int(np.exp(generator.uniform(math.log(5), math.log(50)))),
        marks=int(np.exp(generator.uniform(math.log(12), math.log(300)))),
        ais_nm=float(generator.choice([12.0, 18.0, 24.0, 36.0])),
        clutter=1.0 if generator.uniform() < 0.25 else float(generator.uniform(0.0, 0.6)),
        false_ais=float(generator.uniform(0.0, 0.2)),
        layout=str(generator.choice(["uniform", "anchorages", "lanes"], p=[0.5, 0.3, 0.2])),
        bearing_sigma_deg=float(generator.choice([0.5, 1.0])),
    )


def _is_accepted(found: seeded.Search, model: AssociationModel = MODEL) -> bool:
    return acceptance.decide(found, model).reason is None


def _timed(call: Callable[[], object]) -> tuple[object, float]:
    began = time.process_time()
    return call(), 1e3 * (time.process_time() - began)


def _xy(points: np.ndarray) -> np.ndarray:
    return np.column_stack([points.real, points.imag])


def _pycpd_ms(scene: scenes.Scene, unit_m: float) -> float:
    """Return the CPU ms of pycpd's eight starts with coordinates in ``unit_m`` (a degree is 60 nautical miles)."""
    import pycpd

    def eight_starts() -> None:
        for turn in np.exp(2j * np.pi * np.arange(8) / 8):
            pycpd.RigidRegistration(
                X=_xy(scene.z / unit_m), Y=_xy(turn * scene.rho / unit_m), w=0.1, scale=False
            ).register()

    return _timed(eight_starts)[1]


def _by_icp(made: MadeScene) -> bool:
    """Iterated closest point from eight sides, least mean distance wins."""
    from scipy.spatial import cKDTree

    scene = scenes.build(made.epoch, RADAR, MODEL)
    tree = cKDTree(_xy(scene.z))
    best = (math.inf, 0j, 0j)
    for turn in np.exp(2j * np.pi * np.arange(8) / 8):
        rotation, translation = turn, complex(scene.z.mean() - turn * scene.rho.mean())
        for _ in range(60):
            distance, nearest = tree.query(_xy(rotation * scene.rho + translation))
            matches = np.zeros((len(scene.rho), len(scene.z)))
            matches[np.arange(len(scene.rho)), nearest] = 1.0
            rotation, translation, _ = cpd.maximisation(scene.z, scene.rho, matches)
        best = min(best, (float(distance.mean()), rotation, translation), key=lambda tried: tried[0])
    position = scenes.position_of(scene, complex(best[2]))
    return is_right(made, position, math.degrees(float(np.angle(best[1]))))


def _by_clique(made: MadeScene) -> bool:
    """Subgraph matching: the largest clique of (target, mark) nodes whose distances agree (networkx, 2 s)."""
    import networkx

    scene = scenes.build(made.epoch, RADAR, MODEL)
    target, mark = np.divmod(np.arange(len(scene.rho) * len(scene.z)), len(scene.z))
    apart = np.abs(
        np.abs(scene.rho[target][:, None] - scene.rho[target]) - np.abs(scene.z[mark][:, None] - scene.z[mark])
    )
    agree = (apart < 150.0) & (target[:, None] != target) & (mark[:, None] != mark)
    graph = networkx.from_numpy_array(agree)
    began, best = time.perf_counter(), []
    for clique in networkx.find_cliques(graph):
        best = clique if len(clique) > len(best) else best
        if time.perf_counter() - began > 2.0:
            break
    if len(best) < 2:
        return False
    matches = np.zeros((len(scene.rho), len(scene.z)))
    matches[target[best], mark[best]] = 1.0
    rotation, translation, _ = cpd.maximisation(scene.z, scene.rho, matches)
    return is_right(made, scenes.position_of(scene, translation), math.degrees(float(np.angle(rotation))))


def _epoch_of(
    places: list[Position], own: Position, heading_deg: float, seen: range, generator: np.random.Generator
) -> Epoch:
    marks = tuple(Mark(f"buoy {k}", place, 10.0, kind="aton") for k, place in enumerate(places))
    polar = [inverse(own, places[k]) for k in seen]
    targets = tuple(
        RadarTarget(
            f"{k:02d}", r + 30.0 * generator.normal(), b - heading_deg + 0.5 * generator.normal(),
            range_sigma_m=30.0, bearing_sigma_deg=0.5,
        )
        for k, (r, b) in enumerate(polar)
    )  # fmt: skip
    return Epoch(None, targets, marks)


def _nearest_m(refused: Ambiguous | NoAgreement) -> list[float]:
    places = [a.position for a in refused.alternatives]
    return [min(d for d in (inverse(one, other)[0] for other in places) if d > 300.0) for one in places]


TABLES = {
    table.__name__: table
    for table in (
        methods,
        speed,
        determinable,
        random,
        nothing,
        mirrored,
        rows,
        lines,
        shifted,
        misfit,
        bound,
        growth,
        lengths,
        switches,
        recordings,
        foreign,
    )
}

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tables", nargs="*", choices=[*TABLES, []], default=[])
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    arguments = parser.parse_args()
    FIRST = arguments.first
    for name in arguments.tables or TABLES:
        print(f"\n{name}: {TABLES[name].__doc__}")
        for line in TABLES[name](arguments.scenes):
            print(line, flush=True)
