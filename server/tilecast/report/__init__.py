"""Measures renders of one scene against each other.

    variation = parse_variation("render.accelerator=bvh,grid")
    report = compare("scene.json", variation)              # plain JSON values
    print(table(report))
"""
