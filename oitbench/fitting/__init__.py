"""Fitting the parameters of a method to scenes: views and their errors, and the search."""
