"""Path tracing against Mitsuba 3: the same scenes, both on all cores, taking turns; prints the time to equal error.

    .venv/bin/python core/bench/mitsuba_compare.py [--runs 3] [--samples 16,64,256] [--json out/mitsuba.json]

Needs `pip install mitsuba scipy`, and for llvm_ad_rgb Debian's libllvm19. Same depth, box filter, light and materials. For each
scene both render a long reference. The squared error of an image I is the mean of (I - R1)(I - R2), R1 ours and R2
Mitsuba's: neither's noise biases it. Ours is rendered at powers of two of samples; where its error is the one that
Mitsuba has at 16, 64 and 256 samples follows by interpolation in log-log. Seconds are those of rendering alone: Mitsuba's
after a first run that compiles its kernels, ours `seconds.render`. The ratio is Mitsuba's time over ours at equal error.

Whether the images agree: the difference of the means of the two references, for each channel; and Student's t of two samples
of unequal variance (Welch) between the 32 independent parts of both, for each channel of 64 blocks of pixels, and of each
pixel of two rows, which both render again with 128 times the samples: by fewer, pixels where bright light is met now and then
are not distributed normally. The least p times their number is the family's.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import time
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import numpy as np

import tilecast
from tilecast.scene import images, transforms
from tilecast.scene.loading import load_document

SIZE, DEPTH, BLOCKS, PARTS = 256, 8, 8, 32
ROWS, MORE = (40, 170), 128  # whose pixels are compared one by one; samples there, in those of the whole image
SCENES = Path(__file__).resolve().parents[2] / "scenes"
for _library in ("/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1", "/usr/lib/llvm-19/lib/libLLVM.so.19.1"):
    if os.path.exists(_library):
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", _library)


_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])  # +z to +y, y to -z
# --- The scenes, in both languages

def cornell() -> tuple[dict, dict]:
    ours = json.loads((SCENES / "cornell.json").read_text())
    ours["image"] |= {"width": SIZE, "height": SIZE}
    ours["render"] |= {"max_depth": DEPTH}
    return ours, translated(ours)


def glass_and_mirror() -> tuple[dict, dict]:
    """The box with a ball of glass and one of mirror instead of the cubes."""
    ours, _ = cornell()
    ours["materials"] |= {"glass": {"type": "dielectric", "ior": 1.5}, "mirror": {"type": "mirror"}}
    ours["scene"] = [node for node in ours["scene"] if node["object"] != "cube"] + [
        {"object": {"type": "sphere", "radius": 0.35}, "material": "glass", "transform": [{"translate": [0.4, -0.64, 0.3]}]},
        {"object": {"type": "sphere", "radius": 0.4}, "material": "mirror", "transform": [{"translate": [-0.4, -0.59, -0.3]}]}]
    return ours, translated(ours)


def thousand_lights() -> tuple[dict, dict]:
    """The box under 1,000 points of light of unequal power instead of the lamp, none nearer to a wall than 0.3: the noise of
    points in front of a wall has no end."""
    ours, _ = cornell()
    rng = np.random.default_rng(1000)
    ours["scene"] = [node for node in ours["scene"] if node["material"] != "lamp"]
    ours["lights"] = [{"type": "point", "position": [float(x) for x in rng.uniform([-0.7, 0.3, -0.7], [0.7, 0.7, 0.7])],
                       "intensity": [float(x) for x in 0.004 * rng.pareto(2.0) * rng.uniform(0.2, 1.0, 3)]}
                      for _ in range(1000)]
    return ours, translated(ours)


def textured() -> tuple[dict, dict]:
    """What is flat or a ball in the textured scene, under its environment: all diffuse, with the same images, and holes."""
    ours = json.loads((SCENES / "textured.json").read_text())
    ours["image"] = {"width": SIZE, "height": SIZE}
    ours["render"] |= {"max_depth": DEPTH}
    ours["materials"] = {name: {"type": "diffuse", **{key: material[key] for key in ("reflectance", "opacity") if key in material}}
                         for name, material in ours["materials"].items()}
    ours["scene"] = [node for node in ours["scene"] if node["object"]["type"] in ("rectangle", "sphere")]
    return ours, translated(ours)


CASES = {"cornell": cornell, "glass and mirror": glass_and_mirror, "thousand lights": thousand_lights, "textured": textured}


def translated(scene: dict) -> dict:
    """A scene of rectangles, boxes, spheres, area and point lights, and an environment, as Mitsuba's dictionary."""
    camera, image = scene["camera"], scene["image"]
    out = {"type": "scene",
           "integrator": {"type": "path", "max_depth": scene["render"]["max_depth"]},
           "sensor": {"type": "perspective", "fov": camera["fov"], "fov_axis": "y", "near_clip": 1e-3,
                      "to_world": look_at(camera),
                      "film": {"type": "hdrfilm", "width": image["width"], "height": image["height"],
                               "rfilter": {"type": "box"}, "pixel_format": "rgb", "component_format": "float32"},
                      "sampler": {"type": "independent"}}}
    placed = transforms.matrices([node.transform for node in load_document(scene)[0].scene])
    for i, (node, place) in enumerate(zip(scene["scene"], placed)):
        shape = node["object"]
        shape = scene["objects"][shape] if isinstance(shape, str) else shape
        material = scene["materials"][node["material"]]
        out[f"shape{i}"] = {**shape_of(shape, place), "bsdf": bsdf_of(material, shape["type"])}
        if any(material.get("emission", [])):
            out[f"shape{i}"]["emitter"] = {"type": "area", "radiance": rgb(material["emission"])}
    if isinstance(scene.get("background"), dict):
        out["environment"] = environment_of(scene["background"])
    for i, light in enumerate(scene.get("lights", [])):
        out[f"light{i}"] = {"type": "point", "position": light["position"], "intensity": rgb(light["intensity"])}
    return out


