"""Machines in the files of other programs: bodies and joints in, an instance out.

``source``, ``markup`` and ``readers/`` (one file a format) make a `graph.Graph` of
a file; ``clusters``, ``structure``, ``candidates``, ``kinds``, ``chain_constraints``,
``driven_values`` and ``recognition`` find the six constraints in it; ``instances`` writes them.
"""
