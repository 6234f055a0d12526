"""oitbench from Python, as in a notebook; PYTHON.md shows it.

running : `run`, `open` and `render`
outcome : what a run returns: a table, pictures and truths
gallery : pictures side by side, as a notebook shows them
scenes : scenes that were built in Python, as files that workers read
"""
