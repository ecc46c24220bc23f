"""The atlas: the evidence for the generic counts of all types, recorded and verified."""
