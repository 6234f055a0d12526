"""A page that shows what changed between two runs: pictures, numbers, and cells of one side."""
