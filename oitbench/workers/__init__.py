"""Processes of our own that do risky work: they run plugins, drivers and long computations.

A crash, a hang or a lack of memory then costs one request and not the command. `process` is the
near end, which starts, asks and kills; `serve` is the far end, which answers. They exchange typed
messages, one JSON line each, over pipes.
"""
