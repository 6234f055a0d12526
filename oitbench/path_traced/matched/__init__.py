"""The matched reference: exactly the light transport that a set of effects stands for.

Each effect is computed as it is, where OpenGL approximates it: true visibility instead of shadow
maps, true refraction instead of offsets on the screen, true integrals of the environment. Effects
that are left out have no ray. Light that no effect stands for is absent: no light travels between
diffuse surfaces, and mirrors show the environment alone.
"""
