"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

What is where:

    writing, reading   datasets in netCDF and Zarr        seal   what the checksums of chunks do not cover
    locations, remote  paths and URLs, and what is there  swapping   replacing a store behind a URL
    chunks, netcdf_chunks, zarr_chunks   values into files chunk by chunk, compressed by threads
    packing, filters   the bytes of a chunk                duck_arrays   xarray without imports nobody asked for
    atomic      the one way to replace a file             tables   the one reader of CSV
    machine     whose processes wrote a file              netcdf_lock   one thread at a time in netCDF
"""
