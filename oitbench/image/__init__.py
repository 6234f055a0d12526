"""Images: files, display encoding, and metrics."""
