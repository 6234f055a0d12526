"""Path-traced references: stored, cached and checked."""
