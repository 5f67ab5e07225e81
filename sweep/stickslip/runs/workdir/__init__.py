"""The working store of a run: finished blocks, safe against crashes.

What is where:

    block_store  the store: its blocks, finished and failed
    manifest    what it was made for          encoding   blocks as bytes
    folder      where it is kept: a folder, or any URL           lock   who works on it
"""
