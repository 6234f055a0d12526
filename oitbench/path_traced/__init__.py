"""Path-traced references: Mitsuba renders a `Scene` at the same sub-pixel positions as OpenGL.

Each of these needs only the ones before it:

llvm : the variant of Mitsuba, and the LLVM library for it.
optics : formulas of surfaces, and physical quantities of materials.
export : a scene as shapes, textures and plugins of Mitsuba.
photons : caustics by photon mapping.
trace : lights, the medium and integrators; `trace.render` renders an image.
references : images that are stored, looked up, rendered on demand and checked.
"""
