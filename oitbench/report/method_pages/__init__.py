"""A page for each method: its docstring, its declaration as a diagram, promises and results."""
