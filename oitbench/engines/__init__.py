"""Other engines as rows beside the suite's methods: adapters, pictures, scores and ratios of time.

An adapter draws the transparent geometry of a scene with an engine that knows nothing of the suite.
`adapter` says what one is, `known` finds it by name, and `run` draws, scores and times its rows.
"""

from oitbench.engines.adapter import Algorithm, Content, Drawing, Engine, Surface

__all__ = ["Algorithm", "Content", "Drawing", "Engine", "Surface"]
