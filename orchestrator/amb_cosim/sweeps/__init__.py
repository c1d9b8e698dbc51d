"""Sweeps: thousands of runs of a scenario over a grid or a sample of its values, on Dask, into one Zarr store.

`axes` reads what is varied and `sampling` makes points of it. `engine` hands batches of them to the processes of a Dask
cluster, where `worker` runs them; `store` keeps what they lead to, so that a sweep that was ended goes on where it
was. `refine` looks for the boundary between outcomes; `adaptive` chooses points by the Gaussian process of `surrogate`,
and `adaptive_run` runs them; `maps` and `phases` draw what came out, `figures` calls both, `summary` tells it; `ready`
has sweeps by name.
"""
