"""Helpers for writing scenes.

============ ============================================================================
module       holds
============ ============================================================================
mesh         basic meshes: patches, boxes, surfaces of revolution, spheres
placement    transforms, copies at many places, merging
profiles     outlines with rounded corners, from which meshes are turned
solids       closed solids: turned or lofted
detail       how the size of a mesh follows the parameter `detail`
patterns     checkered surfaces
glass        transmission of solids that absorb light
sweeps       tubes along curves, cylinders, and plates cut from outlines
surroundings environment lights: skies, and rooms with windows
particles    clouds of soft particles: smoke
flames       light that is added: flames and sparks
baking       lighting baked into radiance at vertices
props        ready-made objects that scenes share, one module for each kind
============ ============================================================================

Anything that only one scene needs stays in the file of that scene.
"""
