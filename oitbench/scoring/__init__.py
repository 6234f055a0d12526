"""Scores of stored images, by the metrics of the suite and by those of users' files."""
