"""Sentences -> epochs: everything brought to one instant and one point."""

from navfix.picture.picture import Picture, epochs

__all__ = ["Picture", "epochs"]
