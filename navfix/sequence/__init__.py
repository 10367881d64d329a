"""Over time: dead reckoning between fixes, and a whole log smoothed."""
