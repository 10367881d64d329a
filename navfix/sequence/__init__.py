"""Over time: the navigator that holds a place, dead reckoning, errors common to minutes, and a whole log smoothed."""
