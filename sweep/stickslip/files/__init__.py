"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

writing, reading   datasets in netCDF and Zarr        seal       digests of what the checksums of chunks do not cover
targets            files checked and replaced         locations  paths, folders, URLs
netcdf, filters    chunks into netCDF, compressed by threads      zarr_chunks   into Zarr
tables, texts, layout   the one reader of CSV         sniff      kinds of files
"""
