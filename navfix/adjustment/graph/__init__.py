"""The adjustment as a factor graph: the only package that imports GTSAM; `epoch` for one scan, `window` for many."""

from navfix.adjustment.graph.epoch import GraphSolution, available, load, solve

__all__ = ["GraphSolution", "available", "load", "solve"]
