"""Ready-made objects that scenes share, one module for each kind.

============ ============================================================================
module       holds
============ ============================================================================
architecture columns, arched walls and street lamps
lettering    letters of flat strokes
people       standing people, limbs and hands
chessmen     the six chess pieces
glassware    drinking glasses, drinks and ice
teapot       the Utah teapot
leaves       plants of leaf cards
furniture    tables, chairs, plates, pots and oil lamps
engine_parts parts of a piston engine
============ ============================================================================

A new prop is a function that returns a `Mesh` in meters, standing on y = 0 at the origin. It takes
`detail` if it is curved.
"""
