"""The methods, scenes and reports of all collections, described by a worker that loads their files.

The process that asks never runs code of a plugin: a file that crashes, hangs or ends the process
when it is loaded is only a broken entry.
"""
