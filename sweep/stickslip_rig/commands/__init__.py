"""The commands of rigs: `rig run`, `features`, `calibrate` and what they share."""
