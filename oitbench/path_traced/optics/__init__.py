"""How surfaces reflect, refract, scatter and absorb light."""
