"""Path-traced references: stored in files, looked up, rendered and checked."""
