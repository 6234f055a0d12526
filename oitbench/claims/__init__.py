"""Claims of papers and projects, and what stored results say about each of them.

A claim is an entry of a data file, and names the trials that test it. A trial compares quantities
of methods in a results folder, and the verdict follows from its cases alone.
"""
