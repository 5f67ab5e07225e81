"""Who computes the blocks of a run: threads of this process, or the workers of a Dask cluster."""
