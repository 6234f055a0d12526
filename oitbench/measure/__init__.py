"""What is measured of a frame: bytes, time, visibility; and the exact answer."""
