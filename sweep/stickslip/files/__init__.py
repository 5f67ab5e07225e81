"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

writing, reading   datasets in netCDF and Zarr        seal       digests of what the checksums of chunks do not cover
atomic, targets    files replaced; names checked      locations  paths and URLs, stores replaced behind the latter
chunks, netcdf_chunks, zarr_chunks   values into files chunk by chunk, compressed by threads
packing            the bytes of a chunk               netcdf_lock, lazy_duck_arrays   netCDF and xarray, tamed
tables, blocks, texts   the one reader of CSV         sniff, process   kinds of files; who wrote them
"""
