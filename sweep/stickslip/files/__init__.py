"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

What is where:

    writing, reading   datasets in netCDF and Zarr        seal   what the checksums of chunks do not cover
    chunks, filters    values into netCDF, compressed by threads
    atomic      the one way to replace a file             tables   the one reader of CSV
    machine     whose processes wrote a file              netcdf_lock   one thread at a time in netCDF
"""
