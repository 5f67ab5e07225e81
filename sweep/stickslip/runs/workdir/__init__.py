"""The working store of a run: finished blocks, safe against crashes.

What is where:

    block_store  the store: its blocks, finished and failed
    manifest    what it was made for          encoding   blocks as bytes          lock   who works on it
"""
