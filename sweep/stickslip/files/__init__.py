"""Files, whole or not at all: datasets written, read and sealed, tables that people hand in.

writing, reading   datasets in netCDF and Zarr        locations   paths, URLs, kinds of files
chunks             chunks packed, marked, stored      targets     files checked and replaced, folders
tables, texts, layout   the one reader of CSV
"""
