"""Sweeps: thousands of runs of a scenario over a grid or a sample of values, run on Dask and saved in a Zarr store.

`axes` reads the variations and `sampling` turns them into points. `engine` sends batches of points to the processes of
a Dask cluster, where `worker` runs them; `store` saves the results, so an interrupted sweep can resume. `refine`
locates the boundary between outcomes. `maps` and `phases` plot the results, `figures` calls both of them, and `summary`
prints the results. `ready` reads the named sweeps.
"""
