"""Caustics by photon mapping: the light of beams that passes through refracting solids."""
