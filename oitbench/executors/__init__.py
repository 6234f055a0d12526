"""Where work is done: in this process, in processes of this machine, or by a Dask cluster.

`executor` has the interface: units of work go in, results come out as they finish, and work that is
lost with a worker is done by another one. `in_process`, `processes` and `cluster` are the three
ways, and `places` opens the one that a user asks for.
"""
