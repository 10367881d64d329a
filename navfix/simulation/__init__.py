"""A seeded world: scenarios to NMEA logs with truth (`scenario`, `files`), and scenes of one instant (`scenes`)."""
