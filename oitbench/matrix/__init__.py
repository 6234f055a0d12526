"""Running the benchmark matrix."""
