"""The Knopp thesis's own association: plain rigid CPD from eight sides, outlier share preset, least error wins.

It stands beside the seeded method for comparison (thesis 2.2.4, 4.1.3, 4.2.2, 4.2.3) and always answers: it has no
means to tell when it is wrong. The evidence that it is given here is that of the seeded method at its pose.
"""

from __future__ import annotations

import numpy as np

from navfix.association import cpd, em, evidence, prior
from navfix.association.evidence import Judged
from navfix.association.prior import Prior
from navfix.association.scene import Scene
from navfix.association.seeds import Poses
from navfix.catalog import AssociationModel, CpdModel
from navfix.types import Epoch, FloatArray, HeadingHint, IntArray


def register_scene(scene: Scene, method: CpdModel, heading: HeadingHint | None = None) -> cpd.Registration:
    """Register the targets (centroids) onto the marks (data), one start when a heading is known and eight when not."""
    if heading is not None and scene.reference == "relative":
        turn = np.exp(1j * np.radians(heading.heading_deg))
        return cpd.register(scene.z, scene.rho, outlier_share=method.outlier_share, start_rotation=turn)
    found, _ = cpd.register_from_all_sides(scene.z, scene.rho, outlier_share=method.outlier_share, starts=method.starts)
    return found


def pairs_of(found: cpd.Registration, least_probability: float) -> tuple[IntArray, FloatArray]:
    """Return pairs (k, 2) of target and mark, each target's likeliest mark and each mark once, with P (k,)."""
    target = np.argmax(found.correspondence, axis=0)
    probability = found.correspondence[target, np.arange(found.correspondence.shape[1])]
    order = np.argsort(-probability, kind="stable")
    order = order[probability[order] >= least_probability]
    _, first = np.unique(target[order], return_index=True)
    mark = order[np.sort(first)]
    return np.column_stack([target[mark], mark]), probability[mark]


def judge(found: cpd.Registration, scene: Scene, model: AssociationModel, epoch: Epoch) -> tuple[Judged, Prior]:
    """Return what the seeded method's evidence says of the pose that was found."""
    field = em.Field(scene, model)
    known = prior.of(epoch, scene, field, model)
    pose = Poses(np.array([found.translation]), np.array([float(np.angle(found.rotation))]))
    _, information, _ = em.em_step(field, pose, 1.0)
    return evidence.judge(field, pose, information, known), known
