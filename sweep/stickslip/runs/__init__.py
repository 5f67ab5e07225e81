"""Runs of any size that survive interruption: working store, resume, shards, and the result put together at the end.

    session     run, retry_failed        collecting  collect, status
    threads, dask/   missing blocks here, or on a cluster          assembly    blocks into one result
    work        configuration and number of a block in, arrays out; what any worker calls
    workdir/    the store: manifest, encoding of blocks, lock
    existing_output  a result at the same place; known_cells: its cells

`work.Work.compute` is pure, so that it does not matter who computes a block, when, or how often.
"""
