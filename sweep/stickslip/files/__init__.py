"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

writing, reading   datasets in netCDF and Zarr        seal       digests of what the checksums of chunks do not cover
targets            files checked and replaced         locations  paths, folders, URLs
chunks, netcdf, zarr_chunks   values into files chunk by chunk, compressed by threads
tables, texts      the one reader of CSV              sniff      kinds of files
"""
