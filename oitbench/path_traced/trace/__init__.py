"""Integrators that follow rays through an exported scene, and the rendering of whole images."""
