"""Several epochs adjusted as one network: what stays is an unknown, what is new in each scan averages out."""

from navfix.adjustment.window.adjust import Solved, adjust_window, solve_window
from navfix.adjustment.window.prior import KnownPose
from navfix.adjustment.window.reading import Pairs

__all__ = ["KnownPose", "Pairs", "Solved", "adjust_window", "solve_window"]
