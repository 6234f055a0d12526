"""Light on surfaces and in media, the same for every method."""
