"""Ready-made objects that several scenes share."""
