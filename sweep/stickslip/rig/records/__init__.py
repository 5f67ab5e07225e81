"""Records of a rig: read from people's files, or made from arrays; their samples."""
