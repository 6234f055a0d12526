"""Caustics by photon mapping."""
