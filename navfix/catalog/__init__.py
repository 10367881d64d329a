"""The catalogue: models/*.toml -> validated records. Data live in the files, their meaning here."""

from __future__ import annotations

from navfix.catalog.ais import AisModel, ais_model
from navfix.catalog.association import (
    AssociationModel,
    CpdModel,
    TrackAssociationModel,
    association_method,
    association_model,
    track_association_model,
)
from navfix.catalog.charts import ChartModel, chart_model
from navfix.catalog.damping import kernel
from navfix.catalog.hulls import (
    EchoModel,
    HullModel,
    OutlineModel,
    echo_model,
    hull_model,
    hull_model_of,
    outline_model,
)
from navfix.catalog.loading import build, data_folder, every_table, kinds, names, read_table, table
from navfix.catalog.motion import FilterModel, PersistingModel, filter_model, motion_model, persisting_model
from navfix.catalog.navigation import (
    NavigatorModel,
    OwnMotionModel,
    RadarErrorsModel,
    navigator_model,
    own_motion_model,
    radar_errors_model,
)
from navfix.catalog.radar import RadarModel, radar_model
from navfix.catalog.tracking import (
    StitchingModel,
    TrackingModel,
    TrackModel,
    stitching_model,
    track_model,
    tracking_model,
)
from navfix.catalog.window import AdjustmentModel, WindowModel, adjustment_model, window_model

__all__ = [
    "AdjustmentModel",
    "AisModel",
    "AssociationModel",
    "ChartModel",
    "CpdModel",
    "EchoModel",
    "FilterModel",
    "HullModel",
    "NavigatorModel",
    "OutlineModel",
    "OwnMotionModel",
    "PersistingModel",
    "RadarErrorsModel",
    "RadarModel",
    "StitchingModel",
    "TrackAssociationModel",
    "TrackModel",
    "TrackingModel",
    "WindowModel",
    "adjustment_model",
    "ais_model",
    "association_method",
    "association_model",
    "build",
    "chart_model",
    "data_folder",
    "echo_model",
    "every_table",
    "filter_model",
    "hull_model",
    "hull_model_of",
    "kernel",
    "kinds",
    "motion_model",
    "names",
    "navigator_model",
    "outline_model",
    "own_motion_model",
    "persisting_model",
    "radar_errors_model",
    "radar_model",
    "read_table",
    "stitching_model",
    "table",
    "track_association_model",
    "track_model",
    "tracking_model",
    "window_model",
]
