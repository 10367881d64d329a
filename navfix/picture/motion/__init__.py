"""Motion models: where a mark is some seconds after its report, and how sure that is."""

from navfix.picture.motion.constant_velocity import Carried, carry

__all__ = ["Carried", "carry"]
