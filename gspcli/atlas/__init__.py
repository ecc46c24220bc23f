"""The atlas: how the generic counts of all types are established, recorded and verified."""
