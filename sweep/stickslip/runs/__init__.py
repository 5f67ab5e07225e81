"""Runs of any size that survive interruption: working store, resume, shards, and the result put together at the end.

    session     run, retry_failed                          report       estimate, status, collect
    threads     missing blocks here, studies in memory     cluster      blocks on a Dask cluster, and its workers
    work        configuration and number of a block in, arrays out; what any worker calls
    block_store, formats   the store: its blocks; what its files hold, and who works on it
    output      a result at the same place, whose cells are taken over, and blocks into one result

`work.Work.compute` is pure, so that it does not matter who computes a block, when, or how often.
"""
