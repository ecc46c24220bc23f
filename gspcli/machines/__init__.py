"""Machines in the files of other programs: bodies and joints in, an instance out.

``source`` and ``readers/`` make a `graph.Graph` of a file, ``recognition`` finds the six
constraints in it, and ``api`` writes them.
"""
