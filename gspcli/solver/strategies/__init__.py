"""Ways to the poses of a platform, those of one sort in a file.

The first strategies (`gspcli.solver.all_poses.first_strategies`) are functions of a platform. They
yield ends of paths, or solutions in closed form, for all choices of sides, and know neither proofs
nor counts: the ledger proves what the kernel can. The further strategies (`FURTHER` in
`gspcli.solver.strategies.further`) are functions of the proved poses for one choice of sides. They
add poses to these, and yield whenever these may be all.
"""
