"""Materials and their textures as the core takes them: each handed over once."""

from __future__ import annotations

from typing import Any

from .. import _core
from . import images, schema
from .checks import Path
from .core_errors import at
from .loader import Loader
from .textures import asks_for_uv, textures


class Appearance:
    """Hands materials to the core's builder."""

    def __init__(self, scene: schema.Scene, builder: _core.SceneBuilder, loader: Loader):
        self._named = scene.materials
        self._builder = builder
        self._loader = loader
        self._materials: dict[str, int] = {}
        self._images: dict[tuple[str, ...], _core.Texels] = {}

    def material(self, path: Path, material: str | schema.Material) -> int:
        """The handle of a material: by its name, or by its content where it stands in place."""
        if isinstance(material, str):
            key, path, material = "name " + material, ("materials", material), self._named[material]
        else:
            key = material.model_dump_json()
        if key not in self._materials:
            with at(path):
                self._materials[key] = self._new(path, material)
        return self._materials[key]

    def _new(self, path: Path, material: schema.Material) -> int:
        builder = self._builder
        given = {name: self._setting(path, name, getattr(material, name)) for name in type(material).model_fields
                 if name not in ("type", "of", "weight", "metal", "metallic", "transmission")}
        common = {key: value for name in ("emission", "opacity", "normal_map") for key, value in given.pop(name).items()}
        settings = {key: value for setting in given.values() for key, value in setting.items()}
        match material:
            case schema.Blend():
                parts = [self.material((*path, "of", index), part) for index, part in enumerate(material.of)]
                return builder.blend(parts, [1 - material.weight, material.weight], **common)
            case schema.Principled():
                colour, rough, ior = given["base_color"], given["roughness"], given["ior"]
                metallic, clear = material.metallic, material.transmission
                tint = {"tint" if key == "reflectance" else key: value for key, value in colour.items()}
                shares = {"conductor": metallic, "plastic": (1 - metallic) * (1 - clear),
                          "dielectric": (1 - metallic) * clear}
                parts = {"conductor": rough | colour, "plastic": rough | colour | ior, "dielectric": rough | tint | ior}
                kinds = [kind for kind, share in shares.items() if share > 0]
                if len(kinds) == 1:
                    return builder.material(kinds[0], **parts[kinds[0]], **common)
                handles = [builder.material(kind, **parts[kind]) for kind in kinds]
                return builder.blend(handles, [shares[kind] for kind in kinds], **common)
            case schema.Conductor() if index := material.index():
                return builder.material("conductor", eta=index[0], k=index[1], **given["roughness"], **common)
        return builder.material(material.type, **settings, **common)

    def _setting(self, path: Path, name: str, value: Any) -> dict[str, Any]:
        """A parameter as the core's settings: a value, or the handle of a texture."""
        if value is None:
            return {}
        core_name = "reflectance" if name == "base_color" else name
        if not isinstance(value, schema.Model):
            return {core_name: value}
        key = {"reflectance": "texture", "normal_map": "normal_map"}.get(core_name, f"{core_name}_texture")
        with at((*path, name)):
            return {key: self._texture((*path, name), value)}

    def _texture(self, path: Path, texture: schema.Model) -> int:
        def colour(value: list[float] | float) -> list[float]:
            return value if isinstance(value, list) else [value] * 3

        match texture.type:
            case "checker":
                return self._builder.checker(colour(texture.even), colour(texture.odd), texture.size, texture.space == "uv")
            case "gradient":
                return self._builder.gradient(colour(texture.start), colour(texture.end), texture.along, *texture.range)
        return self._builder.image_texture(self._image(path, texture), texture.wrap, texture.filter, texture.tiling,
                                           texture.offset)

    def _image(self, path: Path, texture: schema.Model) -> _core.Texels:
        """The image of a texture, loaded once for all that take the same from it."""
        file = texture.file
        match texture:
            case schema.NormalMap():
                key = (file, "linear")
            case schema.ScalarImage():
                wanted = [texture.channel] if texture.channel else ["a", "r"] if path[-1] == "opacity" else ["r"]
                key = (file, texture.colour_space, *wanted)
            case schema.EmissionImage():
                key = (file, texture.colour_space, str(texture.factor))
            case _:
                key = (file, texture.colour_space)
        if key not in self._images:
            with self._loader.file(file, (*path, "file")) as data:
                if isinstance(texture, schema.ScalarImage):
                    pixels = images.load_channel(data, file, wanted, texture.colour_space)
                else:
                    pixels = images.load(data, file, key[1])
                    if isinstance(texture, schema.EmissionImage):
                        pixels *= texture.factor
                self._images[key] = images.texels(pixels)
        return self._images[key]


def uses_uvs(materials: list[schema.Material]) -> bool:
    """Whether any of the materials needs texture coordinates."""
    return any(asks_for_uv(texture) for material in materials for _, texture in textures(material))
