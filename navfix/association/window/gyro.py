"""The compass beside a window: evidence for the headings it agrees with, checked by the data and never simply believed.

As for one scan: a heading hint is right with probability 1 - q and worthless with q, eq. (6.8) of the theory. True
bearings hold a heading themselves; there the hint is that they are not turned.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from navfix.association.prior import Prior
from navfix.association.seeds import Poses
from navfix.association.window import jackknife, joint
from navfix.association.window.evidence import Answers
from navfix.association.window.jackknife import PoseAtEnd
from navfix.association.window.joint import Joint, Window
from navfix.association.window.tracks import epoch_time
from navfix.types import FloatArray
from navfix.units import wrap_pi


def cold(window: Window) -> Joint:
    """Find every own motion that explains the window, the compass as evidence where there is one; best first."""
    hint = heading_prior(window)
    near = partial(_plausible, window, hint) if hint.has_hint else None
    found = joint.cold(window, near)
    gained = gain(found, hint)
    if gained is None:
        return found
    evidence = found.answers.evidence + gained
    order = np.argsort(-evidence, kind="stable")
    return Joint(window, replace(found.answers, evidence=evidence).take(order))


def gain(found: Joint, hint: Prior) -> FloatArray | None:
    """Return what the hint adds to the evidence of each answer (k,) of a window, None where there is no hint."""
    if not hint.has_hint or not len(found.answers):
        return None
    return hint.log_gain(*_at_end(found.window, found.answers))


def price(window: Window) -> float:
    """Return what a wrong compass could feign of a lead [nats]: asked for in addition where there is one, else 0."""
    hint = heading_prior(window)
    return -math.log(hint.wrong_share) if hint.has_hint else 0.0


def heading_prior(window: Window) -> Prior:
    """Return what is known of own heading at the end of a window: the newest hint in it, or nothing."""
    scene, shared = window.field.scene, window.field.shared
    known = (0.0, math.radians(shared.compass_sigma_deg)) if scene.flat.reference == "true" else _newest_hint(window)
    if known is None:
        return Prior(window.prior.log_area, shared.hint_wrong_share)
    heading_rad, sigma_rad = known
    return Prior(
        window.prior.log_area,
        shared.hint_wrong_share,
        heading_rad=heading_rad,
        heading_sigma_rad=math.hypot(sigma_rad, math.radians(shared.alignment_sigma_deg)),
        origin=scene.flat.origin,
    )


def _newest_hint(window: Window) -> tuple[float, float] | None:
    """Return heading and sigma [rad] of the newest epoch that has a hint, turned by the yaw seen since."""
    yaw, end_rad = window.field.scene.yaw, window.field.scene.yaw_at_end
    for epoch in reversed(window.epochs):
        hint = epoch.heading_hint
        if hint is not None:
            since_rad = end_rad - yaw.at(epoch_time(epoch))
            return math.radians(hint.heading_deg) + since_rad, math.radians(hint.sigma_deg)
    return None


def _plausible(window: Window, hint: Prior, poses: Poses) -> np.ndarray:
    """Tell which poses (k,) of the gauge knot, in the de-rotated frame, are near the hint when laid at the end."""
    shape, gauge = window.null.shape, window.field.scene.gauge
    turn = float(shape.heading_rad[0, -1] - shape.heading_rad[0, gauge]) + window.field.scene.yaw_at_end
    return hint.plausible(Poses(poses.p, poses.heading_rad + turn))


def notes(window: Window, pose: PoseAtEnd) -> tuple[str, ...]:
    """Return what the pose found says of the hint: a sentence where it is refuted."""
    hint = heading_prior(window)
    if not hint.has_hint:
        return ()
    found = Poses(np.array([pose.p]), np.array([pose.heading_rad]))
    information = np.asarray(np.linalg.inv(pose.covariance), np.float64)[None]
    if hint.hint_holds(found, information)[0, 1] >= 0.5:
        return ()
    off_deg = math.degrees(wrap_pi((hint.heading_rad or 0.0) - float(hint.true_heading(found)[0])))
    source = "compass in the true bearings" if window.field.scene.flat.reference == "true" else "heading hint"
    return (f"The {source} is refuted: it is {off_deg:+.1f}° off.",)


def _at_end(window: Window, answers: Answers) -> tuple[Poses, FloatArray]:
    """Return the poses (k,) of answers at the end of the window and their information (k, 3, 3)."""
    p, heading_rad, _ = jackknife.at_end(window.field, answers.knots)
    formal = jackknife.formal_at_end(window.field, answers.information)
    return Poses(p, heading_rad + window.field.scene.yaw_at_end), np.asarray(np.linalg.inv(formal), np.float64)