def shape_of(shape: dict, place: np.ndarray) -> dict:
    def placed(*first: np.ndarray):
        import mitsuba as mi
        return mi.ScalarTransform4f(np.linalg.multi_dot([place, np.eye(4), *first]))

    match shape["type"]:
        case "rectangle":  # Mitsuba's: half-size 1, in xy, facing +z
            x, z = shape["size"]
            return {"type": "rectangle",
                    "to_world": placed(np.diag([x / 2, 1, z / 2, 1]), _UPRIGHT)}
        case "box":  # of half-size 1
            return {"type": "cube", "to_world": placed()}
        case "sphere":
            return {"type": "sphere", "to_world": placed(np.diag([shape["radius"]] * 3 + [1]), _UPRIGHT)}
    raise ValueError(shape["type"])


def bsdf_of(material: dict, shape: str) -> dict:
    if "opacity" in material:  # seen from both sides, as ours is
        rest = {key: value for key, value in material.items() if key != "opacity"}
        return {"type": "mask", "opacity": bitmap_of(material["opacity"], shape, "a"), "nested": bsdf_of(rest, shape)}
    match material["type"]:
        case "diffuse":
            colour = material.get("reflectance", [0.8, 0.8, 0.8])
            colour = rgb(colour) if isinstance(colour, list) else bitmap_of(colour, shape, "rgb")
            return {"type": "twosided", "nested": {"type": "diffuse", "reflectance": colour}}
        case "mirror":
            return {"type": "conductor", "material": "none"}
        case "dielectric":
            return {"type": "dielectric", "int_ior": material["ior"], "ext_ior": 1.0}
    raise ValueError(material["type"])


def bitmap_of(texture: dict, shape: str, channels: str) -> dict:
    """An image on a rectangle or a sphere. Mitsuba's v grows downwards; its longitude starts a quarter before ours."""
    import mitsuba as mi
    data = (SCENES / texture["file"]).read_bytes()
    pixels = (images.load_channel(data, texture["file"], ["a"], "linear") if channels == "a"
              else images.load(data, texture["file"]))
    u, v = texture.get("tiling", [1, 1])
    to_uv = mi.ScalarTransform3f()
    to_uv = to_uv.translate([0, 1]).scale([u, -v]) if shape == "rectangle" else to_uv.translate([-0.25, 0]).scale([u, v])
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(pixels)), "raw": True, "to_uv": to_uv,
            "wrap_mode": texture.get("wrap", "repeat")}


