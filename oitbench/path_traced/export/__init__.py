"""Export of a scene to Mitsuba: shapes, textures, materials without scattering, and the camera."""
