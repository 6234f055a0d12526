"""Results of a run: records, their folder, baselines and comparisons."""