def environment_of(background: dict) -> dict:
    """Ours at the places of a finer grid: Mitsuba's first and last rows lie at the poles, ours half a pixel off them."""
    import mitsuba as mi
    image = images.load((SCENES / background["file"]).read_bytes(), background["file"]).astype(np.float64)
    height, width, _ = image.shape
    rows, columns = 8 * height, 8 * width
    y = np.clip(np.arange(rows) / (rows - 1) * height - 0.5, 0, height - 1)
    x = (np.arange(columns) + 0.5) / columns * width - 0.5
    y0, x0 = np.floor(y).astype(int), np.floor(x).astype(int)
    a, b = (y - y0)[:, None, None], (x - x0)[None, :, None]
    y1, x0, x1 = np.minimum(y0 + 1, height - 1), x0 % width, (x0 + 1) % width
    fine = ((1 - a) * ((1 - b) * image[np.ix_(y0, x0)] + b * image[np.ix_(y0, x1)])
            + a * ((1 - b) * image[np.ix_(y1, x0)] + b * image[np.ix_(y1, x1)]))
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180 + background.get("rotation", 0))
    return {"type": "envmap", "bitmap": mi.Bitmap(fine.astype(np.float32)), "to_world": turn}


def rgb(value: list[float]) -> dict:
    return {"type": "rgb", "value": list(value)}


def look_at(camera: dict):
    import mitsuba as mi
    return mi.ScalarTransform4f().look_at(origin=camera["position"], target=camera["target"], up=camera["up"])


# --- Rendering

