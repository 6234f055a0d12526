"""Building blocks that several methods share, each beside its shaders."""
