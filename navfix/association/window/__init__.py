"""The joint association of a window: minutes of tracks against the AIS picture, own motion unknown."""
