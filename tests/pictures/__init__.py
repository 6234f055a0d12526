"""Pictures of every effect and of every parameter value on tiny scenes, and their committed means.

========== =====================================================================
module     holds
========== =====================================================================
scenes     tiny scenes, in which each effect and each branch of shading matters
cells      the cells, derived from what methods declare
render     the means of all cells, and the branches of shaders that they reach
branches   branches of the preprocessor in GLSL
committed  the committed means, and the tolerances
========== =====================================================================
"""
