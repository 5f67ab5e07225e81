"""Records of a rig: read from files, or made from arrays; their samples."""
