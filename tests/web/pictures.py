"""Jobs to look at, and what the page's canvas shows of them."""

import base64

import httpx2 as httpx
import numpy as np
from playwright.sync_api import Page

from tilecast import _images

RED, WHITE = [0.6, 0.1, 0.1], [0.8, 0.8, 0.8]


def scene(*, seconds: float | None = None, samples: int = 16, size: tuple[int, int] = (96, 64), **render) -> dict:
    """A sphere on a checkered floor under the sky. seconds: renders for so long, whatever the machine."""
    stop = {} if seconds is None else {"stop": {"seconds": seconds}}
    return {
        "version": 1,
        "camera": {"type": "perspective", "position": [0, 1.5, 5], "target": [0, 0.7, 0], "fov": 35},
        "image": {"width": size[0], "height": size[1]},
        "render": {"samples": samples if seconds is None else 65536, **stop, **render},
        "materials": {"floor": {"type": "diffuse", "reflectance": {"type": "checker", "even": WHITE, "odd": RED}}},
        "scene": [
            {"object": {"type": "rectangle", "size": [20, 20]}, "material": "floor"},
            {"object": {"type": "sphere", "radius": 0.8}, "transform": [{"translate": [0, 0.8, 0]}]},
        ],
        "lights": [{"type": "point", "position": [3, 5, 4], "intensity": [90, 90, 90]}],
        "background": [0.3, 0.4, 0.6],
    }


def post(url: str, document: dict, **fields) -> dict:
    """Submits over HTTP; the job as the server answers."""
    answer = httpx.post(f"{url}/v1/jobs", json={"scene": document, **fields} if fields else document)
    assert answer.status_code == 202, answer.text
    assert answer.headers["location"] == f"/v1/jobs/{answer.json()['id']}"
    return answer.json()


def job(url: str, id_: str) -> dict:
    return httpx.get(f"{url}/v1/jobs/{id_}").raise_for_status().json()


def change(url: str, id_: str, **fields) -> None:
    httpx.patch(f"{url}/v1/jobs/{id_}", json=fields).raise_for_status()


def open_job(page: Page, url: str, id_: str) -> None:
    page.goto(f"{url}/#/jobs/{id_}")
    page.locator("canvas").wait_for()


def wait_for_state(page: Page, state: str, seconds: float = 60) -> None:
    page.locator(f'.job-header .state[data-state="{state}"]').wait_for(timeout=1000 * seconds)


KNOWN = """() => {
  const canvas = document.querySelector("canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let known = 0;
  for (let at = 3; at < data.length; at += 4) known += data[at] === 255;
  return known / (canvas.width * canvas.height);
}"""


def known(page: Page) -> float:
    """The share of the canvas that shows a sample, 0 to 1."""
    return page.evaluate(KNOWN)


def wait_for_known(page: Page, share: float) -> None:
    page.wait_for_function(f"() => ({KNOWN})() >= {share}", polling=50)


def canvas(page: Page) -> np.ndarray:
    """What the canvas shows: uint8 [height, width, 4]."""
    width, height, data = page.evaluate("""() => {
      const canvas = document.querySelector("canvas");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let text = "";
      for (let at = 0; at < data.length; at += 32768) text += String.fromCharCode(...data.subarray(at, at + 32768));
      return [canvas.width, canvas.height, btoa(text)];
    }""")
    return np.frombuffer(base64.b64decode(data), np.uint8).reshape(height, width, 4)


def png(url: str, id_: str, folder) -> np.ndarray:
    """image.png as the server gives it: uint8 [height, width, 3]."""
    file = folder / "image.png"
    file.write_bytes(httpx.get(f"{url}/v1/jobs/{id_}/image.png").raise_for_status().content)
    pixels = _images.read(str(file))[0]
    return np.rint(pixels[..., :3] * 255).astype(np.uint8)


def assert_same_picture(shown: np.ndarray, image: np.ndarray) -> None:
    """The canvas shows image.png.

    It is developed from half floats: relative rounding 2^-11 at most, so 255 * (1 / 2.4) * 1.055 * 2^-11 < 0.06 of a level on
    the power law's part of sRGB and 255 * 12.92 * 0.0031308 * 2^-11 < 0.01 on its linear one. A value may fall on the other
    side of a rounding step, by one level, where it lies that near to it: less than 12% of values that are spread evenly.
    """
    assert shown.shape[:2] == image.shape[:2]
    assert (shown[..., 3] == 255).all()
    difference = np.abs(shown[..., :3].astype(int) - image.astype(int))
    assert difference.max() <= 1
    assert (difference > 0).mean() < 0.12


def expect_picture(page: Page, image: np.ndarray) -> None:
    """As assert_same_picture, for a job that is done: its last tiles are on their way for a moment longer."""
    for _ in range(50):
        try:
            return assert_same_picture(canvas(page), image)
        except AssertionError:
            page.wait_for_timeout(100)
    assert_same_picture(canvas(page), image)
