"""Measures renders of a scene: against the truth, over time, against each other. Plain JSON values and their tables.

    report = error_against_time("scene.json", seeds=6)     # curves: references, checkpoints, slope, labels
    print(curve_table(report))
    report = compare("scene.json", parse_variation("render.accelerator=bvh,grid"))   # measure: what each value costs
    print(table(report))
    calibrate(renders, seeds, samples)                     # calibration: do images know their own error?
    tessellation()                                         # spheres of triangles against the exact one
"""
