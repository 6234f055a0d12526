"""Frozen suites: all that determines an error, with digests, so that numbers of papers compare.

description : what a suite fixes, and its file
digests : of pixels, and of what metrics do
worker, describing : what this checkout has of a suite
freezing : writes the file of a suite; `python -m oitbench.suites.freezing NAME`
planning : the matrix of a suite, refused if this checkout differs
submission : whether a results folder is complete, unmodified and of a suite
"""
