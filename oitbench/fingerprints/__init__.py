"""Fingerprints: digests of everything that determines a result, so that a change is noticed.

scene : the values of a scene, rounded so that another processor gives the same.
sources : the text of source files, with neither comments nor docstrings.
code : methods, the engine and the metrics, by their sources.
"""