class Mitsuba:
    def __init__(self, variant: str, build):
        import mitsuba as mi
        mi.set_variant(variant)
        _, described = build()
        self.mi, self.described, self.scene = mi, described, mi.load_dict(described)

    def render(self, samples: int, seed: int) -> tuple[np.ndarray, float]:
        """(pixels [h, w, 3], seconds)"""
        began = time.perf_counter()
        image = np.array(self.mi.render(self.scene, spp=samples, seed=seed))
        return image.astype(np.float64), time.perf_counter() - began

    def row(self, y: int, samples: int, seed: int) -> np.ndarray:
        """[parts, w, 3]"""
        sensor = self.described["sensor"]
        cropped = {**sensor, "film": {**sensor["film"], "crop_offset_y": y, "crop_height": 1}}
        scene = self.mi.load_dict({**self.described, "sensor": cropped})
        return np.array([np.array(self.mi.render(scene, spp=samples // PARTS, seed=seed + part)).astype(np.float64)[0]
                         for part in range(PARTS)])


class Ours:
    def __init__(self, build):
        self.described, _ = build()

    def render(self, samples: int, seed: int) -> tuple[np.ndarray, float]:
        self.described["render"]["seed"] = seed
        image = tilecast.render(tilecast.load(self.described, folder=SCENES), samples=samples)
        return image.pixels.astype(np.float64), image.stats["seconds"]["render"]

    def row(self, y: int, samples: int, seed: int) -> np.ndarray:
        """[parts, w, 3]"""
        def part(seed: int) -> np.ndarray:
            described = {**self.described, "render": {**self.described["render"], "seed": seed}}
            scene = tilecast.load(described, folder=SCENES).scene
            return scene.render_chunk(0, y, scene.width, 1, 0, samples // PARTS).sums.sum(0)[0] / (samples // PARTS)

        with ThreadPoolExecutor(os.cpu_count()) as threads:
            return np.array(list(threads.map(part, range(seed, seed + PARTS))))


def references(renderer, samples: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Independent renders, together of so many samples, [PARTS, h, w, 3]; and of more those of ROWS, [PARTS, rows * w, 3]."""
    whole = np.array([renderer.render(samples // PARTS, seed + part)[0] for part in range(PARTS)])
    return whole, np.concatenate([renderer.row(y, MORE * samples, seed + 1000) for y in ROWS], 1)


@cache
def our_references(name: str, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """The same for all variants of Mitsuba, one of which must be set."""
    return references(Ours(CASES[name]), samples, 1000)


def family(a: np.ndarray, b: np.ndarray) -> dict:
    """Of two references' parts [PARTS, ...]: the largest t, and the p of the whole family."""
    from scipy import stats
    squares = [part.var(0, ddof=1) / PARTS for part in (a, b)]
    variance = sum(squares) + (1e-5 * b.mean(0)) ** 2  # what has no noise still is rounded
    seen = variance > 0
    t = np.abs(a.mean(0) - b.mean(0))[seen] / np.sqrt(variance[seen])
    freedom = variance[seen] ** 2 / np.maximum(sum(s**2 for s in squares)[seen] / (PARTS - 1), 1e-300)
    p = 2 * stats.t.sf(t, np.maximum(freedom, 1))
    return {"largest_t": float(t.max()), "p": float(min(1.0, p.min() * p.size)), "of": int(p.size)}


def agreement(a: np.ndarray, b: np.ndarray, rows_a: np.ndarray, rows_b: np.ndarray) -> dict:
    """a, b: the two references' parts; then those of the single rows."""
    def blocks(parts: np.ndarray) -> np.ndarray:
        n, h, w, c = parts.shape
        return parts.reshape(n, BLOCKS, h // BLOCKS, BLOCKS, w // BLOCKS, c).mean((2, 4))

    return {"channels": (a.mean((0, 1, 2)) / b.mean((0, 1, 2)) - 1).tolist(), "blocks": family(blocks(a), blocks(b)),
            "pixels": family(rows_a, rows_b)}


def mse(image: np.ndarray, first: np.ndarray, second: np.ndarray) -> float:
    return float(((image - first) * (image - second)).mean())


def measure(name: str, variant: str, counts: list[int], runs: int, samples: int) -> dict:
    theirs, ours = Mitsuba(variant, CASES[name]), Ours(CASES[name])
    (own, own_rows), (other, other_rows) = our_references(name, samples), references(theirs, samples, 3000)
    first, second = own.mean(0), other.mean(0)
    row = {"scene": name, "variant": variant, "agreement": agreement(own, other, own_rows, other_rows), "points": []}
    our_counts = [2**k for k in range(1, 1 + int(math.log2(max(counts))))]
    for count in counts:
        theirs.render(count, 1)  # compiles
    found: dict[tuple[str, int], list[tuple[float, float]]] = {}
    for run in range(runs):
        for count in counts:
            image, seconds = theirs.render(count, 10 + run)
            found.setdefault(("theirs", count), []).append((mse(image, first, second), seconds))
        for count in our_counts:
            image, seconds = ours.render(count, 10 + run)
            found.setdefault(("ours", count), []).append((mse(image, first, second), seconds))
    curve = [[statistics.median(values) for values in zip(*found["ours", count])] for count in our_counts]
    for count in counts:
        error, seconds = (statistics.median(values) for values in zip(*found["theirs", count]))
        # The error falls along the curve, np.interp wants it to rise.
        logs = np.log([[max(e, 1e-30), s] for e, s in reversed(curve)])
        equal = math.exp(np.interp(math.log(error), logs[:, 0], logs[:, 1]))
        inside = logs[0, 0] <= math.log(error) <= logs[-1, 0]
        row["points"].append({"samples": count, "mse": error, "seconds": seconds, "ours_at_equal_mse": equal,
                              "ratio": seconds / equal, "inside": bool(inside)})
    row["ours"] = [{"samples": count, "mse": e, "seconds": s} for count, (e, s) in zip(our_counts, curve)]
    return row


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--samples", default="16,64,256", help="of Mitsuba, whose error ours has to reach")
    parser.add_argument("--reference", type=int, default=2048, help="samples of each of the two references")
    parser.add_argument("--variants", default="llvm_ad_rgb,scalar_rgb")
    parser.add_argument("--scenes", default=",".join(CASES))
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    try:
        import mitsuba  # noqa: F401
    except ImportError:
        raise SystemExit("Mitsuba is not installed: .venv/bin/python -m pip install mitsuba") from None
    rows = []
    for name in arguments.scenes.split(","):
        for variant in arguments.variants.split(","):
            row = measure(name, variant, [int(n) for n in arguments.samples.split(",")], arguments.runs,
                          arguments.reference)
            rows.append(row)
            agreed = row["agreement"]
            print(f"{name}, {variant}: means differ by {' '.join(f'{x:+.3%}' for x in agreed['channels'])}; " + "; ".join(
                f"of {agreed[what]['of']} {what} and channels the largest t is {agreed[what]['largest_t']:.1f}, the family's p "
                f"{agreed[what]['p']:.2g}" for what in ("blocks", "pixels")))
            for point in row["points"]:
                print(f"  {point['samples']:5} samples: MSE {point['mse']:.3g} in {point['seconds']:.2f} s, ours in "
                      f"{point['ours_at_equal_mse']:.2f} s: {point['ratio']:.2f} times as fast"
                      + ("" if point["inside"] else " (beyond what was measured)"), flush=True)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


if __name__ == "__main__":
    main()
