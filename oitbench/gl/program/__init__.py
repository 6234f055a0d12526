"""From a declaration and shaders to compiled passes."""
