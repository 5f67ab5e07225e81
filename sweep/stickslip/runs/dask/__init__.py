"""Blocks of a run computed by the workers of a Dask cluster.

    worker      what runs there: plain data in, plain data out
    connecting  a scheduler found, its workers held against this process
    dispatch    a bounded number of blocks in flight, and the outcome of each

Nothing is kept on the cluster. A worker that sees the store writes its blocks there; from others they are sent back
here.
"""
