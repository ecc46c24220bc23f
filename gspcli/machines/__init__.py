"""Machines in the files of other programs: bodies and joints in, an instance out.

``source`` and ``readers/`` make a `graph.Graph` of a file; ``structure``, ``chain_constraints``
and ``recognition`` find the six constraints in it; ``api`` writes them.
"""
