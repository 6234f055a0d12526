"""The path-traced truth: Mitsuba renders the same `Scene` from the same sub-pixel positions."""
