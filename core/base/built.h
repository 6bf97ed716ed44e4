// What a build leaves out: the features (see all_features()) that the compile definition TILECAST_WITHOUT names, as
// "texture","lens". A normal build leaves nothing out; core/bench/feature_cost.py shows by the others what a feature costs
// scenes that do not use it. Tests whether a scene has a feature stand behind built_with(), so that both the test and the
// code go. What a feature is by itself, without code of its own (instances, hierarchy), cannot be left out.
#pragma once

#include <algorithm>
#include <iterator>
#include <string_view>

namespace tilecast {

#ifndef TILECAST_WITHOUT
#define TILECAST_WITHOUT
#endif
inline constexpr std::string_view kLeftOut[]{"", TILECAST_WITHOUT};  // "": nothing

inline constexpr std::string_view kCanBeLeftOut[]{
    "absorption", "area_lights", "background", "blend", "conductor", "csg", "dielectric", "directional_lights",
    "disk", "dispersion", "emission", "environment", "image_texture", "lens", "light_tree", "mesh", "microfacets", "mirror", "normal_map",
    "opacity", "oren_nayar", "phong", "pixel_filter", "plastic", "point_lights", "rectangle", "shadow_rays", "solid",
    "spot_lights", "texture"};

template <size_t n>
constexpr bool among(const std::string_view (&features)[n], std::string_view feature) {
  return std::ranges::find(features, feature) != std::end(features);
}
static_assert(std::ranges::all_of(kLeftOut, [](auto name) { return name.empty() || among(kCanBeLeftOut, name); }),
              "TILECAST_WITHOUT names a feature that cannot be left out");

consteval bool built_with(std::string_view feature) {
  if (!among(kCanBeLeftOut, feature)) throw "it cannot be left out";
  return !among(kLeftOut, feature);
}

}  // namespace tilecast
