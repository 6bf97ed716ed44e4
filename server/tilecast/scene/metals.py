"""Complex indices of refraction of metals, real and imaginary part, at 650, 550 and 450 nm: what red, green and blue
stand for here. From the measurements that refractiveindex.info collects (Johnson and Christy 1972 and 1974, Rakic 1998,
Querry 1985 and others)."""

METALS: dict[str, tuple[list[float], list[float]]] = {
    "aluminium": ([1.3456, 0.96521, 0.61722], [7.4746, 6.3995, 5.3031]),
    "brass": ([0.444, 0.527, 1.094], [3.695, 2.765, 1.829]),
    "chromium": ([3.1071, 3.1812, 2.323], [3.3314, 3.3291, 3.135]),
    "copper": ([0.27105, 0.67693, 1.3164], [3.6092, 2.6248, 2.2921]),
    "gold": ([0.18299, 0.42108, 1.3734], [3.4242, 2.3459, 1.7704]),
    "iron": ([2.9114, 2.9497, 2.5845], [3.0893, 2.9318, 2.767]),
    "platinum": ([2.3757, 2.0847, 1.8453], [4.2655, 3.7153, 3.1365]),
    "silver": ([0.15943, 0.14512, 0.13547], [3.9291, 3.19, 2.3808]),
}
